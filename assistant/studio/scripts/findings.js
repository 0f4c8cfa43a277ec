// The list of findings: those of the open file, and those that an action had.
import { find, made, shown, word } from "./words.js";
import { Refused } from "./server.js";

const CONTROLS = { "--replace": "replace_there" }; // options of commands that are something to tick here
/** A cure by what the page has for it. */
const byPage = (cure) => cure?.replace(/`(--[a-z-]+)[^`]*`/g, (said, option) => (option in CONTROLS ? `“${word(CONTROLS[option])}”` : said));
let open = null; // goes to a finding: (finding) => void
export function beginFindings(goTo) {
  open = goTo;
  for (const id of ["tab-text", "tab-drawing"]) find(id).addEventListener("chosen", show);
  find("fold-findings").addEventListener("click", () => fold(find("findings").hidden));
  show();
}
/** Opens the pane of findings or closes it; it opens for an error or a warning that is new. */
function fold(on) {
  find("findings").hidden = find("split-foot").hidden = !on;
  find("fold-findings").setAttribute("aria-expanded", String(on));
}
const WORST = ["error", "warning", "info"];
let listed = ""; // what the list had
let ofFile = [], ofDoing = [];

/** Findings of the open file, with their cures: {finding, fixes: [{title, use}]}. */
export function showOfFile(found) {
  const gone = new Set(ofFile.map(keyOf));
  for (const one of found) gone.delete(keyOf(one));
  ofDoing = ofDoing.filter((one) => !gone.has(keyOf(one)));
  ofFile = found;
  show();
}
/** A text has changed: what an action said of its lines is no more true of them. */
export function changedText(path) { ofDoing = ofDoing.filter(({ finding }) => finding.path !== path || finding.line === undefined); }
/** Findings of an action that are shown beside those of others. */
export function alsoOfDoing(found) { ofDoing = [...ofDoing, ...found.map((finding) => ({ finding, fixes: [] }))]; show(); }
export function showOfDoing(found) { ofDoing = found.map((finding) => ({ finding, fixes: [] })); show(); }

/** Does something; what is refused stands in the list then, and undefined comes back. */
export async function doing(does) {
  busy(1);
  try {
    const answer = await does();
    showOfDoing(answer?.findings ?? []);
    return answer;
  } catch (refused) {
    if (!(refused instanceof Refused)) throw refused;
    showOfDoing(refused.findings);
    return undefined;
  } finally {
    busy(-1);
  }
}
let going = 0;
function busy(step) {
  going += step;
  find("findings").setAttribute("aria-busy", String(going > 0));
  counted();
}
const MOST = 300; // that are listed: thousands of rows make the page slow
const keyOf = ({ finding }) => `${finding.code} ${finding.path} ${finding.line} ${finding.message}`;
function show() {
  const ofText = find("panel-text").hidden ? [] : ofFile; // a drawing that is looked at has not the findings of a text
  const own = new Set(ofText.map(keyOf)); // those of the file come with their cures
  const seen = new Set(), list = find("findings"), items = [];
  const all = [...ofDoing.filter((one) => !own.has(keyOf(one))), ...ofText];
  all.sort((one, other) => WORST.indexOf(one.finding.severity) - WORST.indexOf(other.finding.severity));
  for (const { finding, fixes } of all) {
    const key = keyOf({ finding });
    if (seen.has(key)) continue;
    seen.add(key);
    if (seen.size > MOST) break;
    const item = made("li", undefined, finding.severity), button = made("button");
    const where = [finding.path, finding.line, finding.column].filter((part) => part !== undefined).join(":");
    button.append(made("strong", `${finding.code} `), shown(finding.message), made("br"), made("small", [where, byPage(finding.cure)].filter(Boolean).join(" · ")));
    button.addEventListener("click", () => open?.(finding));
    item.append(button);
    for (const { title, use } of fixes) {
      const fix = made("button", `${word("cure")}: ${title}`, "fix");
      fix.addEventListener("click", use);
      item.append(fix);
    }
    items.push(item);
  }
  list.replaceChildren(...items);
  count = items.length ? `${items.length}${seen.size > MOST ? "+" : ""}` : "";
  counted();
  const now = [...seen].join("\n");
  if (!items.length) fold(false);
  else if (all.some((one) => one.finding.severity !== "info" && !listed.includes(keyOf(one)))) fold(true);
  listed = now;
}
let count = "";
/** How many there are; while something is being done, that it is. */
function counted() {
  find("finding-count").textContent = count || word(going > 0 ? "working" : "no_findings");
  find("fold-findings").disabled = !count;
}
