"use strict";
/* Carries runs out beside the page: { model } once, then { run, values, until } or { stop }. */
function vvdpWorker(model, module) {
  const loop = vvdpLoop(model), numbers = vvdpNumbers(model, loop), at = loop.places;
  const MOST_BYTES = 1.5e9;

  const { vectorsFor } = vvdpValues(model, loop);

  function checkUntil(until) {
    const s = { ...model.stepping, until }, lasts = until - s.begin;
    if (!(Number.isFinite(until) && lasts > 0)) throw new Error(`until = ${until} s; expected more than ${s.begin} s`);
    const numbers = ["y", "command", "memory"].reduce((sum, name) => sum + model.arrays[name].shape[0], 1 + model.outputs);
    const rows = lasts / s.record_interval + Math.min(s.window, lasts) / s.window_interval;
    if (rows * numbers * 8 > MOST_BYTES) throw new Error(`until = ${until} s: ${rows.toPrecision(3)} rows to record are too many for a page; the command line takes them`);
    return s.average_from === null ? {} : { average_from: (s.average_from / model.stepping.until) * until };
  }

  let running = 0;
  const breath = () => new Promise((resolve) => setTimeout(resolve, 0));

  /* A run to its end, or to where it is stopped; `reach` hears how far it is. */
  async function run({ values = {}, until = model.stepping.until, level = "exact" }, reach, isStopped) {
    if (level !== "exact") throw new Error(`level ${JSON.stringify(level).slice(0, 40)}: this page has the level "exact"`);
    const means = until === model.stepping.until ? {} : checkUntil(until);
    const vectors = vectorsFor(values), began = performance.now();
    const call = loop.begin(module, { until, ...means }, vectors);
    let answer = at.paused;
    while (answer === at.paused && !isStopped()) {
      answer = call.portion();
      reach(call.time / until);
      await breath();
    }
    if (answer !== at.done && answer !== at.paused) throw new Error(call.failure(answer));
    return { ...numbers.summary(call, answer === at.done, (performance.now() - began) / 1000), ...numbers.series(call) };
  }

  return {
    run: (wanted, reach) => { const mine = ++running; return run(wanted, reach, () => mine !== running || mine === stopped); },
    stop: () => { stopped = running; },
  };
}
var stopped = -1;

if (typeof WorkerGlobalScope !== "undefined") {
  let worker = null;
  self.onmessage = async ({ data }) => {
    if (data.model) {
      const text = atob(data.model.module), code = Uint8Array.from(text, (c) => c.charCodeAt(0));
      worker = vvdpWorker(data.model, await WebAssembly.compile(code));
      self.postMessage({ ready: true });
    } else if (data.stop) worker.stop();
    else {
      try {
        const found = await worker.run(data.wanted, (reach) => self.postMessage({ id: data.id, reach }));
        self.postMessage({ id: data.id, found }, [found.series, found.moving].flatMap(Object.values).map((column) => column.buffer));
      } catch (problem) {
        self.postMessage({ id: data.id, fault: problem instanceof Error ? problem.message : String(problem) });
      }
    }
  };
}
