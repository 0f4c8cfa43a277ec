// The project: its files, opening and creating, and what is dropped onto it.
import { find, made, said, shown, word } from "./words.js";
import { ask, look, send } from "./server.js";
import { alsoOfDoing, doing, showOfDoing } from "./findings.js";
import { on } from "./line.js";
import { saveAll } from "./editor_saving.js";

const opened = []; // called with a file that is chosen
const told = []; // called with the project whenever it is read
export const whenChosen = (does) => opened.push(does);
export const whenRead = (does) => told.push(does);
export const project = { files: [], programs: [], targets: [], controllers: [] };
const FOLDED = "backups/"; // what controllers had is no part of the work
let current = "";
/** A file as the project names it, by whatever name it is told of. */
export function fileOf(path) {
  const before = `${project.folder}/`;
  return path.startsWith(before) ? path.slice(before.length) : path;
}

export async function readProject() {
  Object.assign(project, await look("project"));
  find("folder").textContent = shown(project.folder);
  document.title = `${shown(project.name)} · ${word("studio")}`;
  find("begin").hidden = project.there;
  find("project-does").hidden = !project.there;
  showFiles();
  if (project.findings?.length) showOfDoing(project.findings);
  for (const does of told) does(project);
}
/** The list; the one that had the keyboard has it still. */
function showFiles() {
  const list = find("files"), had = list.contains(document.activeElement) ? document.activeElement.dataset.path : undefined;
  const inside = project.files.filter(isFolded);
  const open = list.querySelector("details")?.open || isFolded({ path: had ?? current });
  list.replaceChildren(...GROUPS.flatMap(([key, holds]) => grouped(key, project.files.filter((file) => !isFolded(file) && groupOf(file) === holds))), ...(inside.length ? [folder(inside, open)] : []));
  if (!project.files.length) list.append(said("li", "no_files", "empty"));
  if (project.more) list.append(said("li", "more_files", "empty"));
  const buttons = walked();
  const first = buttons.find((one) => one.dataset.path === (had ?? current)) ?? buttons[0];
  if (first) first.tabIndex = 0;
  if (had !== undefined) first?.focus();
}
const BUILT = "build/";
/** Groups of files in their order, by the key of their heading: what one works on first, settings last. */
const GROUPS = [["drawings", "drawing"], ["programs", "program"], ["tables", "table"], ["other_files", "file"], ["built", "built"], ["settings", "settings"]];
const OF_KIND = { drawing: "drawing", process: "drawing", program: "program", table: "table", settings: "settings", project: "settings" };
const groupOf = ({ path, kind }) => (path.startsWith(BUILT) ? "built" : OF_KIND[kind] ?? "file");
function grouped(key, files) {
  if (!files.length) return [];
  const head = said("li", key, "group");
  head.setAttribute("role", "none");
  return [head, ...files.map(item)];
}
const isFolded = ({ path }) => path.startsWith(FOLDED);
function folder(files, open) {
  const row = made("li"), part = made("details"), list = made("ul");
  list.setAttribute("role", "group");
  list.append(...files.map(item));
  part.append(made("summary", `${FOLDED} (${files.length})`), list);
  part.open = open;
  row.append(part);
  return row;
}
/** Files that are seen, in their order. */
const walked = () => [...find("files").querySelectorAll("button")].filter((one) => one.closest("details")?.open ?? true);
function item(file) {
  const row = made("li"), button = made("button");
  row.setAttribute("role", "none");
  button.setAttribute("role", "treeitem");
  button.setAttribute("aria-current", String(file.path === current));
  button.dataset.path = file.path;
  button.tabIndex = -1;
  button.append(breakable(file.path));
  if (groupOf(file) !== file.kind) button.append(" ", said("small", `kind_${file.kind}`)); // its heading says it already
  button.addEventListener("click", () => chooseFile(file.path));
  row.append(button);
  return row;
}
/** A path that may be broken after its folders and words. */
function breakable(path) {
  const name = made("bdi");
  name.append(...path.split(/(?<=[/_-])/).flatMap((part) => [made("wbr"), shown(part)]).slice(1));
  return name;
}
/** From file to file by arrow keys; Tab goes past all of them. */
function walkFiles(event) {
  const buttons = walked(), at = buttons.indexOf(document.activeElement);
  const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: buttons.length - 1 }[event.key];
  if (at < 0 || to === undefined || !buttons[to]) return;
  event.preventDefault();
  buttons[at].tabIndex = -1;
  buttons[to].tabIndex = 0;
  buttons[to].focus();
}
/** Shows in the list which file is looked at. */
export function markFile(path) {
  current = path;
  for (const button of find("files").querySelectorAll("button")) {
    button.setAttribute("aria-current", String(button.dataset.path === path));
  }
}
export function chooseFile(path) {
  markFile(path);
  const file = project.files.find((one) => one.path === path) ?? { path, kind: "file" };
  return Promise.all(opened.map((does) => does(file)));
}
async function dropFiles(files) {
  for (const file of files) {
    const data = await file.arrayBuffer();
    const done = await doing(() => send("project/drop", { name: file.name }, data));
    if (!done) return;
    await readProject();
    await chooseFile(done.path);
    if (done.findings.length) alsoOfDoing(done.findings);
  }
}
export function beginProject() {
  const zone = find("drop"), input = find("drop-file");
  input.addEventListener("change", async () => { await dropFiles([...input.files]); input.value = ""; });
  zone.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); input.click(); } });
  for (const name of ["dragover", "drop"]) document.addEventListener(name, (event) => event.preventDefault());
  document.addEventListener("dragover", () => zone.classList.add("over"));
  document.addEventListener("dragleave", () => zone.classList.remove("over"));
  document.addEventListener("drop", (event) => { zone.classList.remove("over"); dropFiles([...(event.dataTransfer?.files ?? [])]); });
  for (const [id, empty] of [["create-empty", true], ["create-example", false]]) {
    find(id).addEventListener("click", async () => { await doing(() => ask("project/create", { empty })); await readProject(); });
  }
  find("open-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    if (await saveAll()) await doing(() => ask("project/open", { folder: find("open-path").value }));
  });
  find("files").addEventListener("keydown", walkFiles);
  find("check").addEventListener("click", async () => { if (await saveAll()) await doing(() => ask("project/check")); });
  find("build").addEventListener("click", async () => { if (!await saveAll()) return; await doing(() => ask("project/build")); await readProject(); });
  on("disk", readProject);
  on("project", readProject);
}
