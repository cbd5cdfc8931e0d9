"use strict";

const BUCKET = 16;
const FAN = 4;

/** Places of the lowest and highest value of each bucket of 16 rows, then of 4 such buckets, and so on. */
class Pyramid {
  constructor(values) {
    this.values = values;
    this.levels = [this.#bottom()];
    while (this.levels.at(-1).low.length > FAN) this.levels.push(this.#above(this.levels.at(-1)));
  }

  #bottom() {
    const { values } = this;
    const level = emptyLevel(BUCKET, values.length / BUCKET);
    for (let bucket = 0; bucket < level.low.length; bucket++) {
      const end = Math.min((bucket + 1) * BUCKET, values.length);
      for (let i = bucket * BUCKET; i < end; i++) this.#take(level, bucket, i, i);
    }
    return level;
  }

  #above(below) {
    const level = emptyLevel(below.size * FAN, below.low.length / FAN);
    for (let child = 0; child < below.low.length; child++) {
      if (below.low[child] >= 0) this.#take(level, Math.floor(child / FAN), below.low[child], below.high[child]);
    }
    return level;
  }

  #take({ low, high }, bucket, lower, higher) {
    const { values } = this;
    if (!Number.isFinite(values[lower])) return;
    if (low[bucket] < 0 || values[lower] < values[low[bucket]]) low[bucket] = lower;
    if (high[bucket] < 0 || values[higher] > values[high[bucket]]) high[bucket] = higher;
  }

  /**
   * Visits rows from `first` to before `end`, in order. Of a bucket that `isFine(first row, last row)` only the lowest
   * and the highest are visited, and its first row where it holds no value.
   */
  walk(first, end, isFine, visit) {
    const top = this.levels.length - 1;
    for (let bucket = 0; bucket < this.levels[top].low.length; bucket++) {
      this.#walkBucket(top, bucket, first, end, isFine, visit);
    }
  }

  #walkBucket(depth, bucket, first, end, isFine, visit) {
    const { size, low, high } = this.levels[depth];
    const begin = bucket * size;
    const stop = Math.min(begin + size, this.values.length);
    if (begin >= stop || stop <= first || begin >= end) return;
    if (begin >= first && stop <= end && isFine(begin, stop - 1)) {
      const [a, b] = [low[bucket], high[bucket]];
      if (a < 0) visit(begin);
      else visit(Math.min(a, b));
      if (a !== b) visit(Math.max(a, b));
    } else if (depth > 0) {
      for (let child = 0; child < FAN; child++) {
        const below = bucket * FAN + child;
        if (below < this.levels[depth - 1].low.length) this.#walkBucket(depth - 1, below, first, end, isFine, visit);
      }
    } else {
      for (let i = Math.max(begin, first); i < Math.min(stop, end); i++) visit(i);
    }
  }
}

function emptyLevel(size, count) {
  return { size, low: new Int32Array(Math.ceil(count)).fill(-1), high: new Int32Array(Math.ceil(count)).fill(-1) };
}

const pyramids = new WeakMap();

/** The pyramid of a column, built when first asked for. */
function pyramidOf(values) {
  if (!pyramids.has(values)) pyramids.set(values, new Pyramid(values));
  return pyramids.get(values);
}

/** The first row whose value is not below `value`; of equal ones the one after the last where `after`. */
function rowOf(values, value, after = false) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < value || (after && values[middle] === value)) low = middle + 1;
    else high = middle;
  }
  return low;
}

const ascending = new WeakMap();

/** Whether a column never falls and has no gaps, so that a row is found by halving. */
function isAscending(values) {
  if (!ascending.has(values)) {
    let isSo = values.length > 0 && Number.isFinite(values[0]);
    for (let i = 1; isSo && i < values.length; i++) isSo = values[i] >= values[i - 1];
    ascending.set(values, isSo);
  }
  return ascending.get(values);
}

/** A line of a panel: its columns, and what they come to between two ends of x. */
class Line {
  constructor(described, column) {
    Object.assign(this, described);
    this.isOn = true;
    this.x = column(described.x);
    this.y = column(described.y);
    this.low = described.low === undefined ? null : column(described.low);
    this.high = described.high === undefined ? null : column(described.high);
    this.isSorted = isAscending(this.x);
    this.isJoined = !["points", "stems"].includes(this.stroke);
    this.isFlag = this.stroke === "flag";
    this.canRipple = this.isSorted && this.low === null && ["-", "--", ":"].includes(this.stroke);
  }

  /** Lowest and highest x. */
  get ends() {
    return extremes(this.x);
  }

  /** Lowest and highest of what is drawn between two ends of x. */
  range(left, right) {
    const columns = [this.y, this.low, this.high].filter((values) => values);
    const found = columns.map((values) => this.#rangeOf(values, left, right));
    if (this.stroke === "stems") found.push([0, 0]);
    return [Math.min(...found.map((each) => each[0])), Math.max(...found.map((each) => each[1]))];
  }

  #rangeOf(values, left, right) {
    let [low, high] = [Infinity, -Infinity];
    const take = (value) => {
      if (value < low) low = value;
      if (value > high) high = value;
    };
    if (!this.isSorted) {
      values.forEach((value, i) => this.x[i] >= left && this.x[i] <= right && take(value));
      return [low, high];
    }
    const [first, end] = [rowOf(this.x, left), rowOf(this.x, right, true)];
    pyramidOf(values).walk(first, end, () => true, (i) => take(values[i]));
    if (this.isJoined) [left, right].forEach((x) => take(this.between(values, x)));
    return [low, high];
  }

  /** The value at x on the drawn line; NaN beyond its ends. */
  between(values, x) {
    const last = rowOf(this.x, x, true) - 1;
    if (last < 0 || x > this.x.at(-1)) return NaN;
    if (this.isFlag || this.stroke === "steps" || last === this.x.length - 1 || this.x[last] === x) return values[last];
    const part = (x - this.x[last]) / (this.x[last + 1] - this.x[last]);
    return values[last] + part * (values[last + 1] - values[last]);
  }

  /** The drawn point at x, or, where points are not joined by a function of x, the one nearest to (x, y) on screen. */
  sample(x, y, scale) {
    if (this.isJoined && this.isSorted) return { x, y: this.between(this.y, x) };
    let [best, distance] = [-1, Infinity];
    const [px, py] = [scale.x(x), scale.y(y)];
    for (let i = 0; i < this.x.length; i++) {
      const away = (scale.x(this.x[i]) - px) ** 2 + (this.stroke === "stems" ? 0 : (scale.y(this.y[i]) - py) ** 2);
      if (away < distance) [best, distance] = [i, away];
    }
    return best < 0 ? { x: NaN, y: NaN } : { x: this.x[best], y: this.y[best] };
  }

  /** Visits the rows to be drawn: all within the ends and one beyond each, or fewer where several share a pixel. */
  walk(values, scale, visit) {
    if (!this.isSorted) {
      for (let i = 0; i < this.x.length; i++) visit(i);
      return;
    }
    const first = Math.max(rowOf(this.x, scale.left) - 1, 0);
    const end = Math.min(rowOf(this.x, scale.right, true) + 1, this.x.length);
    const isFine = (begin, last) => scale.x(this.x[last]) - scale.x(this.x[begin]) <= 1;
    pyramidOf(values).walk(first, end, isFine, visit);
  }
}

/** Lowest and highest of the finite values. */
function extremes(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high && value < Infinity) high = value;
  }
  return [low, high];
}

/**
 * A polyline that is given points in pixels. What falls into one column of pixels is passed on as at most four points,
 * or, where it goes to and fro and `fill` is given, as an upright bar, which is drawn far more quickly.
 */
class Trace {
  constructor(path, isStepped = false, fill = null) {
    this.path = path;
    this.isStepped = isStepped;
    this.fill = fill;
    this.column = NaN;
    this.isDown = false;
    this.bar = null;
  }

  add(x, y) {
    if (!Number.isFinite(y) || !Number.isFinite(x)) {
      this.end();
      return;
    }
    if (this.isStepped && this.isDown) this.#put(x, this.last);
    this.#put(x, y);
  }

  end() {
    this.#flush();
    this.column = NaN;
    this.isDown = false;
    this.bar = null;
  }

  #put(x, y) {
    const column = Math.floor(x);
    if (column !== this.column) {
      this.#flush();
      this.column = column;
      this.beginX = x;
      this.begin = this.low = this.high = y;
    }
    if (y < this.low) this.low = y;
    if (y > this.high) this.high = y;
    this.lastX = x;
    this.last = y;
    if (!this.isDown) this.path.moveTo(x, y);
    this.isDown = true;
  }

  #flush() {
    if (Number.isNaN(this.column)) return;
    const { column, low, high } = this;
    const beyond = Math.min(this.begin, this.last) - low + high - Math.max(this.begin, this.last);
    const isBar = this.fill !== null && beyond > 1;
    const isJoined = isBar && this.bar?.column === column - 1 && this.bar.low <= high && this.bar.high >= low;
    if (!isJoined) this.path.lineTo(this.beginX, this.begin);
    if (isBar) {
      this.fill(column, low, high);
      this.path.moveTo(this.lastX, this.last);
      this.bar = { column, low, high };
      return;
    }
    this.bar = null;
    if (low < Math.min(this.begin, this.last)) this.path.lineTo(this.lastX, low);
    if (high > Math.max(this.begin, this.last)) this.path.lineTo(this.lastX, high);
    this.path.lineTo(this.lastX, this.last);
  }
}
