const SVG = "http://www.w3.org/2000/svg";
const TRAVEL = 90; // px that the fastest line moves in one period

/** The value of a column at a time, between its rows. */
function valueAt(times, values, time) {
  const [low, high, part] = rowsAt(times, time);
  return values[low] + part * (values[high] - values[low]);
}

/** The integral of a column over its times. */
function integral(times, values) {
  const sum = new Float64Array(values.length);
  for (let i = 1; i < sum.length; i++) sum[i] = sum[i - 1] + 0.5 * (values[i] + values[i - 1]) * (times[i] - times[i - 1]);
  return sum;
}

/**
 * A named circuit diagram that shows an instant: lines coloured and widened by pressure, marks that move as far as the
 * oil in them, ports that open and close. `course` has `times`, `period`, and columns by name: `nodes` (pressures),
 * `flows` out of a component and `openings` (0 to 1), both by "part.port".
 */
class CircuitMotion {
  constructor(svg) {
    this.svg = svg;
    this.lines = [...svg.querySelectorAll("[data-node]")].map((group) => ({ group, node: group.dataset.node, key: group.dataset.owner && `${group.dataset.owner}.${group.dataset.port}` }));
    this.ports = new Map();
    for (const line of this.lines) if (line.key) this.#addMarks(line);
  }

  #addMarks(line) {
    const path = line.group.querySelector("polyline");
    if (!path) return;
    line.marks = path.cloneNode();
    for (const [name, text] of Object.entries({ class: "flow-marks", "stroke-dasharray": "3 15", "stroke-width": "2.4", stroke: "#fff", "pointer-events": "none" })) line.marks.setAttribute(name, text);
    path.after(line.marks);
    line.start = path.points[0];
  }

  /** Takes the course of a run; what the diagram shows stays until the next `show`. */
  take(course) {
    this.course = course;
    const all = Object.values(course.nodes).flatMap((values) => [Math.min(...values), Math.max(...values)]);
    this.range = [Math.min(0, ...all), Math.max(1, ...all)];
    this.moved = new Map(Object.entries(course.flows).map(([key, flow]) => [key, integral(course.times, flow)]));
    const [begin, end] = course.period;
    const most = Math.max(1e-12, ...[...this.moved.values()].map((sum) => Math.abs(valueAt(course.times, sum, end) - valueAt(course.times, sum, begin))));
    this.perVolume = TRAVEL / most;
    for (const line of this.lines) if (line.key in course.openings && line.start && !line.port) line.port = this.#addPort(line);
  }

  #addPort(line) {
    const port = document.createElementNS(SVG, "g");
    const parts = [["circle", { r: 8, class: "port-rim" }], ["circle", { r: 0, class: "port-hole" }], ["path", { d: "M -5.6 -5.6 L 5.6 5.6", class: "port-bar" }], ["title", {}]];
    port.append(...parts.map(([tag, attributes]) => {
      const made = document.createElementNS(SVG, tag);
      for (const [name, text] of Object.entries(attributes)) made.setAttribute(name, text);
      return made;
    }));
    port.setAttribute("class", "port");
    port.setAttribute("transform", `translate(${line.start.x} ${line.start.y})`);
    this.svg.querySelector("g").append(port);
    return port;
  }

  /** Shows the instant `time` [s]; gives what it shows: pressures by node, openings by port. */
  show(time) {
    const { course, range } = this;
    const at = (values) => valueAt(course.times, values, time);
    const shown = { nodes: {}, openings: {} };
    for (const name of Object.keys(course.nodes)) shown.nodes[name] = at(course.nodes[name]);
    for (const line of this.lines) {
      if (!(line.node in shown.nodes)) continue;
      const share = (shown.nodes[line.node] - range[0]) / (range[1] - range[0]);
      line.group.style.color = pressureColour(share);
      line.group.style.strokeWidth = String(2.2 + 3.4 * Math.min(Math.max(share, 0), 1));
      const moved = this.moved.get(line.key);
      if (line.marks) line.marks.style.display = moved && !wantsStillness() ? "" : "none";
      if (line.marks && moved) line.marks.style.strokeDashoffset = String(-this.perVolume * (at(moved) - valueAt(course.times, moved, course.period[0])));
      if (line.port) shown.openings[line.key] = this.#showPort(line, at(course.openings[line.key]));
    }
    return shown;
  }

  #showPort(line, opening) {
    const [, hole, bar, title] = line.port.children;
    hole.setAttribute("r", String(6.6 * Math.sqrt(Math.min(Math.max(opening, 0), 1))));
    bar.style.display = opening > 0.005 ? "none" : "";
    line.port.style.color = line.group.style.color;
    title.textContent = `${line.key.replaceAll("_", " ").replace(".", ", ")}: ${Math.round(100 * opening)} % open`;
    return opening;
  }
}
