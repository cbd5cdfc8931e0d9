const RELEASE = 150; // ms after a slider is let go, the whole run replaces drafts
const MOST_RUNS = 20;
const $ = (id) => document.getElementById(id);
const live = new Map();
const state = { system: "", text: "", saved: "", saves: false, changes: new Map(), past: [], rows: [], asked: 0, answered: 0, runs: [], shown: null, wanted: null, figures: null, disk: "" };
let socket = null;
let timer = 0;
let counting = 0;

/** Sends a request; only the newest is worked out. */
function ask(kind, more = {}) {
  state.asked += 1;
  const text = state.text === state.saved ? {} : { text: state.text };
  const view = { series: added.names, ...(kind === "draft" ? { charts: [...live.keys()], moves: $("teach").open } : {}) };
  const message = { n: state.asked, kind, system: state.system, set: [...state.changes.values()], ...view, ...text, ...more };
  clearInterval(counting);
  if (kind === "whole") say("running …");
  $("stop").disabled = kind !== "whole";
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  return message.n;
}

/** Words on the way; a time that is left counts down. */
function sayWhile(words) {
  clearInterval(counting);
  const [, what, seconds] = /^(compiling).* about (\d+) s$/.exec(words) ?? [];
  if (!what) { say(words); return; }
  const ends = performance.now() + 1000 * seconds;
  const tick = () => say(`${what}, about ${Math.max(1, Math.ceil((ends - performance.now()) / 1000))} s left`);
  tick();
  counting = setInterval(tick, 500);
}

function say(words) { $("state").textContent = words; }

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { if (state.system) ask("whole"); };
  socket.onmessage = ({ data }) => receive(...unpack(data));
  socket.onclose = () => { say("server lost; what is shown stays, trying again"); setTimeout(connect, 1000); };
}

/** A packet as its description and a function that gives its columns. */
function unpack(data) {
  const size = Number(new DataView(data).getBigUint64(0, true));
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 8, size)));
  const columns = (head.columns ?? []).map(([at, count, width]) => new (width === 8 ? Float64Array : Float32Array)(data, 8 + size + at, count));
  return [head, (place) => columns[place]];
}

function receive(head, column) {
  if (head.kind === "disk") { takeDisk(head); return; }
  if (head.kind === "words") { if (head.n === state.asked) sayWhile(head.words); return; }
  state.answered = head.n;
  if (head.kind !== "draft" && head.n !== state.asked) return;
  clearInterval(counting);
  const charts = (head.charts ?? []).map((each) => ({ ...each, column }));
  if (head.kind === "series") { takeSeries(charts); return; }
  showFaults(head.faults ?? []);
  if (head.faults) { document.body.classList.add("is-old"); say("not valid"); $("stop").disabled = true; return; }
  if (head.svg) showDiagram(head.svg);
  if (head.means) showMeans(head.means);
  if (head.course) showCourse(unpackCourse(head.course, column));
  if (head.values) showValues(head.values);
  if (head.title) document.title = `${head.title} · vvdp workbench`;
  if (head.kind === "drawing") { document.body.classList.add("is-old"); say("drawn; not yet run"); }
  if (head.charts) { if (head.kind === "figures") state.figures = { charts }; showCharts(charts); }
  if (head.kind === "draft") document.body.classList.add("is-draft");
  if (head.kind === "figures") { document.body.classList.remove("is-draft"); document.body.classList.add("is-old"); }
  if (head.kind === "numbers") showNumbers(head);
}

function showNumbers(head) {
  document.body.classList.remove("is-draft", "is-old");
  $("stop").disabled = true;
  say(head.finished ? "run complete" : "stopped: results so far");
  $("badges").replaceChildren(...head.badges.map(([grade, words]) => element("span", { class: `badge ${grade}` }, words)));
  $("findings").replaceChildren(...head.findings.map(([grade, title, text, remedy]) =>
    element("p", { class: grade }, ...(title ? [element("b", {}, `${title}: `)] : []), text, ...(remedy ? [" ", remedy] : []))));
  const page = new DOMParser().parseFromString(head.listings, "text/html");
  $("listings").replaceChildren(...[...page.body.childNodes].map((each) => document.importNode(each, true)));
  $("line").textContent = head.line;
  showKnownSeries(head.series);
  keep(head);
}

/** Charts in place of those of the same form; only what is chosen is drawn, and a draft has no other. */
function showCharts(charts) {
  const names = state.figures?.charts.map((each) => each.name) ?? charts.map((each) => each.name);
  if (state.wanted === null || !names.some((name) => state.wanted.has(name))) state.wanted = new Set(names.slice(0, 1));
  $("chosen").replaceChildren(...names.map((name) => {
    const button = element("button", { type: "button", "aria-pressed": String(state.wanted.has(name)) }, name.replaceAll("-", " "));
    button.addEventListener("click", () => { if (!state.wanted.delete(name)) state.wanted.add(name); redrawCharts(); });
    return button;
  }));
  for (const [name, { figure }] of live) if (!state.wanted.has(name) || !names.includes(name)) { figure.remove(); live.delete(name); }
  for (const described of charts.filter((each) => state.wanted.has(each.name))) showChart(withOthers(described));
}

/** The charts of the last whole run again: what is chosen, or lies over them, has changed. */
function redrawCharts() { if (state.figures) showCharts(state.figures.charts); }

function showChart(described) {
  const found = live.get(described.name);
  if (found?.chart.fits(described)) { found.chart.update(described, described.column); return; }
  found?.chart.close();
  found?.figure.remove();
  const figure = element("figure");
  const height = 150 + 130 * described.panels.length;
  const still = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  still.setAttribute("height", String(described.sideBySide ? 330 : height));
  figure.append(still);
  $("charts").append(figure);
  live.set(described.name, { chart: new LiveChart(described, figure, described.column), figure });
}

/** The chart with the lines of the selected other runs, dashed, and measured ones, dotted, on the same axes. */
function withOthers(described) {
  const others = state.runs.filter((run) => run.on && run.figures !== state.figures);
  if (!others.length && !measured.laid.length) return described;
  const stride = 100000;
  const laid = [];
  const sources = [described.column];
  const ofOther = (panel, i, run) => {
    const chart = run.figures.charts.find((each) => each.name === described.name);
    const own = [chart?.panels[i], ...(chart?.panels ?? [])].find((each) => each?.title === panel.title && each.y?.label === panel.y.label);
    if (!own) return [];
    const begin = stride * (sources.push(chart.column) - 1);
    return own.lines.map((line) => ({ ...line, x: line.x + begin, y: line.y + begin, low: undefined, high: undefined, stroke: "--", label: `${line.label} (${run.name})` }));
  };
  const panels = described.panels.map((panel, i) => panel.kind !== "lines" ? panel : { ...panel, lines: [...panel.lines, ...others.flatMap((run) => ofOther(panel, i, run))] });
  const first = stride * (sources.push((place) => laid[place]) - 1);
  const whole = panels.map((panel) => panel.kind !== "lines" ? panel : { ...panel, lines: [...panel.lines, ...laidLines(panel, first, laid)] });
  return { ...described, panels: whole, column: (place) => sources[Math.floor(place / stride)](place % stride) };
}

function keep(head) {
  const words = [...state.changes.values()].join(", ") || "as in the file";
  if (state.runs.at(-1)?.words !== words || state.runs.at(-1)?.text !== state.text)
    state.runs.push({ name: `run ${(state.runs.at(-1)?.number ?? 0) + 1}`, number: (state.runs.at(-1)?.number ?? 0) + 1, words, text: state.text, result: head.result, labels: head.labels, figures: state.figures, on: false, finished: head.finished });
  state.runs = state.runs.slice(-MOST_RUNS);
  showRuns();
}

function showRuns() {
  $("runs").replaceChildren(...state.runs.map((run) => {
    const box = element("input", { type: "checkbox", "aria-label": `Compare ${run.name}` });
    box.checked = run.on;
    box.addEventListener("change", () => { run.on = box.checked; showCompared(); redrawCharts(); });
    return element("label", { class: "kept" }, box, element("b", {}, run.name), element("span", {}, run.words), element("small", {}, run.finished ? (run.result.trusted === false ? "not valid" : run.result.settled === false ? "not settled" : "") : "interrupted"));
  }));
  showCompared();
}

/** The numbers of the selected runs that differ, side by side. */
function showCompared() {
  const on = state.runs.filter((run) => run.on);
  if (on.length < 2) { $("compared").replaceChildren(); return; }
  const keys = Object.keys(on[0].labels).filter((key) => on.some((run) => run.result[key] !== on[0].result[key]));
  const head = element("tr", {}, element("th", {}, "SI units"), ...on.map((run) => element("th", { class: "n" }, run.name)));
  const rows = keys.map((key) => element("tr", {}, element("th", { title: key }, on[0].labels[key]), ...on.map((run) => element("td", { class: "n" }, typeof run.result[key] === "number" ? formatNumber(run.result[key]) : String(run.result[key] ?? "not known")))));
  const settings = on.map((run) => new Map(run.words.split(", ").map((words) => words.split("="))));
  const changed = [...new Set(settings.flatMap((each) => [...each.keys()]))].filter((key) => key.includes("."));
  const values = changed.map((key) => element("tr", {}, element("th", { title: key }, key), ...settings.map((each) => element("td", { class: "n" }, each.get(key) ?? "as in the file"))));
  $("compared").replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...values, ...rows)));
}

function showFaults(faults) {
  const words = (each) => [each.line ? `line ${each.line}` : "", each.key, each.message].filter(Boolean).join(": ");
  const rows = new Map([...document.querySelectorAll(".value")].map((row) => [row.dataset.key, row]));
  const last = [...state.changes.keys()].at(-1); // what was changed last is the likeliest cause of a fault without a field
  const beside = (each) => rows.get(each.key) ?? (state.text === state.saved ? rows.get(last) : undefined);
  for (const old of document.querySelectorAll(".wrong")) old.remove();
  for (const each of faults) beside(each)?.append(element("span", { class: "wrong" }, each.message));
  $("faults").hidden = !faults.length;
  $("faults").textContent = faults.map(words).join("\n");
  numberLines(new Set(faults.map((each) => each.line)));
}

function numberLines(wrong = new Set()) {
  const count = $("text").value.split("\n").length;
  const lines = [];
  for (let i = 1; i <= count; i++) lines.push(wrong.has(i) ? element("b", {}, String(i)) : String(i), "\n");
  $("numbers-of-lines").replaceChildren(...lines);
}

/** The values as a table; while one is dragged the rows stay. */
function showValues(rows) {
  const form = JSON.stringify(rows.map((row) => [row.key, row.unit]));
  rows.sort((a, b) => b.key.startsWith("operation.") - a.key.startsWith("operation."));
  state.rows = rows;
  if ($("values").dataset.form === form) { refresh(); return; }
  $("values").dataset.form = form;
  let table = "";
  $("values").replaceChildren(...rows.flatMap((row) => {
    const [head] = row.key.split(/\.(?=[^.]*$)/);
    const group = head === table ? [] : [element("div", { class: "group" }, head)];
    table = head;
    return [...group, valueRow(row)];
  }));
  markChanged();
}

/** Shows the numbers of the last run in the fields, but in what is being moved. */
function refresh() {
  const known = new Map(state.rows.map((row) => [row.key, row]));
  for (const made of document.querySelectorAll(".value")) {
    const row = known.get(made.dataset.key);
    if (made.dataset.key === dragged || row.number === undefined) continue;
    for (const field of made.querySelectorAll("input")) if (field.type === "range" || field !== document.activeElement) field.value = String(Number(row.number.toPrecision(6)));
  }
}

function valueRow(row) {
  const name = row.key.slice(row.key.lastIndexOf(".") + 1).replaceAll("_", " ");
  const id = `value-${row.key}`;
  const made = element("div", { class: "value" }, element("label", { for: id, title: row.key }, name));
  made.dataset.key = row.key;
  const origin = [row.status, row.source, row.remark].filter(Boolean).join(" · ");
  if (row.number === undefined) made.append(element("span", { class: "plain", id }, row.text));
  else {
    const field = element("input", { type: "text", id, inputmode: "decimal", value: String(Number(row.number.toPrecision(6))) });
    const slider = element("input", { type: "range", "aria-label": `${row.key}, slider`, min: String(row.low), max: String(row.high), step: "any", value: String(row.number) });
    slider.addEventListener("input", () => { field.value = String(Number((+slider.value).toPrecision(4))); change(row, field.value, true); });
    slider.addEventListener("change", () => { dragged = ""; clearTimeout(timer); timer = setTimeout(() => ask("whole"), RELEASE); });
    slider.addEventListener("keydown", (event) => arrow(event, slider));
    field.addEventListener("change", () => { slider.value = field.value; change(row, field.value, false); });
    made.append(field, element("span", { class: "unit" }, row.unit), slider);
  }
  made.append(element("span", { class: "origin" }, origin));
  return made;
}

/** Arrows move a slider by a hundredth of its range. */
function arrow(event, slider) {
  const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
  if (!step) return;
  event.preventDefault();
  slider.value = String(+slider.value + (step * (slider.max - slider.min)) / 100);
  slider.dispatchEvent(new Event("input"));
  slider.dispatchEvent(new Event("change"));
}

let dragged = "";
function change(row, number, isDrag) {
  if (!isDrag || dragged !== row.key) state.past.push(new Map(state.changes));
  dragged = isDrag ? row.key : "";
  state.changes.delete(row.key);
  state.changes.set(row.key, `${row.key}=${number}${row.unit ? ` ${row.unit}` : ""}`);
  markChanged();
  clearTimeout(timer);
  ask(isDrag ? "draft" : "whole");
}

function markChanged() {
  for (const row of document.querySelectorAll(".value")) row.classList.toggle("changed", state.changes.has(row.dataset.key));
  $("undo").disabled = !state.past.length;
  $("write").disabled = !state.changes.size;
  $("save").disabled = !state.saves || state.text === state.saved;
}

function undo() {
  const before = state.past.pop();
  if (!before) return;
  if (typeof before === "string") setText(before); else state.changes = before;
  markChanged();
  ask("whole");
}

/** Puts the changed values into the text: only the value of each line, so that origins and comments stay. */
function writeInto(text, changes) {
  const missing = [];
  for (const [key, setting] of changes) {
    const found = written(text, key, JSON.stringify(setting.slice(setting.indexOf("=") + 1)));
    if (found === null) missing.push(key); else text = found;
  }
  return [text, missing];
}

/** The text with another value under a key; a default gets a line. Null of what stands in a part's own file. */
function written(text, key, value) {
  const [header, name] = [key.slice(0, key.lastIndexOf(".")), key.slice(key.lastIndexOf(".") + 1)];
  const another = (old) => old.startsWith("{") ? old.replace(/(\bvalue\s*=\s*)("(?:[^"\\]|\\.)*"|'[^']*'|[-+.\w]+)/, (_, before) => before + value) : value;
  const lines = text.split("\n");
  const span = tableSpan(lines, header);
  if (!span) return withPair(lines, header, name, another) ?? (/^(nodes|components|parts|programs)\./.test(header) ? null : withTable(text, header, [`${name} = ${value}`]));
  const place = lines.slice(...span).findIndex((line) => new RegExp(`^\\s*${name}\\s*=`).test(line)) + span[0];
  if (place < span[0]) return withLine(text, header, name, value);
  lines[place] = lines[place].replace(/(=\s*)(\{[^}]*\}|"(?:[^"\\]|\\.)*"|'[^']*'|[-+.\w]+)/, (_, before, old) => before + another(old));
  return lines.join("\n");
}

function setText(text) { state.text = text; $("text").value = text; numberLines(); }

function write() {
  const [text, missing] = writeInto(state.text, state.changes);
  state.past.push(state.text);
  setText(text);
  state.changes = new Map([...state.changes].filter(([key]) => missing.includes(key)));
  if (missing.length) say(`these stand in the file of a part: ${missing.join(", ")}`);
  markChanged();
  ask("whole");
}

async function post(path, content) {
  const answer = await fetch(path, { method: "POST", body: JSON.stringify(content) });
  return answer.json();
}

async function save() {
  const found = await post("/api/save", { system: state.system, text: state.text, before: state.saved });
  if (found.faults) { showFaults(found.faults); return; }
  state.saved = state.text;
  say("saved");
  markChanged();
}

/** The file has changed on disk: taken over where nothing is unsaved here, else the reader chooses. */
function takeDisk({ system, text }) {
  if (system !== state.system || text === state.saved) return;
  if (text === null) { tellDisk("The file is gone from the disk; what is shown stays."); return; }
  state.disk = text;
  if (state.text === state.saved) loadDisk();
  else tellDisk("The file has changed on the disk, and the text here is not saved.", true);
}

function tellDisk(words, isChoice = false) {
  $("disk").hidden = !words;
  $("disk").querySelector("p").textContent = words;
  for (const name of ["disk-load", "disk-keep"]) $(name).hidden = !isChoice;
}

function loadDisk() {
  tellDisk("");
  state.past.push(state.text);
  state.saved = state.disk;
  setText(state.disk);
  markChanged();
  ask("whole");
}

/** Saving replaces what is on the disk now, knowingly. */
function keepText() {
  tellDisk("");
  state.saved = state.disk;
  markChanged();
}

async function open(name) {
  const found = await post("/api/text", { system: name });
  if (found.faults) { showFaults(found.faults); return; }
  nameSeries([]);
  Object.assign(state, { system: name, saved: found.text, saves: found.saves, changes: new Map(), past: [], wanted: null });
  for (const { figure } of live.values()) figure.remove();
  live.clear();
  schematic.course = null;
  $("joints").hidden = true;
  $("filter").value = "";
  tellDisk("");
  setText(found.text);
  $("values").dataset.form = "";
  markChanged();
  ask("whole");
}

/** Shows the values of the part of that name, or, where there is none, those in whose keys all words stand. */
function filterValues() {
  const wanted = $("filter").value.trim();
  const rows = [...document.querySelectorAll(".value")];
  const ofPart = rows.filter((row) => new RegExp(`(^|\\.)${RegExp.escape?.(wanted) ?? wanted.replace(/[^\w-]/g, "\\$&")}\\.[^.]*$`).test(row.dataset.key));
  const words = wanted.toLowerCase().replaceAll("_", " ").split(/\s+/);
  const found = new Set(wanted && ofPart.length ? ofPart : rows.filter((row) => words.every((word) => row.dataset.key.toLowerCase().replaceAll("_", " ").includes(word))));
  for (const row of rows) row.style.display = found.has(row) ? "" : "none";
  for (const group of document.querySelectorAll(".group")) group.style.display = [...found].some((row) => row.dataset.key.startsWith(`${group.textContent}.`)) ? "" : "none";
  $("filtered").hidden = found.size > 0;
}

function show(which) {
  for (const name of ["values", "text"]) {
    $(`${name}-panel`).hidden = name !== which;
    $(`tab-${name}`).setAttribute("aria-selected", String(name === which));
  }
}

function listen() {
  for (const fold of document.querySelectorAll(".fold")) fold.addEventListener("click", () => {
    const isFolded = fold.closest("section").classList.toggle("folded");
    fold.setAttribute("aria-expanded", String(!isFolded));
  });
  $("tab-values").addEventListener("click", () => show("values"));
  $("tab-text").addEventListener("click", () => show("text"));
  $("text").addEventListener("input", () => { state.text = $("text").value; numberLines(); markChanged(); clearTimeout(timer); ask("draw"); });
  $("text").addEventListener("scroll", () => { $("numbers-of-lines").scrollTop = $("text").scrollTop; });
  $("filter").addEventListener("input", filterValues);
  listenSeries();
  listenMeasured();
  listenTeach();
  listenBuild();
  $("system").addEventListener("change", () => open($("system").value));
  $("run").addEventListener("click", () => ask("whole"));
  $("stop").addEventListener("click", () => socket.send(JSON.stringify({ kind: "stop" })));
  $("undo").addEventListener("click", undo);
  $("write").addEventListener("click", write);
  $("save").addEventListener("click", save);
  $("disk-load").addEventListener("click", loadDisk);
  $("disk-keep").addEventListener("click", keepText);
  $("copy").addEventListener("click", () => navigator.clipboard?.writeText($("line").textContent));
  addEventListener("keydown", (event) => {
    const act = { Enter: () => ask("whole"), s: save, z: event.target === $("text") ? null : undo }[event.key];
    if ((event.ctrlKey || event.metaKey) && act) { event.preventDefault(); act(); }
    else if (event.key === "Escape") { hidePeek(); if (!$("stop").disabled && !$("teach").open) $("stop").click(); }
  });
}

async function start() {
  listen();
  const { systems, first, logs } = await (await fetch("/api/systems")).json();
  $("system").append(...systems.map(({ name, title }) => element("option", { value: name }, title === name ? name : `${name} · ${title}`)));
  $("system").value = first;
  showLogs(logs);
  await open(first);
  connect();
}

start();
