// What is done along the contours of a layer: its values, leads, and the output that is on meanwhile.
import { made, said, word } from "./words.js";
import { fill } from "./parts.js";
import { contourList } from "./contours.js";

const OPTIONS = [["process", "text"], ["speed", "number"], ["approach", "number"], ["retract", "number"], ["travel", "number"], ["offset", "number"], ["side", ["", "nesting", "inside", "outside", "left", "right"]]];
const LEADS = [["line", "lead_line"], ["arc", "lead_arc"], ["tangent", "lead_tangent"]];
const same = (one, other) => JSON.stringify(one ?? null) === JSON.stringify(other ?? null);

export function layerOptions(found, layer) {
  const group = made("fieldset"), disabled = layer.closed + layer.open === 0;
  group.dataset.layer = layer.name;
  group.append(made("legend", layer.name));
  if (disabled) { group.append(made("p", layer.use, "empty")); return group; }
  for (const [key, kind] of OPTIONS) group.append(option(layer, key, kind));
  group.append(output(found, layer), option(layer, "delay", "number"), lead(layer, "lead_in"), lead(layer, "lead_out"));
  group.append(found.contours.some((one) => one.layer === layer.name) ? contourList(found, layer.name) : said("p", "not_listed", "empty"));
  return group;
}
function labelled(key, ...fields) {
  const label = made("label");
  label.append(said("span", key), " ", ...fields);
  return label;
}
function option(layer, key, kind) {
  const input = made(Array.isArray(kind) ? "select" : "input");
  if (Array.isArray(kind)) fill(input, [...new Set([...kind, layer.values[key] ?? ""])], "");
  else { input.type = kind; if (kind === "number") input.step = "any"; }
  input.value = input.dataset.was = layer.values[key] ?? "";
  input.dataset.key = key;
  input.setAttribute("aria-label", `${layer.name}: ${word(key)}`);
  return labelled(key, input);
}
/** A field of several inputs. changed: pairs of a key and its value, where it is another one. */
function compound(label, changed) {
  label.dataset.compound = "";
  label.changed = changed;
  return label;
}
/** The signal that is on along each contour; what the file has of another kind stays as it is. */
function output(found, layer) {
  const { on, off } = layer.values, select = made("select"), names = found.signals.map((one) => one.name);
  const name = names.find((one) => same(on, { [one]: 1 }) && same(off, { [one]: 0 }));
  const own = name === undefined && (on || off) ? [["file", "as_in_file"]] : [];
  fill(select, ["", ...own, ...names.map((one) => [`=${one}`])]);
  for (const one of select.options) if (one.value.startsWith("=")) one.textContent = one.value.slice(1);
  select.value = own.length ? "file" : name === undefined ? "" : `=${name}`;
  const was = select.value;
  select.setAttribute("aria-label", `${layer.name}: ${word("output")}`);
  select.className = "output";
  return compound(labelled("output", select), () => {
    if (select.value === was || select.value === "file") return [];
    const chosen = select.value.slice(1);
    return chosen ? [["on", { [chosen]: 1 }], ["off", { [chosen]: 0 }]] : [["on", null], ["off", null]];
  });
}
function lead(layer, key) {
  const was = layer.values[key], kind = made("select"), size = made("input"), angle = made("input"), sizes = made("span", undefined, "sizes");
  fill(kind, [["", "no_lead"], ...LEADS]);
  kind.value = LEADS.map(([one]) => one).find((one) => was && one in was) ?? "";
  size.type = angle.type = "number";
  size.step = angle.step = "any";
  size.value = was?.[kind.value] ?? "";
  angle.value = was?.angle ?? "";
  angle.placeholder = "90";
  [[kind, key], [size, "length"], [angle, "angle"]].forEach(([one, part]) => one.setAttribute("aria-label", `${layer.name}: ${word(key)}${one === kind ? "" : `, ${word(part)}`}`));
  sizes.append(size, " mm ", angle, " °");
  const show = () => { sizes.hidden = !kind.value; angle.disabled = kind.value === "tangent"; };
  kind.addEventListener("change", show);
  show();
  const label = labelled(key, kind, sizes);
  label.className = "lead";
  return compound(label, () => {
    const now = kind.value ? { [kind.value]: Number(size.value), ...(angle.value === "" || angle.disabled ? {} : { angle: Number(angle.value) }) } : null;
    return same(now, was) ? [] : [[key, now]];
  });
}
/** The outputs of the file, with the numbers of them that controllers count, and a new one. */
export function signals(found) {
  const group = made("fieldset");
  group.id = "outputs";
  group.append(said("legend", "outputs"));
  for (const { name, number: was } of found.signals) {
    const number = made("input"), label = made("label");
    number.type = "number";
    number.min = "0";
    number.value = was ?? "";
    number.setAttribute("aria-label", `${name}: ${word("signal_number")}`);
    label.append(made("span", name), number);
    group.append(compound(label, () => (number.value === String(was ?? "") ? [] : [[["signals", name, "number"], number.value === "" ? null : Number(number.value)]])));
  }
  const name = made("input"), number = made("input"), row = made("label");
  name.id = "new-output";
  name.setAttribute("aria-label", word("new_output"));
  number.id = "new-output-number";
  number.type = "number";
  number.min = "0";
  number.placeholder = word("signal_number");
  number.setAttribute("aria-label", `${word("new_output")}: ${word("signal_number")}`);
  name.addEventListener("change", () => {
    for (const select of group.closest("form").querySelectorAll("select.output")) {
      const other = select.querySelector("[data-new]") ?? select.appendChild(made("option"));
      other.dataset.new = "";
      other.value = `=${name.value.trim()}`;
      other.textContent = name.value.trim();
      if (!name.value.trim()) other.remove();
    }
  });
  row.append(said("span", "new_output"), " ", name, " ", number);
  group.append(compound(row, () => {
    const own = name.value.trim();
    if (!own) return [];
    return [[["signals", own, "kind"], "digital"], [["signals", own, "direction"], "output"], ...(number.value === "" ? [] : [[["signals", own, "number"], Number(number.value)]])];
  }));
  return group;
}
