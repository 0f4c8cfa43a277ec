// The project: its files, opening and creating, and what is dropped onto it.
import { find, made, word } from "./words.js";
import { ask, look, send } from "./server.js";
import { doing, showOfDoing } from "./findings.js";
import { on } from "./line.js";

const opened = []; // called with a file that is chosen
const told = []; // called with the project whenever it is read
export const whenChosen = (does) => opened.push(does);
export const whenRead = (does) => told.push(does);
export const project = { files: [], programs: [], targets: [], controllers: [] };
let current = "";

export async function readProject() {
  Object.assign(project, await look("project"));
  find("folder").textContent = project.folder;
  document.title = `${project.name} · ${word("studio")}`;
  find("begin").hidden = project.there;
  find("files").replaceChildren(...project.files.map(item));
  if (!project.files.length) find("files").append(made("li", word("no_files"), "empty"));
  if (project.findings?.length) showOfDoing(project.findings);
  for (const does of told) does(project);
}
function item(file) {
  const row = made("li"), button = made("button");
  row.setAttribute("role", "none");
  button.setAttribute("role", "treeitem");
  button.setAttribute("aria-current", String(file.path === current));
  button.append(file.path, " ", made("small", file.kind));
  button.addEventListener("click", () => chooseFile(file.path));
  row.append(button);
  return row;
}
export function chooseFile(path) {
  current = path;
  const file = project.files.find((one) => one.path === path) ?? { path, kind: "file" };
  for (const button of find("files").querySelectorAll("button")) {
    button.setAttribute("aria-current", String(button.firstChild.textContent === path));
  }
  return Promise.all(opened.map((does) => does(file)));
}
async function dropFiles(files) {
  for (const file of files) {
    const data = await file.arrayBuffer();
    const done = await doing(() => send("project/drop", { name: file.name }, data));
    if (!done) return;
    await readProject();
    await chooseFile(done.path);
    showOfDoing(done.findings);
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
    await doing(() => ask("project/open", { folder: find("open-path").value }));
  });
  find("check").addEventListener("click", () => doing(() => ask("project/check")));
  find("build").addEventListener("click", async () => { await doing(() => ask("project/build")); await readProject(); });
  on("disk", readProject);
  on("project", readProject);
}
