// What is said about a word: paragraphs and code of Markdown, as text that is never markup.
import { made } from "./words.js";

/** An element with a text that has fences and paragraphs; everything else stands as it is. */
export function markdown(text) {
  const told = made("div", undefined, "told");
  let code = null, said = [];
  const paragraph = () => { if (said.length) told.append(line(said.join("\n"))); said = []; };
  for (const row of text.split("\n")) {
    const fence = row.match(/^`{3,}/)?.[0];
    if (code === null && fence) { paragraph(); code = { fence, rows: [] }; }
    else if (code !== null && row === code.fence) { told.append(made("pre", code.rows.join("\n"))); code = null; }
    else if (code !== null) code.rows.push(row);
    else if (row.trim() === "") paragraph();
    else said.push(row.trimEnd().replace(/\\([^\w\s])/g, "$1"));
  }
  if (code !== null) told.append(made("pre", code.rows.join("\n")));
  paragraph();
  return told;
}
/** A paragraph; what stands between backquotes is code. */
function line(text) {
  const row = made("p");
  text.split(/(`[^`]+`)/).forEach((part, i) => row.append(i % 2 ? made("code", part.slice(1, -1)) : part));
  return row;
}
