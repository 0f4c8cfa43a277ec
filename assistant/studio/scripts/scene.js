// The scene: the page of `view` in a frame of this origin, linked with the text, in which targets are dragged.
import { find, made, said, word } from "./words.js";
import { ask } from "./server.js";
import { doing } from "./findings.js";
import { on, state as window_ } from "./line.js";
import { fileOf, project, whenChosen } from "./project.js";
import { applied, markLine, onLine, onText, openText, texts } from "./editor.js";

const KINDS = new Set(["program", "table", "drawing", "process"]);
const REST = 700; // ms without a key until the scene is worked out anew
const stage = { name: "", path: "", edits: "", handles: [], frame: null, newest: null, opened: "", view: null, held: -1, look: null, alone: false };
let missed = ""; // a file that could not be shown as it was
let last = ""; // the file that was chosen, or in whose text the cursor was moved
let waiting = 0, round = 0, asked = null, next = null, quiet = false;

/** The scripts of the page that is shown, null for none; see `window.view` there. */
export const sceneView = () => stage.view;
/** The file that is shown, empty for none. */
export const sceneOf = () => stage.path;

/** Shows a file, as it stands in the editor; whether that could be done. */
export async function showScene(path) {
  const mine = ++round;
  clearTimeout(waiting);
  await texts.get(path)?.service.ask("words", { first: 0, last: 0 }).catch(() => undefined); // what was typed is there then
  tell("working", "busy");
  const answer = await doing(() => ask("scene/show", { path }));
  if (mine !== round) return false;
  missed = answer ? "" : path;
  if (!answer) { stale(path); return false; }
  if (answer.name !== stage.opened) await open(answer);
  tell(answer.alone ? word("drawn_alone") : "", answer.alone ? "doubtful" : "");
  return true;
}
/** The scene of the text as it was stays in sight, but nothing is dragged in it. */
function stale(path) {
  const old = stage.view && stage.path === path;
  if (old) stage.view.movable = false;
  tell(old ? word("text_changed") : "", old ? "doubtful" : "");
}
/** A new frame stands behind the old one until it draws, so that nothing flickers. */
function open(answer) {
  const frame = stage.newest = made("iframe"), look = stage.path === answer.path && stage.alone === answer.alone && stage.view ? [stage.view.camera(), stage.view.time()] : null;
  const chosen = stage.path === answer.path ? stage.handles[stage.held]?.name : undefined;
  frame.title = `${word("scene")}: ${answer.path}`;
  frame.src = `scene/${answer.name}/page`;
  stage.opened = answer.name;
  find("scene").querySelector(".empty")?.remove();
  find("scene").prepend(frame);
  return new Promise((resolve) => frame.addEventListener("load", () => {
    if (frame !== stage.newest) { frame.remove(); resolve(); return; } // another one was asked for since
    const view = frame.contentWindow.view;
    for (const other of find("scene").querySelectorAll("iframe")) if (other !== frame) other.remove();
    Object.assign(stage, { name: answer.name, path: answer.path, edits: answer.edits, handles: answer.handles, alone: answer.alone, frame, view: view ?? null, held: -1 });
    find("scene-of").textContent = answer.path;
    themed();
    form(-1);
    if (view) {
      view.movable = window_.writes;
      view.host = { picked, chosen: form, dragged, dropped, left: () => form(-1), at: armAt };
      if (look) { view.look(look[0]); view.setTime(look[1]); }
      if (chosen !== undefined) view.take(answer.handles.findIndex((one) => one.name === chosen));
    }
    resolve();
  }));
}
function themed() {
  stage.view?.theme(document.documentElement.className);
}
/** The line of what was clicked: of a target what declares it, of the path the move. */
async function picked({ handle, line }) {
  const one = stage.handles[handle];
  const to = one?.line ? one : line;
  if (to?.path) await quietly(() => openText(fileOf(to.path), to.line));
}
/** Moves the cursor without that leading the arm. */
async function quietly(does) {
  quiet = true;
  try { return await does(); } finally { quiet = false; }
}
function armAt(line) {
  if (line?.path && texts.has(fileOf(line.path))) markLine(fileOf(line.path), line.line);
}
/** The arm goes where the line of the cursor leads. */
function follows({ path, line }) {
  if (quiet || !stage.view) return;
  if (stage.view.goLine(path, line)) return;
  const above = stage.handles.filter((one) => one.path === path && one.line && one.line <= line);
  const near = above.reduce((best, one) => (one.line > (best?.line ?? 0) ? one : best), null);
  if (near && (near.line === line || path.endsWith(".toml"))) stage.view.goTarget(near.name);
}

// ------------------------------------------------------------------------------- dragging

/** The numbers of what is in hand; nothing without. */
function form(i) {
  stage.held = i;
  const one = stage.handles[i], box = find("drag-form");
  box.hidden = !one; // it lies over the scene, which must not move under a finger
  find("drag-state").textContent = one && window_.writes ? word("dragging") : "";
  find("drag-state").className = "";
  if (!one) return;
  find("drag-name").textContent = one.name;
  numbers(one.position);
}
function numbers(place) {
  ["x", "y", "z"].forEach((axis, k) => {
    if (document.activeElement !== find(`drag-${axis}`)) find(`drag-${axis}`).value = String(Math.round(place[k] * 1000) / 1000);
  });
}
/** Asks about the newest place only; one question is on its way at a time. */
async function dragged(i, place) {
  numbers(place);
  next = { i, place };
  if (asked) return;
  while (next) {
    const now = next, name = stage.name;
    next = null;
    asked = ask("scene/moved", { name, handle: now.i, position: now.place }).catch(() => null);
    const answer = await asked;
    asked = null;
    if (answer && name === stage.name && stage.held === now.i) told(answer);
  }
}
function told({ reached, joints, other, touches, near, left, looked }) {
  if (joints) stage.view.stand(joints);
  const parts = [];
  if (reached !== null) parts.push(reached ? word(other ? "reachable_otherwise" : "reachable") : looked > 1 ? `${word("not_reachable")}: ${left} / ${looked}` : word("not_reachable"));
  if (touches) parts.push(`${word("touches")}: ${touches.join(" – ")}`);
  else if (near) parts.push(`${word("too_near")}: ${near.join(" – ")}`);
  tell(parts.join(" · ") || word("dragging"), reached === false || touches ? "bad" : near || other ? "doubtful" : "good");
}
function tell(text, kind) {
  find("drag-state").textContent = kind === "busy" ? word(text) : text;
  find("drag-state").className = kind;
}
/** The edit of the text that puts it there; one step of the editor. */
async function dropped(i, place) {
  const { name, edits } = stage;
  await texts.get(stage.handles[i].path)?.service.ask("words", { first: 0, last: 0 }).catch(() => undefined);
  const answer = await doing(() => ask("scene/edit", { name, handle: i, position: place }));
  if (!answer) { stage.view?.leave(); return; }
  if (await quietly(() => applied(answer.path, answer.edits))) {
    await quietly(() => openText(answer.path, answer.line));
    await showScene(stage.path || edits);
  } else stage.view?.leave();
}
function typed() {
  const place = ["x", "y", "z"].map((axis) => Number(find(`drag-${axis}`).value));
  if (place.every(Number.isFinite)) stage.view?.drag(place);
}
function dragForm() {
  const box = made("form", undefined, "bar");
  box.id = "drag-form";
  box.hidden = true;
  const name = made("strong");
  name.id = "drag-name";
  box.append(name);
  for (const axis of ["x", "y", "z"]) {
    const label = made("label", `${axis} `), input = made("input");
    input.id = `drag-${axis}`;
    input.type = "number";
    input.step = "any";
    input.addEventListener("input", typed);
    label.append(input, " mm");
    box.append(label);
  }
  const put = said("button", "apply"), leave = said("button", "cancel");
  put.id = "drag-apply";
  leave.type = "button";
  leave.addEventListener("click", () => stage.view?.leave());
  box.append(put, leave);
  box.addEventListener("submit", (event) => { event.preventDefault(); typed(); stage.view?.drop(); });
  box.addEventListener("keydown", (event) => {
    if (event.key === "Escape") stage.view?.leave();
    const up = { ArrowUp: 1, ArrowDown: -1 }[event.key], input = event.target;
    if (!up || input.type !== "number") return;
    event.preventDefault();
    input.value = String(Math.round((Number(input.value) + up * (event.shiftKey ? 10 : 1)) * 1000) / 1000);
    typed();
  });
  return box;
}
/** What the button shows; without a file there is none. */
function wants(path) {
  last = path;
  find("scene-bar").hidden = !path;
}
export function beginScene() {
  find("scene").append(dragForm());
  find("show-scene").addEventListener("click", () => {
    if (last) showScene(last);
  });
  whenChosen((file) => { wants(file.path); if (KINDS.has(file.kind) || project.programs.some(({ source }) => source === file.path)) showScene(file.path); });
  onLine((place) => { wants(place.path); follows(place); });
  onText((path) => {
    if (path !== stage.edits && path !== stage.path && path !== missed) return;
    clearTimeout(waiting);
    waiting = setTimeout(() => showScene(missed || stage.path), REST);
  });
  find("theme").addEventListener("themed", themed);
  on("window", () => { if (stage.view) stage.view.movable = window_.writes; });
  on("disk", ({ files }) => { if (stage.path && !files.includes(stage.edits)) { clearTimeout(waiting); waiting = setTimeout(() => showScene(stage.path), REST); } });
  on("project", () => { for (const one of find("scene").querySelectorAll("iframe")) one.remove(); Object.assign(stage, { name: "", path: "", edits: "", handles: [], frame: null, newest: null, opened: "", view: null }); find("scene-of").textContent = ""; form(-1); });
}
