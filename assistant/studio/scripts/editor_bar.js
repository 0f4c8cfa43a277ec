// The bar above a text: which is shown, which are open, and what is not saved.
import { find, made, word } from "./words.js";
import { state as window_ } from "./line.js";
import { closeText, openText, texts } from "./editor.js";
import { isSaved, showConflict } from "./editor_saving.js";

const WRITING = ["save", "format", "rename", "undo", "redo"];
let shown = null;

/** Shows what is true of the text that is shown now, null for none. path: of one that cannot be read. */
export function bar(text, path = "") {
  shown = text;
  find("file-name").textContent = text?.path ?? path;
  find("text-bar").hidden = !text && !path;
  find("translate").hidden = !text?.languages.length;
  for (const id of WRITING) find(id).disabled = !text || !window_.writes;
  find("definition").disabled = !text;
  find("translate").disabled = !text?.languages.length;
  keep(text);
  showConflict(text);
}
/** Whether a text is saved has perhaps changed. */
export function keep(text) {
  const saved = !shown || isSaved(shown);
  if (text === shown) {
    find("file-state").dataset.word = !shown ? "" : saved ? "saved" : "unsaved";
    find("file-state").textContent = shown ? word(find("file-state").dataset.word) : "";
  }
  const row = find("opened"), known = [...texts.values()].map((one) => `${one.path}${isSaved(one) ? "" : " ●"}${one === shown ? " here" : ""}`).join("\n");
  if (row.dataset.known === known) return;
  row.dataset.known = known;
  row.hidden = texts.size < 2;
  row.replaceChildren(...[...texts.values()].map(tab));
}
function tab(text) {
  const part = made("span"), name = made("button", `${text.path.split("/").at(-1)}${isSaved(text) ? "" : " ●"}`), close = made("button", "×");
  name.title = text.path;
  name.setAttribute("aria-pressed", String(text === shown));
  name.addEventListener("click", () => openText(text.path));
  close.disabled = !isSaved(text);
  close.setAttribute("aria-label", `× ${text.path}`);
  close.addEventListener("click", () => { closeText(text); keep(shown); });
  part.append(name, close);
  return part;
}
