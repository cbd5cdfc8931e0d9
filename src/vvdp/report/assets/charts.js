"use strict";

const HINT = "Drag to zoom, Shift and drag to move, wheel to zoom (after a click, or with Ctrl), double click to reset. A click sets cursor A, the next one B.";

/** Height of a panel that stands beside others, at least: on a narrow screen the still is low [px]. */
const LEAST = 260;

/** A figure of the page with its panels, buttons and two cursors. */
class LiveChart {
  constructor(described, figure, column) {
    this.described = described;
    this.figure = figure;
    this.plots = described.panels.map((panel) => new Plot(this, panel, column));
    this.plots.forEach((plot, i) => {
      plot.isAboveAnother = !described.sideBySide && plot.link !== null && plot.link === this.plots[i + 1]?.link;
    });
    this.cursors = { A: null, B: null };
    this.before = this.cursors;
    this.readout = element("table", { class: "live-readout", role: "status", hidden: "" });
    this.grid = element("div", { class: described.sideBySide ? "live-grid live-beside" : "live-grid" });
    if (described.sideBySide) this.grid.style.setProperty("--beside", this.plots.map((plot) => `minmax(0, ${plot.described.height}fr)`).join(" "));
    this.grid.append(...this.plots.map((plot) => plot.node));
    this.node = element("div", { class: "live" }, this.#buttons(), this.grid, this.readout);
    this.#open();
  }

  #open() {
    const still = this.figure.querySelector("svg");
    const height = still.getBoundingClientRect().height;
    this.figure.insertBefore(this.node, still);
    this.figure.classList.add("is-live");
    const total = this.plots.reduce((sum, plot) => sum + plot.described.height, 0);
    const room = (plot) => (plot.isAboveAnother ? 16 : 60);
    const inner = Math.max(height - this.plots.reduce((sum, plot) => sum + room(plot), 0), 110 * this.plots.length);
    for (const plot of this.plots) {
      const share = this.described.sideBySide ? Math.max(height, LEAST) : (inner * plot.described.height) / total + room(plot);
      plot.open(plot.host.clientWidth, Math.max(Math.round(share), 100));
      plot.join();
    }
    this.observer = new ResizeObserver(() => this.#resize());
    this.observer.observe(this.grid);
  }

  /** Takes the chart off the page, with all that waits for events. */
  close() {
    this.observer.disconnect();
    for (const plot of this.plots) plot.close();
    this.node.remove();
  }

  #resize() {
    for (const { frame, host } of this.plots) {
      if (host.clientWidth > 0 && host.clientWidth !== frame.width) frame.setSize({ width: host.clientWidth, height: frame.height });
    }
  }

  #buttons() {
    const all = [
      ["+", "Zoom in", () => this.#each((plot) => plot.change(0.5))],
      ["\u2212", "Zoom out", () => this.#each((plot) => plot.change(2))],
      ["\u2190", "Move left", () => this.#each((plot) => plot.change(1, -0.25))],
      ["\u2192", "Move right", () => this.#each((plot) => plot.change(1, 0.25))],
      ["Reset", "Back to the first view", () => this.reset()],
      ["All", "All data", () => this.#each((plot) => plot.zoom(...plot.extent))],
      ["Clear", "Clear the cursors", () => this.clear()],
    ];
    const buttons = all.map(([text, label, act]) => {
      const button = element("button", { type: "button", "aria-label": label, title: label }, text);
      button.addEventListener("click", act);
      return button;
    });
    return element("div", { class: "live-tools", role: "toolbar", "aria-label": "View", title: HINT }, ...buttons);
  }

  /** Does `act` once for each set of linked panels. */
  #each(act) {
    const done = new Set();
    for (const plot of this.plots) {
      if (plot.link === null || !done.has(plot.link)) act(plot);
      done.add(plot.link);
    }
  }

  /** Ends of y of a panel; those of all panels where they share one scale. */
  yRange(plot, isWhole) {
    const plots = this.described.share && !plot.isField ? this.plots : [plot];
    const found = plots.map((each) => each.content.range(each.view, isWhole));
    return [Math.min(...found.map((each) => each[0])), Math.max(...found.map((each) => each[1]))];
  }

  /** Back to the first view, here and in linked charts. */
  reset() {
    for (const plot of this.plots) plot.reset();
  }

  /** What a double click does: its first click has set a cursor, which is taken back. */
  resetTwice() {
    this.cursors = this.before;
    this.reset();
    this.report();
  }

  /** Sets cursor A, then B, then A anew. */
  place(plot, x, y) {
    if (Number.isNaN(x)) return;
    this.before = this.cursors;
    const isSecond = this.cursors.A !== null && this.cursors.B === null;
    this.cursors = isSecond ? { ...this.cursors, B: { plot, x, y } } : { A: { plot, x, y }, B: null };
    this.report();
  }

  /** Sets one cursor to where the pointer is. */
  put(name, plot) {
    const [x, y] = plot.pointed;
    if (Number.isNaN(x)) return;
    this.cursors = { ...this.cursors, [name]: { plot, x, y } };
    this.report();
  }

  clear() {
    this.before = this.cursors = { A: null, B: null };
    this.report();
  }

  /** Whether other data has the same panels and lines, so that `update` can show it. */
  fits(described) {
    const words = (all) => JSON.stringify(all.panels.map((panel) => [panel.kind, panel.title, panel.link, panel.y?.label, (panel.lines ?? []).map((line) => line.label)]));
    return words(described) === words(this.described);
  }

  /** Shows other data in the same panels; what is hidden, zoomed or marked stays so. */
  update(described, column) {
    this.described = described;
    this.plots.forEach((plot, i) => plot.take(described.panels[i], column));
    this.plots.forEach((plot) => plot.redraw());
    this.report();
  }

  /** A cursor as it counts for a panel: its own, or one set in a panel with the same x. */
  cursorFor(plot, name) {
    const cursor = this.cursors[name];
    return cursor !== null && (cursor.plot === plot || (plot.link !== null && cursor.plot.link === plot.link)) ? cursor : null;
  }

  /** Writes the values at the cursors and their differences below the panels. */
  report() {
    for (const plot of this.plots) plot.mark();
    const { A, B } = this.cursors;
    this.readout.hidden = A === null && B === null;
    if (this.readout.hidden) return;
    const head = element("tr", {}, ...["", "A", "B", "B \u2212 A"].map((text) => element("th", {}, text)));
    this.readout.replaceChildren(element("thead", {}, head), element("tbody", {}, ...this.#alongRows(A, B), ...this.plots.flatMap((plot) => this.#rows(plot))));
  }

  #alongRows(A, B) {
    const { plot } = A ?? B;
    const rows = [readoutRow(plot.described.x.name, A?.x ?? NaN, B?.x ?? NaN, (x) => plot.along(x))];
    if (plot.isField) rows.push(readoutRow(plot.described.y.name, A?.y ?? NaN, B?.y ?? NaN, (y) => withUnit(formatNumber(y), plot.described.y.unit)));
    const second = { s: 1, ms: 1e-3, "µs": 1e-6 }[plot.described.x.unit];
    if (second && A && B && A.x !== B.x) {
      const perSecond = withUnit(formatNumber(1 / (second * Math.abs(B.x - A.x))), "Hz");
      rows.push(element("tr", {}, element("th", { scope: "row" }, "1 / (B \u2212 A)"), element("td", { class: "n", colspan: "3" }, perSecond)));
    }
    return rows;
  }

  #rows(plot) {
    const [A, B] = ["A", "B"].map((name) => {
      const cursor = this.cursorFor(plot, name);
      return cursor && plot.content.sample(cursor.x, cursor.y, plot.scale).map((point) => (plot.isField ? point.z : point.y));
    });
    if (!A && !B) return [];
    return plot.content.lines.flatMap((line, i) =>
      line.isOn ? [readoutRow(line.label, A?.[i] ?? NaN, B?.[i] ?? NaN, (value) => withUnit(formatNumber(value), line.unit))] : []);
  }
}

function readoutRow(label, a, b, format) {
  const cells = [a, b, b - a].map((value) => element("td", { class: "n" }, format(value)));
  return element("tr", {}, element("th", { scope: "row" }, label), ...cells);
}

/** Makes the charts of the page live when they come near to the screen; `vvdpCharts` gives them by name. */
async function startCharts(source) {
  const { charts, column } = await unpackPage(source.textContent);
  const live = new Map();
  const open = (described, figure) => {
    if (!live.has(described.name)) {
      live.set(described.name, new LiveChart(described, figure, column));
      performance.mark(described.name);
    }
    return live.get(described.name);
  };
  const figures = new Map(charts.map((each) => [each.name, document.getElementById(`figure-${each.name}`)]));
  const near = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      near.unobserve(target);
      open(charts.find((each) => figures.get(each.name) === target), target);
    }
  }, { rootMargin: "800px" });
  for (const figure of figures.values()) if (figure) near.observe(figure);
  return { live, column, open: (name) => open(charts.find((each) => each.name === name), figures.get(name)) };
}

const chartData = document.getElementById("chart-data");
const vvdpCharts = chartData && startCharts(chartData);
