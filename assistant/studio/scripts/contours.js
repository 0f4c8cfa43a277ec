// The contours of a drawing: its picture, in which a click leaves one out or takes it back, and a list of the same.
import { made, said, shown, word } from "./words.js";

export const COLOURS = ["#d7301f", "#2667c9", "#1d7a3d", "#8a2a86", "#b77900", "#1f9aa8", "#5a6673"];
const MOST_NUMBERED = 400, MOST_LISTED = 300; // as in the picture of `check --plot`; a longer list is slow
const NUMBER_HIGH = 12, REACH = 12; // px: of a number, and around a line within which a click is on it

const part = (name, values, text) => {
  const one = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(values)) one.setAttribute(key, value);
  if (text !== undefined) one.textContent = text;
  return one;
};
const numbered = ({ numbers }) => (numbers.length > 1 ? `${numbers[0]}–${numbers.at(-1)}` : String(numbers[0] ?? ""));
const called = (one) => [numbered(one), one.what].filter(Boolean).join(" · ");

/** The picture, and the state below it. chooses: called with a layer. chosen: the layer whose contours a click switches. */
export function picture(found, { chooses, chosen }) {
  const box = made("div", undefined, "picture"), state = made("p"), svg = part("svg", { role: "img", "aria-label": found.path });
  const names = found.layers.map((layer) => layer.name), work = found.lines.filter((line) => line.contour !== undefined);
  const drawn = found.contours.map(() => []);
  state.setAttribute("role", "status");
  const tell = (text) => { state.textContent = text || (chosen() && found.contours.some((one) => one.layer === chosen()) ? `${shown(chosen())}: ${word("click_contour")}` : word("click_layer")); };
  for (const { layer, points, contour } of found.lines) {
    const corners = points.map(([x, y]) => `${x},${-y}`).join(" "), colour = COLOURS[Math.max(0, names.indexOf(layer)) % COLOURS.length];
    const line = part("polyline", { points: corners, fill: "none", stroke: colour, "stroke-width": "1.5", "vector-effect": "non-scaling-stroke" });
    const reach = part("polyline", { points: corners, class: "reach", fill: "none", stroke: "transparent", "stroke-width": REACH, "vector-effect": "non-scaling-stroke" });
    line.dataset.of = layer;
    const one = found.contours[contour], click = () => {
      if (!one || layer !== chosen()) { chooses(layer); tell(""); return; }
      const tick = box.parentElement.querySelector(`[data-contour="${contour}"]`);
      if (!tick || tick.disabled) return;
      tick.checked = !tick.checked;
      tick.dispatchEvent(new Event("change", { bubbles: true }));
    };
    line.addEventListener("click", click);
    reach.addEventListener("click", click);
    if (one) {
      drawn[contour].push(line);
      reach.dataset.line = contour;
      reach.append(part("title", {}, called(one)));
    }
    svg.append(line, reach);
  }
  const total = found.contours.reduce((sum, one) => sum + one.numbers.length, 0);
  for (const { points, contour } of total <= MOST_NUMBERED ? work : []) {
    const text = numbered(found.contours[contour]), [x, y] = points[0];
    if (text) { const number = part("text", { x, y: -y, dx: "0.3em", dy: "-0.3em" }, text); drawn[contour].push(number); svg.append(number); }
  }
  const show = (i, used) => { for (const line of drawn[i]) line.classList.toggle("left", !used); };
  found.contours.forEach((one, i) => show(i, !one.left));
  framed(svg, work.length ? work : found.lines);
  box.append(svg, state, views(found));
  box.switched = (i, used) => { show(i, used); tell(`${called(found.contours[i])}: ${word(used ? "followed" : "left_out")}`); };
  box.told = tell;
  return box;
}
/** The work fills the picture; the wheel zooms, a drag moves, a double click shows all of it again. */
function framed(svg, lines) {
  if (!lines.length) return;
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const { points } of lines) for (const [x, y] of points) {
    low[0] = Math.min(low[0], x); low[1] = Math.min(low[1], -y); high[0] = Math.max(high[0], x); high[1] = Math.max(high[1], -y);
  }
  const size = [Math.max(1e-3, high[0] - low[0]), Math.max(1e-3, high[1] - low[1])], edge = 0.06 * Math.max(...size);
  const whole = [low[0] - edge, low[1] - edge, size[0] + 2 * edge, size[1] + 2 * edge];
  let view = whole, held = null;
  const scale = () => Math.max(view[2] / Math.max(1, svg.clientWidth), view[3] / Math.max(1, svg.clientHeight)); // mm of a px
  const look = (next) => { view = next; svg.setAttribute("viewBox", view.join(" ")); svg.style.fontSize = `${NUMBER_HIGH * scale()}px`; apart(svg, NUMBER_HIGH * scale()); };
  const place = ({ clientX, clientY }) => { const at = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse()); return [at.x, at.y]; };
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [x, y] = place(event), by = Math.exp(event.deltaY * 0.002);
    if (view[2] * by > 20 * whole[2] || view[2] * by < 1e-3 * whole[2]) return;
    look([x + (view[0] - x) * by, y + (view[1] - y) * by, view[2] * by, view[3] * by]);
  }, { passive: false });
  svg.addEventListener("pointerdown", (event) => { if (event.button === 0) held = { from: [event.clientX, event.clientY], view, moved: false }; });
  svg.addEventListener("pointermove", (event) => {
    if (!held || !event.buttons) return;
    const [x, y] = [event.clientX - held.from[0], event.clientY - held.from[1]];
    if (!held.moved && Math.hypot(x, y) < 4) return;
    held.moved = true;
    look([held.view[0] - x * scale(), held.view[1] - y * scale(), view[2], view[3]]);
  });
  svg.addEventListener("click", (event) => { if (held?.moved) event.stopPropagation(); held = null; }, true); // a drag is no click
  svg.addEventListener("dblclick", () => look(whole));
  look(whole);
  new ResizeObserver(() => look(view)).observe(svg);
}
/** Groups of contours apart from the largest one, as a side view is: a click leaves one out or takes it back. */
function views(found) {
  const box = made("p", undefined, "views"), ticks = (one) => one.contours.map((i) => box.closest("#panel-drawing").querySelector(`[data-contour="${i}"]`)).filter((tick) => tick && !tick.disabled);
  box.hidden = !found.views.length;
  box.append(said("span", "views"), " ");
  for (const one of found.views.slice(1)) {
    const button = made("button", `${one.size.join(" × ")} mm (${one.contours.length})`);
    button.type = "button";
    button.setAttribute("aria-pressed", String(one.contours.every((i) => found.contours[i].left)));
    button.addEventListener("click", () => {
      const used = button.getAttribute("aria-pressed") === "true";
      for (const tick of ticks(one)) if (tick.checked !== used) { tick.checked = used; tick.dispatchEvent(new Event("change", { bubbles: true })); }
      button.setAttribute("aria-pressed", String(!used));
    });
    box.append(button, " ");
  }
  return box;
}
/** Of numbers that would stand over each other the first one is shown; zooming in shows the others. */
function apart(svg, high) {
  const taken = [];
  for (const one of svg.querySelectorAll("text")) {
    const x = Number(one.getAttribute("x")), y = Number(one.getAttribute("y")), wide = 0.65 * high * one.textContent.length;
    const free = !taken.some((other) => Math.abs(y - other.y) < high && x < other.x + other.wide && other.x < x + wide);
    one.style.display = free ? "" : "none";
    if (free) taken.push({ x, y, wide });
  }
}
/** The contours of a layer, to tick those that are followed. */
export function contourList(found, layer) {
  const box = made("details", undefined, "contours"), head = made("summary"), list = made("ul"), ticks = [];
  const rows = found.contours.map((one, i) => [one, i]).filter(([one]) => one.layer === layer)
    .sort(([one], [other]) => (one.numbers[0] ?? Infinity) - (other.numbers[0] ?? Infinity) || 0);
  const count = () => { head.textContent = `${word("contours")}: ${ticks.filter((one) => one.checked).length} / ${rows.length}`; };
  for (const [one, i] of rows) {
    const row = made("li"), label = made("label"), tick = made("input");
    tick.type = "checkbox";
    tick.defaultChecked = !one.left;
    tick.disabled = !one.at;
    tick.dataset.contour = i;
    tick.addEventListener("change", () => { count(); tick.closest("#panel-drawing").querySelector(".picture").switched(i, tick.checked); });
    label.append(tick, made("span", called(one)));
    row.append(label);
    row.hidden = ticks.push(tick) > MOST_LISTED; // those are had by a click in the picture
    list.append(row);
  }
  const all = (key, used) => {
    const one = said("button", key);
    one.type = "button";
    one.addEventListener("click", () => { for (const tick of ticks) if (!tick.disabled && tick.checked !== used) { tick.checked = used; tick.dispatchEvent(new Event("change", { bubbles: true })); } });
    return one;
  };
  const both = made("p");
  both.append(all("all_contours", true), " ", all("no_contours", false));
  box.append(head, both, list);
  count();
  return box;
}
/** What was switched, as the studio takes it. */
export const switchedContours = (found, form) => [...form.querySelectorAll("[data-contour]")]
  .filter((tick) => tick.checked !== tick.defaultChecked)
  .map((tick) => { const { layer, at } = found.contours[tick.dataset.contour]; return { layer, at, used: tick.checked }; });
