// A drawing: its lines, its layers, and the process of each.
import { find, made, said, shown, word } from "./words.js";
import { ask, look } from "./server.js";
import { doing } from "./findings.js";
import { on, state as window_ } from "./line.js";
import { alsoSaved } from "./editor_saving.js";
import { choose } from "./tabs.js";
import { fill, filled } from "./parts.js";
import { COLOURS, picture, switchedContours } from "./contours.js";
import { layerOptions, signals } from "./layer_form.js";
import { showScene } from "./scene.js";
import { project, readProject, whenChosen } from "./project.js";

const NAMES = { "motion.tool": "tool", "tools.tool.tip": "tip", "frames.work.position": "position", "frames.work.euler_zyx": "turned", "placement.position": "placed", "placement.euler_zyx": "placed_turned", "motion.speed": "motion_speed" };
let path = "", read = "", now = null, layerNow = ""; // the drawing that is shown, what was read of it, and the layer whose options are shown

async function show(file) {
  const drawing = file.kind === "drawing" ? file.path : project.files.find((one) =>
    file.kind === "process" && one.kind === "drawing" && one.path.replace(/\.[^.]+$/, "") === file.path.replace(/\.process\.toml$/, ""))?.path;
  if (!drawing || !await saved()) return;
  path = drawing;
  find("panel-drawing").replaceChildren(); // values of one drawing are not written to another
  const found = await doing(() => look("drawing", { path: drawing }));
  if (!found || path !== drawing) return;
  draw(found);
  if (file.kind === "drawing") choose("tab-drawing");
}
function draw(found) {
  const panel = find("panel-drawing"), form = made("form");
  now = found;
  const scrolls = made("div", undefined, "scroll");
  scrolls.append(made("h2", found.path), picture(found, { chooses: chooseLayer, chosen: () => layerNow }), form);
  form.append(layerTable(found), ...found.layers.map((layer) => layerOptions(found, layer)), values(found), signals(found));
  panel.replaceChildren(scrolls, foot(form));
  panel.querySelector(".foot").told();
  read = JSON.stringify(found);
  const names = found.layers.map((layer) => layer.name);
  chooseLayer(names.includes(layerNow) ? layerNow : found.layers.find((layer) => layer.used)?.name ?? names[0]);
  form.addEventListener("submit", (event) => { event.preventDefault(); write(); });
}
const isChanged = (form) => Object.keys(stated(form)).length > 0;
/** Writes what was changed on the form; whether that could be done. */
async function write() {
  const of = path, form = find("panel-drawing").querySelector("form");
  const done = await doing(() => ask("drawing/process", { path: of, values: stated(form) }));
  if (done && path === of) { draw(done); await readProject(); showScene(done.path); }
  return done !== undefined;
}
/** Writes the form where something was changed there, before it is built or another drawing takes its place. */
async function saved() {
  const form = find("panel-drawing").querySelector("form");
  return !form || !window_.writes || !isChanged(form) || await write();
}
/** The button that writes, and what has to be filled in before anything moves. */
function foot(form) {
  const box = made("p", undefined, "foot"), missing = made("button", undefined, "missing"), unsaved = said("span", "unsaved"), lacks = () => [...form.querySelectorAll("[data-blank]")].filter((one) => one.value === "");
  missing.type = "button";
  missing.addEventListener("click", () => lacks()[0]?.focus());
  box.told = () => {
    const names = lacks().map((one) => one.closest("label").querySelector("span").textContent);
    missing.hidden = !names.length;
    missing.textContent = `${word("to_fill_in")}: ${names.join("; ")}`;
    unsaved.hidden = !isChanged(form);
    for (const one of form.querySelectorAll("[data-blank]")) one.setAttribute("aria-invalid", String(one.value === ""));
  };
  for (const name of ["input", "change"]) form.addEventListener(name, box.told);
  const put = said("button", "write_process");
  put.addEventListener("click", () => form.requestSubmit());
  box.append(put, unsaved, missing);
  return box;
}
/** What the disk has now is shown at once, if nothing is being typed here; else it is asked. */
async function changedOnDisk({ files }) {
  const panel = find("panel-drawing"), form = panel.querySelector("form");
  const stem = path.replace(/\.[^./]+$/, "");
  if (!path || !files.some((one) => one === path || one === `${stem}.process.toml`)) return;
  const found = await look("drawing", { path }).catch(() => undefined); // taken away: what stands here stays
  if (!found || JSON.stringify(found) === read) return;
  if (!isChanged(form)) { draw(found); return; }
  panel.querySelector(".notice")?.remove();
  const asked = made("div", undefined, "notice"), take = said("button", "take_theirs"), keep = said("button", "keep_mine");
  asked.setAttribute("role", "alert");
  take.addEventListener("click", () => draw(found));
  keep.addEventListener("click", () => asked.remove());
  asked.append(said("span", "changed_on_disk"), take, keep);
  panel.prepend(asked);
}
/** Shows the options of a layer below the table, and its lines bold. */
function chooseLayer(name) {
  layerNow = name ?? "";
  const panel = find("panel-drawing");
  for (const row of panel.querySelectorAll("tr[data-layer]")) row.setAttribute("aria-current", String(row.dataset.layer === layerNow));
  for (const group of panel.querySelectorAll("fieldset[data-layer]")) group.hidden = group.dataset.layer !== layerNow;
  for (const line of panel.querySelectorAll("[data-of]")) line.setAttribute("stroke-width", line.dataset.of === layerNow ? "3" : "1.5");
  panel.querySelector(".picture").told("");
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
    row.append(name, cell, made("td", counted(found, layer)), made("td", layer.length ? layer.length.toFixed(0) : ""));
    table.append(row);
  });
  const group = made("fieldset");
  group.append(said("legend", "layers"), table);
  return group;
}
/** How many contours and locations a layer has; of those that are left out, how many are not. */
function counted(found, layer) {
  const all = layer.closed + layer.open + layer.locations, left = found.contours.filter((one) => one.left && one.layer === layer.name).length;
  return left ? `${all - left} / ${all}` : String(all);
}
function values(found) {
  const group = made("fieldset");
  group.append(said("legend", "for_program"));
  for (const { field: name, key, value, choices, proposed, robot } of found.values) {
    const label = made("label"), input = made(choices ? "select" : "input");
    if (choices) filledBy(input, choices, value ?? "");
    else input.type = "text";
    input.dataset.path = name;
    input.dataset.keys = JSON.stringify(key);
    if (!choices && !name.endsWith("speed")) { input.dataset.many = ""; input.placeholder = name.endsWith("euler_zyx") ? "z, y, x" : "x, y, z"; }
    if (Array.isArray(value) && !value.length) input.dataset.blank = "";
    if (!choices) input.value = Array.isArray(value) ? value.join(", ") : value ?? "";
    input.dataset.was = input.value;
    label.append(said("span", NAMES[name] ?? name), " ", input);
    group.append(label);
    if (proposed) group.append(proposal(proposed, robot));
  }
  return group;
}
/** Values of fields with which the robot reaches the work, to be taken by a click. */
function proposal(fields, robot) {
  const place = Object.entries(fields).filter(([, value]) => Array.isArray(value)), one = made("button", "", "proposed");
  one.textContent = `${filled("in_reach", { robot })}: ${place.map(([name, value], i) => (i ? `${word(NAMES[name])} ` : "") + value.join(", ")).join("; ")}`;
  one.type = "button";
  one.addEventListener("click", () => {
    for (const [name, value] of Object.entries(fields)) {
      const input = one.form.querySelector(`[data-path="${name}"]`);
      input.value = Array.isArray(value) ? value.join(", ") : value;
      input.dispatchEvent(new Event("input", { bubbles: true }));
    }
  });
  return one;
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
  for (const input of form.querySelectorAll("[data-layer] [data-key]:not(:disabled)")) {
    const keys = ["layers", input.closest("[data-layer]").dataset.layer, input.dataset.key];
    if (input.type === "checkbox") { if (input.checked !== input.defaultChecked) put(keys, input.checked); }
    else if (input.value !== input.dataset.was) put(keys, input.value === "" ? null : input.type === "number" ? Number(input.value) : input.value);
  }
  for (const one of form.querySelectorAll("[data-compound]")) {
    for (const [key, value] of one.changed()) put(Array.isArray(key) ? key : ["layers", one.closest("[data-layer]").dataset.layer, key], value);
  }
  const contours = switchedContours(now, form);
  if (contours.length) put(["contours"], contours);
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
  alsoSaved(saved);
  on("disk", changedOnDisk);
}
