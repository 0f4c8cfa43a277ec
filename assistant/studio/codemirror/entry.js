// What the studio uses of CodeMirror 6; `make editor` bundles it into codemirror.js beside this file.
export { EditorState, EditorSelection, StateEffect, StateField, Compartment, RangeSetBuilder, Transaction } from "@codemirror/state";
export {
  EditorView, ViewPlugin, Decoration, GutterMarker, gutter, keymap, lineNumbers, drawSelection,
  highlightActiveLine, highlightActiveLineGutter, highlightSpecialChars, hoverTooltip,
} from "@codemirror/view";
export { defaultKeymap, history, historyKeymap, indentWithTab, undo, redo } from "@codemirror/commands";
export { searchKeymap, search } from "@codemirror/search";
export { autocompletion, completionKeymap, closeBrackets } from "@codemirror/autocomplete";
export { setDiagnostics, lintGutter, lintKeymap, linter, forceLinting } from "@codemirror/lint";
