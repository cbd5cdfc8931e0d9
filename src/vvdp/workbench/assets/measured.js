/** Measured channels that lie over the scopes of their unit. */
const measured = { logs: [], laid: [] };

function showLogs(logs) {
  measured.logs = logs;
  $("measured").hidden = !logs.length;
  $("log").replaceChildren(...logs.map((name) => element("option", { value: name }, name)));
  $("measured").addEventListener("toggle", () => { if ($("measured").open && !$("channel").options.length) openLog(); });
}

async function openLog() {
  const found = await post("/api/log", { log: $("log").value });
  tellMeasured(found.faults);
  $("channel").replaceChildren(...(found.channels ?? []).map(({ name, unit }) => element("option", { value: name, "data-unit": unit }, unit ? `${name} [${unit}]` : name)));
  showUnit();
}

/** A unit is asked for where the file has none. */
function showUnit() { $("unit").parentElement.hidden = Boolean($("channel").selectedOptions[0]?.dataset.unit ?? true); }

function tellMeasured(faults = []) { $("measured-fault").textContent = faults.map((each) => each.message).join("\n"); }

async function layOver() {
  const asked = { log: $("log").value, channel: $("channel").value, unit: $("unit").parentElement.hidden ? "" : $("unit").value };
  const answer = await fetch("/api/channel", { method: "POST", body: JSON.stringify(asked) });
  if (!answer.ok) { tellMeasured((await answer.json()).faults); return; }
  const [{ channel }, column] = unpack(await answer.arrayBuffer());
  const times = column(channel.x);
  const until = Math.max(...state.figures.charts.flatMap((chart) => chart.panels.map((panel) => (panel.x.unit === "s" && panel.lines ? chart.column(panel.lines[0].x).at(-1) : 0))));
  const begin = times[0] < 0 || times[0] > until ? 0 : times[0];
  measured.laid.push({ ...channel, log: asked.log, times, values: column(channel.y), begin });
  tellMeasured(channel.remarks.map((message) => ({ message })));
  showLaid();
}

function showLaid() {
  $("laid").replaceChildren(...measured.laid.map((each) => {
    const begin = element("input", { type: "text", inputmode: "decimal", value: String(each.begin), "aria-label": `${each.label} begins at, in seconds` });
    begin.addEventListener("change", () => {
      const number = Number(begin.value);
      tellMeasured(begin.value.trim() && Number.isFinite(number) ? [] : [{ message: `${begin.value}: must be a number of seconds` }]);
      if (begin.value.trim() && Number.isFinite(number)) { each.begin = number; redrawCharts(); }
    });
    const remove = element("button", { type: "button", "aria-label": `Remove ${each.label}` }, "Remove");
    remove.addEventListener("click", () => { measured.laid = measured.laid.filter((other) => other !== each); showLaid(); });
    const fits = [...live.values()].some(({ chart }) => chart.described.panels.some((panel) => fitsPanel(each, panel)));
    const words = fits ? "begins at" : `no scope on view has ${each.unit || "this unit"} over time; begins at`;
    return element("div", { class: "kept" }, element("b", {}, `${each.label}, ${each.log}`), element("span", {}, words), begin, "s", remove);
  }));
  redrawCharts();
}

function fitsPanel(each, panel) { return panel.kind === "lines" && panel.x.unit === "s" && panel.y.unit === each.unit; }

/** The lines that lie over a panel, with the columns that they need at places from `first` on. */
function laidLines(panel, first, columns) {
  return measured.laid.filter((each) => fitsPanel(each, panel)).map((each, i) => {
    const place = first + columns.length;
    columns.push(each.times.map((time) => time - each.times[0] + each.begin), each.values);
    return { label: `${each.label} (measured)`, unit: each.unit, colour: ["#7a3e9d", "#1a7f5a", "#b3476b"][i % 3], stroke: ":", width: 1.6, x: place, y: place + 1 };
  });
}

function listenMeasured() {
  $("log").addEventListener("change", openLog);
  $("channel").addEventListener("change", showUnit);
  $("lay").addEventListener("click", layOver);
}
