// Texts of the page, by language; anybody can add a table beside those that there are.
const tables = JSON.parse(document.getElementById("words").textContent);
const wanted = localStorage.getItem("language") ?? navigator.language.slice(0, 2);
let table = tables[wanted] ?? tables.en;

const STEERING = /[\0-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb]|[\ud800-\udbff](?![\udc00-\udfff])|(?<![\ud800-\udbff])[\udc00-\udfff]/g;

/** Text from outside with a mark for what would turn it around or hide in it. */
export const shown = (text) => String(text).replace(STEERING, "\ufffd");
export const word = (name) => table[name] ?? name;
export const find = (id) => document.getElementById(id);
export function made(tag, text, name) {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = shown(text);
  if (name) element.className = name;
  return element;
}
/** An element whose text is a word of the table, in whatever language is chosen later. */
export function said(tag, key, name) {
  const element = made(tag, word(key), name);
  element.dataset.word = key;
  return element;
}
function translate() {
  for (const element of document.querySelectorAll("[data-word]")) element.textContent = word(element.dataset.word);
  for (const element of document.querySelectorAll("[data-title]")) {
    element.title = word(element.dataset.title);
    element.setAttribute("aria-label", element.title);
  }
}
export function beginWords() {
  const list = find("languages");
  for (const [name, texts] of Object.entries(tables)) {
    const choice = made("option", texts.language);
    choice.value = name;
    choice.lang = name;
    choice.selected = texts === table;
    list.append(choice);
  }
  const use = (name) => {
    table = tables[name];
    document.documentElement.lang = name;
    localStorage.setItem("language", name);
    translate();
  };
  list.addEventListener("change", () => use(list.value));
  use(list.value);
}
