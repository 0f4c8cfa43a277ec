// Saving: a file that somebody else has changed is taken in or asked about, never written over unseen.
import { find, word } from "./words.js";
import { Refused, ask } from "./server.js";
import { showOfDoing } from "./findings.js";
import { state as window_ } from "./line.js";
import { current, dispatch, stateOf, texts } from "./editor.js";
import { bar, keep } from "./editor_bar.js";

export const isSaved = (text) => stateOf(text).doc.eq(text.saved);

export async function save(text) {
  if (!text || !window_.writes) return;
  const doc = stateOf(text).doc;
  try {
    const { stamp } = await ask("text/save", { path: text.path, text: doc.toString(), stamp: text.stamp });
    Object.assign(text, { stamp, saved: doc, theirs: undefined });
    for (const one of texts.values()) one.service.settle();
    showOfDoing([]);
  } catch (refused) {
    if (!(refused instanceof Refused)) throw refused;
    showOfDoing(refused.findings);
    if (refused.findings.some(({ code }) => code === "ST024" || code === "ST026")) await disk(text);
  }
  keep(text);
  showConflict(current()?.text);
}
const others = [];
/** Calls when all is saved, to save what is in a form; whether it is. */
export const alsoSaved = (does) => others.push(does);
/** Saves every text and form; whether all of them are. What the studio builds, runs or sends is on the disk. */
export async function saveAll() {
  for (const text of texts.values()) if (!isSaved(text)) await save(text);
  for (const does of others) if (!await does()) return false;
  return !window_.writes || [...texts.values()].every(isSaved);
}
/** Looks what stands on the disk: taken in where nothing was typed, asked about otherwise. */
export async function disk(text) {
  const found = await ask("text/on_disk", { path: text.path, stamp: text.stamp }).catch(() => null);
  if (!found || found.stamp === text.stamp) return; // what cannot be read now is asked about again when it is saved
  text.theirs = found;
  if (found.text !== undefined && (isSaved(text) || !window_.writes)) take(text);
  else if (found.text !== undefined && found.text.replace(/\r\n?/g, "\n") === stateOf(text).doc.toString()) take(text);
  else showConflict(current()?.text);
}
/** What is on the disk stands here then; one step that can be undone. */
function take(text) {
  const { stamp, text: theirs } = text.theirs, mine = stateOf(text).doc.toString();
  const next = (theirs ?? "").replace(/\r\n?/g, "\n"), most = Math.min(mine.length, next.length);
  let start = 0, end = 0;
  while (start < most && mine[start] === next[start]) start++;
  while (end < most - start && mine.at(-1 - end) === next.at(-1 - end)) end++;
  if (mine !== next) dispatch(text, { changes: { from: start, to: mine.length - end, insert: next.slice(start, next.length - end) }, userEvent: "input.taken" });
  Object.assign(text, { stamp, saved: stateOf(text).doc, theirs: undefined });
  keep(text);
  showConflict(current()?.text);
}
export function showConflict(text) {
  const notice = find("conflict");
  notice.hidden = !text?.theirs;
  find("take-theirs").hidden = text?.theirs?.text === undefined; // of a file that is gone there is nothing to take
  if (text?.theirs) notice.querySelector("span").textContent = `${text.path} ${word("changed_on_disk")}`;
}
export function beginSaving() {
  find("save").addEventListener("click", () => save(current()?.text));
  find("take-theirs").addEventListener("click", () => take(current().text));
  find("keep-mine").addEventListener("click", () => {
    const { text } = current();
    text.stamp = text.theirs.stamp; // that state was seen, and may be written over
    text.theirs = undefined;
    bar(text);
  });
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || !(event.ctrlKey || event.metaKey) || event.key !== "s") return;
    event.preventDefault();
    save(current()?.text);
  });
}
