/** Series that are added by name: they make a scope of their own, with a panel for each unit. */
const OWN_SCOPE = "series";
const added = { names: [], known: new Map() };

function showKnownSeries(series) {
  added.known = new Map(series);
  $("series-names").replaceChildren(...series.map(([name, label]) => element("option", { value: name, label })));
}

function nameSeries(names) {
  added.names = names;
  $("series-added").replaceChildren(...names.map((name) => {
    const button = element("button", { type: "button", "aria-label": `Remove ${name}` }, `${name} ✕`);
    button.addEventListener("click", () => changeSeries(added.names.filter((other) => other !== name)));
    return button;
  }));
}

/** Takes other names; of a whole run that is on view the scope comes from the server at once. */
function changeSeries(names) {
  nameSeries(names);
  if (names.length) state.wanted?.add(OWN_SCOPE);
  const isRunning = !$("stop").disabled || document.body.classList.contains("is-draft");
  ask(isRunning ? "whole" : "series");
}

function addSeries() {
  const name = $("series").value.trim();
  $("series-fault").textContent = !name || added.known.has(name) ? "" : `${name}: no series of this run has this name`;
  if (!added.known.has(name)) return;
  $("series").value = "";
  if (!added.names.includes(name)) changeSeries([...added.names, name]);
}

/** The scope of the run on view, in place of the one before; none where nothing is added. */
function takeSeries(charts) {
  if (!state.figures) return;
  state.figures.charts = [...state.figures.charts.filter((each) => each.name !== OWN_SCOPE), ...charts];
  redrawCharts();
}

function listenSeries() {
  $("series").addEventListener("change", addSeries);
}
