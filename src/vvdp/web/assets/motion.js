"use strict";
/* Circuit diagrams at a time of the run: lines coloured by pressure, flow as dashes, ports, shafts and rods. */
function vvdpMotion(model, ask) {
  const SVG = "http://www.w3.org/2000/svg";
  const FASTEST = 90, LEAST = 1e-3, SLOWER = [1, 10, 100, 1000];
  const diagrams = [], clockwork = new SlowClock(draw);
  let columns = null, scales = null;

  const make = (name, attributes, parent) => {
    const found = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) found.setAttribute(key, value);
    parent?.append(found);
    return found;
  };
  const polyline = (points, width, parent) => make("polyline", { points: points.join(" "), fill: "none", "stroke-width": width, "stroke-linejoin": "round" }, parent);

  /* The marks of a diagram: below its ink the oil, above it dashes, closed ports, and what turns or slides. */
  function prepare(figure, drawn) {
    const svg = figure.querySelector("svg"), quiet = { "aria-hidden": "true", "pointer-events": "none", class: "moving", display: "none" };
    const below = make("g", quiet), above = make("g", quiet, svg);
    svg.insertBefore(below, svg.querySelector("title")?.nextSibling ?? svg.firstChild);
    const line = (points, of) => {
      const oil = polyline(points, 8, below), dashes = polyline(points, 3, above);
      dashes.setAttribute("stroke", "#fff");
      dashes.setAttribute("stroke-dasharray", "5 9");
      return { ...of, oil, dashes, shift: 0 };
    };
    const wires = drawn.wires.map((wire) => {
      const found = line(wire.points, wire), [x0, y0, x1, y1] = wire.points, long = Math.hypot(x1 - x0, y1 - y0) || 1;
      if (wire.opening) {
        const [u, v] = [(x1 - x0) / long, (y1 - y0) / long];
        found.gate = make("path", { transform: `matrix(${u} ${v} ${-v} ${u} ${x0 + 4 * u} ${y0 + 4 * v})`, stroke: "#a3180c", "stroke-width": 4, class: "gate" }, above);
      }
      return found;
    });
    const rails = drawn.rails.map((rail) => {
      const xs = [...new Set([rail.ends[0], ...rail.joints.map(([x]) => x), rail.ends[1]])].sort((a, b) => a - b);
      const parts = xs.slice(1).map((x, i) => line([xs[i], rail.y, x, rail.y], { until: xs[i], pressure: rail.pressure }));
      return { ...rail, parts };
    });
    const turning = drawn.turning.map(([x, y, r, angle]) => {
      const hub = make("g", { transform: `translate(${x} ${y})` }, above);
      make("circle", { r, fill: "none", stroke: "#0b3c6f", "stroke-opacity": 0.25, "stroke-width": 2 }, hub);
      return { angle, r, dot: make("circle", { r: 4, fill: "#0b3c6f", class: "turning" }, hub) };
    });
    const sliding = drawn.sliding.map(([x0, y0, x1, , position]) => {
      make("path", { d: `M ${x0} ${y0 - 7} H ${x1}`, stroke: "#0b3c6f", "stroke-opacity": 0.3, "stroke-width": 3 }, above);
      return { position, ends: [x0, x1], dot: make("circle", { r: 5, cy: y0 - 7, fill: "#0b3c6f", class: "sliding" }, above) };
    });
    return { groups: [below, above], wires, rails, turning, sliding };
  }

  const extremes = (names) => {
    let low = Infinity, high = -Infinity;
    for (const name of names) for (const x of columns[name] ?? []) { if (x < low) low = x; if (x > high) high = x; }
    return high >= low ? [low, high] : [0, 0];
  };
  const starting = (word) => Object.keys(columns).filter((name) => name.startsWith(`${word} `));

  function colourOf(pressure) {
    const [low, high] = scales.pressure;
    return pressureColour(high > low ? (pressure - low) / (high - low) : 0);
  }

  /* Flows along the lines; a line of which none is recorded takes what is left at its junction, if it alone does so. */
  function flowsOf(drawn, value) {
    const flows = drawn.wires.map((wire) => (wire.flow ? wire.sign * value(wire.flow) : NaN));
    for (const { joints } of drawn.rails) {
      const unknown = joints.filter(([, i]) => Number.isNaN(flows[i]));
      if (unknown.length === 1) flows[unknown[0][1]] = -joints.reduce((sum, [, i]) => sum + (Number.isNaN(flows[i]) ? 0 : flows[i]), 0);
    }
    return flows.map((flow) => (Number.isNaN(flow) ? 0 : flow));
  }

  /* Dashes move the faster the larger the flow, by the root of its share of the largest; none where nearly nothing flows. */
  function run(line, flow, passed) {
    const share = scales.flow > 0 ? Math.min(Math.abs(flow) / scales.flow, 1) : 0;
    line.dashes.setAttribute("display", share < LEAST ? "none" : "inline");
    line.shift = (line.shift - Math.sign(flow) * FASTEST * Math.sqrt(share) * passed) % 14;
    line.dashes.setAttribute("stroke-dashoffset", line.shift.toFixed(2));
  }

  /* How far a port is open, of the furthest; a valve without a delay keeps no opening, so its flow tells there. */
  function openShare({ opening, flow }, value) {
    const [, most] = scales.opening[opening], largest = Math.max(...(scales.flows[flow] ?? [0]).map(Math.abs));
    return most > 0 ? value(opening) / most : largest > 0 ? Math.abs(value(flow)) / largest : 0;
  }

  /* Two halves of a bar across a line, as far apart as the root of the open share; none where it is open as far as ever. */
  function close(gate, share) {
    const gap = 8 * Math.sqrt(Math.min(Math.max(share, 0), 1));
    gate.setAttribute("d", gap < 8 ? `M 0 8 V ${gap.toFixed(2)} M 0 -8 V ${(-gap).toFixed(2)}` : "");
  }

  /* Shows the time; `passed` is what went by on the wall [s]. */
  function draw(time, passed) {
    const [low, high, share] = rowsAt(columns.time, time), value = (name) => columns[name][low] + share * (columns[name][high] - columns[name][low]);
    for (const drawn of diagrams) {
      const flows = flowsOf(drawn, value);
      drawn.wires.forEach((wire, i) => {
        wire.oil.setAttribute("stroke", columns[wire.pressure] ? colourOf(value(wire.pressure)) : "#c9ced4");
        run(wire, flows[i], passed);
        if (wire.gate) close(wire.gate, openShare(wire, value));
      });
      for (const rail of drawn.rails) {
        const kept = rail.joints.reduce((sum, [, i]) => sum + flows[i], 0) / (rail.joints.length || 1);
        for (const part of rail.parts) {
          part.oil.setAttribute("stroke", columns[part.pressure] ? colourOf(value(part.pressure)) : "#c9ced4");
          run(part, rail.joints.reduce((sum, [x, i]) => (x <= part.until ? sum + flows[i] - kept : sum), 0), passed);
        }
      }
      for (const { angle, r, dot } of drawn.turning) {
        const a = value(angle);
        dot.setAttribute("cx", (r * Math.cos(a)).toFixed(2));
        dot.setAttribute("cy", (r * Math.sin(a)).toFixed(2));
      }
      for (const { position, ends: [x0, x1], dot } of drawn.sliding) {
        const [least, most] = scales.positions[position], part = most > least ? (value(position) - least) / (most - least) : 0.5;
        dot.setAttribute("cx", (x0 + part * (x1 - x0)).toFixed(2));
      }
    }
    reach.value = String(time);
    clock.textContent = `t = ${Number(time.toPrecision(6))} s`;
    document.dispatchEvent(new CustomEvent("vvdp-time", { detail: time }));
  }

  function play(is) {
    clockwork.run(is && !wantsStillness() && columns !== null);
    start.textContent = wantsStillness() ? "Show pressures" : clockwork.isRunning ? "Pause" : "Animate";
    start.hidden = wantsStillness() && columns !== null;
  }

  /* Takes the columns of a run; none take the marks away. */
  function show(found) {
    columns = found;
    for (const { groups } of diagrams) for (const group of groups) group.setAttribute("display", found ? "inline" : "none");
    reach.disabled = !found;
    legend.hidden = !found;
    if (!found) { clock.textContent = ""; play(false); return; }
    const each = (word) => Object.fromEntries(starting(word).map((name) => [name, extremes([name])]));
    scales = {
      pressure: extremes(starting("pressure")), flow: Math.max(...extremes(starting("flow")).map(Math.abs)),
      flows: each("flow"), opening: each("opening"), positions: each("position"),
    };
    const [first, last] = [found.time[0], found.time.at(-1)];
    reach.min = String(first);
    reach.max = String(last);
    legend.lastChild.textContent = `${Number((scales.pressure[1] / 1e5).toPrecision(3))} bar`;
    legend.firstChild.textContent = `${Number((scales.pressure[0] / 1e5).toPrecision(3))}`;
    const { time } = clockwork;
    clockwork.period = [first, last];
    goTo(time);
    play(clockwork.isRunning);
  }

  /* Shows a time, or the nearest one that is recorded. */
  function goTo(time) {
    const [first, last] = clockwork.period;
    clockwork.go(last > first ? Math.min(Math.max((time - first) / (last - first), 0), 1) : 0);
  }

  const html = (name, attributes, ...children) => {
    const found = Object.assign(document.createElement(name), attributes);
    found.append(...children);
    return found;
  };
  const start = html("button", { type: "button", className: "play" });
  const slower = html("select", {}, ...SLOWER.map((n) => html("option", { value: String(n) }, n === 1 ? "real time" : `${n} times slower`)));
  slower.setAttribute("aria-label", "Speed of the animation");
  slower.value = String((clockwork.slowness = 10));
  const reach = html("input", { type: "range", step: "any", disabled: true });
  reach.setAttribute("aria-label", "Time of the run that the diagrams show");
  const clock = html("output", {}), legend = html("span", { className: "scale", hidden: true }, html("span", {}), html("i", {}), html("span", {}));

  start.addEventListener("click", async () => {
    if (columns) { play(!clockwork.isRunning); return; }
    start.disabled = true;
    show(await ask());
    play(true);
    start.disabled = false;
  });
  reach.addEventListener("input", () => { play(false); goTo(Number(reach.value)); });
  /* Slow enough for single strokes, the run is looked at where it is recorded finely. */
  slower.addEventListener("change", () => {
    clockwork.slowness = Number(slower.value);
    const from = columns?.time.at(-1) - model.stepping.window;
    if (columns && clockwork.slowness >= 100 && clockwork.time < from) goTo(from);
  });
  stillness.addEventListener("change", () => play(clockwork.isRunning));

  for (const [name, drawn] of Object.entries(model.figures)) {
    const figure = document.getElementById(`figure-${name}`);
    if (!figure?.querySelector("svg")) continue;
    if (!diagrams.length) figure.prepend(html("div", { className: "motion" }, start, slower, reach, clock, legend));
    diagrams.push(prepare(figure, drawn));
  }
  play(false);
  return { show };
}
