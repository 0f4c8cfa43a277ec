// The text of the program: the line that the arm is at, and from a line to when it is come to.
// Only the lines that are seen are elements of the page, so that a text may be long.
const HEIGHT = 18; // px of a line, as in the style
const listing = find("listing"), spacer = made("div");
const texts = []; // {text of the line, number in its file, counted through all files; 0 for a heading}
for (const one of data.texts) {
  if (data.texts.length > 1) texts.push({ text: one.path ?? "", number: "", line: 0 });
  one.lines.forEach((text, i) => texts.push({ text, number: i + 1, line: one.first + i }));
}
const rowOf = new Map(texts.map((one, i) => [one.line, i]));
const firstTime = new Map();
played.lines.forEach((line, i) => { if (line && !firstTime.has(line)) firstTime.set(line, played.times[i]); });
const found = new Map(); // line → severity of a finding there, the worst first
for (const severity of ["info", "warning", "error"]) for (const finding of data.findings) {
  const line = finding.severity === severity && finding.move !== null ? data.moves[finding.move].global : 0;
  if (line) found.set(line, severity);
}
let lineNow = 0;

function listed() {
  const first = Math.max(0, Math.floor(listing.scrollTop / HEIGHT) - 5);
  const end = Math.min(texts.length, first + Math.ceil(listing.clientHeight / HEIGHT) + 10);
  spacer.replaceChildren(...texts.slice(first, end).map((one, i) => {
    const item = made("button", undefined, found.get(one.line));
    item.style.top = `${(first + i) * HEIGHT}px`;
    item.append(made("b", String(one.number)), one.text);
    item.disabled = !firstTime.has(one.line);
    item.classList.toggle("now", one.line !== 0 && one.line === lineNow);
    item.addEventListener("click", () => go(firstTime.get(one.line)));
    return item;
  }));
}
/** Scrolls the text to a line. */
function showLine(line) {
  const row = rowOf.get(line);
  if (row !== undefined) within(listing, row * HEIGHT, HEIGHT);
  listed();
}
function currentLine(line) {
  if (line === lineNow) return;
  lineNow = line;
  showLine(line);
}

if (texts.length) {
  spacer.style.height = `${texts.length * HEIGHT}px`;
  listing.append(spacer);
  listing.addEventListener("scroll", listed);
  new ResizeObserver(listed).observe(listing);
  if (data.left.lines) listing.after(made("p", `${data.left.lines} more lines`, "where"));
} else find("source").hidden = true;
