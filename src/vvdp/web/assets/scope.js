"use strict";
/* One PWM period beside a diagram in motion: pressures, and the openings of ports, with the time that the diagram shows. */
function vvdpScope(figure) {
  const SVG = "http://www.w3.org/2000/svg", WIDTH = 880, LEFT = 64, RIGHT = 10, LEAST_ROWS = 24;
  const COLOURS = ["#0b3c6f", "#d9730d", "#2f7d4f", "#7a4b9d", "#a3180c", "#3a8fb7", "#8a6d1a", "#5b6570"];
  const PANELS = [
    { word: "pressure", label: "bar", from: 10, height: 150, value: (x) => x / 1e5 },
    { word: "opening", label: "open", from: 180, height: 70, value: (x) => x },
  ];
  let columns = null, begin = 0, period = 0, shown = null;

  const svg = document.createElementNS(SVG, "svg"), cursor = document.createElementNS(SVG, "path"), drawn = document.createElementNS(SVG, "g");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", "One PWM period: pressures and openings over time");
  cursor.setAttribute("stroke", "#1b1f24");
  svg.append(drawn, cursor);
  const legend = Object.assign(document.createElement("p"), { className: "scope-legend" }), all = Object.assign(document.createElement("div"), { className: "scope", hidden: true });
  all.append(svg, legend);
  figure?.append(all);

  function add(name, attributes, text) {
    const found = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) found.setAttribute(key, value);
    found.textContent = text ?? "";
    drawn.append(found);
  }

  const rowAt = (t) => { let low = 0, high = columns.time.length; while (low < high) { const middle = (low + high) >> 1; if (columns.time[middle] < t) low = middle + 1; else high = middle; } return low; };

  /* The beginning of the period to show at a time: the one around it, or the last where that is recorded too coarsely. */
  function periodAt(t) {
    const end = columns.time.at(-1), start = begin + period * Math.floor((t - begin) / period);
    const isFine = start >= columns.time[0] && start + period <= end && rowAt(start + period) - rowAt(start) >= LEAST_ROWS;
    return isFine ? start : begin + period * (Math.floor(((end - begin) / period) * (1 + 1e-9)) - 1);
  }

  const x = (t) => LEFT + ((t - shown) / period) * (WIDTH - LEFT - RIGHT);

  function panel({ word, label, from, height, value }, first, last) {
    const names = Object.keys(columns).filter((name) => name.startsWith(`${word} `));
    if (!names.length) return "";
    const lines = names.map((name) => Array.from(columns[name].slice(first, last), value));
    const least = Math.min(0, ...lines.flat()), most = Math.max(...lines.flat(), least + 1e-9), y = (v) => from + height * (1 - (v - least) / (most - least));
    for (const share of [0, 0.5, 1]) {
      const level = least + share * (most - least);
      add("path", { d: `M ${LEFT} ${y(level)} H ${WIDTH - RIGHT}`, stroke: "#d8dde2" });
      add("text", { x: LEFT - 6, y: y(level) + 4, "text-anchor": "end", "font-size": 12, fill: "#5b6570" }, `${Number(level.toPrecision(3))} ${share === 1 ? label : ""}`.trim());
    }
    lines.forEach((line, i) => add("polyline", { points: line.map((v, row) => `${x(columns.time[first + row]).toFixed(1)},${y(v).toFixed(1)}`).join(" "), fill: "none", stroke: COLOURS[i % COLOURS.length], "stroke-width": 1.6 }));
    return names.map((name, i) => Object.assign(document.createElement("span"), { textContent: name.replaceAll("_", " "), style: `border-color: ${COLOURS[i % COLOURS.length]}` }));
  }

  function redraw() {
    drawn.replaceChildren();
    const first = Math.max(rowAt(shown) - 1, 0), last = Math.min(rowAt(shown + period) + 1, columns.time.length);
    legend.replaceChildren(...PANELS.flatMap((each) => panel(each, first, last)));
    const height = Object.keys(columns).some((name) => name.startsWith("opening ")) ? 275 : 190;
    add("text", { x: LEFT, y: height - 4, "font-size": 12, fill: "#5b6570" }, `one period, ${Number((1e3 * period).toPrecision(4))} ms, from t = ${Number(shown.toPrecision(6))} s`);
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${height}`);
  }

  /* Takes a run; without one, or without periods, there is nothing to show. */
  function show(found) {
    const { averaged_from_s: from, averaged_to_s: to, averaged_periods: periods } = found?.summary ?? {};
    all.hidden = !periods;
    columns = periods ? found.moving : null;
    [begin, period, shown] = [from, (to - from) / periods, null];
  }

  document.addEventListener("vvdp-time", ({ detail: t }) => {
    if (!columns) return;
    const start = periodAt(t);
    if (start !== shown) { shown = start; redraw(); }
    const phase = shown + (((t - shown) % period) + period) % period;
    cursor.setAttribute("d", `M ${x(phase).toFixed(1)} 10 V 250`);
  });

  return { show };
}
