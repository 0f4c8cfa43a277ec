// The outline: what a text declares, one inside another.
import { find, made } from "./words.js";
import { current, openText } from "./editor.js";

const MANY = 50; // of one kind behind each other that stand folded: thousands of rows make the page slow
const opened = new Set(); // kinds whose folds are open: the list is made anew while somebody types

export function showOutline(items) {
  find("outline").replaceChildren(...rows(items));
  find("outline-title").hidden = !items.length;
}
function rows(items) {
  const runs = [];
  for (const item of items) {
    const run = runs.at(-1);
    if (run?.[0].kind === item.kind && !run[0].children.length && !item.children.length) run.push(item);
    else runs.push([item]);
  }
  return runs.flatMap((run) => (run.length > MANY ? [folded(run)] : run.map(row)));
}
/** Its rows are made when somebody looks at them. */
function folded(run) {
  const one = made("li"), fold = made("details"), inner = made("ul");
  fold.append(made("summary", `${run[0].name} … ${run.at(-1).name} (${run.length})`), inner);
  fold.addEventListener("toggle", () => {
    opened[fold.open ? "add" : "delete"](run[0].kind);
    inner.replaceChildren(...(fold.open ? run.map(row) : []));
  });
  fold.open = opened.has(run[0].kind);
  one.append(fold);
  return one;
}
function row({ name, kind, detail, line, children }) {
  const one = made("li"), button = made("button", `${name} `);
  button.append(made("small", [...new Set([kind, detail.replace(/\s*=$/, "")])].filter(Boolean).join(" ")));
  button.addEventListener("click", () => openText(current().text.path, line + 1));
  one.append(button);
  if (children.length) {
    const inner = made("ul");
    inner.append(...rows(children));
    one.append(inner);
  }
  return one;
}
