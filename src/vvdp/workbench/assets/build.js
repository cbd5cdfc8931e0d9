/** Drawing by hand: every act is a change of lines in the text, so that the drawing is the file. */
const MOVE = 120; // px of one column of the diagram's grid
const HEADER = /^\s*\[\s*([\w.\-"' ]+?)\s*\]\s*(#.*)?$/; // and no row of an array
const NODE_OF = { oil: "volume", shaft: "shaft", rod: "rod" };
const build = { isOn: false, types: [], chosen: null };

/** First and last line of a table of the text: from its header to before the next one; null where it has none. */
function tableSpan(lines, header) {
  const headers = lines.flatMap((line, i) => { const found = HEADER.exec(line); return found ? [[found[1], i]] : []; });
  const place = headers.findIndex(([name]) => name === header);
  return place < 0 ? null : [headers[place][1], headers[place + 1]?.[1] ?? lines.length];
}

/** The text with a table more, before how it is run. */
function withTable(text, header, own) {
  const lines = text.replace(/\n*$/, "").split("\n");
  const [begin] = tableSpan(lines, "run") ?? [lines.length];
  let place = begin;
  while (place > 0 && begin < lines.length && /^\s*#/.test(lines[place - 1])) place -= 1; // its comment stays with it
  lines.splice(place, 0, ...(place && lines[place - 1].trim() ? [""] : []), `[${header}]`, ...own, ...(place < lines.length ? [""] : []));
  return `${lines.join("\n")}\n`;
}

/** The pairs of a table that stands in one line: key, and where its value begins and ends; null where the line has none. */
function inlinePairs(line) {
  const pairs = [];
  let [depth, quote, start] = [0, "", line.indexOf("{") + 1];
  const put = (end) => {
    const found = /^\s*([\w-]+)\s*=\s*/.exec(line.slice(start, end));
    if (found) pairs.push({ key: found[1], from: start + found[0].length, to: start + line.slice(start, end).trimEnd().length });
    start = end + 1;
  };
  for (let i = start; start && i < line.length; i++) {
    const letter = line[i];
    if (quote) { if (letter === "\\" && quote === '"') i++; else if (letter === quote) quote = ""; }
    else if (letter === '"' || letter === "'") quote = letter;
    else if (letter === "[" || letter === "{") depth++;
    else if (depth && (letter === "]" || letter === "}")) depth--;
    else if (letter === "," && !depth) put(i);
    else if (letter === "}") { put(i); return { pairs, end: i }; }
  }
  return null;
}

/** The line of an entry that stands in one line of its table, as `supply = { type = "tank" }` below `[nodes]`; -1 of others. */
function inlinePlace(lines, header) {
  const cut = header.lastIndexOf(".");
  const span = tableSpan(lines, header.slice(0, cut));
  const found = span ? lines.slice(...span).findIndex((line) => new RegExp(`^\\s*${header.slice(cut + 1)}\\s*=\\s*\\{`).test(line)) : -1;
  return found < 0 ? -1 : span[0] + found;
}

/** The text with another value of an entry in one line; null where there is no such entry. */
function withPair(lines, header, key, value) {
  const place = inlinePlace(lines, header);
  const line = lines[place];
  const inline = line && inlinePairs(line);
  if (!inline) return null;
  const pair = inline.pairs.find((each) => each.key === key);
  lines[place] = pair
    ? line.slice(0, pair.from) + value(line.slice(pair.from, pair.to)) + line.slice(pair.to)
    : `${line.slice(0, inline.end).trimEnd()}${inline.pairs.length ? "," : ""} ${key} = ${value("")} ${line.slice(inline.end)}`;
  return lines.join("\n");
}

/** The text with another value of a table, in a line or in its one line; null where the table stands otherwise in the text. */
function withLine(text, header, key, value) {
  const lines = text.split("\n");
  const span = tableSpan(lines, header);
  if (!span) return withPair(lines, header, key, () => value);
  const line = lines.slice(...span).findIndex((each) => new RegExp(`^\\s*${key}\\s*=`).test(each));
  if (line < 0) lines.splice(span[0] + 1, 0, `${key} = ${value}`);
  else lines[span[0] + line] = lines[span[0] + line].replace(/(=\s*)("[^"]*"|'[^']*'|\[[^\]]*\]|[^\s#]+)/, (_, before) => before + value);
  return lines.join("\n");
}

function withoutTable(text, header) {
  const lines = text.split("\n");
  const span = tableSpan(lines, header);
  if (!span) {
    const place = inlinePlace(lines, header);
    if (place >= 0) lines.splice(place, 1);
    return lines.join("\n");
  }
  const last = lines.slice(...span).findLastIndex((line) => line.trim() && !/^\s*#/.test(line)); // comments before the next table are its
  lines.splice(span[0], last + 1 + (lines[span[0] + last + 1]?.trim() === "" ? 1 : 0));
  return lines.join("\n");
}

/** Entries of a table of the text, in tables of their own or in one line: name, type, the words that are written in them. */
function drawnParts(text, table) {
  const lines = text.split("\n");
  const word = /^\s*([\w-]+)\s*=\s*["']([^"']*)["']/;
  const own = lines.flatMap((line) => { const found = new RegExp(`^\\s*\\[\\s*${table}\\.([\\w-]+)\\s*\\]`).exec(line); return found ? [[found[1], lines.slice(...tableSpan(lines, `${table}.${found[1]}`))]] : []; });
  const span = tableSpan(lines, table);
  const inline = (span ? lines.slice(...span) : []).flatMap((line) => {
    const name = /^\s*([\w-]+)\s*=\s*\{/.exec(line)?.[1];
    const pairs = name && inlinePairs(line)?.pairs;
    return pairs ? [[name, pairs.map(({ key, from, to }) => `${key} = ${line.slice(from, to)}`)]] : [];
  });
  return new Map([...own, ...inline].map(([name, written]) => {
    const words = Object.fromEntries(written.flatMap((line) => { const found = word.exec(line); return found ? [[found[1], found[2]]] : []; }));
    return [name, { ...words, table, known: build.types.find((each) => each.table === table && each.type === words.type) }];
  }));
}

/** What has ports: components, and parts that are circuits of their own. */
function drawnOwners(text) { return new Map([...drawnParts(text, "components"), ...drawnParts(text, "parts")]); }

/** Whether a port of anything is joined to a node. */
function isJoined(text, node) { return [...drawnOwners(text).values()].some((part) => Object.values(part).includes(node)); }

/** The ports of what is drawn: name, and what can be joined there; of a part in a file as the diagram shows them. */
function portsOf(name, part) {
  if (part.known) return Object.entries(part.known.ports);
  const shown = [...$("diagram").querySelectorAll("[data-owner]")].filter((group) => group.dataset.owner === name);
  return shown.map(({ dataset: { owner, port, node } }) => [port, joins({ owner, port, node })]);
}

/** Takes another text: as one change that can be undone, drawn at once. */
function edit(text, words) {
  if (text === null) { say("this part is written in a form that only the text can change"); return; }
  state.past.push(state.text);
  const before = state.text.split("\n");
  setText(text);
  showLine(text.split("\n").findIndex((line, i) => line !== before[i]));
  markChanged();
  build.chosen = null;
  ask("draw");
  say(words);
}

/** Shows a line of the text, marked. */
function showLine(place) {
  const field = $("text");
  const lines = field.value.split("\n");
  const begin = lines.slice(0, place).reduce((sum, line) => sum + line.length + 1, 0);
  field.setSelectionRange(begin, begin + (lines[place] ?? "").length);
  field.scrollTop = $("numbers-of-lines").scrollTop = Math.max(0, 18 * place - 90);
}

/** Drops a part: each of its ports gets a node of its own, so that the circuit can be drawn. */
function addPart(type) {
  const taken = new Set([...drawnParts(state.text, "nodes").keys(), ...drawnOwners(state.text).keys()]);
  const stem = type.type.replaceAll("-", "_");
  let name = stem;
  for (let i = 2; taken.has(name); i++) name = `${stem}_${i}`;
  const ports = Object.keys(type.ports);
  let text = withTable(state.text, `${type.table}.${name}`, [`type = "${type.type}"`, ...ports.map((port) => `${port} = "${name}_${port}"`), ...type.lines]);
  for (const port of ports) {
    const word = NODE_OF[type.ports[port]];
    const node = build.types.find((each) => each.table === "nodes" && each.type === word);
    text = withTable(text, `nodes.${name}_${port}`, [`type = "${word}"`, ...node.lines]);
  }
  edit(text, `${name} added`);
}

/** What can be joined at an end, a port or a node: "oil", "shaft" or "rod". */
function joins(end) {
  const owner = drawnOwners(state.text).get(end.owner);
  return owner?.known?.ports[end.port] || drawnParts(state.text, "nodes").get(end.node)?.known?.joins;
}

/** Whether two ends may be joined: they take the same, are not joined yet, and one of them is a port. */
function canJoin(a, b) { return Boolean(joins(a)) && joins(a) === joins(b) && a.node !== b.node && Boolean(a.port || b.port); }

/** Joins a port to a node: that of the other end. A node that was only the port's own goes. */
function joinEnds(a, b) {
  const isOwn = (end) => end.port && end.node === `${end.owner}_${end.port}`;
  const [moved, kept] = a.port && (isOwn(a) || !isOwn(b) || !b.port) ? [a, b] : [b, a];
  const { table } = drawnOwners(state.text).get(moved.owner);
  let text = withLine(state.text, `${table}.${moved.owner}`, moved.port, `"${kept.node}"`);
  if (text !== null && isOwn(moved) && !isJoined(text, moved.node)) text = withoutTable(text, `nodes.${moved.node}`);
  edit(text, `${moved.owner}, ${moved.port} joined to ${kept.node}`);
}

/** Removes a part, and the nodes that were only its own. */
function removePart(name) {
  const part = drawnOwners(state.text).get(name);
  let text = withoutTable(state.text, `${part?.table ?? "nodes"}.${name}`);
  for (const [port] of part ? portsOf(name, part) : []) if (!isJoined(text, `${name}_${port}`)) text = withoutTable(text, `nodes.${name}_${port}`);
  edit(text === state.text ? null : text, `${name} removed`);
  $("joints").hidden = true;
}

/** Puts a part at a place of the grid: columns to the right, rows upward. */
function placePart(name, column, row) {
  const table = drawnOwners(state.text).get(name)?.table ?? "nodes";
  edit(withLine(state.text, `${table}.${name}`, "at", `[${Math.max(0, Math.round(10 * column) / 10)}, ${Math.max(0, Math.round(row))}]`), `${name} moved`);
}

/** Column and row of a point of the diagram; a row is the nearest one of those that are drawn, or one beyond. */
function gridPlace(svg, x, y) {
  const heights = [...new Set([...svg.querySelectorAll("[data-part][tabindex]")].map((group) => Math.round(centreOf(group).y / 12) * 12))].sort((a, b) => b - a);
  const nearest = heights.reduce((best, height, i) => (Math.abs(height - y) < Math.abs(heights[best] - y) ? i : best), 0);
  const beyond = y < Math.min(...heights) - 70 ? 1 : 0;
  return [(x - 14) / MOVE, nearest + beyond];
}

/** The middle of a symbol in the units of the diagram. */
function centreOf(group) {
  const found = /translate\(([-\d.]+) ([-\d.]+)\)/.exec(group.querySelector("[transform]")?.getAttribute("transform") ?? "");
  return found ? { x: +found[1], y: +found[2] } : { x: 0, y: 0 };
}

/** A point of the window in the units of the diagram. */
function inDiagram(svg, event) { return new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse()); }

/** Makes the drawn diagram one that can be changed: ports to join, symbols to move. */
function dressForBuilding() {
  const svg = $("diagram").querySelector("svg");
  if (!build.isOn || !svg) return;
  const owners = drawnOwners(state.text);
  for (const group of svg.querySelectorAll("[data-owner]")) {
    const start = group.querySelector("polyline")?.points[0];
    const { owner, port, node } = group.dataset;
    if (start) addHandle(svg, owners.has(owner) ? { owner, port, node } : { node }, start);
  }
  for (const group of svg.querySelectorAll("[data-part][tabindex]")) makeMovable(svg, group);
  markEnds();
}

function addHandle(svg, end, { x, y }) {
  const handle = document.createElementNS(SVG, "circle");
  const words = end.port ? `${end.owner}, port ${end.port}, at ${end.node}` : `node ${end.node}`;
  for (const [name, text] of Object.entries({ cx: x, cy: y, r: 7, class: "handle", tabindex: 0, role: "button", "aria-label": `${words}: join` })) handle.setAttribute(name, text);
  handle.end = end;
  const title = document.createElementNS(SVG, "title");
  title.textContent = words;
  handle.append(title);
  handle.addEventListener("pointerdown", (event) => { event.stopPropagation(); chooseEnd(end); });
  handle.addEventListener("pointerup", (event) => { event.stopPropagation(); if (build.chosen && build.chosen !== end) chooseEnd(end); });
  handle.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); chooseEnd(end); } });
  svg.append(handle);
}

/** The first end is chosen, the second one is joined to it where it fits. */
function chooseEnd(end) {
  if (build.chosen === null) build.chosen = end;
  else if (build.chosen === end) build.chosen = null;
  else if (canJoin(build.chosen, end)) { joinEnds(build.chosen, end); return; }
  else { say(joins(build.chosen) === joins(end) ? "these two are joined already" : `${joins(build.chosen)} and ${joins(end)} cannot be joined`); build.chosen = null; }
  markEnds();
}

/** Highlights the ends that can be joined to the chosen one. */
function markEnds() {
  for (const handle of document.querySelectorAll("#diagram .handle")) {
    handle.classList.toggle("is-chosen", handle.end === build.chosen);
    handle.classList.toggle("fits", build.chosen !== null && canJoin(build.chosen, handle.end));
  }
}

function makeMovable(svg, group) {
  const name = group.dataset.part;
  group.addEventListener("pointerdown", (event) => {
    const begin = inDiagram(svg, event);
    const centre = centreOf(group);
    let isMoved = false;
    const move = (next) => {
      const now = inDiagram(svg, next);
      isMoved ||= Math.hypot(now.x - begin.x, now.y - begin.y) > 12;
      if (isMoved) group.setAttribute("transform", `translate(${now.x - begin.x} ${now.y - begin.y})`);
    };
    const end = (last) => {
      removeEventListener("pointermove", move);
      if (!isMoved) return;
      const now = inDiagram(svg, last);
      group.addEventListener("click", (click) => click.stopImmediatePropagation(), { capture: true, once: true });
      placePart(name, ...gridPlace(svg, centre.x + now.x - begin.x, centre.y + now.y - begin.y));
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end, { once: true });
  });
  group.addEventListener("keydown", (event) => {
    const [dx, dy] = { ArrowLeft: [-0.5, 0], ArrowRight: [0.5, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [];
    if (event.key === "Delete") removePart(name);
    if (dx === undefined) return;
    event.preventDefault();
    const { x, y } = centreOf(group);
    const [column, row] = gridPlace(svg, x, y);
    placePart(name, column + dx, row + dy);
  });
}

/** Below the filter: to which node each port of a part is joined, as lists; a shaft or rod has no line to draw. */
function showJoints(name) {
  const part = drawnOwners(state.text).get(name);
  const nodes = drawnParts(state.text, "nodes");
  $("joints").hidden = !build.isOn || !(part || nodes.has(name));
  const lists = (part ? portsOf(name, part) : []).map(([port, kind]) => {
    const fitting = [...nodes].filter(([, node]) => node.known?.joins === kind).map(([node]) => node);
    const list = element("select", {}, ...fitting.map((node) => element("option", { value: node }, node)));
    list.value = part[port];
    list.addEventListener("change", () => { joinEnds({ owner: name, port, node: part[port] }, { node: list.value }); showJoints(name); });
    return element("label", {}, `${port} (${kind})`, list);
  });
  const remove = element("button", { type: "button" }, `Remove ${name}`);
  remove.addEventListener("click", () => removePart(name));
  $("joints").replaceChildren(...lists, remove);
}

async function toggleBuild() {
  build.isOn = !build.isOn;
  $("draw").setAttribute("aria-pressed", String(build.isOn));
  $("palette").hidden = !build.isOn;
  $("joints").hidden = true;
  if (!build.types.length) build.types = (await (await fetch("/api/palette")).json()).types;
  if (build.isOn) { showPalette(); show("text"); }
  ask("draw");
}

function showPalette() {
  const words = $("palette-filter").value.toLowerCase().split(/\s+/);
  const fitting = build.types.filter((each) => words.every((word) => `${each.type} ${each.table}`.includes(word)));
  $("palette-list").replaceChildren(...fitting.map((type) => {
    const button = element("button", { type: "button", draggable: "true", title: `Add: ${type.type}` }, svgElement(type.symbol), element("span", {}, type.type));
    button.addEventListener("click", () => addPart(type));
    button.addEventListener("dragstart", (event) => event.dataTransfer.setData("text/plain", type.type));
    return button;
  }));
}

function listenBuild() {
  $("draw").addEventListener("click", toggleBuild);
  $("palette-filter").addEventListener("input", showPalette);
  $("diagram").addEventListener("dragover", (event) => { if (build.isOn) event.preventDefault(); });
  $("diagram").addEventListener("drop", (event) => {
    const type = build.types.find((each) => each.type === event.dataTransfer.getData("text/plain"));
    if (!build.isOn || !type) return;
    event.preventDefault();
    addPart(type);
  });
}
