"use strict";
/* The page: sliders and numbers, notes, charts of a run as computed and as set. `vvdp.run` is for other scripts. */
const vvdp = (() => {
  const model = JSON.parse(document.getElementById("model").textContent);
  const url = URL.createObjectURL(new Blob([document.getElementById("worker").textContent], { type: "text/javascript" }));
  const worker = new Worker(url), waiting = new Map();
  const place = (id) => document.getElementById(id);
  let count = 0, latest = 0, draft = "exact", running = null, next = null;
  const set = {};

  worker.onmessage = ({ data }) => {
    if (data.ready) { draft = data.isFused || !model.modules.quick ? "exact" : "quick"; readied(); return; }
    const mine = waiting.get(data.id);
    if (data.reach !== undefined) { mine?.reach(data.reach); return; }
    waiting.delete(data.id);
    if (data.fault !== undefined) mine?.reject(new Error(data.fault));
    else mine?.resolve(data.found);
  };
  let readied = null;
  const ready = new Promise((resolve, reject) => {
    readied = resolve;
    worker.onerror = (problem) => reject(new Error(`the run cannot be worked out here: ${problem.message}`));
  });
  worker.postMessage({ model });

  async function send(wanted, reach = () => {}) {
    await ready;
    const id = ++count;
    return new Promise((resolve, reject) => {
      waiting.set(id, { resolve, reject, reach });
      worker.postMessage({ id, wanted });
    });
  }

  const node = (name, attributes = {}, ...children) => {
    const found = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) found.setAttribute(key, value);
    found.append(...children);
    return found;
  };

  const shown = (value, { scale, datum }) => {
    if (typeof value === "boolean") return value ? "yes" : "no";
    return Number.isFinite(value) ? String(Number(((value - datum) / scale).toPrecision(4))) : "\u2013";
  };

  /* Key numbers as computed and as set, side by side. */
  function showNumbers(found) {
    document.body.classList.toggle("is-set", Boolean(found));
    showCells(found);
    showTexts(found);
    if (model.report) return;
    const hidden = new Set(["wall_time_s", "finished"]);
    const rows = Object.entries(model.labels).filter(([key]) => !hidden.has(key)).map(([key, unit]) => {
      const before = model.summary[key], now = found ? found[key] : undefined;
      const moved = now !== undefined && shown(now, unit) !== shown(before, unit);
      return node("tr", {}, node("td", {}, unit.label), node("td", { class: "n" }, shown(before, unit)),
        node("td", { class: moved ? "n moved" : "n" }, now === undefined ? "" : shown(now, unit)), node("td", { class: "u" }, unit.symbol));
    });
    const head = node("tr", {}, ...["", "as computed", "as you set it", ""].map((word) => node("th", word && { class: "n" } || {}, word)));
    place("key-numbers").replaceChildren(node("table", {}, node("thead", {}, head), node("tbody", {}, ...rows)));
  }

  /* What powers of sources add up to, into the circuit and out of it. */
  function withSums(found) {
    const powers = Object.entries(found).flatMap(([key, x]) => (key.startsWith("power_") ? [x] : []));
    const sum = (sign) => powers.reduce((whole, x) => whole + Math.max(sign * x, 0), 0);
    return { ...found, put_in: sum(1), given_out: sum(-1) };
  }

  /* The listings of a report: below what was computed, what was set. */
  function showCells(found) {
    const now = found && withSums(found);
    for (const [name, cells] of Object.entries(model.cells ?? {})) {
      const rows = document.querySelectorAll(`[data-listing="${name}"] tbody tr:not(.group)`);
      for (const [row, at, key, before, unit] of cells) {
        const cell = rows[row].cells[1 + at];
        cell.querySelector(".now")?.remove();
        if (now?.[key] === undefined) continue;
        const words = shown(now[key], unit);
        cell.append(node("span", { class: words === shown(before, unit) ? "now" : "now moved" }, words));
      }
    }
  }

  /* The values in the diagrams of a report. */
  function showTexts(found) {
    for (const [name, texts] of Object.entries(model.texts ?? {})) {
      const lines = document.querySelectorAll(`#figure-${name} svg tspan`);
      for (const line of lines) {
        if (line.dataset.before !== undefined) line.textContent = line.dataset.before;
        line.classList.remove("moved");
      }
      for (const [at, before, words, key, unit] of found ? texts : []) {
        if (found[key] === undefined) continue;
        const now = `${words} ${shown(found[key], unit)} ${unit.symbol}`, line = lines[at];
        line.dataset.before ??= line.textContent;
        if (now === before) continue;
        line.textContent = line.textContent.replace(before, now);
        line.classList.add("moved");
      }
    }
  }

  function showNotes(now) {
    const lines = (title, words) => words.map((each) => node("div", { class: "notice" }, node("strong", {}, title), node("p", {}, each)));
    const computed = model.report ? [] : lines("As computed", model.warnings), own = now ? lines("As you set it", now) : [];
    place("notes").replaceChildren(...computed, ...own);
  }

  function showSetting() {
    const words = Object.entries(set).map(([setting, number]) => {
      const unit = model.values.find((each) => each.setting === setting).unit;
      return unit ? ` --set '${setting}="${number} ${unit}"'` : ` --set ${setting}=${number}`;
    });
    const until = untilSet();
    const line = `${model.command}${words.join("")}${until === model.stepping.until ? "" : ` --until "${until} s"`}`;
    place("setting").hidden = !words.length && until === model.stepping.until;
    place("setting").querySelector("code").textContent = line;
    writeAddress(until);
  }

  /* What is set stands in the address behind "#", which stays in the browser: a link repeats it. */
  function writeAddress(until) {
    const told = new URLSearchParams({ ...set, ...(until === model.stepping.until ? {} : { until }) }).toString();
    if (told || location.hash.includes("=")) history.replaceState(null, "", `#${told}`);
  }

  /* Sets what the address tells, all of it or nothing. */
  function readAddress() {
    if (!location.hash.includes("=")) return;
    const told = [...new URLSearchParams(location.hash.slice(1))], boxes = [];
    for (const [setting, number] of told) {
      if (setting === "until") continue;
      const at = model.values.findIndex((each) => each.setting === setting);
      if (at < 0) { fault(`the address: ${setting.slice(0, 60)} is no value of this system`); return; }
      if (model.values[at].why_not) { fault(`the address: ${setting} stays as it is on this page: ${model.values[at].why_not}`); return; }
      boxes.push([document.querySelector(`.value[data-place="${at}"]`), number.slice(0, 60)]);
    }
    for (const [box, number] of boxes) change(box, number);
    const until = told.find(([setting]) => setting === "until");
    if (until) place("until").value = until[1].slice(0, 20);
    soon();
  }

  const untilSet = () => Number(place("until").value.replace(",", "."));

  function fault(words) {
    place("fault").hidden = !words;
    place("fault").textContent = words || "";
  }

  /* The charts with what was set over what was computed, which is dotted and paler then. */
  async function showCharts(series) {
    const page = await vvdpCharts;
    for (const [name, panels] of Object.entries(model.charts)) {
      const live = page.open(name);
      live.first ??= live.described;
      const columns = [], at = (values) => -1 - (columns.push(values) - 1);
      const scaled = (key, [scale, datum]) => Float64Array.from(series[key], (x) => (x - datum) / scale);
      const described = { ...live.first, panels: live.first.panels.map((panel, p) => ({ ...panel, lines: panel.lines.flatMap((line, i) => {
        const own = series && panels[p][i];
        if (!own) return [line];
        const stroke = line.stroke === "steps" ? "steps" : ":";
        const before = { ...line, label: `${line.label}, as computed`, stroke, colour: `${line.colour}99`, width: 1 };
        return [before, { ...line, x: at(scaled("time_s", own.x)), y: at(scaled(own.key, own.y)) }];
      }) })) };
      if (series) described.panels = described.panels.map((panel) => ({ ...panel, levels: [] }));
      const column = (i) => (i < 0 ? columns[-1 - i] : page.column(i));
      if (live.fits(described)) { live.update(described, column); continue; }
      live.close();
      page.live.set(name, Object.assign(new LiveChart(described, live.figure, column), { first: live.first }));
    }
  }

  function busy(is) {
    place("stop").disabled = !is;
    place("state").textContent = is ? "running" : place("state").textContent;
  }

  async function runNow(level = "exact") {
    const mine = ++latest;
    fault("");
    showSetting();
    busy(true);
    try {
      const began = performance.now();
      const found = await send({ values: { ...set }, until: untilSet(), level }, (reach) => { if (mine === latest) place("reach").value = reach; });
      if (mine !== latest) return;
      showNumbers(found.summary);
      showNotes(found.warnings);
      scope.show(found);
      moving.show(found.moving);
      await showCharts(found.series);
      place("level").textContent = found.level;
      place("state").textContent = `${found.summary.finished ? "done" : "stopped"} in ${((performance.now() - began) / 1000).toPrecision(2)} s`;
    } catch (problem) {
      if (mine === latest) { fault(problem.message); place("state").textContent = "no result"; }
    } finally {
      if (mine === latest) busy(false);
    }
  }

  const scope = vvdpScope(place(`figure-${Object.keys(model.figures)[0]}`));
  const moving = vvdpMotion(model, () => send({ values: { ...set }, until: untilSet() }).then(
    (found) => { scope.show(found); return found.moving; }, (problem) => { fault(problem.message); return null; }));

  /* Runs what is set: at once in place of a run in progress, but behind one that shows what is being dragged. */
  async function soon(isDragged = false) {
    next = { isDragged };
    if (running?.isDragged) return;
    while (next) {
      const mine = (running = next);
      next = null;
      await runNow(mine.isDragged ? draft : "exact");
      if (running !== mine) return;
    }
    running = null;
  }

  /* A value from its slider or its number; what is not one is left to the worker to refuse. */
  function change(box, text, isDragged) {
    const value = model.values[Number(box.dataset.place)], number = text.trim().replace(",", ".");
    const [slider, field] = box.querySelectorAll("input");
    if (field !== document.activeElement || Number(number) === value.number) field.value = number;
    if (Number.isFinite(Number(number))) slider.value = number;
    const isSame = number !== "" && Number(number) === value.number;
    if (isSame) delete set[value.setting];
    else set[value.setting] = number;
    box.classList.toggle("changed", !isSame);
    soon(isDragged);
  }

  function reset() {
    latest++;
    next = running = null;
    worker.postMessage({ stop: true });
    for (const box of document.querySelectorAll(".value")) {
      const value = model.values[Number(box.dataset.place)];
      box.querySelectorAll("input").forEach((input) => { input.value = value.number; });
      box.classList.remove("changed");
      delete set[value.setting];
    }
    place("until").value = model.stepping.until;
    place("reach").value = 0;
    place("state").textContent = "";
    place("level").textContent = "exact";
    fault("");
    showSetting();
    showNumbers(null);
    showNotes(null);
    showCharts(null);
    scope.show(null);
    moving.show(null);
    busy(false);
  }

  for (const box of document.querySelectorAll(".value")) {
    const value = model.values[Number(box.dataset.place)], [slider, field] = box.querySelectorAll("input");
    const step = Number(slider.dataset.step);
    slider.addEventListener("input", () => {
      const at = Number(slider.value), isEnd = at <= value.low || at >= value.high;
      const number = isEnd ? at : Number((value.low + Math.round((at - value.low) / step) * step).toPrecision(6));
      change(box, String(Math.min(Math.max(number, value.low), value.high)), true);
      field.value = set[value.setting] ?? value.number;
    });
    slider.addEventListener("change", () => soon());
    field.addEventListener("change", () => change(box, field.value));
  }
  place("start").addEventListener("click", () => soon());
  place("stop").addEventListener("click", () => worker.postMessage({ stop: true }));
  place("reset").addEventListener("click", reset);
  place("until").addEventListener("change", () => soon());
  place("until").value = model.stepping.until;
  for (const name of [...Object.keys(model.charts), ...Object.keys(model.texts ?? {})]) place(`figure-${name}`).classList.add("follows");
  showNumbers(null);
  showNotes(null);
  readAddress();
  window.addEventListener("hashchange", readAddress);

  return {
    model,
    run: async ({ values = {}, until, level } = {}) => {
      const { summary, series } = await send({ values, ...(until === undefined ? {} : { until }), ...(level === undefined ? {} : { level }) });
      return { summary, series };
    },
    stop: () => worker.postMessage({ stop: true }),
  };
})();
window.vvdp = vvdp;
