"use strict";
/* The numbers and series of a run from its arrays, as the command line has them. */
function vvdpNumbers(model, loop) {
  const at = model.places, judge = model.judgement, limits = judge.limits, finite = Number.isFinite;

  function remaining(means) {
    return means[0].map((_, i) => {
      const first = means[1][i] - means[0][i], second = means[2][i] - means[1][i];
      const ratio = Math.min(Math.max(first !== 0 ? second / first : limits.slowest, 0), limits.slowest);
      return Math.abs(means[2][i] + (second * ratio) / (1 - ratio) - (means[0][i] + means[1][i] + means[2][i]) / 3);
    });
  }

  /* Whether means over three spans still change, from states at their four ends. */
  function isSettled(times, states) {
    const spans = [0, 1, 2].map((i) => times[i + 1] - times[i]);
    if (!spans.every((span) => span > 0)) return false;
    const kept = judge.units.flatMap((unit, i) => (unit ? [i] : []));
    const means = spans.map((span, k) => kept.map((i) => (states[k + 1][i] - states[k][i]) / span));
    const size = kept.map((_, j) => Math.abs((means[0][j] + means[1][j] + means[2][j]) / 3));
    const largest = {};
    kept.forEach((i, j) => { largest[judge.units[i]] = Math.max(largest[judge.units[i]] ?? 0, size[j]); });
    return remaining(means).every((drift, j) => drift <= limits.settled * Math.max(size[j], limits.small * largest[judge.units[kept[j]]]));
  }

  function isPaced(times) {
    const spans = [0, 1, 2].map((i) => times[i + 1] - times[i]);
    const drift = remaining(spans.map((span) => [1 / span]))[0];
    return spans.every((span) => span > 0) && drift <= limits.settled / ((spans[0] + spans[1] + spans[2]) / 3);
  }

  const rowOf = (call, name, row) => {
    const n = call.arrays[name].shape[1];
    return call.get(name).slice(row * n, (row + 1) * n);
  };

  /* The window of the means: whole periods between marks, else the plain time. */
  function windowOf(call, end, finished) {
    const clock = call.get("clock"), from = loop.meansFrom(call.stepping, end), inside = [];
    const times = call.get("mark_times");
    for (let i = 0; i < clock[at.stored]; i++) if (times[i] >= from) inside.push(i);
    if (inside.length >= 2) {
      const last = inside.length - 1, third = Math.floor(last / 3);
      const kept = [0, last - 3 * third, last - 2 * third, last - third, last].map((i) => inside[i]);
      const t = kept.map((i) => times[i]), states = kept.map((i) => rowOf(call, "mark_states", i));
      const settled = inside.length > 3 && isPaced(t.slice(1)) && isSettled(t.slice(1), states.slice(1));
      return { begin: t[0], end: t[4], first: states[0], last: states[4], periods: last, settled };
    }
    const final = call.get("y").slice(), spans = clock[at.spans];
    if (!spans) return { begin: call.stepping.begin, end, first: call.initial, last: final, periods: 0, settled: false };
    const begun = Math.min(finished ? 4 : 1, spans), span = call.get("span_times");
    const states = [...Array(begun).keys()].map((i) => rowOf(call, "span_states", i));
    const ends = [...span.slice(1, begun), end], reached = [...states.slice(1), final];
    return { begin: span[0], end, first: states[0], last: final, periods: 0, settled: ends.length === 4 && isSettled(ends, reached) };
  }

  /* Energy and oil between two states; null without books. */
  function balance(call, before, after, low, high) {
    if (!call.instance.exports.vvdp_stored) return null;
    const held = call.stored(before), holds = call.stored(after), books = judge.books;
    const change = (name) => books[name].map((i) => after[i] - before[i]), sum = (x) => x.reduce((a, b) => a + b, 0);
    const size = (x) => sum(x.map(Math.abs));
    const supplied = change("supplied"), spent = change("spent"), stored = holds[0] - held[0];
    const throughput = Math.max(size(supplied), size(spent), Math.abs(stored), Math.abs(held[0]), Math.abs(holds[0]));
    const share = (missing, whole) => (whole > 0 ? missing / whole : 0);
    const into = change("taken_in"), out = change("given_out");
    const oils = into.map((one, i) => {
      const gain = holds[i + 1] - held[i + 1];
      return share(one - out[i] - gain, Math.max(Math.abs(one), Math.abs(out[i]), Math.abs(gain), holds[i + 1]));
    });
    const oil = oils.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    const falls = judge.falling.some((i) => after[i] - before[i] < -limits.balance * throughput);
    const leaves = judge.ranges.some(([least, most], i) => (least !== null && low[i] < least) || (most !== null && high[i] > most));
    return { stored, energy: share(sum(supplied) - sum(spent) - stored, throughput), oil, possible: !falls && !leaves };
  }

  function summary(call, finished, seconds) {
    const clock = call.get("clock"), end = finished ? call.stepping.until : call.time, w = windowOf(call, end, finished);
    const low = call.get("low").slice(), high = call.get("high").slice(), final = call.get("y").slice();
    const value = { mean: (i) => (w.last[i] - w.first[i]) / (w.end - w.begin), low: (i) => low[i], high: (i) => high[i] };
    const found = { duration_s: end, finished, averaged_from_s: w.begin, averaged_to_s: w.end, averaged_periods: w.periods, settled: w.settled };
    for (const [key, [constant, ...terms]] of Object.entries(model.sums)) {
      found[key] = terms.reduce((sum, [kind, place, factor]) => sum + factor * value[kind](place), constant);
    }
    const whole = balance(call, call.initial, final, low, high), part = balance(call, w.first, w.last, low, high);
    if (whole) Object.assign(found, { stored_power_W: part.stored / (w.end - w.begin), energy_residual: whole.energy, mass_residual: whole.oil, second_law: whole.possible });
    const putIn = Object.entries(found).reduce((sum, [key, x]) => (key.startsWith("power_") ? sum + Math.max(x, 0) : sum), 0);
    if (putIn > 0 && Math.abs(found.stored_power_W ?? 0) > limits.settled * putIn) found.settled = false;
    const broken = brokenBounds(found);
    found.cavitation_volume = Object.entries(judge.pressures).some(([key, reference]) => found[key] + reference < judge.cavitation);
    found.within_validity = broken.length === 0;
    if (whole) found.trusted = Math.max(Math.abs(whole.energy), Math.abs(whole.oil)) <= limits.balance && whole.possible && !broken.length;
    Object.assign(found, {
      steps: clock[at.steps] - clock[at.rejected], rejected_steps: clock[at.rejected], evaluations: clock[at.evaluations],
      stiff_method: clock[at.method] === 1, wall_time_s: seconds,
    });
    return { summary: found, warnings: warnings(found, broken) };
  }

  function shown(x, unit) {
    return `${Number((((x - unit.datum) / unit.scale)).toPrecision(4))} ${unit.symbol}`.trim();
  }

  /* A sentence for each law that is used outside its range. */
  function brokenBounds(found) {
    const words = new Set();
    for (const each of judge.bounds) {
      const value = (each.size ? Math.abs(found[each.key]) : found[each.key]) + each.offset;
      const under = each.least !== null && value < each.least, over = each.most !== null && value > each.most;
      if (!finite(value) || !(under || over)) continue;
      const limit = each.least !== null && each.most !== null
        ? `outside ${shown(each.least, each.unit)} to ${shown(each.most, each.unit)}`
        : `${under ? "below" : "above"} ${shown(under ? each.least : each.most, each.unit)}`;
      words.add(`${each.label}: ${shown(value, each.unit)}, ${limit}; ${each.otherwise}`);
    }
    return [...words];
  }

  function warnings(found, broken) {
    const words = [];
    if (Math.max(Math.abs(found.energy_residual ?? 0), Math.abs(found.mass_residual ?? 0)) > limits.balance) words.push("the balances do not close: a residual is above the limit; try a tenth of run.relative_tolerance");
    if (found.second_law === false) words.push("the run cannot be: a loss gives energy back, or a state left its range");
    if (!found.finished) words.push(`the run was interrupted at ${Number(found.duration_s.toPrecision(6))} s`);
    words.push(...broken);
    if (!found.settled && judge.steady) words.push("not settled: a mean would still change by more than 0.1 % if the run went on; let it last longer (run.until), or average later (run.average_from)");
    return words;
  }

  /* The recorded columns: by the names of the report's table, and those that move the diagrams. */
  function series(call) {
    const rows = call.get("clock")[at.records], named = [model.series, model.moving];
    const wanted = named.flatMap((each) => Object.values(each)).filter(([kind]) => kind === "output").map(([, place]) => place);
    const outputs = wanted.length ? call.outputs(rows, [...new Set(wanted)]) : null;
    const of = { time: ["record_times", 1], state: ["record", call.arrays.record.shape[1]], command: ["record_command", call.arrays.record_command.shape[1]] };
    const [shown, moving] = named.map((each) => Object.fromEntries(Object.entries(each).map(([key, [kind, place, less]]) => {
      const column = new Float64Array(rows), [values, width, from] = kind === "output" ? [outputs.get(place), 1, 0] : [call.get(of[kind][0]), of[kind][1], place];
      for (let i = 0; i < rows; i++) column[i] = values[i * width + from] - less;
      return [key, column];
    })));
    return { series: shown, moving: { ...moving, time: call.get("record_times").slice(0, rows) } };
  }

  return { summary, series };
}
