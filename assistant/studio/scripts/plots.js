// Curves over time, with axes, units and a legend that tells the values at a time.
import { find, made } from "./words.js";

const NS = "http://www.w3.org/2000/svg", HIGH = 150, LEFT = 58, RIGHT = 8, TOP = 8, BELOW = 34;
const drawn = new Set(); // plots that are on the page
let at = null; // seconds at which the values are told, null for nowhere

function part(name, attributes, text) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}
/** Round numbers that divide a range. */
function ticks(low, high, most) {
  const raw = Math.max(high - low, 1e-9) / Math.max(1, most), ten = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * ten).find((one) => one >= raw), found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}
const short = (value) => (Math.abs(value) >= 1e5 ? value.toExponential(1) : String(Number(value.toFixed(Math.abs(value) >= 100 ? 1 : 3))));

/** Where a time is among times that grow: the last that is not after it. */
export function indexAt(t, time) {
  let low = 0, high = t.length - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (t[middle] <= time + 1e-9) low = middle; else high = middle - 1; }
  return low;
}
/** A plot. curves: [{name, t, values, second}]; second: of another program, drawn in dashes. across: seconds when it is clicked. */
export function plot({ id, title, unit, over, curves, across }) {
  const figure = made("figure", undefined, "curves"), caption = made("figcaption"), svg = part("svg", { class: "plot", role: "img", "aria-label": `${title}, ${unit}` });
  figure.id = id;
  const values = curves.map((curve, i) => {
    const item = made("span", undefined, `curve-${curve.colour ?? i}${curve.second ? " second" : ""}`), value = made("output");
    item.append(made("b", curve.second ? "┅ " : "━ "), curve.name, " ", value);
    return { item, value };
  });
  caption.append(made("strong", `${title}, ${unit}`), " ", ...values.map(({ item }) => item));
  const field = made("div", undefined, "field"), cursor = made("div", undefined, "cursor"); // of its own, so that curves are not drawn anew
  field.append(svg, cursor);
  figure.append(caption, field);
  let scale = null;
  const draw = () => {
    const wide = Math.max(220, svg.clientWidth || figure.clientWidth || 480), inside = wide - LEFT - RIGHT, high = HIGH - TOP - BELOW;
    let end = 0, low = Infinity, top = -Infinity;
    for (const { t, values: column } of curves) {
      end = Math.max(end, t.at(-1) ?? 0);
      for (const value of column) { if (value < low) low = value; if (value > top) top = value; }
    }
    if (!(top >= low)) { low = 0; top = 1; }
    if (top - low < 1e-6) { low -= 1; top += 1; }
    const marks = ticks(low, top, 5), edge = (top - low) * 0.04;
    low -= edge; top += edge; end = end || 1;
    const x = (time) => LEFT + (time / end) * inside, y = (value) => TOP + ((top - value) / (top - low)) * high;
    svg.setAttribute("viewBox", `0 0 ${wide} ${HIGH}`);
    svg.style.height = `${HIGH}px`;
    svg.replaceChildren();
    for (const mark of marks) {
      svg.append(part("line", { x1: LEFT, x2: wide - RIGHT, y1: y(mark), y2: y(mark), class: "grid" }));
      svg.append(part("text", { x: LEFT - 5, y: y(mark) + 4, "text-anchor": "end" }, short(mark)));
    }
    for (const mark of ticks(0, end, Math.max(2, inside / 70))) {
      svg.append(part("line", { x1: x(mark), x2: x(mark), y1: TOP, y2: TOP + high, class: "grid" }));
      svg.append(part("text", { x: x(mark), y: HIGH - BELOW + 14, "text-anchor": "middle" }, short(mark)));
    }
    svg.append(part("text", { x: LEFT + inside / 2, y: HIGH - 4, "text-anchor": "middle" }, over));
    svg.append(part("text", { x: 0, y: 0, "text-anchor": "middle", transform: `translate(11 ${TOP + high / 2}) rotate(-90)` }, unit));
    curves.forEach(({ t, values: column, second, colour }, i) => {
      const points = column.map((value, k) => `${k ? "L" : "M"}${x(t[k]).toFixed(1)} ${y(value).toFixed(1)}`).join("");
      svg.append(part("path", { d: points || "M0 0", class: `curve-${colour ?? i}${second ? " second" : ""}` }));
    });
    scale = { x, end, wide, inside };
    mark();
  };
  const mark = () => {
    if (!scale) return;
    cursor.hidden = at === null;
    if (at !== null) cursor.style.transform = `translateX(${scale.x(Math.min(at, scale.end)).toFixed(1)}px)`;
    curves.forEach(({ t, values: column }, i) => { values[i].value.textContent = at === null || !t.length ? "" : short(column[indexAt(t, at)]); });
  };
  const seconds = (event) => {
    const box = svg.getBoundingClientRect(), place = ((event.clientX - box.left) / box.width) * scale.wide;
    return Math.min(scale.end, Math.max(0, ((place - LEFT) / scale.inside) * scale.end));
  };
  svg.addEventListener("pointerdown", (event) => { if (scale) { svg.setPointerCapture(event.pointerId); across?.(seconds(event)); } });
  svg.addEventListener("pointermove", (event) => { if (scale && event.buttons) across?.(seconds(event)); });
  const seen = new ResizeObserver(() => { if (figure.isConnected && figure.clientWidth) draw(); });
  seen.observe(figure);
  drawn.add({ figure, mark, seen });
  return figure;
}
/** Puts plots in place of those that an element had. */
export function showPlots(id, figures) {
  find(id).replaceChildren(...figures);
  for (const one of drawn) if (!one.figure.isConnected) { one.seen.disconnect(); drawn.delete(one); }
}
/** Tells the values at a time, in all plots; null for no time. */
export function markTime(time) {
  at = time;
  for (const { mark } of drawn) mark();
}
