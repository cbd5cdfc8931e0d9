"use strict";

/** As in `plot.py`: widths of a line within which the two strokes of a cycle leave no gap. */
const CLOSEST = 2;

/** Lines over x: what a plot of them asks of its content. */
class LinesContent {
  constructor(described, column) {
    this.described = described;
    this.lines = described.lines.map((line) => new Line(line, column));
    this.marks = this.lines.some((line) => ["points", "marked", "stems"].includes(line.stroke));
  }

  /** Lowest and highest x of all data. */
  get extent() {
    const { log } = this.described.x;
    const ends = this.lines.map((line) => (log ? extremes(line.x.filter((value) => value > 0)) : line.ends));
    const all = [Math.min(...ends.map((each) => each[0])), Math.max(...ends.map((each) => each[1]))];
    return this.marks || !(all[0] < all[1]) ? widen(all, 0.02, log) : all;
  }

  /** Ends of y for what is seen of x. */
  range([left, right], isWhole) {
    const { low, high, log } = this.described.y;
    const found = this.lines.filter((line) => line.isOn).map((line) => line.range(left, right));
    if (isWhole) this.described.levels.forEach(({ value, upright }) => upright || found.push([value, value]));
    let ends = [Math.min(...found.map((each) => each[0])), Math.max(...found.map((each) => each[1]))];
    if (log && !(ends[0] > 0)) ends[0] = Math.min(...this.lines.map((line) => line.y.reduce((least, y) => (y > 0 && y < least ? y : least), Infinity)));
    ends = widen(ends, 0.05, log);
    return [low ?? ends[0], high ?? ends[1]];
  }

  draw(context, scale, ratio) {
    for (const line of this.lines) if (line.isOn) drawLine(context, line, scale, ratio);
    for (const level of this.described.levels) drawLevel(context, level, scale, ratio);
  }

  /** Lines that are shown, with the point of each at (x, y). */
  sample(x, y, scale) {
    return this.lines.map((line) => (line.isOn ? line.sample(x, y, scale) : { x: NaN, y: NaN }));
  }
}

function drawLine(context, line, scale, ratio) {
  context.strokeStyle = context.fillStyle = line.colour;
  context.lineWidth = line.width * 1.4 * ratio;
  context.lineJoin = "bevel";
  if (line.isFlag) {
    drawFlag(context, line, scale, ratio);
    return;
  }
  if (line.low) drawBand(context, line, scale);
  const path = new Path2D();
  const thick = context.lineWidth;
  const fill = (column, low, high) => context.fillRect(column, low - thick / 2, Math.max(1, thick), high - low + thick);
  if (line.stroke === "stems") {
    const foot = scale.y(Math.max(0, scale.log ? scale.bottom : 0));
    line.walk(line.y, scale, (i) => {
      path.moveTo(scale.x(line.x[i]), foot);
      path.lineTo(scale.x(line.x[i]), scale.y(line.y[i]));
    });
  } else if (line.isJoined) {
    const trace = line.isSorted ? new Trace(path, line.stroke === "steps", fill) : new Pen(path);
    const rows = [];
    line.walk(line.y, scale, (i) => rows.push(i));
    const places = rows.map((i) => scale.x(line.x[i]));
    const close = line.canRipple ? closeCycles(line, rows, places, CLOSEST * thick) : [];
    let next = 0;
    rows.forEach((i, k) => {
      if (k >= close[next]?.last) next += 1;
      if (k > close[next]?.first) trace.end();
      else trace.add(places[k], scale.y(line.y[i]));
    });
    trace.end();
    for (const part of close) drawCycles(context, path, part, scale);
  }
  context.setLineDash((DASHES[line.stroke] ?? []).map((length) => length * ratio));
  context.stroke(path);
  context.setLineDash([]);
  if (["points", "marked"].includes(line.stroke)) drawMarks(context, line, scale, ratio);
}

/** A polyline that passes on every point: for lines that turn back. */
class Pen {
  constructor(path) {
    this.path = path;
    this.isDown = false;
  }

  add(x, y) {
    const isThere = Number.isFinite(x) && Number.isFinite(y);
    if (isThere && this.isDown) this.path.lineTo(x, y);
    else if (isThere) this.path.moveTo(x, y);
    this.isDown = isThere;
  }

  end() {
    this.isDown = false;
  }
}

/** A bar while a flag is 1; a short one is a pixel long. */
function drawFlag(context, line, scale, ratio) {
  const [foot, top] = [scale.y(line.foot), scale.y(line.top)];
  let begin = null;
  const end = (x) => {
    if (begin !== null) context.fillRect(begin, top, Math.max(x - begin, ratio), foot - top);
    begin = null;
  };
  line.walk(line.y, scale, (i) => {
    const x = scale.x(line.x[i]);
    if (line.y[i] !== 1) end(x);
    else begin ??= x;
  });
  end(scale.x(line.x.at(-1)));
}

/** A pale band over close cycles; their mean is added to the path of the line. */
function drawCycles(context, path, { points }, scale) {
  const band = new Path2D();
  for (const { x, high } of points) band.lineTo(x, scale.y(high));
  for (const { x, low } of points.slice().reverse()) band.lineTo(x, scale.y(low));
  fillPale(context, band);
  points.forEach(({ x, mean }, i) => (i === 0 ? path.moveTo(x, scale.y(mean)) : path.lineTo(x, scale.y(mean))));
}

function fillPale(context, path) {
  context.globalAlpha = 0.25;
  context.fill(path);
  context.globalAlpha = 1;
}

function drawBand(context, line, scale) {
  const sides = [line.high, line.low].map((values) => {
    const points = [];
    const collect = { moveTo: () => {}, lineTo: (x, y) => points.push([x, y]) };
    const trace = new Trace(collect, line.stroke === "steps");
    line.walk(values, scale, (i) => Number.isFinite(values[i]) && trace.add(scale.x(line.x[i]), scale.y(values[i])));
    trace.end();
    return points;
  });
  const path = new Path2D();
  [...sides[0], ...sides[1].reverse()].forEach(([x, y]) => path.lineTo(x, y));
  fillPale(context, path);
}

function drawMarks(context, line, scale, ratio) {
  const size = 3 * ratio;
  const path = new Path2D();
  line.walk(line.y, scale, (i) => {
    const [x, y] = [scale.x(line.x[i]), scale.y(line.y[i])];
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    path.moveTo(x + size, y);
    path.arc(x, y, size, 0, 2 * Math.PI);
  });
  context.fill(path);
}

function drawLevel(context, level, scale, ratio) {
  const { left, top, width, height } = scale.box;
  const at = level.upright ? scale.x(level.value) : scale.y(level.value);
  const isSeen = level.upright ? at >= left && at <= left + width : at >= top && at <= top + height;
  if (!isSeen) return;
  context.strokeStyle = context.fillStyle = level.colour;
  context.lineWidth = 1.2 * ratio;
  context.setLineDash((DASHES[level.stroke] ?? []).map((length) => length * ratio));
  context.beginPath();
  context.moveTo(level.upright ? at : left, level.upright ? top : at);
  context.lineTo(level.upright ? at : left + width, level.upright ? top + height : at);
  context.stroke();
  context.setLineDash([]);
  context.font = FONT.replace("12px", `${11 * ratio}px`);
  context.textAlign = level.upright ? "left" : "right";
  const isHigh = level.upright || at - top < 14 * ratio;
  context.textBaseline = isHigh ? "top" : "bottom";
  if (level.upright) context.fillText(level.label, at + 4 * ratio, top + 2 * ratio);
  else context.fillText(level.label, left + width - 4 * ratio, at + (isHigh ? 3 : -2) * ratio);
}

/** A map: values over a grid of x and y, in the colours of its contours. */
class FieldContent {
  constructor(described, column) {
    this.described = described;
    [this.across, this.up, this.z] = described.grid.map(column);
    this.hatch = described.hatch === undefined ? null : column(described.hatch);
    this.marks = described.marks === undefined ? [] : column(described.marks);
    this.colours = described.colours.map((text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)));
    this.lines = [{ label: described.z.name, unit: described.z.unit, colour: "", isOn: true }];
  }

  get extent() {
    return [this.across[0], this.across.at(-1)];
  }

  range() {
    return [this.up[0], this.up.at(-1)];
  }

  sample(x, y) {
    return [{ x, y, z: mixed(this.z, this.across.length, cellsAlong(this.across, 1, () => x), cellsAlong(this.up, 1, () => y), 0, 0) }];
  }

  draw(context, { box, toX, toY }, ratio) {
    const [wide, high] = [Math.round(box.width), Math.round(box.height)];
    if (wide < 1 || high < 1) return; // too narrow to show anything
    const across = cellsAlong(this.across, wide, (column) => toX(box.left + column + 0.5));
    const up = cellsAlong(this.up, high, (row) => toY(box.top + row + 0.5));
    const steps = this.#steps(across, up);
    const image = context.createImageData(wide, high);
    const pixels = new Uint32Array(image.data.buffer);
    for (let row = 0, place = 0; row < high; row++) {
      for (let column = 0; column < wide; column++, place++) {
        const isEdge = (column > 0 && isCrossed(steps, place, 1)) || (row > 0 && isCrossed(steps, place, wide));
        const isHeavy = this.hatch !== null && (row + column) % 12 < 2 && mixed(this.hatch, this.across.length, across, up, column, row) > 0.5;
        pixels[place] = this.#colour(steps[place], isEdge, isHeavy);
      }
    }
    context.putImageData(image, Math.round(box.left), Math.round(box.top));
    this.#label(context, steps, wide, box, ratio);
    this.#cross(context, { box, toX, toY }, ratio);
  }

  /** The value of each contour beside it, where it crosses a row nearest to the middle, clear of the other labels. */
  #label(context, steps, wide, box, ratio) {
    const { steps: levels } = this.described;
    const high = steps.length / wide;
    const best = levels.map(() => ({ far: Infinity }));
    for (let row = Math.round(0.15 * high); row < 0.85 * high; row += 4) {
      for (let column = Math.round(0.12 * wide); column < 0.88 * wide; column++) {
        const [a, b] = [steps[row * wide + column - 1], steps[row * wide + column]];
        if (a === b || a < 0 || b < 0) continue;
        const far = Math.abs(row - 0.5 * high) + Math.abs(column - 0.5 * wide);
        for (let level = Math.min(a, b); level < Math.max(a, b); level++) if (far < best[level].far) best[level] = { far, x: column, y: row };
      }
    }
    context.font = FONT.replace("12px", `${11 * ratio}px`);
    context.textAlign = "center";
    context.textBaseline = "middle";
    const placed = [];
    best.forEach(({ far, x, y }, level) => {
      if (far === Infinity || placed.some(([left, top]) => Math.abs(left - x) < 34 * ratio && Math.abs(top - y) < 15 * ratio)) return;
      placed.push([x, y]);
      context.strokeStyle = "#fff";
      context.lineWidth = 3 * ratio;
      context.strokeText(formatNumber(levels[level]), box.left + x, box.top + y);
      context.fillStyle = INK;
      context.fillText(formatNumber(levels[level]), box.left + x, box.top + y);
    });
  }

  /** The colours with the values from which on they count. */
  get scale() {
    const { steps: levels, colours } = this.described;
    return levels.map((level, i) => ({ colour: colours[Math.min(i, colours.length - 1)], text: formatNumber(level) }));
  }

  /** A cross at each marked point of the grid that is in view. */
  #cross(context, { box, toX, toY }, ratio) {
    const [left, right] = [toX(box.left), toX(box.left + box.width)];
    const [top, bottom] = [toY(box.top), toY(box.top + box.height)];
    context.strokeStyle = "#a3180c";
    context.lineWidth = ratio;
    const size = 3 * ratio;
    context.beginPath();
    this.marks.forEach((mark, place) => {
      const across = (this.across[place % this.across.length] - left) / (right - left);
      const down = (this.up[Math.floor(place / this.across.length)] - top) / (bottom - top);
      if (!(mark > 0) || across < 0 || across > 1 || down < 0 || down > 1) return;
      const x = box.left + Math.min(Math.max(across * box.width, size), box.width - size);
      const y = box.top + Math.min(Math.max(down * box.height, size), box.height - size);
      context.moveTo(x - size, y - size);
      context.lineTo(x + size, y + size);
      context.moveTo(x - size, y + size);
      context.lineTo(x + size, y - size);
    });
    context.stroke();
  }

  /** Between which levels each pixel is: 0 below the first, -1 where there is no value. */
  #steps(across, up) {
    const { steps: levels } = this.described;
    const steps = new Int16Array(across.cells.length * up.cells.length);
    for (let row = 0, place = 0; row < up.cells.length; row++) {
      for (let column = 0; column < across.cells.length; column++, place++) {
        const value = mixed(this.z, this.across.length, across, up, column, row);
        steps[place] = Number.isNaN(value) ? -1 : rowOf(levels, value, true);
      }
    }
    return steps;
  }

  /** A colour as the four bytes of a pixel. */
  #colour(step, isEdge, isHeavy) {
    if (step < 0) return 0xffe8e5e3;
    if (isEdge) return 0xff241f1b;
    const plain = step === 0 ? [255, 255, 255] : this.colours[Math.min(step, this.colours.length) - 1];
    const [red, green, blue] = isHeavy ? plain.map((part) => Math.round((part + 2 * 255) / 3)) : plain;
    return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  }
}

/** For each pixel of an axis its cell and how far it is into it. */
function cellsAlong(axis, count, valueOf) {
  const cells = new Int32Array(count);
  const parts = new Float64Array(count);
  for (let pixel = 0; pixel < count; pixel++) {
    const value = valueOf(pixel);
    const cell = (cells[pixel] = cellOf(axis, value));
    parts[pixel] = cell < 0 ? NaN : (value - axis[cell]) / (axis[cell + 1] - axis[cell]);
  }
  return { cells, parts };
}

/** The value at a pixel, straight between the four points around it; NaN outside. */
function mixed(values, wide, across, up, column, row) {
  const [i, j] = [across.cells[column], up.cells[row]];
  if (i < 0 || j < 0) return NaN;
  const [a, b, at] = [across.parts[column], up.parts[row], j * wide + i];
  return (1 - b) * ((1 - a) * values[at] + a * values[at + 1]) + b * ((1 - a) * values[at + wide] + a * values[at + wide + 1]);
}

function isCrossed(steps, place, back) {
  return steps[place - back] >= 0 && steps[place - back] !== steps[place];
}

/** The cell of an axis that holds a value; -1 outside. */
function cellOf(axis, value) {
  if (!(value >= axis[0] && value <= axis.at(-1)) || axis.length < 2) return -1;
  return Math.min(rowOf(axis, value, true) - 1, axis.length - 2);
}
