// What the studio knows of a text: each change goes there in its order, and what is found comes back.
import { setDiagnostics } from "../codemirror/codemirror.js";
import { ask } from "./server.js";
import { changedText, showOfFile } from "./findings.js";
import { state as window_ } from "./line.js";
import { markdown } from "./editor_markdown.js";
import { showOutline } from "./editor_outline.js";
import { appliedAll, dispatch, offset, placeOf } from "./editor.js";
import { coloured } from "./editor_marks.js";

const SOON = 15, REST = 400; // ms without a key until it is sent, and until the whole program is looked at
const SEEN = 30; // lines above and below those that are seen, which are coloured too
const CURED = 60; // lines on each side of a cursor whose findings are offered cures
const SORTS = { target: "constant", instruction: "function", procedure: "function", label: "text" };

export class Service {
  version = 0;
  #open; #text; #pending = null; #before = null; #sending = null; #soon = 0; #rest = 0; #findings = []; #fixes = []; #outline = []; #translated = []; #apart = false; #seeing = false; #unseen = false;

  constructor(text, open) { this.#text = text; this.#open = open; }
  get state() { return this.#open.stateOf(); }

  /** A change, and the text before it. */
  changed(changes, before) {
    this.#before ??= before;
    this.#pending = this.#pending ? this.#pending.compose(changes) : changes;
    this.#fixes = [];
    changedText(this.#text.path);
    clearTimeout(this.#soon);
    this.#soon = setTimeout(() => this.#send(), SOON);
    this.settle();
  }
  /** Asks about the text as it stands now; undefined where it was changed meanwhile. */
  async ask(what, values = {}) {
    await this.#send();
    const version = this.version;
    const answer = await ask(`text/${what}`, { path: this.#text.path, version, ...values });
    return answer.stale || version !== this.version || this.#pending ? undefined : answer;
  }
  /** The same; what is refused for a reason that is no matter of the user is left out. */
  #quietly(what, values) { return this.ask(what, values).catch(() => undefined); }

  async #send() {
    clearTimeout(this.#soon);
    while (this.#sending) await this.#sending;
    if (!this.#pending) return;
    const changes = this.#edits();
    this.version += 1;
    const asked = { path: this.#text.path, version: this.version, ...this.#lines() };
    if (this.#apart) asked.text = this.state.doc.toString(); // something was lost on its way there
    else asked.changes = changes;
    this.#sending = ask("text/change", asked).then((answer) => { this.#apart = false; this.#told(answer); }, () => { this.#apart = true; });
    await this.#sending;
    this.#sending = null;
  }
  /** What is pending, the last place first: each is then where it was. */
  #edits() {
    const made = [], doc = this.#before;
    this.#pending.iterChanges((from, to, _from, _to, text) => made.unshift({ from: placeOf(doc, from), to: placeOf(doc, to), text: text.toString() }), true);
    this.#pending = this.#before = null;
    return made;
  }
  #told({ words, findings }) {
    if (this.#pending) return;
    this.#colour(words);
    if (findings) this.#found(findings);
  }
  #lines() {
    const view = this.#open.isHere() ? this.#open.view() : null, doc = this.state.doc;
    if (!view) return { first: 0, last: 0 };
    const { from, to } = view.viewport;
    return { first: Math.max(0, doc.lineAt(from).number - 1 - SEEN), last: doc.lineAt(Math.min(to, doc.length)).number - 1 + SEEN };
  }
  #colour(rows) {
    if (this.#open.isHere()) dispatch(this.#text, { effects: coloured(this.state.doc, rows) });
  }
  /** The lines that are seen have changed; while they are asked about, only the newest wait. */
  async seen() {
    this.#unseen = true;
    if (this.#seeing) return;
    this.#seeing = true;
    while (this.#unseen && this.#open.isHere()) {
      this.#unseen = false;
      const answer = await this.#quietly("words", this.#lines());
      if (answer) this.#colour(answer.words);
    }
    this.#seeing = false;
  }
  shown() {
    this.seen();
    this.#list();
    showOutline(this.#outline);
  }
  /** Looks at the whole program when typing rests. */
  settle(rest = REST) {
    clearTimeout(this.#rest);
    this.#rest = setTimeout(async () => {
      const answer = await this.#quietly("settled");
      if (!answer) return;
      this.#outline = answer.outline;
      if (this.#open.isHere()) showOutline(this.#outline);
      this.#found(answer.findings);
      this.seen();
      this.cures();
    }, rest);
  }
  #found(findings) {
    this.#findings = findings;
    this.#list();
  }
  /** Cures of what is found near the cursor; each of them was tried there. */
  async cures(first, last) {
    if (!this.#findings.length) return;
    const at = placeOf(this.state.doc, this.state.selection.main.head)[0];
    const answer = await this.#quietly("fixes", { first: first ?? Math.max(0, at - CURED), last: last ?? at + CURED });
    if (!answer) return;
    this.#fixes = answer.found;
    this.#list();
  }
  /** What was found when the text was translated. */
  translated(findings) {
    this.#translated = findings;
    this.#list();
  }
  /** Those of the finding, each with what makes it. */
  #fixesOf(finding) {
    if (!window_.writes) return [];
    const same = (one) => ["code", "message", "line", "column"].every((key) => one.finding[key] === finding[key]);
    return (this.#fixes.find(same)?.fixes ?? []).map((fix) => ({ title: fix.title, preferred: fix.preferred, use: () => appliedAll(fix.changes) }));
  }
  /** Cures at a line from 0, of the whole text known so far. */
  fixesAt(line) {
    return this.#findings.filter((one) => one.from[0] <= line && line <= one.to[0]).flatMap((one) => this.#fixesOf(one).map((fix) => ({ ...fix, finding: one })));
  }
  #list() {
    if (!this.#open.isHere()) return;
    const doc = this.state.doc;
    const told = this.#findings.map((finding) => ({ finding, fixes: this.#fixesOf(finding) }));
    dispatch(this.#text, setDiagnostics(this.state, told.map(({ finding, fixes }) => {
      const from = offset(doc, finding.from);
      return {
        from, to: Math.max(from, Math.min(offset(doc, finding.to), doc.lineAt(from).to)), // of a whole module its first line
        severity: finding.severity, source: finding.code,
        message: [finding.message, finding.cure].filter(Boolean).join("\n"),
        actions: fixes.map(({ title, use }) => ({ name: title, apply: use })),
      };
    })));
    showOfFile([...told, ...this.#translated.map((finding) => ({ finding, fixes: [] }))]);
  }
  async completions(context) {
    const begun = context.matchBefore(/[\w$*]+/), behind = context.matchBefore(/[.\\]/);
    if (!begun && !behind && !context.explicit) return null;
    const answer = await this.#quietly("completions", { at: placeOf(context.state.doc, context.pos) });
    if (!answer?.words.length || context.aborted) return null;
    if (!context.explicit && answer.words.length === 1 && answer.words[0].text === begun?.text) return null;
    return {
      from: offset(context.state.doc, answer.words[0].from), filter: false,
      options: answer.words.map((one) => ({ label: one.label, apply: one.text, detail: one.detail, info: one.about ? () => markdown(one.about) : undefined, type: SORTS[one.kind] ?? one.kind })),
    };
  }
  async hover(at) {
    const doc = this.state.doc, found = await this.#quietly("hover", { at: placeOf(doc, at) });
    return found?.text ? { text: found.text, from: offset(doc, found.from), to: offset(doc, found.to) } : null;
  }
}
