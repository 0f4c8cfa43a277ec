// Parts of a panel: made in code, with words of the table.
import { made, said, word } from "./words.js";

export const bar = (...parts) => { const one = made("div", undefined, "bar"); one.append(...parts); return one; };
export const group = (key, ...parts) => { const one = made("fieldset"); one.append(said("legend", key), ...parts); return one; };
export const input = (id, kind, values = {}) => Object.assign(made(kind), { id, ...values });
export const labelled = (key, field) => { const one = made("label"); one.append(said("span", key), " ", field); return one; };
export function button(id, key, does, name) {
  const one = said("button", key, name);
  one.id = id;
  one.type = "button";
  if (does) one.addEventListener("click", name === "alarm" ? does : once(does));
  return one;
}
/** Once for each click: the second of two that come as one, or of an impatient one, does nothing. */
function once(does) {
  let going = false;
  return async (event) => {
    if (going || event.detail > 1) return;
    going = true;
    try { await does(event); } finally { going = false; }
  };
}
export function form(id, does, ...parts) {
  const one = input(id, "form", { className: "bar", autocomplete: "off" });
  one.append(...parts);
  one.addEventListener("submit", (event) => { event.preventDefault(); does(); });
  return one;
}
/** A list of choices: values, or pairs of a value and the key of its word. */
export function fill(select, values, keep = select.value) {
  select.replaceChildren(...values.map((value) => {
    const [own, key] = Array.isArray(value) ? value : [value];
    const one = key ? said("option", key) : made("option", own);
    one.value = own;
    return one;
  }));
  const there = [...select.options].map((one) => one.value);
  select.value = there.includes(keep) ? keep : there[0] ?? "";
}
export function row(...cells) {
  const one = made("tr");
  one.append(...cells.map((cell) => {
    if (cell instanceof HTMLTableCellElement) return cell;
    if (!(cell instanceof Node)) return made("td", cell ?? "");
    const place = made("td");
    place.append(cell);
    return place;
  }));
  return one;
}
export function table(keys, rows, name = "") {
  const one = made("table", undefined, name), head = made("tr");
  head.append(...keys.map((key) => key ? said("th", key) : made("td")));
  one.append(head, ...rows);
  return one;
}
/** A text that may be long, folded away under its title. */
export function folded(title, text, open = false) {
  const one = made("details");
  one.append(made("summary", title), made("pre", text));
  one.open = open;
  return one;
}
export const filled = (key, values) => Object.entries(values).reduce((text, [name, value]) => text.replace(`{${name}}`, value), word(key));
