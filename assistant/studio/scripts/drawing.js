// A drawing: its lines, its layers, and the process of each.
import { find, made, said, shown, word } from "./words.js";
import { ask, look } from "./server.js";
import { doing } from "./findings.js";
import { on } from "./line.js";
import { choose } from "./tabs.js";
import { fill } from "./parts.js";
import { showScene } from "./scene.js";
import { project, readProject, whenChosen } from "./project.js";

const COLOURS = ["#d7301f", "#2667c9", "#1d7a3d", "#8a2a86", "#b77900", "#1f9aa8", "#5a6673"];
const OPTIONS = [["process", "text"], ["speed", "number"], ["approach", "number"], ["retract", "number"], ["travel", "number"], ["offset", "number"]];
const NAMES = { "motion.tool": "tool", "tools.tool.tip": "tip", "frames.work.position": "position", "frames.work.euler_zyx": "turned", "placement.position": "placed", "placement.euler_zyx": "placed_turned", "motion.speed": "motion_speed" };
let path = "", read = "", layerNow = ""; // the drawing that is shown, what was read of it, and the layer whose options are shown

async function show(file) {
  const drawing = file.kind === "drawing" ? file.path : project.files.find((one) =>
    file.kind === "process" && one.kind === "drawing" && one.path.replace(/\.[^.]+$/, "") === file.path.replace(/\.process\.toml$/, ""))?.path;
  if (!drawing) return;
  path = drawing;
  find("panel-drawing").replaceChildren(); // values of one drawing are not written to another
  const found = await doing(() => look("drawing", { path: drawing }));
  if (!found || path !== drawing) return;
  draw(found);
  if (file.kind === "drawing") choose("tab-drawing");
}
function draw(found) {
  const panel = find("panel-drawing"), form = made("form");
  panel.replaceChildren(made("h2", found.path), picture(found), form);
  form.append(layerTable(found), ...found.layers.map(layerOptions), values(found), said("button", "write_process"));
  read = JSON.stringify(found);
  const names = found.layers.map((layer) => layer.name);
  chooseLayer(names.includes(layerNow) ? layerNow : found.layers.find((layer) => layer.used)?.name ?? names[0]);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const done = await doing(() => ask("drawing/process", { path: found.path, values: stated(form) }));
    if (done && path === found.path) { draw(done); await readProject(); await showScene(done.path); }
  });
}
/** What the disk has now is shown at once, if nothing is being typed here; else it is asked. */
async function changedOnDisk({ files }) {
  const panel = find("panel-drawing"), form = panel.querySelector("form");
  const stem = path.replace(/\.[^./]+$/, "");
  if (!path || !files.some((one) => one === path || one === `${stem}.process.toml`)) return;
  const found = await look("drawing", { path }).catch(() => undefined); // taken away: what stands here stays
  if (!found || JSON.stringify(found) === read) return;
  if (Object.keys(stated(form)).length === 0) { draw(found); return; }
  panel.querySelector(".notice")?.remove();
  const asked = made("div", undefined, "notice"), take = said("button", "take_theirs"), keep = said("button", "keep_mine");
  asked.setAttribute("role", "alert");
  take.addEventListener("click", () => draw(found));
  keep.addEventListener("click", () => asked.remove());
  asked.append(said("span", "changed_on_disk"), take, keep);
  panel.prepend(asked);
}
function picture(found) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const names = found.layers.map((layer) => layer.name), box = [Infinity, Infinity, -Infinity, -Infinity];
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", found.path);
  for (const { layer, points } of found.lines) {
    const line = document.createElementNS(svg.namespaceURI, "polyline");
    for (const [x, y] of points) { box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], -y); box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], -y); }
    line.setAttribute("points", points.map(([x, y]) => `${x},${-y}`).join(" "));
    line.setAttribute("fill", "none");
    line.setAttribute("stroke", COLOURS[Math.max(0, names.indexOf(layer)) % COLOURS.length]);
    line.setAttribute("stroke-width", "1.5");
    line.setAttribute("vector-effect", "non-scaling-stroke");
    line.dataset.of = layer;
    line.addEventListener("click", () => chooseLayer(layer));
    svg.append(line);
  }
  const wide = Math.max(1, box[2] - box[0]), high = Math.max(1, box[3] - box[1]), edge = 0.03 * Math.max(wide, high);
  if (found.lines.length) svg.setAttribute("viewBox", [box[0] - edge, box[1] - edge, wide + 2 * edge, high + 2 * edge].join(" "));
  return svg;
}
/** Shows the options of a layer below the table, and its lines bold. */
function chooseLayer(name) {
  layerNow = name ?? "";
  const panel = find("panel-drawing");
  for (const row of panel.querySelectorAll("tr[data-layer]")) row.setAttribute("aria-current", String(row.dataset.layer === layerNow));
  for (const group of panel.querySelectorAll("fieldset[data-layer]")) group.hidden = group.dataset.layer !== layerNow;
  for (const line of panel.querySelectorAll("[data-of]")) line.setAttribute("stroke-width", line.dataset.of === layerNow ? "3" : "1.5");
}
function layerTable(found) {
  const table = made("table"), head = made("tr");
  for (const key of ["layers", "worked", "contours", "length"]) head.append(said("th", key));
  table.append(head);
  found.layers.forEach((layer, i) => {
    const row = made("tr"), name = made("td"), choose = made("button"), colour = made("span", "■ "), use = made("input"), cell = made("td");
    row.dataset.layer = layer.name;
    colour.style.color = COLOURS[i % COLOURS.length];
    choose.type = "button";
    choose.append(colour, shown(layer.name), " ", made("small", layer.use));
    name.append(choose);
    use.type = "checkbox";
    use.defaultChecked = layer.used;
    use.disabled = layer.closed + layer.open === 0;
    use.dataset.key = "used";
    use.setAttribute("aria-label", `${layer.name}: ${word("worked")}`);
    cell.append(use);
    row.addEventListener("click", (event) => { if (event.target !== use) chooseLayer(layer.name); });
    row.append(name, cell, made("td", String(layer.closed + layer.open + layer.locations)), made("td", layer.length ? layer.length.toFixed(0) : ""));
    table.append(row);
  });
  const group = made("fieldset");
  group.append(said("legend", "layers"), table);
  return group;
}
function layerOptions(layer) {
  const group = made("fieldset"), disabled = layer.closed + layer.open === 0;
  group.dataset.layer = layer.name;
  group.append(made("legend", layer.name));
  if (disabled) { group.append(made("p", layer.use, "empty")); return group; }
  for (const [key, type] of OPTIONS) {
    const input = made("input"), label = made("label");
    input.type = type;
    if (type === "number") input.step = "any";
    input.value = input.dataset.was = layer.values[key] ?? "";
    input.dataset.key = key;
    input.setAttribute("aria-label", `${layer.name}: ${word(key)}`);
    label.append(said("span", key), " ", input);
    group.append(label);
  }
  return group;
}
function values(found) {
  const group = made("fieldset");
  group.append(said("legend", "process"));
  for (const { field: name, key, value, choices } of found.values) {
    const label = made("label"), input = made(choices ? "select" : "input");
    if (choices) filledBy(input, choices, value ?? "");
    else input.type = "text";
    input.dataset.path = name;
    input.dataset.keys = JSON.stringify(key);
    if (!choices && !name.endsWith("speed")) input.dataset.many = "";
    if (!choices) input.value = Array.isArray(value) ? value.join(", ") : value ?? "";
    input.dataset.was = input.value;
    label.append(said("span", NAMES[name] ?? name), " ", input);
    group.append(label);
  }
  return group;
}
const filledBy = (select, choices, value) => fill(select, choices.map((one) => one || ["", "of_controller"]), value);
/** What was changed on the form, as tables of the process file; null takes a key away. */
function stated(form) {
  const out = Object.create(null); // so that a layer may have any name
  const put = (keys, value) => {
    let here = out;
    for (const key of keys.slice(0, -1)) here = here[key] ??= Object.create(null);
    here[keys.at(-1)] = value;
  };
  for (const input of form.querySelectorAll("[data-layer] input:not(:disabled)")) {
    const keys = ["layers", input.closest("[data-layer]").dataset.layer, input.dataset.key];
    if (input.type === "checkbox") { if (input.checked !== input.defaultChecked) put(keys, input.checked); }
    else if (input.value !== input.dataset.was) put(keys, input.value === "" ? null : input.type === "number" ? Number(input.value) : input.value);
  }
  for (const input of form.querySelectorAll("[data-path]")) {
    if (input.value !== input.dataset.was) put(JSON.parse(input.dataset.keys), input.tagName === "SELECT" ? input.value || null : typed(input.value, "many" in input.dataset));
  }
  return out;
}
/** Numbers; whatever is none goes as it was typed, and is told of. */
function typed(text, many) {
  const numbers = text.split(/[,;\s]+/).filter(Boolean).map(Number);
  if (!numbers.length) return null;
  if (numbers.some(Number.isNaN)) return text;
  return many ? numbers : numbers.length === 1 ? numbers[0] : text;
}
export function beginDrawing() {
  whenChosen(show);
  on("disk", changedOnDisk);
}
