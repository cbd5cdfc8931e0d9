(() => {
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const linear = (v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const light = (colour) => colour.slice(0, 3).reduce((sum, v, i) => sum + linear(v / 255) * [0.2126, 0.7152, 0.0722][i], 0);
  const lineage = (e) => (e ? [e, ...lineage(e.parentElement)] : []);
  const styles = (e) => lineage(e).map((each) => getComputedStyle(each));
  const ground = (e) => styles(e).map((s) => numbers(s.backgroundColor)).find((c) => c.length < 4 || c[3] > 0) ?? [255, 255, 255];
  const isPlain = (e) => styles(e).every((s) => s.opacity === "1" && s.filter === "none" && s.visibility === "visible");
  const hasText = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim());
  const isLarge = ({ fontSize, fontWeight }) => parseFloat(fontSize) >= (fontWeight >= 700 ? 18.66 : 24);
  const texts = [...document.querySelectorAll("body *")].filter((e) => !e.closest("svg, option, :disabled, .live-tools") && hasText(e) && e.checkVisibility() && isPlain(e));
  return texts.map((e) => {
    const [a, b] = [light(numbers(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
    return { ratio: (a + 0.05) / (b + 0.05), least: isLarge(getComputedStyle(e)) ? 3 : 4.5, text: e.textContent.slice(0, 40) };
  });
})()
