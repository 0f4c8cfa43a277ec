// A drawing: its lines, its layers, and the process of each.
import { find, made, said, shown, word } from "./words.js";
import { ask, look } from "./server.js";
import { doing } from "./findings.js";
import { on } from "./line.js";
import { choose } from "./tabs.js";
import { project, readProject, whenChosen } from "./project.js";

const COLOURS = ["#d7301f", "#2667c9", "#1d7a3d", "#8a2a86", "#b77900", "#1f9aa8", "#5a6673"];
const COLUMNS = [["process", "text"], ["speed", "number"], ["approach", "number"], ["retract", "number"], ["offset", "number"]];
const NAMES = { "tools.tool.tip": "tip", "frames.work.position": "position", "frames.work.euler_zyx": "turned", "placement.position": "placed", "placement.euler_zyx": "placed_turned", "motion.speed": "motion_speed" };
let path = "", read = ""; // the drawing that is shown, and what was read of it

async function show(file) {
  const drawing = file.kind === "drawing" ? file.path : project.files.find((one) =>
    file.kind === "process" && one.kind === "drawing" && one.path.replace(/\.[^.]+$/, "") === file.path.replace(/\.process\.toml$/, ""))?.path;
  if (!drawing) return;
  path = drawing;
  find("panel-drawing").replaceChildren(); // values of one drawing are not written to another
  const found = await doing(() => look("drawing", { path: drawing }));
  if (!found || path !== drawing) return;
  fill(found);
  if (file.kind === "drawing") choose("tab-drawing");
}
function fill(found) {
  const panel = find("panel-drawing"), form = made("form");
  panel.replaceChildren(made("h2", found.path), picture(found), form);
  form.append(layerTable(found), values(found), said("button", "write_process"));
  read = JSON.stringify(found);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const done = await doing(() => ask("drawing/process", { path: found.path, values: stated(form) }));
    if (done && path === found.path) { fill(done); await readProject(); }
  });
}
/** What the disk has now is shown at once, if nothing is being typed here; else it is asked. */
async function changedOnDisk({ files }) {
  const panel = find("panel-drawing"), form = panel.querySelector("form");
  const stem = path.replace(/\.[^./]+$/, "");
  if (!path || !files.some((one) => one === path || one === `${stem}.process.toml`)) return;
  const found = await look("drawing", { path }).catch(() => undefined); // taken away: what stands here stays
  if (!found || JSON.stringify(found) === read) return;
  if (Object.keys(stated(form)).length === 0) { fill(found); return; }
  panel.querySelector(".notice")?.remove();
  const asked = made("div", undefined, "notice"), take = said("button", "take_theirs"), keep = said("button", "keep_mine");
  asked.setAttribute("role", "alert");
  take.addEventListener("click", () => fill(found));
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
    svg.append(line);
  }
  const wide = Math.max(1, box[2] - box[0]), high = Math.max(1, box[3] - box[1]), edge = 0.03 * Math.max(wide, high);
  if (found.lines.length) svg.setAttribute("viewBox", [box[0] - edge, box[1] - edge, wide + 2 * edge, high + 2 * edge].join(" "));
  return svg;
}
function layerTable(found) {
  const table = made("table"), head = made("tr");
  for (const key of ["layers", "worked", ...COLUMNS.map(([name]) => name)]) head.append(said("th", key));
  table.append(head);
  found.layers.forEach((layer, i) => {
    const row = made("tr"), name = made("td"), colour = made("span", "■ "), use = made("input"), cell = made("td");
    row.dataset.layer = layer.name;
    colour.style.color = COLOURS[i % COLOURS.length];
    name.append(colour, shown(layer.name), made("br"), made("small", layer.use));
    use.type = "checkbox";
    use.defaultChecked = layer.used;
    use.disabled = layer.closed + layer.open === 0;
    use.dataset.key = "used";
    use.setAttribute("aria-label", `${layer.name}: ${word("worked")}`);
    cell.append(use);
    row.append(name, cell);
    for (const [key, type] of COLUMNS) {
      const input = made("input"), place = made("td");
      input.type = type;
      if (type === "number") input.step = "any";
      input.value = input.dataset.was = layer.values[key] ?? "";
      input.dataset.key = key;
      input.disabled = use.disabled;
      input.setAttribute("aria-label", `${layer.name}: ${word(key)}`);
      place.append(input);
      row.append(place);
    }
    table.append(row);
  });
  const group = made("fieldset");
  group.append(said("legend", "layers"), table);
  return group;
}
function values(found) {
  const group = made("fieldset");
  group.append(said("legend", "process"));
  for (const { field: name, key, value } of found.values) {
    const label = made("label"), input = made("input");
    input.type = "text";
    input.dataset.path = name;
    input.dataset.keys = JSON.stringify(key);
    if (!name.endsWith("speed")) input.dataset.many = "";
    input.value = input.dataset.was = Array.isArray(value) ? value.join(", ") : value ?? "";
    label.append(said("span", NAMES[name] ?? name), " ", input);
    group.append(label);
  }
  return group;
}
/** What was changed on the form, as tables of the process file; null takes a key away. */
function stated(form) {
  const out = Object.create(null); // so that a layer may have any name
  const put = (keys, value) => {
    let here = out;
    for (const key of keys.slice(0, -1)) here = here[key] ??= Object.create(null);
    here[keys.at(-1)] = value;
  };
  for (const row of form.querySelectorAll("tr[data-layer]")) for (const input of row.querySelectorAll("input:not(:disabled)")) {
    const keys = ["layers", row.dataset.layer, input.dataset.key];
    if (input.type === "checkbox") { if (input.checked !== input.defaultChecked) put(keys, input.checked); }
    else if (input.value !== input.dataset.was) put(keys, input.value === "" ? null : input.type === "number" ? Number(input.value) : input.value);
  }
  for (const input of form.querySelectorAll("input[data-path]")) {
    if (input.value !== input.dataset.was) put(JSON.parse(input.dataset.keys), typed(input.value, "many" in input.dataset));
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
