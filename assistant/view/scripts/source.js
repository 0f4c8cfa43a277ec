// The text of the program: the line that the arm is at, and from a line to when it is come to.
// Only the lines that are seen are elements of the page, so that a text may be long.
const HEIGHT = 18; // px of a line, as in the style
const listing = find("listing"), spacer = made("div");
const texts = []; // {text of the line, number in its file, counted through all files; 0 for a heading}
for (const one of data.texts) {
  if (data.texts.length > 1) texts.push({ text: one.path ?? "", number: "", line: 0 });
  one.lines.forEach((text, i) => texts.push({ text, number: i + 1, line: one.first + i }));
}
const LEVELS = ["supported", "partial", "not"];
const said = { supported: "says the same", partial: "says it with a change", not: "is not said" };
/** Each line of what a program was made of, beside what it became. */
function pairs(made) {
  const linesOf = (all) => new Map(all.flatMap((one) => one.lines.map((text, i) =>
    [one.first + i, { text, number: String(i + 1), path: i ? null : one.path }])));
  const from = linesOf(made.texts), to = linesOf(data.texts), all = rows(made.rows), found = [];
  const written = all.some((line, i) => i % 3 === 1 && line);
  for (let i = 0; i < all.length; i += 3) {
    const [before, after, level] = all.subarray(i, i + 3), mine = from.get(before), its = to.get(after);
    if (before && made.texts.length > 1 && mine?.path) found.push({ text: mine.path, number: "", line: 0, before: 0 });
    found.push({ mine, its: after ? its : null, before, line: written ? after : before, level: LEVELS[level], why: made.reasons[before] ?? "" });
  }
  return found;
}
if (data.beside) {
  texts.splice(0, texts.length, ...pairs(data.beside));
  const long = Math.min(64, Math.max(30, ...texts.map((one) => one.mine?.text.length ?? 0)));
  listing.style.setProperty("--left", `${long}ch`);
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

function listed() {
  const first = Math.max(0, Math.floor(listing.scrollTop / HEIGHT) - 5);
  const end = Math.min(texts.length, first + Math.ceil(listing.clientHeight / HEIGHT) + 10);
  spacer.replaceChildren(...texts.slice(first, end).map((one, i) => {
    const item = made("button", undefined, (one.line && found.get(one.line)) || (one.before && foundBeside.get(one.before)) || undefined);
    item.style.top = `${(first + i) * HEIGHT}px`;
    if (one.text === undefined) cells(item, one);
    else item.append(made("b", String(one.number)), one.text);
    item.disabled = !firstTime.has(one.line);
    item.classList.toggle("now", (one.line !== 0 && one.line === lineNow) || first + i === rowNow);
    item.addEventListener("click", () => go(firstTime.get(one.line)));
    return item;
  }));
}
/** A line, how far it is said, and what it became. */
function cells(item, { mine, its, level, why }) {
  item.append(made("b", mine?.number ?? ""), made("span", mine?.text ?? "", "left"));
  item.append(made("i", undefined, level), made("b", its?.number ?? ""), made("span", its?.text ?? ""));
  item.title = [mine && level ? said[level] : "", why, mine?.text.trim()].filter(Boolean).join("\n");
}
/** Scrolls the text to a line. */
function showLine(line) { showRow(rowOf.get(line)); }
/** Scrolls to a line of what the program was made of. */
function showBeside(line) {
  rowNow = besideRow.get(line) ?? -1;
  showRow(besideRow.get(line));
}
function showRow(row) {
  if (row !== undefined) within(listing, row * HEIGHT, HEIGHT);
  listed();
}
function currentLine(line) {
  if (line === lineNow) return;
  lineNow = line;
  rowNow = -1;
  showLine(line);
  host("at", lineAt());
}

if (texts.length) {
  spacer.style.height = `${texts.length * HEIGHT}px`;
  listing.append(spacer);
  listing.addEventListener("scroll", listed);
  new ResizeObserver(listed).observe(listing);
  if (data.left.lines) listing.after(made("p", `${data.left.lines} more lines`, "where"));
} else find("source").hidden = true;
