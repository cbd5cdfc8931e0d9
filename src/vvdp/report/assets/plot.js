"use strict";

/** Panels whose x is the same quantity move together. */
const linked = new Map();

/** What they show since it was last changed, for those that are opened later. */
const zoomed = new Map();

const KEYS = "Arrows move the pointer, a and b set the cursors, + and - zoom, Shift with arrows moves, 0 resets, Escape clears.";

/** One panel: axes, pointer and cursors around its content. */
class Plot {
  constructor(chart, described, column) {
    this.chart = chart;
    this.described = described;
    this.isField = described.kind === "field";
    this.content = this.isField ? new FieldContent(described, column) : new LinesContent(described, column);
    this.extent = this.content.extent;
    this.home = [described.x.low ?? this.extent[0], described.x.high ?? this.extent[1]];
    this.view = this.home;
    this.yView = null;
    this.link = described.link ?? null;
    this.legend = element("div", { class: "live-legend" });
    this.host = element("div", { class: "live-plot" });
    this.node = element("div", { class: "live-panel" });
    if (described.title) this.node.append(element("div", { class: "live-title" }, described.title));
    this.node.append(this.legend, this.host);
    this.#fillLegend();
  }

  /** Builds the plot once its place in the page is known. */
  open(width, height) {
    this.frame = new uPlot(this.#options(width, height), [this.view, [0, 1]], this.host);
    const { over } = this.frame;
    over.tabIndex = 0;
    over.setAttribute("role", "application");
    over.setAttribute("aria-label", `${this.described.y.label} over ${this.described.x.label}. ${KEYS}`);
    this.dots = this.content.lines.map((line) => over.appendChild(element("i", { class: "live-dot", style: `background:${line.colour || INK}` })));
    this.marks = ["A", "B"].map((name) => over.appendChild(element("i", { class: this.isField ? "live-mark live-ring" : "live-mark", "data-name": name })));
    over.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    over.addEventListener("click", (event) => this.#click(event));
    over.addEventListener("keydown", (event) => this.#key(event));
    if (this.described.equal) this.#makeRoom();
  }

  /** Widens x until y fits in where a unit of both is as long. */
  #makeRoom() {
    const { width, height } = this.frame.bbox;
    const [low, high] = this.chart.yRange(this, true);
    const middle = 0.5 * (this.home[0] + this.home[1]);
    const half = 0.5 * Math.max(this.home[1] - this.home[0], ((high - low) * width) / height);
    this.home = this.extent = [middle - half, middle + half];
    this.show(this.home);
  }

  #options(width, height) {
    const { x, y } = this.described;
    const axis = (side, of, room) => ({
      ...side, label: of.label, stroke: QUIET, font: FONT, labelFont: FONT, labelSize: 20, size: room,
      grid: { stroke: GRID, width: 1 }, ticks: { stroke: "#6b747d", width: 1, size: 4 }, border: { show: true, stroke: "#6b747d", width: 1 },
      values: (_, ticks, __, ___, step) => tickLabels(ticks, of.log ? 0 : step),
      ...(of.log ? { splits: (_, __, low, high) => logTicks(low, high), filter: (_, ticks) => ticks } : {}),
    });
    return {
      width, height, padding: [8, 20, 0, 0], legend: { show: false },
      cursor: {
        points: { show: false }, drag: { x: true, y: this.isField, setScale: false, dist: 4 },
        bind: { mousedown: (_, __, handler) => (event) => this.#press(event, handler), dblclick: () => () => this.chart.resetTwice() },
      },
      scales: {
        x: { time: false, distr: x.log ? 3 : 1, range: () => this.view },
        y: { distr: y.log ? 3 : 1, range: () => this.#yRange() },
      },
      series: [{}, { scale: "y", points: { show: false }, paths: () => null }],
      axes: [this.isAboveAnother ? { ...axis({ scale: "x" }, x, 8), label: undefined, values: () => [] } : axis({ scale: "x" }, x, 32), { ...axis({ scale: "y" }, y, 62), ...(this.content.lines.every((line) => line.isFlag) ? { values: () => [] } : {}) }],
      hooks: { draw: [() => this.#draw()], setSelect: [(u) => this.#select(u)], setCursor: [() => this.#point()] },
    };
  }

  #yRange() {
    const isHome = this.view[0] === this.home[0] && this.view[1] === this.home[1];
    const found = this.yView ?? this.chart.yRange(this, isHome);
    if (!this.described.equal || !this.frame) return found;
    const { width, height } = this.frame.bbox;
    const half = (0.5 * (this.view[1] - this.view[0]) * height) / width;
    const middle = 0.5 * (found[0] + found[1]);
    return [middle - half, middle + half];
  }

  /** Places in pixels of values of x and y, for drawing and for measuring distances. */
  get scale() {
    const { bbox, scales } = this.frame;
    const along = ({ min, max }, isLog, from, length) => {
      const [a, b] = isLog ? [Math.log10(min), Math.log10(max)] : [min, max];
      const factor = length / (b - a);
      const place = isLog ? (value) => from + (Math.log10(value) - a) * factor : (value) => from + (value - a) * factor;
      const back = (pixel) => (isLog ? 10 ** (a + (pixel - from) / factor) : a + (pixel - from) / factor);
      return [place, back];
    };
    const [x, toX] = along(scales.x, this.described.x.log, bbox.left, bbox.width);
    const [y, toY] = along(scales.y, this.described.y.log, bbox.top + bbox.height, -bbox.height);
    return { x, y, toX, toY, left: this.view[0], right: this.view[1], bottom: scales.y.min, log: this.described.y.log, box: bbox };
  }

  #draw() {
    const { ctx, bbox } = this.frame;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    this.content.draw(ctx, this.scale, devicePixelRatio);
    ctx.restore();
    this.#placeMarks();
  }

  /** Shows x from `left` to `right`, and of a map y from `low` to `high`. */
  show(view, yView = null) {
    this.view = view;
    this.yView = yView;
    this.frame.setScale("x", { min: view[0], max: view[1] });
    if (this.isField || this.described.equal) this.frame.setScale("y", Object.fromEntries(["min", "max"].map((key, i) => [key, this.#yRange()[i]])));
  }

  /** Other data of the same lines. A view that was zoomed stays, where it still has something to show. */
  take(described, column) {
    const shown = this.content.lines.map((line) => line.isOn);
    const isHome = this.view[0] === this.home[0] && this.view[1] === this.home[1];
    this.described = described;
    this.content = this.isField ? new FieldContent(described, column) : new LinesContent(described, column);
    this.content.lines.forEach((line, i) => { if (shown[i] !== undefined) line.isOn = shown[i]; });
    this.extent = this.content.extent;
    this.home = [described.x.low ?? this.extent[0], described.x.high ?? this.extent[1]];
    if (isHome || !(this.view[0] < this.extent[1] && this.view[1] > this.extent[0])) this.view = this.home;
  }

  redraw() {
    this.show(this.view, this.yView);
  }

  /** Shows part of x here and in all panels that are linked; not beyond the data. */
  zoom(left, right) {
    const [least, most] = [Math.min(this.extent[0], this.home[0]), Math.max(this.extent[1], this.home[1])];
    if (!(right - left > 1e-9 * (most - least))) return;
    let view = [Math.max(left, least), Math.min(right, most)];
    if (left < least) view[1] = Math.min(least + (right - left), most);
    if (right > most) view[0] = Math.max(most - (right - left), least);
    if (this.link === null) {
      this.show(view, this.yView);
      return;
    }
    zoomed.set(this.link, view);
    for (const peer of linked.get(this.link)) peer.adopt();
  }

  /** Takes its place among the panels of the same x, and shows what they show. */
  join() {
    if (this.link === null) return;
    linked.set(this.link, (linked.get(this.link) ?? new Set()).add(this));
    if (zoomed.has(this.link)) this.adopt();
  }

  /** Leaves the panels of the same x, and the page. */
  close() {
    linked.get(this.link)?.delete(this);
    this.frame.destroy();
  }

  /** Shows what the panels of the same x show, unless it has nothing there. */
  adopt() {
    const view = zoomed.get(this.link);
    if (view[0] < this.extent[1] && view[1] > this.extent[0]) this.show(view);
  }

  /** Back to the first view, with all panels of the same x. */
  reset() {
    zoomed.delete(this.link);
    for (const peer of this.link === null ? [this] : linked.get(this.link)) peer.show(peer.home);
  }

  /** Zooms by `factor` about x, or moves by a share of what is seen. */
  change(factor, share = 0, about = 0.5) {
    const isLog = this.described.x.log;
    const [a, b] = isLog ? this.view.map(Math.log10) : this.view;
    const [centre, move] = [a + about * (b - a), share * (b - a)];
    const ends = [centre - (centre - a) * factor + move, centre + (b - centre) * factor + move];
    this.zoom(...(isLog ? ends.map((end) => 10 ** end) : ends));
  }

  #select(u) {
    const { left, width, top, height } = u.select;
    if (width < 4 && height < 4) return;
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.wasDragged = true;
    if (this.isField && height > 4) this.yView = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
    this.zoom(u.posToVal(left, "x"), u.posToVal(left + width, "x"));
  }

  #press(event, handler) {
    this.wasDragged = false;
    if (event.button === 0 && !event.shiftKey) return handler(event);
    if (event.button > 1) return null;
    event.preventDefault();
    let last = event.clientX;
    const move = (next) => {
      this.wasDragged = true;
      this.change(1, (last - next.clientX) / this.frame.over.clientWidth);
      last = next.clientX;
    };
    addEventListener("mousemove", move);
    addEventListener("mouseup", () => removeEventListener("mousemove", move), { once: true });
    return null;
  }

  #wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.frame.over) return;
    event.preventDefault();
    const about = event.offsetX / this.frame.over.clientWidth;
    this.change(1.0015 ** event.deltaY, 0, Math.min(Math.max(about, 0), 1));
  }

  #click(event) {
    if (this.wasDragged || event.detail > 1) return;
    const { left, top } = this.frame.cursor;
    if (left >= 0) this.chart.place(this, this.frame.posToVal(left, "x"), this.frame.posToVal(top, "y"));
  }

  #key(event) {
    const { frame } = this;
    const step = event.ctrlKey ? 1 : 10;
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    const acts = {
      "+": () => this.change(0.5), "-": () => this.change(2), 0: () => this.chart.reset(), Escape: () => this.chart.clear(),
      a: () => this.chart.put("A", this), b: () => this.chart.put("B", this), Enter: () => this.chart.place(this, ...this.pointed),
    };
    if (event.shiftKey && moves[event.key]?.[0]) this.change(1, moves[event.key][0] / 50);
    else if (moves[event.key]) {
      const [right, down] = moves[event.key];
      const begin = frame.cursor.left >= 0 ? frame.cursor : { left: frame.over.clientWidth / 2, top: frame.over.clientHeight / 2 };
      const clip = (value, most) => Math.min(Math.max(value, 0), most);
      frame.setCursor({ left: clip(begin.left + right, frame.over.clientWidth), top: clip(begin.top + down, frame.over.clientHeight) });
    } else if (acts[event.key] && !event.altKey && !event.metaKey) acts[event.key]();
    else return;
    event.preventDefault();
  }

  /** x and y under the pointer, NaN where there is none. */
  get pointed() {
    const { left, top } = this.frame.cursor;
    return left < 0 ? [NaN, NaN] : [this.frame.posToVal(left, "x"), this.frame.posToVal(top, "y")];
  }

  #point() {
    const [x, y] = this.pointed;
    this.tell(x, y);
    if (this.link === null) return;
    for (const peer of linked.get(this.link)) if (peer !== this) peer.follow(x);
  }

  /** The pointer is at x in a linked panel. */
  follow(x) {
    const left = x >= this.view[0] && x <= this.view[1] ? this.frame.valToPos(x, "x") : -10;
    this.frame.setCursor({ left, top: -10 }, false);
    this.tell(left < 0 ? NaN : x, NaN);
  }

  /** Writes the values at (x, y) beside the names of the lines. */
  tell(x, y) {
    const { scale } = this;
    const found = Number.isNaN(x) ? null : this.content.sample(x, Number.isNaN(y) ? scale.toY(scale.box.top) : y, scale);
    this.values.forEach((value, i) => {
      const { line, text, isPoint } = this.#valueAt(found?.[i], i);
      value.textContent = found ? (isPoint ? `${text} at ${this.along(found[i].x)}` : text) : "";
      this.#placeDot(this.dots[i], found && line.isOn && !this.isField && !line.isFlag ? found[i] : null);
    });
    const words = this.isField ? `${this.along(x)}, ${withUnit(formatNumber(y), this.described.y.unit)}` : this.along(x);
    this.where.textContent = found ? words : "";
  }

  #valueAt(found, i) {
    const line = this.content.lines[i];
    const text = withUnit(formatNumber((this.isField ? found?.z : found?.y) ?? NaN), line.unit);
    return { line, text, isPoint: !this.isField && !(line.isJoined && line.isSorted) };
  }

  /** A value of x with its unit. */
  along(x) {
    return withUnit(formatAlong(x, this.view[1] - this.view[0]), this.described.x.unit);
  }

  #placeDot(dot, point) {
    const isThere = point !== null && Number.isFinite(point.y) && point.x >= this.view[0] && point.x <= this.view[1];
    dot.style.display = isThere ? "block" : "none";
    if (!isThere) return;
    dot.style.transform = `translate(${this.frame.valToPos(point.x, "x")}px, ${this.frame.valToPos(point.y, "y")}px)`;
  }

  #placeMarks() {
    this.marks?.forEach((mark, i) => {
      const cursor = this.chart.cursorFor(this, i ? "B" : "A");
      const isThere = cursor !== null && cursor.x >= this.view[0] && cursor.x <= this.view[1];
      mark.style.display = isThere ? "block" : "none";
      if (!isThere) return;
      const down = this.isField ? this.frame.valToPos(cursor.y, "y") : 0;
      mark.style.transform = `translate(${this.frame.valToPos(cursor.x, "x")}px, ${down}px)`;
    });
  }

  /** Draws the cursors where they are now. */
  mark() {
    this.#placeMarks();
  }

  #fillLegend() {
    this.where = element("span", { class: "live-where" });
    this.values = this.content.lines.map(() => element("span", { class: "live-value" }));
    const names = this.content.lines.map((line, i) => (this.isField ? element("span", {}, line.label) : this.#switch(line, i)));
    if (this.described.legend) this.legend.append(element("span", { class: "live-heading" }, this.described.legend));
    names.forEach((name, i) => this.legend.append(element("span", { class: "live-entry" }, name, this.values[i])));
    this.legend.append(this.where);
    if (!this.isField) return;
    const steps = this.content.scale.map(({ colour, text }) => element("span", {}, element("i", { style: `background:${colour}` }), text));
    this.legend.append(element("div", { class: "live-levels", title: "a colour counts from its value on" }, ...steps, this.described.z.unit));
  }

  #switch(line, place) {
    const kind = { "--": "dashed", ":": "dotted", points: "point" }[line.stroke] ?? "solid";
    const swatch = element("i", { class: `live-swatch live-${kind}`, style: `color:${line.colour}` });
    const button = element("button", { type: "button", "aria-pressed": "true", title: "Show or hide" }, swatch, line.label);
    button.addEventListener("click", () => {
      const now = this.content.lines[place];
      now.isOn = !now.isOn;
      button.setAttribute("aria-pressed", String(now.isOn));
      this.redraw();
      this.chart.report();
    });
    return button;
  }
}
