/** The diagram of the page: mean values, a click opens the table of a part, the pointer shows what it did. */
const schematic = { course: null };

/** The course of a packet with its columns. */
function unpackCourse(described, column) {
  const all = (places) => Object.fromEntries(Object.entries(places).map(([name, place]) => [name, column(place)]));
  const curves = Object.fromEntries(Object.entries(described.curves).map(([part, lines]) => [part, lines.map((line) => ({ ...line, y: column(line.y) }))]));
  return { times: column(described.times), period: described.period, curves, nodes: all(described.nodes), flows: all(described.flows), openings: all(described.openings) };
}

/** An SVG text as an element of the page. */
function svgElement(text) {
  return document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
}

/** Cuts the empty margins of a diagram that is in the page. */
function cropped(svg) {
  const { x, y, width, height } = svg.querySelector("g").getBBox();
  svg.setAttribute("viewBox", [x - 8, y - 8, width + 16, height + 16].join(" "));
}

function showDiagram(svg) {
  hidePeek();
  const made = svgElement(svg);
  $("diagram").replaceChildren(made);
  if (made.getBoundingClientRect().width) cropped(made);
  for (const group of made.querySelectorAll("[data-part], [data-node]:not([data-owner])")) {
    const name = group.dataset.part ?? group.dataset.node;
    group.addEventListener("click", () => openTable(name));
    group.addEventListener("pointerenter", (event) => peek(name, event.clientX, event.clientY));
    group.addEventListener("pointerleave", hidePeek);
    if (!group.dataset.part || group.firstElementChild.localName === "text") continue;
    for (const [key, word] of Object.entries({ tabindex: "0", role: "button", "aria-label": `${name}: show its values` })) group.setAttribute(key, word);
    group.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); openTable(name); } });
    group.addEventListener("focus", () => { const box = group.getBoundingClientRect(); if (group.matches(":focus-visible")) peek(name, box.right, box.bottom); });
    group.addEventListener("blur", hidePeek);
  }
  made.setAttribute("role", "group"); // an image would hide the buttons in it
  dressForBuilding();
}

/** Writes the mean values of a run beside their parts; what is not known of a draft is a dash. */
function showMeans(means) {
  for (const place of document.querySelectorAll("#diagram [data-mean]")) place.textContent = means[place.dataset.mean] ?? NOTHING;
}

/** Shows the values of one part. */
function openTable(name) {
  hidePeek();
  show("values");
  const column = $("file");
  if (column.classList.contains("folded")) column.querySelector(".fold").click();
  $("filter").value = name;
  filterValues();
  showJoints(name);
  column.scrollIntoView({ block: "nearest" });
  $("filter").focus();
}

/** What a part did in the last periods, as small curves beside the pointer. */
function peek(name, x, y) {
  const { course } = schematic;
  const curves = course?.curves[name] ?? [];
  $("peek").replaceChildren(element("b", {}, name.replaceAll("_", " ")), ...(curves.length ? curves.map((curve) => smallCurve(course.times, curve)) : [element("small", {}, "nothing of it is recorded over time")]));
  $("peek").hidden = false;
  const { width, height } = $("peek").getBoundingClientRect();
  $("peek").style.left = `${Math.max(4, Math.min(x + 14, innerWidth - width - 6))}px`;
  $("peek").style.top = `${Math.max(4, Math.min(y + 14, innerHeight - height - 6))}px`;
}

function hidePeek() { $("peek").hidden = true; }

function smallCurve(times, { label, unit, y }) {
  const [low, high] = extremes(y);
  const [left, right] = [times[0], times.at(-1)];
  const place = (value, from, to, length) => (to > from ? ((value - from) / (to - from)) * length : length / 2);
  const points = Array.from(y, (value, i) => `${place(times[i], left, right, 210).toFixed(1)},${(46 - place(value, low, high, 42)).toFixed(1)}`);
  const made = svgElement(`<svg xmlns="${SVG}" viewBox="0 0 210 48" width="210" height="48"><polyline points="${points.join(" ")}" fill="none" stroke="currentColor" stroke-width="1.4"/></svg>`);
  const words = low < high ? `${formatNumber(low, 3)} to ${withUnit(formatNumber(high, 3), unit)}` : withUnit(formatNumber(low, 3), unit);
  return element("div", {}, element("span", {}, `${label}: `, element("b", {}, words)), made);
}
