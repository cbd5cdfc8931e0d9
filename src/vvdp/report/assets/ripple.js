"use strict";

/** As in `ripple.py`: cycles as close as may be in a stretch, those that suffice beside it, and what has crossed. */
const STRETCH = 8;
const BESIDE = 4;
const HELD = 0.1;

const integrals = new WeakMap();

/** The integral of a line over x up to each row. */
function integralOf({ x, y }) {
  if (!integrals.has(y)) {
    const sum = new Float64Array(y.length);
    for (let i = 1; i < y.length; i++) sum[i] = sum[i - 1] + 0.5 * (y[i] + y[i - 1]) * (x[i] - x[i - 1]);
    integrals.set(y, sum);
  }
  return integrals.get(y);
}

/**
 * Cycles of a line that follow one another within `closest` pixels, from the rows that are to be drawn and their places
 * in pixels: a list of parts, each with its first and last of these rows and points of x, low, high and mean.
 */
function closeCycles(line, rows, places, closest) {
  const width = places.at(-1) - places[0];
  const count = Math.floor(width / (STRETCH * closest));
  if (rows.length <= STRETCH || !(count > 0) || rows.some((i) => !Number.isFinite(line.y[i]))) return [];
  const stretch = places.map((place) => Math.min(Math.floor(((place - places[0]) / width) * count), count - 1));
  const rises = risesOf(rows.map((i) => line.y[i]), stretch, count);
  const counts = new Array(count).fill(0);
  for (const k of rises) counts[stretch[k]] += 1;
  const isClose = counts.map((each) => each >= BESIDE);
  for (const [begin, end] of runsOf(isClose)) isClose.fill(counts.slice(begin, end).some((each) => each >= STRETCH), begin, end);
  const bin = (k) => Math.floor((places[k] - places[0]) / closest);
  const knots = rises.filter((k, i) => i === 0 || bin(k) !== bin(rises[i - 1]));
  const inside = knots.slice(1).map((k, i) => isClose[stretch[k]] && isClose[stretch[knots[i]]]);
  return runsOf(inside).map(([begin, end]) => {
    const shown = knots.slice(begin, end + 1);
    const means = meansOf(line, shown.map((k) => rows[k]));
    if (begin === 0 && isClose[0]) shown[0] = 0;
    if (end === knots.length - 1 && isClose.at(-1)) shown[shown.length - 1] = rows.length - 1;
    return { first: shown[0], last: shown.at(-1), points: pointsOf(line, rows, places, shown, means) };
  });
}

/** Where values rise through the middle of their range within a stretch. */
function risesOf(values, stretch, count) {
  const [low, high] = [new Array(count).fill(Infinity), new Array(count).fill(-Infinity)];
  values.forEach((value, k) => {
    low[stretch[k]] = Math.min(low[stretch[k]], value);
    high[stretch[k]] = Math.max(high[stretch[k]], value);
  });
  const found = [];
  let held = 0;
  values.forEach((value, k) => {
    const [a, b] = [low[stretch[k]], high[stretch[k]]];
    const away = (value - 0.5 * (a + b)) / (b > a ? 0.5 * HELD * (b - a) : 1);
    if (Math.abs(away) <= 1) return;
    if (away > 1 && held < 0) found.push(k);
    held = Math.sign(away);
  });
  return found;
}

/** First place and the place after the last of each run of flags. */
function runsOf(flags) {
  const found = [];
  flags.forEach((flag, k) => {
    if (flag && !flags[k - 1]) found.push([k, k]);
    if (flag) found.at(-1)[1] = k + 1;
  });
  return found;
}

/** Means of a line between one row and the next of `rows`. */
function meansOf(line, rows) {
  const sum = integralOf(line);
  return rows.slice(1).map((row, i) => (sum[row] - sum[rows[i]]) / (line.x[row] - line.x[rows[i]]));
}

function pointsOf(line, rows, places, shown, means) {
  const points = means.map((mean, i) => {
    let [low, high] = [Infinity, -Infinity];
    const end = i === means.length - 1 ? shown[i + 1] : shown[i + 1] - 1;
    for (let k = shown[i]; k <= end; k++) {
      low = Math.min(low, line.y[rows[k]]);
      high = Math.max(high, line.y[rows[k]]);
    }
    return { x: 0.5 * (places[shown[i]] + places[shown[i + 1]]), low, high, mean };
  });
  return [{ ...points[0], x: places[shown[0]] }, ...points, { ...points.at(-1), x: places[shown.at(-1)] }];
}
