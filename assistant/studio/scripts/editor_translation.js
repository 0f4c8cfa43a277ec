// The translation of a text beside it: a line of the one shows what it is in the other.
import { EditorView } from "../codemirror/codemirror.js";
import { find, made, word } from "./words.js";
import { current, dispatch, onLine, stateOf } from "./editor.js";
import { lookedAt } from "./editor_view.js";
import { coloured, linked } from "./editor_marks.js";

let view = null, pairs = [], timer = 0, of = "", asked = 0;
const panel = () => find("translation"), list = () => find("translate");

/** Shows the translation of a text, if one is wanted. rest: ms until it is asked for. */
export function translate(text, rest = 0) {
  if (of !== text.path) { close(); choices(text); }
  clearTimeout(timer);
  if (!list().value) return close();
  timer = setTimeout(() => look(text, list().value), rest);
}
function choices(text) {
  const before = list().value, none = made("option", word("translation"));
  none.value = "";
  list().replaceChildren(none, ...text.languages.map(({ name, title }) => Object.assign(made("option", title), { value: name })));
  list().value = text.languages.some(({ name }) => name === before) ? before : "";
  of = text.path;
}
export function closeTranslation() {
  clearTimeout(timer);
  of = "";
  close();
}
function close() {
  asked += 1;
  view?.destroy();
  view = null;
  pairs = [];
  panel().hidden = true;
  const text = current()?.text;
  if (!text) return;
  dispatch(text, { effects: linked(stateOf(text), []) });
  text.service.translated([]);
}
async function look(text, language) {
  const turn = ++asked;
  const done = await text.service.ask("translation", { language }).catch((refused) => ({ findings: refused.findings ?? [], text: "", pairs: [], words: [], name: "" }));
  if (!done || turn !== asked || current()?.text !== text || list().value !== language) return;
  text.service.translated(done.findings.filter(({ severity }) => severity !== "info"));
  show(done);
}
/** What there was before stays while the text cannot be translated. */
function show(done) {
  panel().hidden = false;
  panel().classList.toggle("before", !done.text);
  if (!done.text) {
    const said = made("p", done.findings[0]?.message ?? "", "written");
    if (view) panel().firstChild.replaceWith(said);
    else panel().replaceChildren(said);
    return;
  }
  pairs = done.pairs;
  const top = view?.scrollDOM.scrollTop ?? 0;
  view?.destroy();
  const name = made("p", [done.name, ...done.others ?? []].join(", "), "written");
  panel().replaceChildren(name);
  view = new EditorView({ state: lookedAt(done.text, back), parent: panel() });
  view.scrollDOM.tabIndex = 0;
  view.dispatch({ effects: coloured(view.state.doc, done.words) });
  view.scrollDOM.scrollTop = top;
  const { view: source } = current();
  forth(source.state.doc.lineAt(source.state.selection.main.head).number);
}
/** From a line of the text to those that it became. */
function forth(line) {
  if (!view) return;
  const found = pairs.filter(({ source }) => source.includes(line - 1));
  mark(found);
  const first = found.flatMap(({ written }) => written)[0];
  if (first !== undefined) scroll(view, first + 1);
}
/** From a line of the translation to those that it came from. */
function back(line) {
  const found = pairs.filter(({ written }) => written.includes(line - 1));
  mark(found);
  const first = found.flatMap(({ source }) => source)[0];
  if (first !== undefined && current()) scroll(current().view, first + 1);
}
function mark(found) {
  const { text, view: source } = current() ?? {};
  if (!text || !view) return;
  dispatch(text, { effects: linked(source.state, found.flatMap((one) => one.source.map((at) => at + 1))) });
  view.dispatch({ effects: linked(view.state, found.flatMap((one) => one.written.map((at) => at + 1))) });
}
function scroll(there, line) {
  const doc = there.state.doc;
  if (line <= doc.lines) there.dispatch({ effects: EditorView.scrollIntoView(doc.line(line).from, { y: "nearest", yMargin: 60 }) });
}
export function beginTranslation() {
  list().addEventListener("change", () => { const text = current()?.text; if (text) translate(text); });
  onLine(({ line }) => forth(line));
}
