/** The full-screen view for a class: one diagram that moves, one scope over one period, and a few sliders. */
/** Duty ratio, load, speed and air: of each the first value whose key has one of the forms, the likeliest form first. */
const LESSON = [[/duty_ratio$/], [/load\.(area|pressure|force|mass)$/, /load_pressure$/, /load[^.]*\.(?!.*(volume|start|coefficient|exponent))[^.]*$/], [/pump_speed$/, /speed$/, /frequency$/], [/air_fraction$/]];
const FULL = ["#d9730d", "#0b5cad", "#1a7f5a", "#7a3e9d"];
const teach = { motion: null, chart: null, clock: new SlowClock((time) => showInstant(time)), course: null };

/** What each packet says of the last periods. */
function showCourse(course) {
  schematic.course = course;
  if ($("teach").open) showLesson();
}

function openTeach() {
  const drawn = $("diagram").querySelector("svg");
  if (!drawn) return;
  $("teach").showModal();
  $("teach-title").textContent = document.title.replace(/ · vvdp workbench$/, "");
  teach.chart = null;
  const svg = drawn.cloneNode(true);
  for (const each of svg.querySelectorAll("[tabindex]")) for (const name of ["tabindex", "role", "aria-label"]) each.removeAttribute(name);
  svg.setAttribute("role", "img");
  for (const line of svg.querySelectorAll("text tspan:not([font-weight])")) line.remove();
  $("teach-diagram").replaceChildren(svg);
  cropped(svg);
  teach.motion = new CircuitMotion(svg);
  $("teach-chart").replaceChildren();
  $("teach-values").replaceChildren(...lessonRows().map(lessonSlider));
  if (schematic.course) showLesson();
  play(!wantsStillness());
  $("play").focus();
}

/** Values for duty ratio, load, speed and air, as far as the circuit has them; else the first that can be moved. */
function lessonRows() {
  const movable = state.rows.filter((row) => row.number !== undefined && !/^(run|limits|initial)\./.test(row.key));
  const first = (forms) => forms.map((form) => movable.find((row) => form.test(row.key))).find(Boolean);
  const found = LESSON.map(first).filter(Boolean);
  return [...new Set(found.length > 1 ? found : [...found, ...movable.slice(0, 3)])];
}

/** A slider that moves the same value as the one of the table. */
function lessonSlider(row) {
  const own = [...document.querySelectorAll(".value")].find((each) => each.dataset.key === row.key).querySelector("[type=range]");
  const words = (value) => withUnit(formatNumber(+value, 3), row.unit);
  const slider = element("input", { type: "range", min: own.min, max: own.max, step: "any", value: own.value });
  const output = element("output", {}, words(own.value));
  for (const name of ["input", "change"]) slider.addEventListener(name, () => { own.value = slider.value; output.textContent = words(slider.value); own.dispatchEvent(new Event(name)); });
  slider.addEventListener("keydown", (event) => arrow(event, slider));
  return element("label", {}, row.key.split(".").slice(-2).join(", ").replaceAll("_", " ").replace(/^operation, /, ""), slider, output);
}

/** Shows other data; the instant keeps its place in the period. */
function showLesson() {
  const { course } = schematic;
  teach.course = course;
  teach.motion.take(course);
  teach.clock.period = course.period;
  const [low, high] = teach.motion.range;
  const [first, , last] = $("teach-scale").children;
  first.textContent = `${formatNumber(low, 3)} bar`;
  last.textContent = `${formatNumber(high, 3)} bar`;
  $("teach-scale").children[1].style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(pressureColour).join(", ")})`;
  showScope(course);
  teach.clock.go(teach.clock.share);
}

/** The chart of one period: pressures, and open ports below. */
function showScope(course) {
  const columns = [course.times.map((time) => 1000 * (time - course.period[0]))];
  const line = (label, values, i, unit) => ({ label: label.replaceAll("_", " "), unit, colour: FULL[i % FULL.length], stroke: "-", width: 2.2, x: 0, y: columns.push(values) - 1 });
  const x = { label: "time [ms]", name: "time", unit: "ms", low: 0, high: 1000 * (course.period[1] - course.period[0]), log: false };
  const panel = (name, unit, ends, lines) => ({ kind: "lines", title: "", height: 1, equal: false, legend: "", link: "teach", x, y: { label: unit ? `${name} [${unit}]` : name, name, unit, low: ends[0], high: ends[1], log: false }, lines, levels: [] });
  const pressures = lessonPressures(course).map((name, i) => line(name, course.nodes[name], i, "bar"));
  const openings = Object.entries(course.openings).slice(0, 4).map(([key, values], i) => line(key.replace(".", ", "), values, i, ""));
  const described = { name: "teach", sideBySide: false, share: false, panels: [panel("pressure", "bar", [null, null], pressures), ...(openings.length ? [panel("open fraction", "", [0, 1.05], openings)] : [])] };
  if (teach.chart?.fits(described)) { teach.chart.update(described, (place) => columns[place]); return; }
  const still = document.createElementNS(SVG, "svg");
  still.setAttribute("height", String(Math.max(260, 0.5 * innerHeight)));
  const figure = element("figure", {}, still);
  $("teach-chart").replaceChildren(figure);
  teach.chart = new LiveChart(described, figure, (place) => columns[place]);
  teach.now = teach.chart.plots.map((plot) => plot.frame.over.appendChild(element("i", { class: "teach-now" })));
}

/** The volumes whose pressure moves most. */
function lessonPressures(course) {
  const ripple = (name) => { const [low, high] = extremes(course.nodes[name]); return high - low; };
  return Object.keys(course.nodes).filter((name) => name in course.curves).sort((a, b) => ripple(b) - ripple(a)).slice(0, 3);
}

/** Shows one instant in diagram, scope and words. */
function showInstant(time) {
  if (!teach.course) return;
  const shown = teach.motion.show(time);
  $("instant").value = String(teach.clock.share);
  $("instant").setAttribute("aria-valuetext", `${formatNumber(1000 * (time - teach.course.period[0]), 3)} ms`);
  teach.chart.plots.forEach((plot, i) => { teach.now[i].style.transform = `translateX(${plot.frame.valToPos(1000 * (time - teach.course.period[0]), "x")}px)`; });
  $("teach-pressures").replaceChildren(...lessonPressures(teach.course).map((name, i) => element("span", { style: `--own:${FULL[i]}` }, `${name.replaceAll("_", " ")} `, element("b", {}, `${shown.nodes[name].toFixed(1)} bar`))));
}

function play(isRunning) {
  teach.clock.run(isRunning);
  $("play").textContent = isRunning ? "Pause" : "Play";
  $("play").setAttribute("aria-pressed", String(isRunning));
}

function listenTeach() {
  $("open-teach").addEventListener("click", openTeach);
  $("close-teach").addEventListener("click", () => $("teach").close());
  $("teach").addEventListener("close", () => play(false));
  $("play").addEventListener("click", () => play(!teach.clock.isRunning));
  $("instant").addEventListener("input", () => { play(false); teach.clock.go(+$("instant").value); });
  $("slowness").addEventListener("input", () => {
    teach.clock.slowness = Math.round(10 ** $("slowness").value);
    $("slowed").textContent = `${teach.clock.slowness} times`;
  });
}
