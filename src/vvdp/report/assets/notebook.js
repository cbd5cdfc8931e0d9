"use strict";

/** One live chart, and where there is data of several runs a slider that shows one after the other. */
async function startNotebook() {
  const { charts, column } = await unpackPage(document.getElementById("chart-data").textContent);
  const place = document.getElementById("words");
  const words = JSON.parse(place.dataset.words);
  const middle = Math.floor(words.length / 2);
  const chart = new LiveChart(charts[middle], document.querySelector("figure"), column);
  if (words.length === 1) return chart;
  const slider = element("input", { type: "range", min: "0", max: String(words.length - 1), step: "1", value: String(middle) });
  const output = element("output", {}, words[middle]);
  slider.setAttribute("aria-valuetext", words[middle]);
  slider.addEventListener("input", () => {
    chart.update(charts[+slider.value], column);
    output.textContent = words[+slider.value];
    slider.setAttribute("aria-valuetext", words[+slider.value]);
  });
  place.append(element("label", {}, place.dataset.label, slider, output));
  return chart;
}

const vvdpNotebook = startNotebook();
