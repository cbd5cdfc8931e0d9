const RELEASE = 150; // ms after a slider is let go, the whole run replaces drafts
const MOST_RUNS = 20;
const $ = (id) => document.getElementById(id);
const live = new Map();
const state = { system: "", text: "", saved: "", saves: false, changes: new Map(), past: [], rows: [], asked: 0, answered: 0, runs: [], shown: null, wanted: null, figures: null };
let socket = null;
let timer = 0;

/** Sends a request; only the newest is worked out. */
function ask(kind, more = {}) {
  state.asked += 1;
  const text = state.text === state.saved ? {} : { text: state.text };
  const message = { n: state.asked, kind, system: state.system, set: [...state.changes.values()], ...text, ...more };
  if (kind === "whole") say("running …");
  if (kind === "whole") setTimeout(() => { if (state.answered < message.n && state.asked === message.n) say("running or compiling; a new circuit takes a few seconds"); }, 900);
  $("stop").disabled = kind !== "whole";
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  return message.n;
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
  state.answered = head.n;
  if (head.kind !== "draft" && head.n !== state.asked) return;
  showFaults(head.faults ?? []);
  if (head.faults) { document.body.classList.add("is-old"); say("not valid"); $("stop").disabled = true; return; }
  if (head.svg) showDiagram(head.svg);
  if (head.values) showValues(head.values);
  if (head.title) document.title = `${head.title} · vvdp workbench`;
  if (head.kind === "drawing") { document.body.classList.add("is-old"); say("drawn; not yet run"); }
  if (head.charts) { if (head.kind === "figures") state.figures = { charts: head.charts, column }; showCharts(head.charts, column); }
  if (head.kind === "draft") document.body.classList.add("is-draft");
  if (head.kind === "figures") { document.body.classList.remove("is-draft"); document.body.classList.add("is-old"); }
  if (head.kind === "numbers") showNumbers(head);
}

function showDiagram(svg) {
  const parsed = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement;
  $("diagram").replaceChildren(document.importNode(parsed, true));
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
  keep(head);
}

/** Charts in place of those of the same form; only what is chosen is drawn. */
function showCharts(charts, column) {
  const names = charts.map((each) => each.name);
  if (state.wanted === null || !names.some((name) => state.wanted.has(name))) state.wanted = new Set(names.slice(0, 1));
  $("chosen").replaceChildren(...names.map((name) => {
    const button = element("button", { type: "button", "aria-pressed": String(state.wanted.has(name)) }, name.replaceAll("-", " "));
    button.addEventListener("click", () => { if (!state.wanted.delete(name)) state.wanted.add(name); showCharts(charts, column); });
    return button;
  }));
  for (const [name, { figure }] of live) if (!state.wanted.has(name) || !names.includes(name)) { figure.remove(); live.delete(name); }
  for (const described of charts.filter((each) => state.wanted.has(each.name))) showChart(...withKept(described, column));
}

function showChart(described, column) {
  const found = live.get(described.name);
  if (found?.chart.fits(described)) { found.chart.update(described, column); return; }
  found?.figure.remove();
  const figure = element("figure");
  const height = 150 + 130 * described.panels.length;
  const still = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  still.setAttribute("height", String(described.sideBySide ? 330 : height));
  figure.append(still);
  $("charts").append(figure);
  live.set(described.name, { chart: new LiveChart(described, figure, column), figure });
}

/** The chart with the lines of the selected other runs, dashed, on the same axes. */
function withKept(described, column) {
  const others = state.runs.filter((run) => run.on && run.figures !== state.figures);
  if (!others.length) return [described, column];
  const stride = 100000;
  const panels = described.panels.map((panel, i) => panel.kind !== "lines" ? panel : { ...panel, lines: [...panel.lines, ...others.flatMap((run, r) => {
    const own = run.figures.charts.find((each) => each.name === described.name)?.panels[i];
    const moved = (place) => place === undefined ? {} : place + stride * (r + 1);
    return (own?.lines ?? []).map((line) => ({ ...line, x: moved(line.x), y: moved(line.y), low: undefined, high: undefined, stroke: "--", label: `${line.label} (${run.name})` }));
  })] });
  return [{ ...described, panels }, (place) => (place < stride ? column(place) : others[Math.floor(place / stride) - 1].figures.column(place % stride))];
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
    box.addEventListener("change", () => { run.on = box.checked; showCompared(); if (state.figures) showCharts(state.figures.charts, state.figures.column); });
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
  $("compared").replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows)));
}

function showFaults(faults) {
  const words = (each) => [each.line ? `line ${each.line}` : "", each.key, each.message].filter(Boolean).join(": ");
  const beside = (each) => [...document.querySelectorAll(".value")].find((row) => row.dataset.key === each.key);
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
  const lines = text.split("\n");
  const missing = [];
  for (const [key, setting] of changes) {
    const value = JSON.stringify(setting.slice(setting.indexOf("=") + 1));
    const cut = key.lastIndexOf(".");
    let header = "";
    const place = lines.findIndex((line) => {
      header = /^\s*\[\s*([^\[\]]+?)\s*\]/.exec(line)?.[1] ?? header;
      return header === key.slice(0, cut) && new RegExp(`^\\s*${key.slice(cut + 1)}\\s*=`).test(line);
    });
    if (place < 0) { missing.push(key); continue; }
    const quoted = /(=\s*)("(?:[^"\\]|\\.)*"|'[^']*'|[-+.\w]+)/;
    const inner = /(\bvalue\s*=\s*)("(?:[^"\\]|\\.)*"|'[^']*'|[-+.\w]+)/;
    const isTable = /=\s*\{/.test(lines[place]);
    if (isTable && !inner.test(lines[place])) { missing.push(key); continue; }
    lines[place] = lines[place].replace(isTable ? inner : quoted, (_, before) => before + value);
  }
  return [lines.join("\n"), missing];
}

function setText(text) { state.text = text; $("text").value = text; numberLines(); }

function write() {
  const [text, missing] = writeInto(state.text, state.changes);
  state.past.push(state.text);
  setText(text);
  state.changes = new Map([...state.changes].filter(([key]) => missing.includes(key)));
  if (missing.length) say(`no line of their own: ${missing.join(", ")}`);
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

async function open(name) {
  const found = await post("/api/text", { system: name });
  if (found.faults) { showFaults(found.faults); return; }
  Object.assign(state, { system: name, saved: found.text, saves: found.saves, changes: new Map(), past: [], wanted: null });
  for (const { figure } of live.values()) figure.remove();
  live.clear();
  setText(found.text);
  $("values").dataset.form = "";
  markChanged();
  ask("whole");
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
  $("filter").addEventListener("input", () => {
    const words = $("filter").value.toLowerCase().split(/\s+/);
    for (const row of document.querySelectorAll(".value")) row.hidden = !words.every((word) => row.dataset.key.replaceAll("_", " ").includes(word));
    for (const row of document.querySelectorAll(".value")) row.style.display = row.hidden ? "none" : "";
  });
  $("system").addEventListener("change", () => open($("system").value));
  $("run").addEventListener("click", () => ask("whole"));
  $("stop").addEventListener("click", () => socket.send(JSON.stringify({ kind: "stop" })));
  $("undo").addEventListener("click", undo);
  $("write").addEventListener("click", write);
  $("save").addEventListener("click", save);
  $("copy").addEventListener("click", () => navigator.clipboard?.writeText($("line").textContent));
  addEventListener("keydown", (event) => {
    const act = { Enter: () => ask("whole"), s: save, z: event.target === $("text") ? null : undo }[event.key];
    if ((event.ctrlKey || event.metaKey) && act) { event.preventDefault(); act(); }
    else if (event.key === "Escape" && !$("stop").disabled) $("stop").click();
  });
}

async function start() {
  listen();
  const { systems, first } = await (await fetch("/api/systems")).json();
  $("system").append(...systems.map(({ name, title }) => element("option", { value: name }, title === name ? name : `${name} · ${title}`)));
  $("system").value = first;
  await open(first);
  connect();
}

start();
