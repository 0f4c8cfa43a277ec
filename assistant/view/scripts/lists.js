// Lists: findings, moves, and what is shown.
const findingButtons = [], moveButtons = [];
const more = (list, left, what) => { if (left) list.append(made("li", `${left} more ${what}`, "where")); };
const within = (list, top, height) => {
  if (top < list.scrollTop || top + height > list.scrollTop + list.clientHeight) list.scrollTop = top - list.clientHeight / 2;
};

function highlight(names) {
  for (const body of bodies) for (const mesh of body.group.children) {
    if (mesh.material.emissive) mesh.material.emissive.set(names.includes(body.name) ? "#7a1c0c" : "#000000");
  }
  dirty = true;
}
function choose(finding, button) {
  findingButtons.forEach((one) => one.classList.toggle("now", one === button));
  const mark = finding.mark;
  notice("");
  highlight(mark ? [mark.one, mark.other] : []);
  if (!mark) {
    if (finding.time !== null) go(finding.time);
    else goMove(finding.move);
    if (finding.line) showLine(finding.line);
    else if (finding.beside) showBeside(finding.beside);
    if (finding.at) approach(new THREE.Vector3(...finding.at));
    return;
  }
  if (mark.time !== null) go(mark.time);
  else {
    play(false);
    follow(false);
    stand(mark.joints);
    notice(data.motion.whole > seconds + 1
      ? "This place is not in the part of the program that is played."
      : "This place is not on the way that is played: another branch of the program leads there.");
  }
  approach(new THREE.Vector3(...mark.points[0]));
}
function goMove(move) {
  if (move !== null && data.moves[move].time !== null) go(data.moves[move].time);
  else if (move !== null && data.moves[move].global) showLine(data.moves[move].global);
}
function currentMove(move) {
  if (move === currentMove.at) return;
  moveButtons[currentMove.at]?.classList.remove("now");
  const button = moveButtons[move];
  if (button) {
    button.classList.add("now");
    within(find("move-list"), button.parentElement.offsetTop - find("move-list").offsetTop, 40);
  }
  currentMove.at = move;
}

for (const finding of data.findings) {
  const item = made("li"), button = made("button", undefined, finding.severity);
  button.append(made("strong", `${finding.code} `), finding.message);
  if (finding.cure) button.append(made("div", finding.cure, "where"));
  if (finding.where) button.append(made("div", finding.where, "where"));
  button.disabled = !finding.mark && !finding.at && finding.move === null && !finding.line && !finding.beside;
  button.addEventListener("click", () => choose(finding, button));
  findingButtons.push(button);
  item.append(button);
  find("finding-list").append(item);
  const time = finding.mark ? finding.mark.time : finding.time;
  if (time !== null && seconds > 0) {
    const tick = made("i");
    tick.style.left = `${(100 * time) / seconds}%`;
    tick.style.background = SEVERITIES[finding.severity];
    find("marks").append(tick);
  }
}
if (!data.findings.length) find("finding-list").append(made("li", "none", "where"));
more(find("finding-list"), data.left.findings, "findings");

data.moves.forEach((move, i) => {
  const item = made("li"), button = made("button");
  button.append(made("div", move.text || move.label, "text"));
  const when = move.time === null ? "not on the way that is played" : `${move.time.toFixed(2)} s`;
  const place = [move.path, move.line].filter((part) => part !== null).join(":");
  const speed = move.length && move.seconds ? `, ${Math.round(move.length / move.seconds)} mm/s on average` : "";
  const far = typeof move.length === "number" ? `${move.length.toFixed(1)} mm in ${move.seconds.toFixed(2)} s${speed}` : "";
  button.append(made("div", [`${move.procedure} move ${move.number}`, place, data.still ? "" : when, far].filter(Boolean).join(" · "), "where"));
  button.disabled = move.time === null && !move.global;
  button.addEventListener("click", () => goMove(i));
  moveButtons.push(button);
  item.append(button);
  find("move-list").append(item);
});
if (!data.moves.length) find("move-list").append(made("li", "none", "where"));
more(find("move-list"), data.left.moves, "moves");

function toggle(text, colour, set, id) {
  const item = made("li"), label = made("label"), box = made("input");
  box.type = "checkbox";
  box.checked = true;
  if (id) box.id = id;
  box.addEventListener("change", () => { set(box.checked); dirty = true; });
  label.append(box);
  if (colour) { const swatch = made("i"); swatch.style.background = colour; label.append(swatch); }
  label.append(text);
  item.append(label);
  find("shown").append(item);
}
const rest = (what, left) => (left ? `${what} (${left} more are not shown)` : what);
toggle(data.still ? "path: straight and arcs red, joint moves blue" : data.motion.held ? "path of the tool" : "path of the flange", null, (on) => { path.visible = on; });
toggle(rest("targets", data.left.targets), null, (on) => { targets.visible = on; });
toggle("names", null, () => {}, "with-names");
if (data.zones && !data.still) toggle(rest("zones", data.left.zones), "#7a4fb5", (on) => { zones.visible = on; });
if (data.drawn.length) toggle(rest("lines of the drawing", data.left.drawn), "var(--text)", (on) => { drawn.visible = on; });
if (marks.children.length) toggle("places of findings", null, (on) => { marks.visible = on; });
for (const body of bodies) toggle(body.name, body.colour, (on) => want(body, on));
