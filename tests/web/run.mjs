// Carries a system out in its module and writes what it leaves: node run.mjs SCRIPTS MODEL JOB OUT
import fs from "node:fs";

const [, , scripts, modelFile, job, out] = process.argv;
const text = ["loop.js", "numbers.js", "values.js", "worker.js"].map((name) => fs.readFileSync(`${scripts}/${name}`, "utf8")).join("\n");
const { vvdpLoop, vvdpModules, vvdpValues, vvdpWorker } = new Function(`${text}; return { vvdpLoop, vvdpModules, vvdpValues, vvdpWorker };`)();
const model = JSON.parse(fs.readFileSync(modelFile, "utf8"));
const { values, what, level } = JSON.parse(job), modules = vvdpModules(model), module = await modules.moduleOf(level);

if (what === "imports") {
  console.log(JSON.stringify([WebAssembly.Module.imports(module), modules.isFused]));
} else if (what === "step") {
  const call = vvdpLoop(model).begin(module, {}), before = call.get("clock")[model.places.steps];
  call.numbers.budget = 1;
  while (call.get("clock")[model.places.steps] < before + values.steps) call.portion();
  console.log(JSON.stringify([...call.get("y")]));
} else if (what === "run") {
  const { summary, warnings, series } = await vvdpWorker(model, modules).run({ values, level }, () => {});
  console.log(JSON.stringify({ summary, warnings, rows: series.time_s?.length, keys: Object.keys(series) }));
} else {
  const loop = vvdpLoop(model), at = loop.places, { vectorsFor } = vvdpValues(model, loop), vectors = vectorsFor(values);
  const call = loop.begin(module, {}, vectors);
  let answer = at.paused;
  while (answer === at.paused) answer = call.portion();
  const clock = call.get("clock"), counts = { record: clock[at.records], mark: clock[at.stored], span: clock[at.spans] };
  const whole = { answer, bytes: {} }, rows = [];
  for (const [name, one] of Object.entries(call.arrays)) {
    const count = counts[/^(record|mark|span)_?/.exec(name)?.[1]] ?? one.shape[0];
    const width = one.shape.slice(1).reduce((a, b) => a * b, 1), values = call.get(name).slice(0, count * width);
    whole.bytes[name] = values.byteLength;
    rows.push(Buffer.from(values.buffer, values.byteOffset, values.byteLength));
  }
  fs.writeFileSync(out, Buffer.concat(rows));
  console.log(JSON.stringify(whole));
}
