// Running a program on the virtual controller: held, stepped, switched by hand, and seen over time.
import { EditorView } from "../codemirror/codemirror.js";
import { find, made, said, word } from "./words.js";
import { ask, look } from "./server.js";
import { doing, showOfDoing } from "./findings.js";
import { on, state as window_ } from "./line.js";
import { project, whenChosen, whenRead } from "./project.js";
import { breakPoints, current, markLine, offset, onBreakPoints, onText, openText } from "./editor.js";
import { bar, button, fill, form, group, input, labelled, row } from "./parts.js";
import { sceneOf, showScene } from "./scene.js";
import { saveAll } from "./editor_saving.js";
import { beginRunTime, compare, forgetMotion, goesToLine, pose, ranBy, scrub, showMotion } from "./run_time.js";

const RUNS = new Set(["program", "drawing", "table"]), MOST_ROWS = 500;
const KEYS = { F8: "run-go", F7: "run-step", F10: "run-over", "Shift+F8": "run-end" };
let run = { state: "" }, rows = [], reading = null, marked = null, motionOf = "", changed = false;

const is = (...states) => states.includes(run.state);
function keyed(id, key, keys) {
  const one = Object.assign(button(id, key), { title: keys });
  one.setAttribute("aria-keyshortcuts", keys);
  return one;
}
function shape() {
  const fold = (id, key, inside) => { const one = input(id, "details"); one.append(said("summary", key), inside); return one; };
  const state = input("run-state", "p");
  state.setAttribute("role", "status");
  const question = form("run-question", answer, made("strong"), input("run-answer", "input"), said("button", "answer"));
  question.hidden = true;
  const signal = form("run-signal", switchInput, labelled("input_name", input("signal-name", "input", { size: 10, autocomplete: "off" })), labelled("value", input("signal-value", "input", { type: "number", step: "any", value: "1" })), said("button", "set_input"));
  const time = input("run-over-time", "div", { hidden: true }), results = made("div");
  const slider = input("run-time", "input", { type: "range", min: "0", max: "1", value: "0" });
  time.append(group("time", bar(button("run-play", "play"), input("run-at", "output")), slider), group("plots", input("run-plots", "div")));
  results.append(input("compare-result", "p"), input("compare-plots", "div"));
  find("panel-run").append(
    bar(labelled("program", input("run-program", "select")), labelled("robot", input("run-robot", "select")), labelled("script", input("run-script", "select")), labelled("real_time", input("run-real", "input", { type: "checkbox" }))),
    bar(button("run-start", "start"), keyed("run-go", "go_on", "F8"), button("run-pause", "pause"), keyed("run-step", "step", "F7"), keyed("run-over", "step_over", "F10"), button("run-out", "step_out"), keyed("run-end", "end", "Shift+F8")),
    state, question,
    group("inputs", input("run-inputs", "div", { className: "bar" }), signal),
    group("outputs", input("run-outputs", "div", { className: "bar numbers" })),
    fold("run-data-part", "variables", input("run-data", "div")),
    fold("run-log-part", "log", input("run-log", "ol")),
    time,
    group("compare", form("compare-form", () => compare(asked()), input("compare-with", "select"), said("button", "start")), results),
  );
  for (const [id, key] of [["run-answer", "answer"], ["compare-with", "compare"], ["run-time", "time"]]) find(id).setAttribute("aria-label", word(key));
}
async function answer() {
  await doing(() => ask("run/answer", { text: find("run-answer").value }));
  find("run-answer").value = "";
}
function switchInput() {
  return doing(() => ask("run/signal", { name: find("signal-name").value, value: Number(find("signal-value").value) }));
}
// ------------------------------------------------------------------ what to run
const runnable = () => project.files.filter((file) => RUNS.has(file.kind)).map((file) => file.path);
async function choicesOf(path) {
  const found = await look("run/choices", { path }).catch(() => null);
  if (!found) return;
  fill(find("run-robot"), [["", "no_robot"], ...new Set([found.robot, ...found.robots].filter(Boolean))], found.robot ?? find("run-robot").value);
  fill(find("run-script"), [["", "none"], ...found.scripts]);
}
const asked = () => ({ path: find("run-program").value, robot: find("run-robot").value, script: find("run-script").value, real_time: find("run-real").checked });
async function start(at_once) {
  const wanted = asked();
  if (!wanted.path) return;
  if (!await saveAll()) return;
  changed = false;
  if (sceneOf() !== wanted.path) showScene(wanted.path); // whose arm shows the run
  forgetMotion();
  rows = [];
  find("run-log").replaceChildren();
  delete find("run-log").dataset.shown;
  motionOf = "";
  const points = Object.fromEntries(runnable().map((path) => [path, breakPoints(path)]).filter(([, lines]) => lines.length));
  const begun = await doing(() => ask("run/start", { ...wanted, points, at_once }));
  if (begun && is("")) show(begun);
}
/** Nothing is pressed twice: it counts as running until it is told how it stands. */
async function go(how) {
  show({ ...run, state: "running", chain: null });
  if (!await doing(() => ask("run/go", { how }))) show(await look("run"));
}

// ------------------------------------------------------------------ how it stands
function show(now) {
  run = now;
  ranBy(run.program);
  const held = is("held"), going = is("running", "waits", "asks", "held"), writes = window_.writes;
  const can = { "run-start": writes, "run-go": writes && held, "run-pause": writes && is("running", "waits"), "run-end": writes && going };
  for (const id of ["run-step", "run-over", "run-out"]) can[id] = writes && (held || (!going && id === "run-step"));
  for (const [id, may] of Object.entries(can)) find(id).disabled = !may;
  find("run-state").textContent = [told(), changed && run.state ? word("text_changed") : ""].filter(Boolean).join(" · ");
  find("run-question").hidden = !is("asks");
  find("run-question").firstChild.textContent = run.question ?? "";
  signals();
  data();
  if (run.chain && going) pose(run.chain);
  markHeld(going && !(is("running") && !find("run-real").checked) ? run : null);
  readLog();
  if (is("ended")) showOfDoing(run.findings);
  settle();
}
function told() {
  if (!run.state) return "";
  const where = run.line ? `${run.path}:${run.line}` : "", time = `${(run.time ?? 0).toFixed(2)} s`;
  if (is("held")) return `${word("held_at")} ${where} · ${time}`;
  if (is("waits")) return `${word("waits_for")} ${run.waits} · ${where} · ${time}`;
  if (is("asks")) return `${word("asks")} · ${where} · ${time}`;
  if (is("ended")) return `${word("ended")}${run.ended === "end" ? "" : ` (${run.ended === "until" ? word("by_hand") : run.message || run.ended})`} · ${run.summary}`;
  return `${word("running")} · ${where} · ${time}`;
}
/** Once it stands: what moved until now. */
async function settle() {
  const key = is("held", "waits", "asks", "ended") ? `${run.state} ${run.time} ${run.logged}` : "";
  if (!key || key === motionOf) return;
  motionOf = key;
  await readLog();
  if (motionOf === key && run.robot) await showMotion(rows);
}
function signals() {
  const inputs = (run.inputs ?? []).map(({ name, value }) => {
    const key = made("button", `${name} = ${value}`), isOn = value === 1;
    key.type = "button";
    key.dataset.input = name;
    key.setAttribute("aria-pressed", String(isOn));
    key.disabled = !window_.writes || !is("running", "held", "waits", "asks");
    key.addEventListener("click", () => doing(() => ask("run/signal", { name, value: isOn ? 0 : 1 })));
    return key;
  });
  renew(find("run-inputs"), inputs.length ? inputs : [said("span", "none", "empty")], JSON.stringify([run.inputs, run.state, window_.writes]));
  const outputs = (run.outputs ?? []).map(({ name, value }) => made("span", `${name} = ${value}`, value ? "output-on" : ""));
  renew(find("run-outputs"), outputs.length ? outputs : [said("span", "none", "empty")], JSON.stringify(run.outputs));
}
/** Only what changed is made anew, so that a key that is being pressed stays. */
function renew(element, parts, key) {
  if (element.dataset.shown === key) return;
  const focus = document.activeElement?.dataset.input;
  element.dataset.shown = key;
  element.replaceChildren(...parts);
  if (focus !== undefined) [...element.children].find((one) => one.dataset.input === focus)?.focus();
}
function data() {
  const parts = [];
  if (run.stack?.length > 1) parts.push(lines(run.stack.map((call) => ({ ...call, what: call.name }))));
  for (const { title, rows: shown } of run.data ?? []) {
    if (!shown.length) continue;
    const table = made("table", undefined, "numbers");
    table.append(...shown.map(({ name, type, value }) => row(name, type, value)));
    parts.push(made("h3", title), table);
  }
  renew(find("run-data"), parts.length ? parts : [said("p", "only_held", "empty")], JSON.stringify([run.stack, run.data]));
}
function lines(shown) {
  const list = made("ul");
  list.append(...shown.map(line));
  return list;
}
function line(row) {
  const item = made("li"), button = made("button");
  const where = row.line ? `${row.path.split("/").at(-1)}:${row.line}` : "";
  button.append(made("small", [row.time === undefined ? "" : row.time.toFixed(3), where].filter(Boolean).join("  ")), " ", row.what);
  button.addEventListener("click", async () => { if (row.line) await openText(row.path, row.line); if (row.time !== undefined && !find("run-over-time").hidden) scrub(row.time); });
  item.append(button);
  return item;
}
function readLog() {
  reading ??= read().finally(() => { reading = null; });
  return reading;
}
async function read() {
  while (rows.length < (run.logged ?? 0) || is("ended")) {
    const found = await look("run/log", { first: rows.length }).catch(() => null);
    if (!found?.rows.length) break;
    rows.push(...found.rows);
  }
  const list = find("run-log");
  if (list.dataset.shown === String(rows.length)) return;
  list.dataset.shown = String(rows.length);
  list.replaceChildren(...rows.slice(-MOST_ROWS).map(line));
}
// ------------------------------------------------------------------ the line in the text
async function markHeld(place) {
  const next = place?.line ? place : null;
  if (marked && marked.path !== next?.path) markLine(marked.path, undefined);
  marked = next;
  if (!next || !project.files.some((file) => file.path === next.path)) return;
  if (is("held", "waits", "asks") && current()?.text.path !== next.path) {
    const focus = document.activeElement;
    await openText(next.path);
    focus?.focus?.();
  }
  if (marked !== next) return;
  markLine(next.path, next.line);
  const shown = current();
  if (shown?.text.path !== next.path) return;
  const doc = shown.view.state.doc;
  shown.view.dispatch({ effects: EditorView.scrollIntoView(offset(doc, [next.line - 1, 0]), { y: "nearest", yMargin: 40 }) });
}
export function beginRun() {
  shape();
  beginRunTime();
  goesToLine((row) => markHeld(row));
  const press = {
    "run-start": () => start(false), "run-go": () => go("on"), "run-pause": () => doing(() => ask("run/pause")), "run-over": () => go("over"),
    "run-out": () => go("out"), "run-end": () => doing(() => ask("run/end")), "run-step": () => (is("held") ? go("step") : start(true)),
  };
  for (const [id, does] of Object.entries(press)) find(id).addEventListener("click", does);
  document.addEventListener("keydown", (event) => {
    const id = KEYS[`${event.shiftKey ? "Shift+" : ""}${event.key}`];
    if (!id || event.altKey || event.ctrlKey) return;
    event.preventDefault();
    if (id === "run-go" && !is("held")) find("run-start").click();
    else find(id).click();
  });
  find("machine").addEventListener("chosen", ({ target }) => {
    const split = target.id === "tab-run"; // the scene stays in sight: its arm follows the run
    find("machine").classList.toggle("split", split);
    if (split) find("panel-scene").hidden = false;
  });
  find("run-program").addEventListener("change", () => choicesOf(find("run-program").value));
  whenChosen((file) => { if (RUNS.has(file.kind) && !is("running", "held", "waits", "asks")) { find("run-program").value = file.path; choicesOf(file.path); } });
  whenRead(() => { fill(find("run-program"), runnable()); fill(find("compare-with"), runnable()); if (find("run-program").value) choicesOf(find("run-program").value); });
  onBreakPoints((path) => { if (is("running", "held", "waits", "asks")) doing(() => ask("run/points", { path, lines: breakPoints(path) })); });
  onText((path) => { if (!changed && run.state && (path === run.program || path === run.path)) { changed = true; show(run); } });
  on("run", show);
  on("window", async () => show(await look("run").catch(() => ({ state: "" }))));
  on("project", () => { forgetMotion(); show({ state: "" }); });
  on("lost", () => show({ state: "" }));
  show({ state: "" });
}
