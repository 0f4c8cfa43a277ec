// The text of the program: the line that the arm is at, and from a line to when it is come to.
// Long lines wrap in their column. Only the lines that are seen are elements of the page, so that a text may be long.
const HEIGHT = 18; // px of a line, as in the style
const listing = find("listing"), spacer = made("div"), block = made("div"), head = made("div", undefined, "head");
const texts = []; // {text of the line, number in its file, counted through all files; 0 for a heading}
/** A line without the step number that it begins with, where that is its number as well. */
const cell = (text, number) => ({ text: (text.startsWith(`${number} `) ? text.slice(`${number} `.length) : text).replaceAll("\t", "    "), number: String(number) });
for (const one of data.texts) {
  if (data.texts.length > 1) texts.push({ own: { text: one.path ?? "", number: "" }, line: 0 });
  one.lines.forEach((text, i) => texts.push({ own: cell(text, i + 1), line: one.first + i }));
}
const LEVELS = ["supported", "partial", "not"];
const said = { supported: "says the same", partial: "says it with a change", not: "is not said" };
/** Each line of what a program was made of, beside what it became. */
function pairs(made) {
  const linesOf = (all) => new Map(all.flatMap((one) => one.lines.map((text, i) =>
    [one.first + i, { ...cell(text, i + 1), path: i ? null : one.path }])));
  const from = linesOf(made.texts), to = linesOf(data.texts), all = rows(made.rows), found = [];
  const written = all.some((line, i) => i % 3 === 1 && line);
  document.body.classList.toggle("alone", !written);
  for (let i = 0; i < all.length; i += 3) {
    const [before, after, level] = all.subarray(i, i + 3), mine = from.get(before), its = to.get(after);
    if (before && made.texts.length > 1 && mine?.path) found.push({ own: { text: mine.path, number: "" }, line: 0, before: 0 });
    found.push({ own: mine, its: after ? its : undefined, before, line: written ? after : before, level: LEVELS[level], why: made.reasons[before] ?? "" });
  }
  return found;
}
const fileName = (all) => (all.length === 1 ? (all[0].path ?? "").split(/[\\/]/).at(-1) : `${all.length} files`);
if (data.beside) {
  texts.splice(0, texts.length, ...pairs(data.beside));
  document.body.classList.add("beside");
  find("source").querySelector("h2").textContent = data.beside.heading;
  if (data.beside.left) listing.after(made("p", `${data.beside.left} more lines`, "where"));
}
const rowOf = new Map(), besideRow = new Map();
texts.forEach((one, i) => {
  if (!rowOf.has(one.line)) rowOf.set(one.line, i);
  if (one.before && !besideRow.has(one.before)) besideRow.set(one.before, i);
});
const firstTime = new Map();
played.lines.forEach((line, i) => { if (line && !firstTime.has(line)) firstTime.set(line, played.times[i]); });
const foundBeside = new Map(), found = new Map(); // line → severity of a finding there, the worst first
for (const severity of ["info", "warning", "error"]) for (const finding of data.findings) {
  if (finding.severity !== severity) continue;
  const line = finding.line || (finding.move !== null ? data.moves[finding.move].global : 0);
  if (line) found.set(line, severity);
  if (finding.beside) foundBeside.set(finding.beside, severity);
}
let lineNow = 0, rowNow = -1;

const widths = (text) => { // in characters: those of East Asia are twice as wide
  let wide = 0;
  for (const sign of text) wide += sign.codePointAt(0) < 0x1100 ? 1 : 2;
  return wide;
};
const BREAKS = /(?<= )(?=[^ ])|(?<=[^\s[({])(?=[[({])(?<!\w)/; // where browsers break lines of programs
/** How many lines a text takes; a part that is too long breaks anywhere. */
function wrapped(one, room) {
  if (!one || (one.wide ??= widths(one.text)) <= room) return 1;
  const later = Math.max(4, room - hang(one.text));
  let lines = 1, left = room;
  for (const part of one.text.split(BREAKS)) {
    let wide = widths(part);
    if (wide > left && left < later) { lines += 1; left = later; }
    for (; wide > left; left = later) { wide -= left; lines += 1; }
    left -= wide;
  }
  return lines;
}
const hang = (text) => Math.min(16, text.length - text.trimStart().length) + 2;
let tops = [0], high = [], columns = ""; // px above each line and of it, and how many characters fit in the columns
/** How high each line is in the columns as they are; what is shown tells it better. */
function measured() {
  const [own, its] = [head.children[1], head.children[4]].map((one) => (one ? Math.max(8, Math.floor((one.clientWidth - 1) / sign()) - 1) : 8)); // less the gap behind them
  if (`${own} ${its}` === columns) return;
  columns = `${own} ${its}`;
  high = texts.map((one) => HEIGHT * Math.max(wrapped(one.own, own), wrapped(one.its, its)));
  stack(0);
}
function stack(first) {
  for (let i = first; i < texts.length; i++) tops[i + 1] = tops[i] + high[i];
  spacer.style.height = `${tops.at(-1)}px`;
}
function sign() {
  const probe = made("code", "0".repeat(100));
  head.append(probe);
  const wide = probe.getBoundingClientRect().width / 100;
  probe.remove();
  return wide || 7;
}
const rowAt = (top) => {
  let low = 0, high = texts.length - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (tops[middle] <= top) low = middle; else high = middle - 1; }
  return low;
};
function listed() {
  measured();
  const first = Math.max(0, rowAt(listing.scrollTop) - 5);
  const end = Math.min(texts.length, rowAt(listing.scrollTop + listing.clientHeight) + 11);
  block.replaceChildren(...texts.slice(first, end).map((one, i) => {
    const item = made("button", undefined, (one.line && found.get(one.line)) || (one.before && foundBeside.get(one.before)) || undefined);
    item.append(...cells(one.own));
    if (data.beside) item.append(made("i", undefined, one.level), ...cells(one.its));
    item.title = [one.own && one.level ? said[one.level] : "", one.why].filter(Boolean).join("\n");
    item.disabled = !firstTime.has(one.line);
    item.classList.toggle("now", (one.line !== 0 && one.line === lineNow) || first + i === rowNow);
    item.addEventListener("click", () => go(firstTime.get(one.line)));
    return item;
  }));
  block.style.top = `${tops[first]}px`;
  let wrong = false;
  for (let i = first; i < end; i++) {
    const real = block.children[i - first].offsetHeight || high[i]; // none where the listing is hidden
    wrong ||= real !== high[i];
    high[i] = real;
  }
  if (wrong) stack(first);
}
/** The number and the text of a line; empty for none. */
function cells(one) {
  const text = made("span", one?.text ?? "");
  if (one) text.style.setProperty("--hang", `${hang(one.text)}ch`);
  return [made("b", one?.number ?? ""), text];
}
/** Scrolls the text to a line. */
function showLine(line) { showRow(rowOf.get(line)); }
/** Scrolls to a line of what the program was made of. */
function showBeside(line) {
  rowNow = besideRow.get(line) ?? -1;
  showRow(besideRow.get(line));
}
function showRow(row) {
  measured();
  for (let tries = 0; tries < 3; tries++) { // lines on the way may be higher than was thought
    if (row !== undefined) within(listing, tops[row], high[row] + (data.beside ? HEIGHT : 0));
    listed();
  }
}
function currentLine(line) {
  if (line === lineNow) return;
  lineNow = line;
  rowNow = -1;
  showLine(line);
  host("at", lineAt());
}

if (texts.length) {
  head.append(...cells({ text: data.beside ? fileName(data.beside.texts) : "", number: "" }));
  if (data.beside) head.append(made("i"), ...cells({ text: fileName(data.texts), number: "" }));
  spacer.append(block);
  listing.append(head, spacer);
  listing.addEventListener("scroll", listed);
  new ResizeObserver(listed).observe(listing);
  if (data.left.lines) listing.after(made("p", `${data.left.lines} more lines`, "where"));
} else find("source").hidden = true;
