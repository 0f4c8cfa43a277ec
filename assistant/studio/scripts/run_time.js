// What a run did over time: its plots, the time line that the arm of the scene follows, and two programs compared.
import { find, made, said, word } from "./words.js";
import { ask, look } from "./server.js";
import { doing, showOfDoing } from "./findings.js";
import { saveAll } from "./editor_saving.js";
import { sceneOf, sceneView } from "./scene.js";
import { indexAt, markTime, plot, showPlots } from "./plots.js";

const FOLLOWS = 150; // ms between two lines that are shown
const AXES = ["x", "y", "z"], TURNS = ["z", "y", "x"];
let motion = { samples: 0, t: [] }, moves = [], times = [], playing = null, followed = 0, following = 0;

let program = ""; // that ran
export const ranBy = (path) => { program = path ?? ""; };
/** The arm of the scene stands there, by the joints of its chain; null says nothing. The scene of another program has an arm of its own. */
export function pose(chain) {
  if (chain && sceneOf() === program) sceneView()?.stand?.(chain);
}
const column = (rows, i) => rows.map((row) => row[i]);

/** Curves of what moved. others: {name, found} of two programs, the second in dashes. */
function curvesOf(read, names, others) {
  return others.flatMap(({ name, found }, second) => names(found).map((label, i) => ({
    name: others.length > 1 ? `${label} (${name})` : label, t: found.t, values: read(found, i), second: second === 1, colour: i,
  })));
}
function figures(others, across, prefix) {
  const over = `${word("time")}, s`, all = others.filter(({ found }) => found.samples);
  if (!all.length) return [said("p", "no_motion", "empty")];
  const one = (id, title, unit, read, names) => plot({ id: `${prefix}-${id}`, title: word(title), unit, over, across, curves: curvesOf(read, names, all) });
  return [
    one("position", "place", "mm", (found, i) => column(found.position, i), () => AXES),
    one("orientation", "orientation", "°", (found, i) => column(found.orientation, i), () => TURNS),
    one("speed", "tool_speed", "mm/s", (found) => found.speed, () => ["TCP"]),
    one("joints", "joints", "°", (found, i) => column(found.joints, i), (found) => found.axes),
    ...signals(all, across, prefix, over),
  ];
}
function signals(all, across, prefix, over) {
  const curves = all.flatMap(({ name, found }, second) => ["input", "output"].flatMap((kind) => found[`${kind}_names`].map((label, i) => ({
    name: `${word(`${kind}s`)}: ${label}${all.length > 1 ? ` (${name})` : ""}`, t: found.t, values: column(found[`${kind}s`], i), second: second === 1,
  }))));
  return curves.length ? [plot({ id: `${prefix}-signals`, title: word("signals"), unit: "0/1", over, across, curves: curves.slice(0, 12) })] : [];
}
/** Takes in what the arm did until now. rows: of the log. */
export async function showMotion(rows) {
  motion = await look("run/motion").catch(() => ({ samples: 0, t: [] }));
  moves = rows.filter(({ line, path }) => path && line);
  times = moves.map((row) => row.time);
  const end = motion.t.at(-1) ?? 0, slider = find("run-time");
  find("run-over-time").hidden = motion.samples < 2;
  slider.max = end;
  slider.step = end > 0 ? Math.min(0.01, end / 100) : 0.01;
  slider.disabled = find("run-play").disabled = !motion.samples;
  showPlots("run-plots", figures([{ name: "", found: motion }], (time) => scrub(time), "plot"));
  slider.value = end;
  tell(end);
}
export function forgetMotion() {
  stop();
  motion = { samples: 0, t: [] };
  moves = [];
  find("run-over-time").hidden = true;
  markTime(null);
}
function tell(time) {
  find("run-at").textContent = `${time.toFixed(2)} s`;
  find("run-time").setAttribute("aria-valuetext", `${time.toFixed(2)} s`);
  markTime(time);
}
let lineThere = null; // shows a line of a text
export const goesToLine = (does) => { lineThere = does; };
/** The moment of the recorded motion: the arm stands as it did, the line is marked that it went by. */
export function scrub(time) {
  find("run-time").value = time;
  tell(time);
  if (!motion.samples) return;
  const i = indexAt(motion.t, time), j = Math.min(i + 1, motion.t.length - 1), span = motion.t[j] - motion.t[i];
  const share = span > 0 ? Math.min(1, Math.max(0, (time - motion.t[i]) / span)) : 0;
  pose(motion.chain[i].map((value, axis) => value + share * (motion.chain[j][axis] - value)));
  if (moves.length) follow(moves[indexAt(times, time)]);
}
/** The text follows less often than the arm: a text that is scrolled is laid out anew. */
function follow(row) {
  const wait = FOLLOWS - (performance.now() - followed);
  clearTimeout(following);
  if (wait > 0) { following = setTimeout(() => follow(row), wait); return; }
  followed = performance.now();
  lineThere?.(row);
}
function stop() {
  if (playing !== null) cancelAnimationFrame(playing);
  playing = null;
  find("run-play").setAttribute("aria-pressed", "false");
}
function play() {
  if (playing !== null) { stop(); return; }
  const end = motion.t.at(-1) ?? 0, from = Number(find("run-time").value), begin = from >= end - 0.01 ? 0 : from, began = performance.now();
  const frame = (now) => {
    const time = Math.min(end, begin + (now - began) / 1000);
    scrub(time);
    if (time < end) playing = requestAnimationFrame(frame);
    else stop();
  };
  find("run-play").setAttribute("aria-pressed", "true");
  playing = requestAnimationFrame(frame);
}
const ANSWERS = { equal: "compared_equal", different: "compared_different", "not compared": "compared_not" };
/** Compares two programs as a run is asked for now, and lays their curves over each other. */
export async function compare(asked) {
  const second = find("compare-with").value, result = find("compare-result");
  if (!second || !await saveAll()) return;
  result.textContent = word("running");
  showPlots("compare-plots", []);
  const done = await doing(() => ask("run/compare", { ...asked, first: asked.path, second }));
  result.textContent = "";
  if (!done) return;
  showOfDoing(done.findings);
  const far = done.deviation, names = done.names.map((name) => name.split("/").at(-1));
  const told = far ? `${word("deviation")}: ${far.distance.toFixed(3)} mm, ${far.angle.toFixed(3)}° (${names[far.of]}, ${far.time.toFixed(2)} s)` : word("no_motion");
  result.append(made("strong", told, "numbers"), made("br"), made("strong", word(ANSWERS[done.answer])), made("br"), done.line, made("br"), names.map((name, i) => `${name}: ${done.seconds[i].toFixed(2)} s`).join(" · "));
  if (done.line) result.append(" · ", Object.assign(made("a", word("side_by_side")), { href: "run/compared", target: "_blank", id: "compare-page" }));
  showPlots("compare-plots", figures(done.motions.map((found, i) => ({ name: names[i], found })), undefined, "compare"));
}
export function beginRunTime() {
  let drawing = 0;
  find("run-time").addEventListener("input", () => {
    stop();
    cancelAnimationFrame(drawing);
    drawing = requestAnimationFrame(() => scrub(Number(find("run-time").value)));
  });
  find("run-play").addEventListener("click", play);
}
