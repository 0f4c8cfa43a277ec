// What is marked in a text: words by their sort, break points, the line of the arm, linked lines.
import { Decoration, EditorView, GutterMarker, RangeSetBuilder, StateEffect, StateField, gutter } from "../codemirror/codemirror.js";

const MARKS = ["declaration", "readonly", "predefined"]; // bits 0, 1 and 2
const known = new Map();
function look(sort, marks) {
  const name = [`word-${sort}`, ...MARKS.filter((_, i) => marks & (1 << i)).map((one) => `mark-${one}`)].join(" ");
  if (!known.has(name)) known.set(name, Decoration.mark({ class: name }));
  return known.get(name);
}
/** Decorations that come as effects, and move with the text by then. */
function field(effect, moving) {
  return StateField.define({
    create: () => Decoration.none,
    update(value, update) {
      const moved = update.docChanged ? moving(value, update) : value;
      return update.effects.reduce((now, one) => (one.is(effect) ? one.value : now), moved);
    },
    provide: (own) => EditorView.decorations.from(own),
  });
}
const setWords = StateEffect.define(), setArm = StateEffect.define(), setLinked = StateEffect.define(), setPoints = StateEffect.define();
const withLines = (name) => (value, update) => lineSet(update.state.doc, numbersOf(value, update.state.doc, (at) => update.changes.mapPos(at, 1)), name);
const words = field(setWords, (value, update) => value.map(update.changes));
const armed = field(setArm, withLines("arm-here")), linkedLines = field(setLinked, withLines("linked"));

/** Colours of some lines, [line, column, length, sort, marks] each, from 0; all others lose theirs. */
export function coloured(doc, rows) {
  const built = new RangeSetBuilder();
  for (const [at, column, length, sort, marks] of rows) {
    if (at >= doc.lines) break;
    const there = doc.line(at + 1), from = there.from + column;
    if (from + length <= there.to && length) built.add(from, from + length, look(sort, marks));
  }
  return setWords.of(built.finish());
}
function lineSet(doc, numbers, name) {
  const there = [...new Set(numbers)].filter((one) => one >= 1 && one <= doc.lines).sort((a, b) => a - b);
  return Decoration.set(there.map((one) => Decoration.line({ class: name }).range(doc.line(one).from)));
}
export const arm = (state, at) => setArm.of(lineSet(state.doc, at === undefined || at === null ? [] : [at], "arm-here"));
export const linked = (state, numbers) => setLinked.of(lineSet(state.doc, numbers, "linked"));

class Point extends GutterMarker {
  toDOM() { return Object.assign(document.createElement("span"), { className: "point-mark", textContent: "●" }); }
}
const point = new Point();
const points = StateField.define({
  create: () => Decoration.none,
  update(value, update) {
    const moved = update.docChanged ? placed(update.state.doc, numbersOf(value, update.state.doc, (at) => update.changes.mapPos(at, 1))) : value;
    return update.effects.reduce((now, one) => (one.is(setPoints) ? one.value : now), moved);
  },
});
const placed = (doc, numbers) => Decoration.none.update({ add: [...new Set(numbers)].sort((a, b) => a - b).map((one) => point.range(doc.line(one).from)) });
/** Lines in which marks stand, once they are moved. */
function numbersOf(value, doc, moved = (at) => at) {
  const found = [];
  for (let at = value.iter(); at.value; at.next()) found.push(doc.lineAt(moved(at.from)).number);
  return [...new Set(found)];
}
export const pointLines = (state) => numbersOf(state.field(points), state.doc);
export function setPoint(state, at) {
  const all = pointLines(state);
  return setPoints.of(placed(state.doc, at >= 1 && at <= state.doc.lines ? [...all, at] : all));
}
export function togglePoint(state, at) {
  const all = pointLines(state);
  return setPoints.of(placed(state.doc, all.includes(at) ? all.filter((one) => one !== at) : [...all, at]));
}
/** The fields of a text. toggle: called with a line whose break point is clicked. */
export const marks = (toggle) => [
  words, armed, linkedLines, points,
  gutter({
    class: "points", markers: (view) => view.state.field(points), initialSpacer: () => point,
    domEventHandlers: { mousedown: (view, block) => { toggle(view.state.doc.lineAt(block.from).number); return true; } },
  }),
];
export const seenMarks = [words, linkedLines];
