"use strict";

const INK = "#1b1f24";
const QUIET = "#4b545d";
const GRID = "#e6e9ec";
const NOTHING = "\u2013";
const FONT = '12px "Helvetica Neue", Arial, "Liberation Sans", "DejaVu Sans", sans-serif';
const DASHES = { "--": [6, 4], ":": [2, 3] };

/** An element with attributes and children. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** A number with at most so many significant digits, as the tables of the page have it. */
function formatNumber(value, digits = 5) {
  if (!Number.isFinite(value)) return NOTHING;
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  if (exponent >= -4 && exponent < 6) return withMinus(trimZeros(value.toFixed(Math.max(digits - 1 - exponent, 0))));
  const raised = [...String(Number(exponent))].map((each) => (each === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[each])).join("");
  return withMinus(`${trimZeros(mantissa)}·10${raised}`);
}

/** A value of x, with the places that a width of `span` can show. */
function formatAlong(value, span) {
  if (!Number.isFinite(value)) return NOTHING;
  const places = Math.min(Math.max(3 - Math.floor(Math.log10(span)), 0), 12);
  return withMinus(value.toFixed(places));
}

function trimZeros(text) {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

function withMinus(text) {
  return text.replace("-", "\u2212");
}

function withUnit(text, unit) {
  return unit && text !== NOTHING ? `${text} ${unit}` : text;
}

/** Words of the ticks of an axis. */
function tickLabels(ticks, step) {
  const largest = Math.max(...ticks.map(Math.abs));
  if (!step || largest >= 1e6 || largest < 1e-3) return ticks.map((value) => formatNumber(value, 4));
  let places = 0;
  while (places < 9 && Math.abs(step * 10 ** places - Math.round(step * 10 ** places)) > 1e-6) places++;
  return ticks.map((value) => withMinus((value === 0 ? 0 : value).toFixed(places)));
}

/** Ticks of a logarithmic axis: whole powers of ten, with 2 and 5 where there are few. */
function logTicks(low, high) {
  const ticks = [];
  const factors = Math.log10(high / low) > 3 ? [1] : [1, 2, 5];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
    ticks.push(...factors.map((factor) => factor * 10 ** power));
  }
  return ticks.filter((tick) => tick >= low * (1 - 1e-9) && tick <= high * (1 + 1e-9));
}

/** Ends moved apart by a share of what is between them. */
function widen([low, high], share, isLog) {
  if (!(low <= high)) return isLog ? [1, 10] : [0, 1];
  if (isLog) return [low * (high / low) ** -share || low / 2, high * (high / low) ** share].map((end, i) => (low === high ? end * [0.5, 2][i] : end));
  const room = share * (high - low) || Math.abs(low) * 0.05 || 1;
  return [low - room, high + room];
}
