"use strict";
/* What diagrams in motion have in common: the colour of a pressure, values between rows, a clock that slows time. */
const PRESSURE_STOPS = [[47, 127, 209], [140, 96, 196], [226, 74, 44]]; // least, middle, largest
const STEPS = 12; // pictures per period where the person asked for less motion
const stillness = matchMedia("(prefers-reduced-motion: reduce)");

/** Whether the person asked for less motion. */
function wantsStillness() { return stillness.matches; }

/** The colour of a share, 0 to 1, of the range of pressures. */
function pressureColour(share) {
  const place = Math.min(Math.max(share, 0), 1) * (PRESSURE_STOPS.length - 1);
  const first = Math.min(Math.floor(place), PRESSURE_STOPS.length - 2);
  const mixed = PRESSURE_STOPS[first].map((low, i) => Math.round(low + (place - first) * (PRESSURE_STOPS[first + 1][i] - low)));
  return `rgb(${mixed.join(" ")})`;
}

/** The rows around a time, and the share of the way from the first to the second. */
function rowsAt(times, time) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  const part = times[high] > times[low] ? (time - times[low]) / (times[high] - times[low]) : 0;
  return [low, high, Math.min(Math.max(part, 0), 1)];
}

/** A clock that runs over one period, slowed; with less motion wanted it stands at a few instants instead. */
class SlowClock {
  /** `show` takes the time [s], and what went by on the wall [s]. */
  constructor(show) {
    this.show = show;
    this.slowness = 100;
    this.period = [0, 1];
    this.share = 0;
    this.isRunning = false;
  }

  get time() { return this.period[0] + this.share * (this.period[1] - this.period[0]); }

  /** Goes to a share of the period. */
  go(share) {
    this.share = this.exact = share;
    this.show(this.time, 0);
  }

  run(isRunning) {
    const wasRunning = this.isRunning;
    this.isRunning = isRunning;
    if (!isRunning || wasRunning) return;
    this.before = performance.now();
    this.exact = this.share;
    requestAnimationFrame(() => this.#tick());
  }

  #tick() {
    if (!this.isRunning) return;
    const now = performance.now();
    const passed = Math.min(now - this.before, 200) / 1000;
    this.exact = (this.exact + passed / this.slowness / (this.period[1] - this.period[0])) % 1;
    this.before = now;
    const share = wantsStillness() ? Math.floor(this.exact * STEPS) / STEPS : this.exact;
    if (share !== this.share) {
      this.share = share;
      this.show(this.time, passed);
    }
    requestAnimationFrame(() => this.#tick());
  }
}
