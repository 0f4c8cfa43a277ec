// The editor of one text: its keys and looks.
import {
  Compartment, EditorState, EditorView, StateEffect, autocompletion, closeBrackets, completionKeymap, defaultKeymap, drawSelection,
  highlightActiveLine, highlightActiveLineGutter, highlightSpecialChars, history, historyKeymap, hoverTooltip, keymap,
  lineNumbers, lintGutter, lintKeymap, search, searchKeymap,
} from "../codemirror/codemirror.js";
import { word } from "./words.js";
import { state as window_ } from "./line.js";
import { marks, seenMarks } from "./editor_marks.js";
import { cureHere, formatText, goToDeclaration, rename } from "./editor_doing.js";
import { save } from "./editor_saving.js";
import { markdown } from "./editor_markdown.js";

const reading = new Compartment(), setReading = StateEffect.define();
const nonce = document.querySelector("meta[name=nonce]").content;
const LOOKS = EditorView.theme({
  "&": { color: "var(--text)", backgroundColor: "var(--paper)" },
  ".cm-scroller": { fontFamily: "ui-monospace, monospace", lineHeight: "1.5" },
  ".cm-gutters": { backgroundColor: "var(--side)", color: "var(--faint)", borderRight: "1px solid var(--line)" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "light-dark(#80a0c022, #80a0c01c)" },
  ".cm-content": { caretColor: "var(--text)" },
  ".cm-cursor": { borderLeftColor: "var(--text)", borderLeftWidth: "2px" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": { backgroundColor: "light-dark(#b8d4f6, #2f4f75)" },
  ".cm-tooltip, .cm-panels": { color: "var(--text)", backgroundColor: "var(--paper)", border: "1px solid var(--line)" },
  ".cm-tooltip-autocomplete > ul > li[aria-selected]": { backgroundColor: "var(--accent)", color: "var(--paper)" },
  ".cm-completionDetail": { color: "inherit", opacity: ".75" },
  ".cm-completionMatchedText": { textDecoration: "none", fontWeight: "700" },
  ".points .cm-gutterElement": { padding: "0 2px", cursor: "pointer", minWidth: "1.1em" },
  ".cm-lint-marker": { content: "normal", width: ".3em", height: "1.1em", margin: ".15em auto", borderRadius: "2px", backgroundColor: "var(--info)" },
  ".cm-lint-marker-error": { backgroundColor: "var(--error)" }, ".cm-lint-marker-warning": { backgroundColor: "var(--warning)" },
  ".cm-gutter-lint": { width: ".8em" }, ".cm-gutter-lint .cm-gutterElement": { padding: "0 .1em" },
  ".cm-diagnostic": { padding: ".3rem .6rem", whiteSpace: "pre-line", maxWidth: "40rem" },
  ".cm-diagnosticAction": { backgroundColor: "var(--accent)", color: "var(--paper)", font: "inherit", minHeight: "1.6rem", margin: ".2rem .3rem .1rem 0" },
  ".cm-searchMatch": { backgroundColor: "light-dark(#ffe08a, #6b5410)" },
  ".cm-panel.cm-search": { padding: ".3rem .5rem", font: "inherit" }, ".cm-panel.cm-search label": { fontSize: "1em", whiteSpace: "nowrap", marginRight: ".5rem" },
  ".cm-panel.cm-search [name=close]": { minHeight: "1.6rem", minWidth: "1.8rem", fontSize: "1.1em" },
  ".cm-button, .cm-textfield": { backgroundImage: "none", fontSize: "1em", padding: ".15rem .5rem", minHeight: "1.8rem", borderRadius: "4px", backgroundColor: "var(--side)", color: "inherit", border: "1px solid var(--line)" },
});
const SAID = {
  Find: "find_text", next: "find_next", previous: "find_previous", all: "find_all", "match case": "find_case", regexp: "find_pattern",
  "by word": "find_words", Replace: "replace_text", replace: "replace_text", "replace all": "replace_all",
}; // what the editor says by itself, and our words for it
const phrases = () => EditorState.phrases.of(Object.fromEntries(Object.entries(SAID).map(([theirs, ours]) => [theirs, word(ours)])));
const common = () => [
  EditorView.cspNonce.of(nonce), LOOKS, phrases(), highlightSpecialChars(), EditorState.tabSize.of(4), drawSelection(), lineNumbers(),
  EditorView.contentAttributes.of({ "aria-label": "text" }),
];
export const reads = (on) => setReading.of(on);
const readingNow = (on) => reading.reconfigure(EditorState.readOnly.of(on));
/** A text may be read only by then: the effect is turned into what the editor knows. */
const follows = EditorState.transactionExtender.of((change) => {
  const wanted = change.effects.find((one) => one.is(setReading));
  return wanted ? { effects: readingNow(wanted.value) } : null;
});

/** The state of a text that is opened. told: called with every change. point: with a line whose break point is to change. */
export function begun(doc, text, { told, point }) {
  const service = text.service;
  return EditorState.create({
    doc,
    extensions: [
      reading.of(EditorState.readOnly.of(!window_.writes)), follows, common(), history(), highlightActiveLine(), highlightActiveLineGutter(),
      closeBrackets(), search({ top: true }), lintGutter(), marks(point),
      autocompletion({ override: [(context) => service.completions(context)], icons: false, maxRenderedOptions: 60 }),
      hoverTooltip(async (view, at) => {
        const found = await service.hover(at);
        return found && { pos: found.from, end: found.to, above: true, create: () => ({ dom: markdown(found.text) }) };
      }),
      keymap.of([
        { key: "Mod-s", run: () => { save(text); return true; } },
        { key: "Mod-.", run: (view) => { cureHere(text, view); return true; } },
        { key: "F12", run: () => { goToDeclaration(); return true; } },
        { key: "F2", run: () => { rename(); return true; } },
        { key: "Shift-Alt-f", run: () => { formatText(text); return true; } },
        { key: "F9", run: (view) => { point(view.state.doc.lineAt(view.state.selection.main.head).number); return true; } },
        ...completionKeymap, ...lintKeymap, ...searchKeymap, ...historyKeymap, ...defaultKeymap,
      ]),
      EditorView.updateListener.of(told),
    ],
  });
}
/** A text that is only looked at. moved: called with the line of its cursor, from 1. */
export function lookedAt(doc, moved) {
  return EditorState.create({
    doc,
    extensions: [
      EditorState.readOnly.of(true), common(), seenMarks, keymap.of([...searchKeymap, ...defaultKeymap]), search({ top: true }),
      EditorView.updateListener.of((update) => {
        if (update.selectionSet) moved(update.state.doc.lineAt(update.state.selection.main.head).number);
      }),
    ],
  });
}
