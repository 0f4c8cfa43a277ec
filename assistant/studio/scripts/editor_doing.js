// What is done with a name or a line: declaration, new name, cure, layout.
import { find, made, word } from "./words.js";
import { doing } from "./findings.js";
import { state as window_ } from "./line.js";
import { applied, appliedAll, current, openText, placeOf } from "./editor.js";

let renamed = null; // the name that gets another one: {text, at}
const here = () => {
  const { text, view } = current();
  return { text, view, at: placeOf(view.state.doc, view.state.selection.main.head) };
};
export async function goToDeclaration() {
  if (!current()) return;
  const { text, at } = here();
  const found = await doing(() => text.service.ask("definition", { at }));
  if (found?.path) await openText(found.path, found.from[0] + 1, found.from[1] + 1);
}
export async function formatText(text) {
  if (!window_.writes) return;
  const answer = await doing(() => text.service.ask("formatted"));
  if (answer) await applied(text.path, answer.edits);
}
/** Asks for a new name of what stands at the cursor. */
export async function rename() {
  if (!current() || !window_.writes) return;
  const { text, at } = here();
  const found = await doing(() => text.service.ask("renameable", { at }));
  if (!found?.name) return;
  renamed = { text, at };
  find("rename-form").hidden = false;
  find("rename-name").value = found.name;
  find("rename-name").select();
  find("rename-name").focus();
}
function closeRename() {
  renamed = null;
  find("rename-form").hidden = true;
  current()?.view.focus();
}
/** Offers what cures the line of the cursor; one alone that is meant is made at once. */
export async function cureHere(text, view) {
  const [line] = placeOf(view.state.doc, view.state.selection.main.head);
  await text.service.cures(line, line);
  const fixes = text.service.fixesAt(line);
  document.querySelector(".cures")?.remove();
  if (fixes.length) offer(fixes, view);
}
function offer(fixes, view) {
  const box = made("div", undefined, "cures"), place = view.coordsAtPos(view.state.selection.main.head);
  box.setAttribute("role", "menu");
  box.setAttribute("aria-label", word("cure"));
  const close = () => view.focus(); // whereby it loses the focus, and goes
  for (const { title, use, finding } of fixes) {
    const button = made("button", title);
    button.setAttribute("role", "menuitem");
    button.append(made("small", ` ${finding.code}`));
    button.addEventListener("click", () => { close(); use(); });
    box.append(button);
  }
  box.addEventListener("keydown", (event) => {
    const all = [...box.children], step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (event.key === "Escape") { event.preventDefault(); close(); }
    if (step) { event.preventDefault(); all[(all.indexOf(document.activeElement) + step + all.length) % all.length].focus(); }
  });
  box.addEventListener("focusout", (event) => { if (!box.contains(event.relatedTarget)) queueMicrotask(() => box.remove()); });
  document.body.append(box);
  box.style.left = `${Math.max(0, Math.min(place?.left ?? 0, innerWidth - box.offsetWidth - 8))}px`;
  box.style.top = `${Math.max(0, Math.min((place?.bottom ?? 0) + 2, innerHeight - box.offsetHeight - 8))}px`;
  box.firstChild.focus();
}
export function beginDoing() {
  find("definition").addEventListener("click", goToDeclaration);
  find("format").addEventListener("click", () => { if (current()) formatText(current().text); });
  find("rename").addEventListener("click", rename);
  find("rename-cancel").addEventListener("click", closeRename);
  find("rename-form").addEventListener("keydown", (event) => { if (event.key === "Escape") closeRename(); });
  find("rename-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    if (!renamed) return;
    const { text, at } = renamed, name = find("rename-name").value;
    const answer = await doing(() => text.service.ask("rename", { at, name }));
    if (!answer) return;
    closeRename();
    await appliedAll(answer.changes);
  });
}
