// Control of the arm: taken by its name, moved by a key that is held, given up by all that goes wrong.
import { find, said, word } from "./words.js";
import { ask } from "./server.js";
import { doing, showOfDoing } from "./findings.js";
import { on, say, state as window_ } from "./line.js";
import { bar, button, fill, filled, form, group, input, labelled } from "./parts.js";
import { confirmed, connection, stopAll, whenConnected } from "./controller.js";

const ALONG = ["X", "Y", "Z", "A", "B", "C"];
let mine = null; // what the studio said when control was taken: {name, watch, fastest}
let hold = 0, presses = 0, tick = 0, joints = [];

function shape() {
  const ask_ = form("control-ask", take, said("span", "control_ask"), input("control-name", "input", { autocomplete: "off", spellcheck: false }), said("button", "take_control"));
  ask_.querySelector("button").id = "take-control";
  ask_.querySelector("input").setAttribute("aria-label", word("control_ask"));
  const dead = button("dead-man", "hold_key");
  dead.setAttribute("aria-pressed", "false");
  const state = input("hold-state", "p");
  state.setAttribute("role", "status");
  const box = input("control", "div");
  box.hidden = true;
  box.append(
    bar(input("control-of", "strong"), button("give-up", "give_up", giveUp), button("stop-here", "stop_all", stopAll, "alarm")),
    bar(said("span", "motors"), button("motors-on", "on", () => motors(true)), button("motors-off", "off", () => motors(false))),
    bar(labelled("axis", input("jog-axis", "select")), labelled("direction", input("jog-by", "select")), labelled("frame", input("jog-frame", "select")), labelled("percent", input("jog-speed", "input", { type: "number", min: 1, step: 1, value: 10 })), input("jog-limits", "output")),
    dead, state, input("watch-time", "p", { className: "faint" }),
    bar(said("span", "hand"), button("hand-open", "opens", () => hand(true)), button("hand-close", "closes", () => hand(false))),
    form("teach-form", teach, labelled("target_name", input("teach-name", "input", { size: 10, spellcheck: false })), labelled("into_file", input("teach-file", "input", { value: "taught.toml", size: 14, spellcheck: false })), labelled("as_joints", input("teach-joints", "input", { type: "checkbox" })), labelled("replace", input("teach-again", "input", { type: "checkbox" })), said("button", "teach"), input("taught", "output")),
  );
  find("control-part").append(group("control", ask_, box));
  fill(find("jog-by"), ["+", "−"]);
  fill(find("jog-frame"), [["base", "base"], ["tool", "tool"]]);
}
async function take() {
  const name = find("control-name").value;
  find("control-name").value = "";
  const done = await doing(() => ask("control/take", { word: name }));
  if (!done) return;
  mine = done;
  tick = 0; // those of an earlier control tell nothing
  const axes = connection.axes.length ? connection.axes.map((one) => one.axis) : ["J1", "J2", "J3", "J4", "J5", "J6"];
  fill(find("jog-axis"), [...axes, ...ALONG]);
  find("jog-speed").max = done.fastest;
  find("jog-speed").value = done.fastest;
  showLimits();
  show();
  find("dead-man").focus();
}
async function giveUp() {
  release();
  await doing(() => ask("control/give-up"));
}
async function motors(on_) {
  release();
  await doing(() => ask("control/motors", { on: on_ }));
}
async function hand(open) {
  await doing(() => confirmed((word_) => ask("control/hand", { number: 1, open, word: word_ })));
}
async function teach() {
  const [name, file] = [find("teach-name").value, find("teach-file").value];
  const done = await doing(() => ask("control/teach", { name, file, joints: find("teach-joints").checked, replace: find("teach-again").checked }));
  find("taught").textContent = done ? `${name} → ${done.file}` : "";
}
function show() {
  find("control").hidden = !mine;
  find("control-ask").hidden = Boolean(mine);
  find("take-control").disabled = !window_.writes || !connection.operates;
  if (mine) {
    find("control-of").textContent = `${word("control_of")} ${mine.name}`;
    find("watch-time").textContent = filled("watch_time", { ms: Math.round(1000 * mine.watch), percent: mine.fastest });
  }
  showHold();
}
function showHold(key = hold ? "held" : "released") {
  const dead = find("dead-man");
  dead.classList.toggle("held", hold > 0);
  dead.setAttribute("aria-pressed", String(hold > 0));
  find("hold-state").dataset.word = key;
  find("hold-state").textContent = word(key);
}
function showLimits() {
  const axis = find("jog-axis").value, limit = connection.axes.find((one) => one.axis === axis);
  const now = joints[Number(axis.slice(1)) - 1];
  find("jog-limits").textContent = limit ? `${now === undefined ? "" : now.toFixed(2)} (${limit.least} … ${limit.most} ${limit.unit})` : "";
  find("jog-frame").disabled = !ALONG.includes(axis);
}
// ------------------------------------------------------------------------------ the held key
function press() {
  if (!mine || hold) return;
  presses += 1;
  hold = presses;
  beat();
  showHold();
}
/** Whatever ends the hold: a key let go, the mouse that leaves, another window in front. */
function release() {
  if (!hold) return;
  hold = 0;
  beat();
  showHold();
}
function beat() {
  if (!mine) return;
  const axis = find("jog-axis").value, by = find("jog-by").value === "+" ? 1 : -1;
  say({ kind: "beat", tick, hold, axis, by, frame: find("jog-frame").value, speed: Number(find("jog-speed").value) });
}
function beginHold() {
  const dead = find("dead-man");
  dead.addEventListener("pointerdown", (event) => { if (event.isPrimary && event.button === 0) { event.preventDefault(); dead.focus(); press(); } });
  for (const name of ["pointerup", "pointercancel", "pointerleave", "lostpointercapture", "contextmenu"]) dead.addEventListener(name, (event) => { if (name === "contextmenu") event.preventDefault(); release(); });
  dead.addEventListener("click", (event) => event.preventDefault());
  dead.addEventListener("blur", release);
  dead.addEventListener("keydown", (event) => { // elsewhere the space bar scrolls, types, or opens a file
    if (event.key !== " ") { if (event.key !== "Shift") release(); return; }
    event.preventDefault();
    if (!event.repeat) press();
  });
  document.addEventListener("keyup", (event) => { if (event.key === " ") { if (event.target === dead) event.preventDefault(); release(); } });
  document.addEventListener("chosen", release); // another tab hides what is held
  for (const name of ["blur", "pagehide", "freeze"]) addEventListener(name, release);
  document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });
}
export function beginControl() {
  shape();
  beginHold();
  find("jog-axis").addEventListener("change", showLimits);
  find("jog-speed").addEventListener("change", ({ target }) => { // what is shown is what it moves at
    target.value = Math.min(mine?.fastest ?? 1, Math.max(1, Number(target.value) || 1));
  });
  on("tick", (message) => { tick = message.tick; beat(); });
  on("control", (message) => {
    if (message.findings?.length) showOfDoing(message.findings);
    hold = 0;
    if (message.ended) mine = null;
    show();
    if (message.cut) showHold(message.stands ? "cut" : "may_move");
  });
  on("monitor", (sample) => { joints = sample.position?.joints ?? []; if (mine) showLimits(); });
  on("window", show);
  find("languages").addEventListener("change", show);
  on("lost", () => { mine = null; hold = 0; show(); });
  whenConnected((found) => {
    if (!found.controlled) mine = null;
    show();
  });
}
