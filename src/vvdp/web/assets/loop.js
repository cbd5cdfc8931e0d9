"use strict";
/* A system in its WebAssembly module: the call of the compiled loop, in portions. Used by a page's worker, and in tests. */
function vvdpLoop(model) {
  const at = model.places, KINDS = { f8: Float64Array, i8: BigInt64Array };
  const PORTION = 5000, MORE = 2;

  function unpack(one) {
    if (!one.bytes) return new KINDS[one.kind](one.shape.reduce((count, n) => count * n, 1));
    const text = atob(one.bytes), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new KINDS[one.kind](bytes.buffer);
  }

  /* Whole numbers as Python and NumPy round them: halves to the even one. */
  function round(x) {
    const low = Math.floor(x), rest = x - low;
    return rest < 0.5 || (rest === 0.5 && low % 2 === 0) ? low : low + 1;
  }

  /* A number of so many digits as Python's format "g" has it. */
  function plain(x, digits = 6) {
    if (!Number.isFinite(x)) return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
    const [mantissa, power] = x.toExponential(digits - 1).split("e"), size = Math.abs(power);
    if (x === 0 || (power >= -4 && power < digits)) return String(Number(x.toPrecision(digits)));
    return `${Number(mantissa)}e${power[0]}${String(size).padStart(2, "0")}`;
  }

  function recordTimes(s) {
    const first = Math.ceil(s.begin / s.record_interval - 1e-9), times = [];
    for (let i = first; i < round(s.until / s.record_interval) + 1; i++) times.push(Math.max(i * s.record_interval, s.begin));
    const begin = Math.max(s.begin, s.until - s.window), count = round((s.until - begin) / s.window_interval) + 1;
    for (let i = 0; i < count; i++) times.push(begin + i * s.window_interval);
    times.push(s.begin);
    const sorted = Float64Array.from(times).sort();
    const kept = sorted.filter((t, i) => i === 0 || t - sorted[i - 1] > 0);
    return kept
      .filter((t, i) => i === 0 || t - kept[i - 1] > 1e-3 * s.window_interval)
      .filter((t) => t <= s.until * (1 + 1e-12))
      .map((t) => Math.min(t, s.until));
  }

  function meansFrom(s, end) {
    if (s.average_from === null) return s.begin;
    if (s.average_from < end) return Math.max(s.begin, s.average_from);
    const middle = 0.5 * (s.begin + end), sample = round(middle / s.sample_period) * s.sample_period;
    return s.begin <= sample && sample < end ? sample : middle;
  }

  function spanTimes(s) {
    if (s.average_from === null) return new Float64Array(0);
    const first = meansFrom(s, s.until);
    let third = (s.until - first) / 3;
    third = s.sample_period * Math.floor((third / s.sample_period) * (1 + 1e-9)) || third;
    const times = [first, ...[3, 2, 1].map((n) => s.until - third * n)].map((t) => Math.max(t, first));
    return Float64Array.from(times, (t) => {
      const sample = round(t / s.sample_period) * s.sample_period;
      return Math.abs(t - sample) < 1e-9 * s.sample_period ? sample : t;
    });
  }

  /* The arrays of a run by name, each { shape, values } where it begins with numbers, else { shape }. */
  function arraysOf(s, vectors, marks) {
    const found = {}, records = recordTimes(s), spans = spanTimes(s);
    for (const [name, one] of Object.entries(model.arrays)) found[name] = { kind: one.kind, shape: one.shape, values: unpack(one) };
    for (const [name, values] of Object.entries(vectors)) found[name].values = values;
    const n = found.y.shape[0], rows = records.length;
    found.clock.values[at.time] = s.begin;
    Object.assign(found, {
      record_times: { shape: [rows], values: records }, record: { shape: [rows, n] },
      record_command: { shape: [rows, found.command.shape[0]] }, record_memory: { shape: [rows, found.memory.shape[0]] },
      mark_times: { shape: [marks] }, mark_states: { shape: [marks, n] },
      span_times: { shape: [spans.length], values: spans }, span_states: { shape: [spans.length, n] },
      low: { shape: [n], values: found.y.values }, high: { shape: [n], values: found.y.values },
    });
    return found;
  }

  const numbersIn = (shape) => shape.reduce((a, b) => a * b, 1);

  /* Places everything in memory: arrays, records of arrays, then the slots of the call. */
  class Call {
    constructor(instance, memory, stepping, vectors) {
      this.instance = instance; this.memory = memory; this.stepping = stepping; this.marks = 256;
      this.end = (instance.exports.__heap_base.value + 15) & ~15;
      this.arrays = arraysOf(stepping, vectors, this.marks);
      this.records = { pattern: {}, bench: {} };
      for (const [name, one] of Object.entries(model.pattern)) this.records.pattern[name] = { kind: one.kind, shape: one.shape, values: unpack(one) };
      for (const [name, shape] of Object.entries(model.bench)) this.records.bench[name] = { shape };
      for (const group of [this.arrays, ...Object.values(this.records)]) for (const one of Object.values(group)) this.place(one);
      this.numbers = { t_end: stepping.until, longest: stepping.longest_step, marks_from: stepping.begin, method: stepping.method, budget: PORTION, overwrite: 0 };
      this.count = this.words().length;
      this.slots = this.room(8 * (this.count + 2));
    }

    room(bytes) {
      const found = this.end;
      this.end += (bytes + 15) & ~15;
      const lacking = this.end - this.memory.buffer.byteLength;
      if (lacking > 0) this.memory.grow(Math.ceil(lacking / 65536));
      return found;
    }

    place(one) {
      one.address = this.room(8 * numbersIn(one.shape));
      if (one.values) this.view(one).set(one.values);
      else this.view(one).fill(one.kind === "i8" ? 0n : 0);
    }

    view(one) {
      return new KINDS[one.kind || "f8"](this.memory.buffer, one.address, numbersIn(one.shape));
    }

    get(name) {
      return this.view(this.arrays[name]);
    }

    /* The arguments as whole numbers of 8 bytes. */
    words() {
      const bits = new DataView(new ArrayBuffer(8)), found = [];
      const arrayWords = (one) => [BigInt(one.address), ...one.shape.map(BigInt)];
      for (const each of model.arguments) {
        if (each.is === "array") found.push(...arrayWords(this.arrays[each.name]));
        else if (each.is === "int") found.push(BigInt(this.numbers[each.name]));
        else if (each.is === "float") { bits.setFloat64(0, this.numbers[each.name]); found.push(bits.getBigInt64(0)); }
        else {
          const group = this.records[each.name], inner = each.fields.flatMap((name) => arrayWords(group[name]));
          const block = (this.blocks ??= {})[each.name] ??= this.room(8 * inner.length);
          new BigInt64Array(this.memory.buffer, block, inner.length).set(inner);
          found.push(BigInt(block));
        }
      }
      return found;
    }

    /* Carries the run on by a portion; what the loop answers. Throws where the model raises. */
    portion() {
      const words = this.words();
      new BigInt64Array(this.memory.buffer, this.slots, words.length + 2).set([...words, 0n, 0n]);
      this.instance.exports.vvdp_run(this.slots);
      const [answer, failed] = new BigInt64Array(this.memory.buffer, this.slots + 8 * words.length, 2);
      this.fail(failed);
      if (Number(answer) === at.marks_full) { this.widen(); return at.paused; }
      return Number(answer);
    }

    fail(number) {
      if (number) throw new Error(`the run ended at t = ${plain(this.time)} s: ${model.reasons[String(number)] ?? "a check failed"}`);
    }

    /* Readies a call of a function that takes a time and arrays, each { address, count }; `which` goes before the time. */
    entry(name, arrays, which) {
      const words = [...(which === undefined ? [] : [BigInt(which)]), 0n, ...arrays.flatMap(({ address, count }) => [BigInt(address), BigInt(count)])];
      const slots = this.room(8 * (words.length + 2)), at = words.length - 2 * arrays.length - 1;
      new BigInt64Array(this.memory.buffer, slots, words.length).set(words);
      const numbers = new BigInt64Array(this.memory.buffer, slots, words.length + 2), floats = new Float64Array(this.memory.buffer, slots, words.length);
      return (time, addresses = []) => {
        numbers[words.length + 1] = 0n;
        floats[at] = time;
        addresses.forEach((address, i) => { numbers[at + 1 + 2 * i] = BigInt(address); });
        this.instance.exports[name](slots);
        this.fail(numbers[words.length + 1]);
      };
    }

    vector(name) {
      const one = this.arrays[name];
      return { address: one.address, count: numbersIn(one.shape) };
    }

    scratch(name, count) {
      return ((this.scratches ??= {})[name] ??= { address: this.room(8 * Math.max(count, 1)), count });
    }

    /* What is held between samples, worked out for the parameters at the beginning. */
    hold() {
      const [first, last] = model.held;
      if (first === last) return;
      const to = this.scratch("held", this.arrays.command.shape[0]);
      this.entry("vvdp_sample", [this.vector("y"), this.vector("command"), this.vector("memory"), this.vector("params"), to], 0)(this.time);
      this.get("command").set(new Float64Array(this.memory.buffer, to.address + 8 * first, last - first), first);
    }

    /* What the circuit holds in a state: energy, then the volume of each oil. */
    stored(state) {
      const from = this.scratch("state", state.length), to = this.scratch("stored", 64);
      new Float64Array(this.memory.buffer, from.address, from.count).set(state);
      this.entry("vvdp_stored", [from, this.vector("params"), to])(0);
      return new Float64Array(this.memory.buffer, to.address, to.count).slice();
    }

    /* Some outputs of the circuit at the recorded rows, by their places. */
    outputs(rows, places) {
      const [n, commands] = [this.arrays.record.shape[1], this.arrays.record_command.shape[1]];
      const to = this.scratch("outputs", model.outputs), found = new Map(places.map((place) => [place, new Float64Array(rows)]));
      const { address: state } = this.arrays.record, { address: command } = this.arrays.record_command;
      const outputs = this.entry("vvdp_outputs", [{ address: state, count: n }, { address: command, count: commands }, this.vector("params"), to]);
      const row = new Float64Array(this.memory.buffer, to.address, model.outputs), times = this.get("record_times");
      for (let i = 0; i < rows; i++) {
        outputs(times[i], [state + 8 * i * n, command + 8 * i * commands]);
        for (const [place, column] of found) column[i] = row[place];
      }
      return found;
    }

    /* Why the run could not go on, in the words of the command line. */
    failure(answer) {
      const culprit = this.get("clock")[at.culprit], state = this.get("y");
      const order = model.states.map((path, i) => [path, i]).filter(([path]) => !path.startsWith("books."));
      const rank = ([, i]) => [answer === at.below_zero && i === culprit ? 0 : 1, Number.isFinite(state[i]) ? 1 : 0, i];
      order.sort((a, b) => { const [x, y] = [rank(a), rank(b)]; return x[0] - y[0] || x[1] - y[1] || x[2] - y[2]; });
      const values = order.slice(0, 3).map(([path, i]) => `${path} = ${plain(state[i], 4)}`).join(", ");
      const more = order.length > 3 ? `, and ${order.length - 3} more` : "";
      const named = (answer === at.restless ? model.modes : model.states)[culprit] ?? "";
      const why = model.failures[answer].replace("{culprit}", () => named);
      return `the run cannot go on at t = ${plain(this.time)} s: ${why}; state: ${values}${more}`;
    }

    get time() {
      return this.get("clock")[at.time];
    }

    widen() {
      this.marks *= MORE;
      for (const name of ["mark_times", "mark_states"]) {
        const one = this.arrays[name], before = this.view(one).slice();
        one.shape = [this.marks, ...one.shape.slice(1)];
        one.values = undefined;
        this.place(one);
        this.view(one).set(before);
      }
    }
  }

  const memory = new WebAssembly.Memory({ initial: model.pages });

  /* A run from its beginning; `vectors` may replace y, command, memory, params. It takes the memory of the run before,
     which browsers are slow to free. */
  function begin(module, stepping, vectors) {
    new Uint8Array(memory.buffer, 0, model.pages * 65536).fill(0);
    const instance = new WebAssembly.Instance(module, { env: { memory } });
    const call = new Call(instance, memory, { ...model.stepping, ...stepping }, vectors || {});
    if (vectors) call.hold();
    call.initial = call.get("y").slice();
    return call;
  }

  return { begin, unpack, meansFrom, plain, places: at };
}
