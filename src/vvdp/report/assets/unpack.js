"use strict";

/**
 * The data of a page: a description of its charts and columns, and the numbers, deflated and in base64.
 * Returns the charts and a function that gives a column by its place; each is unpacked when first asked for.
 */
async function unpackPage(text) {
  const page = JSON.parse(text);
  const stream = new Blob([bytesOf(page.bytes)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = await new Response(stream).arrayBuffer();
  const known = new Map();
  const column = (place) => {
    if (!known.has(place)) known.set(place, unpackColumn(bytes, page.columns[place]));
    return known.get(place);
  };
  return { charts: page.charts, column };
}

/** Base64 as bytes, by the browser itself where it can. */
function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** The numbers of a column; `parts` counts its runs or blocks. */
function unpackColumn(bytes, { form, at, count, parts, block }) {
  if (form === "exact") return new Float64Array(bytes, at, count);
  if (form === "runs") return unpackRuns(new Float64Array(bytes, at, 3 * parts), count);
  return unpackBlocks(bytes, at, count, parts, block);
}

/** Stretches of even steps: start, step and count of each. */
function unpackRuns(runs, count) {
  const values = new Float64Array(count);
  let place = 0;
  for (let r = 0; r < runs.length; r += 3) {
    for (let i = 0; i < runs[r + 2]; i++) values[place++] = runs[r] + i * runs[r + 1];
  }
  return values;
}

/**
 * Each block has its lowest value and its step; the numbers are counts of that step, 65535 where there is none. Kept
 * are their differences modulo 65536, all low bytes before all high bytes.
 */
function unpackBlocks(bytes, at, count, parts, block) {
  const scales = new Float64Array(bytes, at, 2 * parts);
  const low = new Uint8Array(bytes, at + 16 * parts, count);
  const high = new Uint8Array(bytes, at + 16 * parts + count, count);
  const values = new Float64Array(count);
  let code = 0;
  for (let i = 0; i < count; i++) {
    code = (code + low[i] + 256 * high[i]) & 65535;
    const b = 2 * Math.floor(i / block);
    values[i] = code === 65535 ? NaN : scales[b] + code * scales[b + 1];
  }
  return values;
}
