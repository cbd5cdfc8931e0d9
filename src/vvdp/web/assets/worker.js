"use strict";
/* Whether `a b + c` has one rounding in this browser: its instruction for that may have two. */
function vvdpIsFused() {
  const text = "AGFzbQEAAAABCAFgA3x8fAF8AwIBAAcFAQFmAAAKFgEUACAA/RQgAf0UIAL9FP2HAv0hAAs=";
  const code = Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), small = 2 ** -30;
  if (!WebAssembly.validate(code)) return false;
  const { f } = new WebAssembly.Instance(new WebAssembly.Module(code)).exports;
  return f(1 + small, 1 + small, -1 - 2 * small) === small * small;
}

/* The module of each level, compiled when it is first asked for. */
function vvdpModules(model) {
  const isFused = vvdpIsFused(), LEVELS = { exact: isFused ? "fused" : "exact", quick: "quick" }, compiled = {};

  async function unpacked(text) {
    const packed = new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]);
    return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  }

  async function moduleOf(level) {
    if (!Object.hasOwn(LEVELS, level)) throw new Error(`level ${JSON.stringify(level).slice(0, 40)}: expected "exact" or "quick"`);
    if (!model.modules[LEVELS[level]]) throw new Error(`level "${level}": the page would be too large with it; expected "exact"`);
    return (compiled[level] ??= unpacked(model.modules[LEVELS[level]]).then(WebAssembly.compile));
  }

  return { moduleOf, isFused };
}

/* Carries runs out beside the page: { model } once, then { run, values, until, level } or { stop }. */
function vvdpWorker(model, { moduleOf, isFused } = vvdpModules(model)) {
  const loop = vvdpLoop(model), numbers = vvdpNumbers(model, loop), at = loop.places;
  const MOST_BYTES = 1.5e9, BREATH_MS = 15;

  const { vectorsFor } = vvdpValues(model, loop);

  function checkUntil(until) {
    const s = { ...model.stepping, until }, lasts = until - s.begin;
    if (!(Number.isFinite(until) && lasts > 0)) throw new Error(`until = ${until} s; must be greater than ${s.begin} s`);
    const numbers = ["y", "command", "memory"].reduce((sum, name) => sum + model.arrays[name].shape[0], 1 + model.outputs);
    const rows = lasts / s.record_interval + Math.min(s.window, lasts) / s.window_interval;
    if (rows * numbers * 8 > MOST_BYTES) throw new Error(`until = ${until} s: ${rows.toPrecision(3)} rows to record are too many for a page; the command line takes them`);
    return s.average_from === null ? {} : { average_from: (s.average_from / model.stepping.until) * until };
  }

  let running = 0, last = Promise.resolve();
  /* Lets messages in; a timer would take 4 ms each time. */
  const breath = () => new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => { port1.close(); resolve(); };
    port2.postMessage(null);
  });

  /* A run to its end, or to where it is stopped; `reach` hears how far it is. */
  async function run({ values = {}, until = model.stepping.until, level = "exact" }, reach, isStopped) {
    const module = await moduleOf(level);
    const means = until === model.stepping.until ? {} : checkUntil(until);
    const vectors = vectorsFor(values), began = performance.now();
    const call = loop.begin(module, { until, ...means }, vectors);
    let answer = at.paused, breathed = began;
    while (answer === at.paused && !isStopped()) {
      answer = call.portion();
      if (performance.now() - breathed < BREATH_MS) continue;
      reach(call.time / until);
      await breath();
      breathed = performance.now();
    }
    if (answer !== at.done && answer !== at.paused) throw new Error(call.failure(answer));
    return { level, ...numbers.summary(call, answer === at.done, (performance.now() - began) / 1000), ...numbers.series(call) };
  }

  return {
    run: (wanted, reach) => {
      const mine = ++running, found = last.then(() => run(wanted, reach, () => mine !== running || mine === stopped));
      last = found.catch(() => {});
      return found;
    },
    stop: () => { stopped = running; },
    moduleOf, isFused,
  };
}
var stopped = -1;

if (typeof WorkerGlobalScope !== "undefined") {
  let worker = null;
  self.onmessage = async ({ data }) => {
    if (data.model) {
      worker = vvdpWorker(data.model);
      await worker.moduleOf("exact");
      self.postMessage({ ready: true, isFused: worker.isFused });
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
