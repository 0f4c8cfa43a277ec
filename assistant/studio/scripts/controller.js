// The controller: connecting, what it does, its programs beside ours, settings, errors, backups.
import { find, made, said, word } from "./words.js";
import { ask, look, Refused } from "./server.js";
import { doing, showOfDoing } from "./findings.js";
import { on } from "./line.js";
import { choose } from "./tabs.js";
import { saveAll } from "./editor_saving.js";
import { project, whenRead } from "./project.js";
import { bar, button, fill, filled, folded, form, group, input, labelled, row, table } from "./parts.js";

const NOT_CONFIRMED = "ST041", NO_PASSWORD = "CN112";
const MOST_DIGITS = 3;
export const connection = { connected: false, controlled: false, axes: [] };
const told = []; // called whenever the connection is another one
export const whenConnected = (does) => told.push(does);
let answer = null; // of who is asked to confirm something

/** Asks for something that may have to be confirmed by typing the name of the controller. */
export async function confirmed(does) {
  try {
    return await does("");
  } catch (refused) {
    if (!(refused instanceof Refused) || refused.findings[0]?.code !== NOT_CONFIRMED) throw refused;
    const word_ = await askedFor(refused.findings[0]);
    return word_ ? does(word_) : undefined;
  }
}
function askedFor(finding) {
  answer?.("");
  const { message, cure } = finding;
  find("confirm-what").textContent = `${message.split(",")[0]}. ${cure}`;
  find("confirm").hidden = false;
  find("confirm-word").value = "";
  find("confirm-word").focus();
  return new Promise((resolve) => { answer = resolve; });
}
function confirmBy(text) {
  find("confirm").hidden = true;
  answer?.(text);
  answer = null;
}
function shape() {
  const cancel = button("confirm-cancel", "cancel", () => confirmBy(""));
  const confirm = form("confirm", () => confirmBy(find("confirm-word").value), input("confirm-what", "span"), input("confirm-word", "input", { autocomplete: "off", spellcheck: false }), said("button", "apply"), cancel);
  confirm.className = "notice";
  confirm.hidden = true;
  confirm.setAttribute("role", "alert");
  const password = labelled("password", input("password", "input", { type: "password", autocomplete: "off" }));
  password.id = "password-label";
  password.hidden = true;
  const state = input("controller-state", "output");
  state.setAttribute("role", "status");
  const rest = input("connected", "div");
  rest.hidden = true;
  rest.append(
    group("state", input("monitor", "div"), form("signals-form", watch, labelled("signals", input("signal-names", "input", { autocomplete: "off", spellcheck: false })), said("button", "apply"))),
    input("control-part", "div"),
    group("programs_there", bar(button("plan", "plan", plan), button("deploy", "deploy", deploy), button("verify", "verify", verify), button("roll-back", "roll_back", rollBack)), input("programs", "div")),
    group("parameters", form("parameters-form", readParameters, input("parameter-names", "input", { autocomplete: "off", spellcheck: false }), said("button", "read")), input("parameters", "div")),
    group("errors", bar(button("read-errors", "read", readErrors), button("acknowledge", "acknowledge", acknowledge)), input("errors", "div")),
    group("backup", bar(button("backup", "backup", backUp), input("backups", "select"), button("compare-backup", "plan", () => restore(false)), button("restore", "restore", () => restore(true))), input("restoring", "div")),
  );
  find("panel-controller").append(
    form("connect-form", connect, labelled("controller", input("controller-name", "select")), password, said("button", "connect"), button("disconnect", "disconnect", disconnect), state),
    confirm, rest,
  );
  for (const [id, key] of [["parameter-names", "parameters"], ["backups", "backup"], ["confirm-word", "controller"]]) find(id).setAttribute("aria-label", word(key));
}
// ---------------------------------------------------------------------------- connection
async function connect() {
  const field = find("password"), password = field.value;
  field.value = "";
  const done = await doing(async () => {
    try {
      return await ask("controller/connect", { name: find("controller-name").value, password });
    } catch (refused) {
      const asked = refused instanceof Refused && refused.findings[0]?.code === NO_PASSWORD;
      find("password-label").hidden = !asked && find("password-label").hidden;
      if (asked) field.focus();
      throw refused;
    }
  });
  if (done) find("password-label").hidden = true;
}
async function disconnect() {
  await doing(() => ask("controller/leave"));
}
async function refresh() {
  const before = connection.connected && connection.name;
  Object.assign(connection, { controlled: false }, await look("controller"));
  const { connected } = connection;
  find("connected").hidden = !connected;
  find("disconnect").hidden = !connected;
  find("stop-all").hidden = !connected;
  find("controller-state").textContent = connected
    ? [connection.name, connection.virtual ? word("virtual") : connection.address, connection.identity.robot, connection.identity.version].filter(Boolean).join(" · ")
    : word("not_connected");
  if (!connected || connection.name !== before) confirmBy("");
  if (connected && connection.name !== before) {
    for (const id of ["programs", "parameters", "errors", "restoring", "monitor"]) find(id).replaceChildren();
    shownPlan("");
    await readBackups();
  }
  for (const does of told) does(connection);
}
export function stopAll() {
  return doing(async () => {
    find("controller-state").textContent = ""; // what was true before is not told meanwhile
    const rest = await ask("control/stop").catch((refused) => { showRest({ stands: false, reason: "" }); throw refused; });
    showRest(rest);
    return rest;
  });
}
/** Whether the arm stands; that nobody knows is shown whatever is looked at. */
function showRest({ stands, reason }) {
  find("controller-state").textContent = stands ? word("stands") : `${word("may_move")} ${reason}`;
  if (!stands) choose("tab-controller");
}
// ------------------------------------------------------------------------------- looking
const number = (value) => value === null || value === undefined ? "–" : Number(value).toFixed(MOST_DIGITS).replace(/\.?0+$/, "");
function show(sample) {
  if (sample.lost) showOfDoing(sample.findings);
  if (sample.findings) { find("monitor").replaceChildren(...sample.findings.map((one) => made("p", `${one.code} ${one.message}`, "changed"))); return; }
  const { state, position } = sample, limits = new Map(connection.axes.map((one) => [one.axis, one]));
  const words = [state.mode, `${word("motors")} ${word(state.motors ? "on" : "off")}`, state.running ? word("running") : word("stands"), state.override === null ? "" : `${state.override} %`];
  const lines = [made("p", words.filter(Boolean).join(" · "))];
  if (state.emergency) lines.push(said("p", "emergency", "alarm"));
  for (const fault of state.faults) lines.push(made("p", `${fault.number} ${fault.text} ${fault.cure}`, "changed"));
  for (const task of state.tasks) if (task.program) lines.push(made("p", `${task.name}: ${task.program} ${task.line ?? ""} ${task.running ? word("running") : ""}`));
  const joints = position.joints.flatMap((value, i) => {
    const limit = limits.get(`J${i + 1}`), name = `J${i + 1}`;
    return value === null ? [] : [row(name, number(value), limit ? `${number(limit.least)} … ${number(limit.most)} ${limit.unit}` : "")];
  });
  const pose = [...["X", "Y", "Z"].map((axis, i) => row(axis, number(position.position[i]), "mm")), row(word("orientation"), position.quaternion.map(number).join(", "), "w, x, y, z")];
  const signals = Object.entries(sample.signals).map(([name, value]) => row(name, number(value), ""));
  find("monitor").replaceChildren(...lines, table(["axis", "place", "limits"], [...joints, ...pose], "numbers"), ...(signals.length ? [table(["signals", "value"], signals, "numbers")] : []));
}
async function watch() {
  const signals = find("signal-names").value.split(/[,\s]+/).filter(Boolean);
  await doing(() => ask("controller/watch", { signals }));
}
// ----------------------------------------------------------------------------- deploying
const replaced = () => [...find("programs").querySelectorAll("input:checked")].map((one) => one.value);
const replacing = (name) => labelled("replace_there", input("", "input", { type: "checkbox", value: name }));
/** A row of a program, and one below it with what differs. */
function programRows(name, state, more, differences) {
  const below = made("td");
  below.colSpan = 3;
  below.append(...differences);
  return [row(name, state, more), ...(differences.length ? [row(below)] : [])];
}
function planned(file) {
  const conflict = file.change === "conflict", differences = file.reason ? [made("p", file.reason, "changed")] : [];
  if (file.since) differences.push(folded(word("drift"), file.since, true));
  if (file.taught && !file.since) differences.push(folded(word("taught_there"), file.taught, true));
  if (file.diff) differences.push(folded(word("to_send"), file.diff, !file.since));
  const state = made("td", file.state ?? file.change, { unchanged: "same", conflict: "changed" }[file.change] ?? "");
  return programRows(file.name, state, conflict ? replacing(file.name) : "", differences);
}
function showPlan(done) {
  if (!done) return;
  const parts = done.targets.flatMap((target) => {
    const others = [...target.foreign, ...target.left];
    const listed = others.length ? [made("p", `${word("not_ours")}: ${others.join(", ")}`)] : [];
    const kept = target["kept in"] ? [made("p", `${word("kept_in")} ${target["kept in"]}`)] : [];
    return [table(["program", "state", ""], target.files.flatMap(planned)), ...listed, ...kept];
  });
  find("programs").replaceChildren(...parts);
}
/** Draws the list of programs anew; what is ticked meanwhile would be lost, so nothing can be. */
async function redrawn(does) {
  find("programs").inert = true;
  try {
    await does();
  } finally {
    find("programs").inert = false;
  }
}
async function plan() {
  if (!await saveAll()) return;
  await redrawn(async () => {
    const done = await doing(() => ask("controller/plan", { replace: replaced() }));
    showPlan(done);
    shownPlan(done?.plan ?? "");
  });
}
/** Only a plan that is in sight is deployed, and as it is there. */
function shownPlan(name) {
  find("deploy").disabled = !name;
  find("deploy").dataset.plan = name;
}
async function deploy() {
  const { plan } = find("deploy").dataset, replace = replaced();
  shownPlan("");
  await redrawn(async () => showPlan(await doing(() => ask("controller/deploy", { plan, replace }))));
}
const SEEN = { "as deployed": "same", changed: "changed", gone: "changed" };
function showSeen(done) {
  const rows = done.targets.flatMap((target) => target.programs).flatMap(({ name, seen, since }) => {
    const state = made("td", seen === "as deployed" ? word("as_left") : seen, SEEN[seen] ?? "");
    return programRows(name, state, seen === "changed" ? replacing(name) : "", since ? [folded(word("drift"), since, true)] : []);
  });
  const summary = made("p", word(done.ok ? "as_left" : "drift"), done.ok ? "same" : "changed");
  summary.id = "drift";
  find("programs").replaceChildren(summary, table(["program", "state", ""], rows));
}
async function verify() {
  shownPlan("");
  await redrawn(async () => {
    const done = await doing(() => ask("controller/verify"));
    if (done) showSeen(done);
  });
}
async function rollBack() {
  shownPlan("");
  await redrawn(async () => {
    const done = await doing(() => ask("controller/rollback", { replace: replaced() }));
    if (done) find("programs").replaceChildren(table(["program", "state"], done.files.map((file) => row(file.name, file.state))));
    else showSeen(await ask("controller/verify")); // beside why it was refused
  });
}
// ------------------------------------------------------------------------------ settings
function showParameters(found) {
  const rows = Object.entries(found).map(([name, value]) => {
    const field = input("", "input", { value, spellcheck: false });
    field.setAttribute("aria-label", name);
    const change = button("", "set_input", async () => {
      const wanted = { name, value: field.value }; // what is confirmed is what was asked about
      const done = await doing(() => confirmed((word_) => ask("controller/parameter", { ...wanted, word: word_ })));
      if (done) field.value = done.parameters[name] ?? field.value;
    });
    return row(name, field, change);
  });
  find("parameters").replaceChildren(rows.length ? table(["parameters", "value", ""], rows) : said("p", "none"));
}
async function readParameters() {
  const names = find("parameter-names").value.split(/\s+/).filter(Boolean);
  const done = await doing(() => ask("controller/parameters", { names }));
  if (done) showParameters(done.parameters);
}
async function readErrors() {
  const done = await doing(() => look("controller/log"));
  if (!done) return;
  const rows = done.log.map((one) => {
    const text = made("td", one.text);
    if (one.cure) text.append(made("br"), made("small", one.cure));
    return row((one.time ?? "").replace("T", " ").slice(0, 19), made("td", String(one.number), one.level === "error" ? "changed" : ""), text);
  });
  find("errors").replaceChildren(rows.length ? table(["time", "errors", ""], rows) : said("p", "none"));
}
async function acknowledge() {
  if (await doing(() => ask("controller/acknowledge"))) await readErrors();
}
// ------------------------------------------------------------------------------- backups
async function readBackups() {
  fill(find("backups"), (await look("controller/backups")).folders.reverse());
}
async function backUp() {
  const done = await doing(() => ask("controller/backup"));
  if (!done) return;
  await readBackups();
  find("restoring").replaceChildren(made("p", filled("backed_up", { count: done.files, folder: done.folder })));
}
async function restore(apply) {
  const folder = find("backups").value;
  const done = await doing(() => confirmed((word_) => ask("controller/restore", { folder, apply, word: word_ })));
  if (!done) return;
  const changes = Object.entries(done.changes), left = Object.entries(done.left_out).map(([what, why]) => row(what, why));
  find("restoring").replaceChildren(
    made("p", done.restored ? word("restored") : word(changes.length ? "differs" : "as_backup"), changes.length && !done.restored ? "changed" : "same"),
    ...(done.restored && done.needs_restart ? [said("p", "needs_restart")] : []),
    ...changes.map(([what, text]) => folded(what, text, !done.restored)),
    ...(left.length ? [table(["left_out", ""], left)] : []),
  );
}
export function beginController() {
  shape();
  whenRead(() => {
    fill(find("controller-name"), project.controllers.map((one) => one.name));
    return refresh();
  });
  find("stop-all").addEventListener("click", stopAll);
  on("controller", refresh);
  on("monitor", show);
  on("lost", () => { find("connected").hidden = true; });
}
