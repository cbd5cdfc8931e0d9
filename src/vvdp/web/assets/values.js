"use strict";
/* Values that were set, and the numbers of the model that follow them. */
function vvdpValues(model, loop) {
  const WORK = { "+": (x, c) => x + c, "*": (x, c) => x * c, "/": (x, c) => x / c, over: (x, c) => c / x };

  const BACK = { "+": (y, c) => y - c, "*": (y, c) => y / c, "/": (y, c) => y * c, over: (y, c) => c / y };

  const follow = (steps, x) => steps.reduce((value, [operation, constant]) => WORK[operation](value, constant), x);

  /* The number in the unit of a setting that has a value [SI]. */
  const unfollow = (steps, si) => steps.reduceRight((value, [operation, constant]) => BACK[operation](value, constant), si);

  const { plain } = loop;

  /* A value [SI] of a setting from a number or a text with its unit. Throws with the reason where it cannot be. */
  function readValue(setting, given) {
    const value = model.values.find((each) => each.setting === setting);
    if (!value) throw new Error(`${setting} is no value of this system`);
    if (value.why_not) throw new Error(`${setting} stays as it is on this page: ${value.why_not}`);
    const [, number, unit] = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/.exec(String(given)) ?? [];
    const words = `'${`${String(given).trim().slice(0, 60)}${unit ? "" : ` ${value.unit}`}`.trim()}'`;
    if (number === undefined) throw new Error(`${setting}: ${words} is not a number with a unit; write for example '${value.example}'`);
    if (unit && unit !== value.unit) throw new Error(`${setting}: write the number in ${value.unit || "no unit"}, not in ${JSON.stringify(unit).slice(0, 40)}`);
    const si = follow(value.steps, Number(number)), written = value.unit ? `${words} = ` : "";
    if (!Number.isFinite(si)) throw new Error(`${setting}: ${written}${plain(si)} is not a finite number; expected ${value.kind}, for example '${value.example}'`);
    if (!(value.least <= si && si <= value.most)) throw new Error(`${setting}: ${words} is outside ${[value.least, value.most].map((end) => plain(unfollow(value.steps, end))).join(" to ")}${value.unit && ` ${value.unit}`} for ${value.kind}`);
    if (!(value.low <= Number(number) && Number(number) <= value.high)) throw new Error(`${setting}: ${number} ${value.unit} is beyond what this page has been tried with, ${value.low} to ${value.high} ${value.unit}; the command line takes it`);
    return { value, number: Number(number), si };
  }

  /* The vectors of a case with other values; null where there are none. Throws where two act on one number. */
  function vectorsFor(values) {
    const found = {}, touched = new Map();
    for (const [setting, given] of Object.entries(values)) {
      const { value, number, si } = readValue(setting, given);
      if (number === value.number) continue;
      for (const [name, place, operation, constant] of value.followers) {
        const key = `${name} ${place}`;
        if (touched.has(key)) throw new Error(`${setting} and ${touched.get(key)} act together; change one of them`);
        touched.set(key, setting);
        found[name] ??= loop.unpack(model.arrays[name]);
        found[name][place] = WORK[operation](si, constant);
      }
    }
    return Object.keys(found).length ? found : null;
  }

  return { readValue, vectorsFor };
}
