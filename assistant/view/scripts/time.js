// Time: what is shown of the way that is played.
let now = 0, playing = false, last = 0;

function setTime(time) {
  now = Math.min(seconds, Math.max(0, time));
  document.body.classList.remove("led");
  find("time").value = String(now);
  find("clock").textContent = `${now.toFixed(2)} of ${seconds.toFixed(2)} s`;
  ride(now);
  stand(jointsAt(now));
  reading();
  current();
}
/** How fast the tool is, and which axis is closest to its limit. */
function reading() {
  if (!count) return;
  const [low, high, part] = sampleAt(now), between = (column) => column[low] + part * (column[high] - column[low]);
  const axis = motion.nearest[part < 0.5 ? low : high], { names, halves, units } = data.motion;
  const left = Math.round(between(motion.room) * halves[axis]), unit = units[axis] === "mm" ? " mm" : "°";
  find("reading").textContent = `${Math.round(between(motion.speeds))} mm/s${halves[axis] ? ` · ${names[axis]} is closest to its limit: ${left}${unit} left` : ""}`;
}
/** The move that the arm is in, in the list and in the text. */
function current() {
  const at = now <= played.until ? begun(played.times, now) - 1 : -1;
  if (at === current.at) return;
  current.at = at;
  currentMove(at < 0 ? -1 : played.moves[at]);
  currentLine(at < 0 ? 0 : played.lines[at]);
}
function play(on) {
  playing = on;
  if (on) follow(false);
  find("play").textContent = on ? "❚❚" : "▶";
  if (on && now >= seconds) setTime(0);
}
/** Stops, and goes to a time. */
function go(time) {
  play(false);
  follow(false);
  setTime(time);
}
function before() {
  const at = begun(played.times, now) - 1;
  const start = at >= 0 ? played.times[at] : 0;
  go(now - start > 0.05 ? start : at > 0 ? played.times[at - 1] : 0);
}
function after() {
  const at = begun(played.times, now);
  go(at < played.times.length ? played.times[at] : seconds);
}
function tick(at) {
  const gone = (at - last) / 1000;
  if (playing) {
    setTime(now + gone * Number(find("rate").value));
    if (now >= seconds) play(false);
  }
  led(gone);
  last = at;
  draw(at);
  requestAnimationFrame(tick);
}
