// The outline: what a text declares, one inside another.
import { find, made } from "./words.js";
import { current, openText } from "./editor.js";

export function showOutline(items) {
  find("outline").replaceChildren(...items.map(item));
}
function item({ name, kind, detail, line, children }) {
  const row = made("li"), button = made("button", `${name} `);
  button.append(made("small", [...new Set([kind, detail.replace(/\s*=$/, "")])].filter(Boolean).join(" ")));
  button.addEventListener("click", () => openText(current().text.path, line + 1));
  row.append(button);
  if (children.length) {
    const inner = made("ul");
    inner.append(...children.map(item));
    row.append(inner);
  }
  return row;
}
