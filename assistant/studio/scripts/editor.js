// Texts that are open: one is shown, the others keep their state. What other parts ask of them.
import { EditorSelection, EditorView, redo, undo } from "../codemirror/codemirror.js";
import { find, made, said as saidWord } from "./words.js";
import { Refused, ask } from "./server.js";
import { showOfDoing, showOfFile } from "./findings.js";
import { on, state as window_ } from "./line.js";
import { choose } from "./tabs.js";
import { fileOf, markFile, project, whenChosen } from "./project.js";
import { bar, keep } from "./editor_bar.js";
import { begun, reads } from "./editor_view.js";
import { arm, pointLines, setPoint, togglePoint } from "./editor_marks.js";
import { Service } from "./editor_service.js";
import { beginDoing } from "./editor_doing.js";
import { beginTranslation, closeTranslation, translate } from "./editor_translation.js";
import { beginSaving, disk, isSaved } from "./editor_saving.js";

const NO_TEXT = new Set(["drawing", "picture", "shape"]);
export const texts = new Map(); // by path: {path, state, service, stamp, saved, title, languages}
const lines = [], typed = [], pointed = [], waiting = new Map(); // waiting: break points of texts that are not open yet
let view = null, here = null, line = 0;

/** The text that is shown, with its view; null where there is none. */
export const current = () => here && { text: here, view };
/** Calls with {path, line} when the line of the cursor changes; lines count from 1. */
export const onLine = (does) => lines.push(does);
/** Calls with a path when its text changes. */
export const onText = (does) => typed.push(does);
/** Calls with a path when its break points change. */
export const onBreakPoints = (does) => pointed.push(does);
/** Lines with break points, from 1. */
export const breakPoints = (path) => texts.has(path) ? pointLines(stateOf(texts.get(path))) : [...(waiting.get(path) ?? [])].sort((a, b) => a - b);

/** Shows a file, and a line of it from 1; whether it is there. */
export async function openText(path, at, column) {
  const text = await opened(path);
  if (!text) return false;
  show(text);
  if (at !== undefined) goTo(at, column);
  return true;
}
/** Marks a line from 1: "arm-here" is one line of a text (undefined for none), "break" a break point. */
export function markLine(path, at, kind = "arm-here") {
  const text = texts.get(path);
  if (kind === "break" && !text) {
    const known = waiting.get(path) ?? waiting.set(path, new Set()).get(path);
    known.has(at) || known.add(at);
    return;
  }
  if (text) dispatch(text, { effects: kind === "break" ? setPoint(stateOf(text), at) : arm(stateOf(text), at) });
}
/** Makes edits, {from: [line, column], to, text} from 0, as one step that can be undone. */
export async function applied(path, edits) {
  const text = await opened(path);
  if (!text || !window_.writes) return false;
  const doc = stateOf(text).doc;
  const changes = edits.map((one) => ({ from: offset(doc, one.from), to: offset(doc, one.to), insert: one.text }));
  if (changes.length) dispatch(text, { changes, userEvent: "input.edit" });
  return true;
}
/** Makes edits of several files, each an array by its path. */
export async function appliedAll(changes) {
  for (const [path, edits] of Object.entries(changes)) await applied(path, edits);
}
export function offset(doc, [at, column]) {
  if (at >= doc.lines) return doc.length;
  const there = doc.line(at + 1);
  return Math.min(there.from + column, there.to);
}
export const placeOf = (doc, at) => {
  const there = doc.lineAt(at);
  return [there.number - 1, at - there.from];
};
export const stateOf = (text) => (text === here ? view.state : text.state);

/** Changes a text, whether it is shown or not. */
export function dispatch(text, change) {
  if (text === here) view.dispatch(change);
  else {
    const done = text.state.update(change);
    text.state = done.state;
    told(text, done);
  }
}
const opening = new Map();
async function opened(path) {
  if (texts.has(path)) return texts.get(path);
  if (!opening.has(path)) opening.set(path, begin(path).finally(() => opening.delete(path)));
  return opening.get(path);
}
async function begin(path) {
  let answer;
  try { answer = await ask("text/open_text", { path }); } catch (refused) {
    if (!(refused instanceof Refused)) throw refused;
    return unreadable(path, refused.findings);
  }
  const text = { path, stamp: answer.stamp, title: answer.title, language: answer.language, languages: answer.languages };
  text.service = new Service(text, { stateOf: () => stateOf(text), isHere: () => text === here, view: () => view });
  text.state = begun(answer.text, text, { told: (update) => told(text, update), point: (at) => pointedAt(text, at) });
  text.saved = text.state.doc;
  for (const at of waiting.get(path) ?? []) text.state = text.state.update({ effects: setPoint(text.state, at) }).state;
  waiting.delete(path);
  texts.set(path, text);
  text.service.settle(0);
  return text;
}
/** Its findings stand in the place of the text, where nothing can be saved then. */
function unreadable(path, findings) {
  leave();
  find("editor").replaceChildren(...findings.map(({ code, message, cure }) => made("p", `${code} ${message}${cure ? `: ${cure}` : ""}`, "unreadable")));
  bar(null, path);
  showOfDoing(findings);
  choose("tab-text");
  return null;
}
function leave() {
  if (here) here.state = view.state;
  view?.destroy();
  view = here = null;
  closeTranslation();
  showOfFile([]);
  find("outline").replaceChildren();
}
function show(text) {
  choose("tab-text");
  if (text !== here) {
    leave();
    find("editor").replaceChildren();
    here = text;
    view = new EditorView({ state: text.state, parent: find("editor") });
    view.scrollDOM.tabIndex = 0; // what scrolls can be scrolled by keys
    line = 0;
    text.service.shown();
    translate(text);
  }
  bar(text);
  markFile(text.path);
  view.focus();
  said();
}
function goTo(at, column = 1) {
  const place = offset(view.state.doc, [Math.max(0, at - 1), column - 1]);
  view.dispatch({ selection: EditorSelection.cursor(place), effects: EditorView.scrollIntoView(place, { y: "center" }) });
  said();
}
/** Everything that a change of a text is told to. */
function told(text, update) {
  const changed = update.docChanged;
  if (changed) text.service.changed(update.changes, update.startState.doc);
  if (changed) for (const does of typed) does(text.path);
  if (text === here) {
    if (changed) { keep(text, update.state); translate(text, 900); }
    else if (update.viewportChanged) text.service.seen();
    if (changed || update.selectionSet) said(update.state);
  } else if (changed) keep(text, update.state);
  if (pointLines(update.startState ?? update.state).join() !== pointLines(update.state).join()) for (const does of pointed) does(text.path);
}
function pointedAt(text, at) {
  dispatch(text, { effects: togglePoint(stateOf(text), at) });
}
function said(state = view.state) {
  const now = state.doc.lineAt(state.selection.main.head).number;
  if (now === line) return;
  line = now;
  for (const does of lines) does({ path: here.path, line });
}
/** Goes to a finding of any file; one of a drawing or of no file leaves the text as it is. */
export async function goToFinding(finding, chooseFile) {
  if (!finding.path) return;
  const path = fileOf(finding.path);
  const file = project.files.find((one) => one.path === path);
  if (!file) return;
  await chooseFile(path);
  if (!NO_TEXT.has(file.kind)) await openText(path, finding.line ?? 1, finding.column ?? 1);
}
export function closeText(text) {
  texts.delete(text.path);
  if (text === here) { leave(); find("editor").replaceChildren(saidWord("p", "nothing_open", "empty")); bar(null); }
  ask("text/close", { path: text.path }).catch(() => undefined);
}
export function beginEditor() {
  whenChosen((file) => (NO_TEXT.has(file.kind) ? undefined : openText(file.path)));
  find("undo").addEventListener("click", () => { if (view) undo(view); });
  find("redo").addEventListener("click", () => { if (view) redo(view); });
  on("window", () => { for (const text of texts.values()) dispatch(text, { effects: reads(!window_.writes) }); bar(here); });
  on("lost", () => { for (const text of texts.values()) dispatch(text, { effects: reads(true) }); bar(here); });
  on("disk", ({ files }) => { for (const path of files) if (texts.has(path)) disk(texts.get(path)); for (const text of texts.values()) text.service.settle(); });
  on("project", () => { for (const text of [...texts.values()]) closeText(text); });
  addEventListener("beforeunload", (event) => { if ([...texts.values()].some((text) => !isSaved(text))) event.preventDefault(); });
  beginSaving();
  beginDoing();
  beginTranslation();
}
