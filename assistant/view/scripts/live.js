// Following a controller: the arm stands where the controller says that it is. Nothing is sent to it.
const TRAIL = 5000; // places of the tool that are kept
const live = { on: false, from: null, to: null, part: 0, seconds: 0.1, count: 0, line: null };

/** Shows what the controller tells, or what the program says again. */
function follow(on) {
  if (data.live === null || on === live.on) return;
  live.on = on;
  find("live").setAttribute("aria-pressed", String(on));
  find("live").classList.toggle("now", on);
  if (on) {
    play(false);
    ride(0);
    currentMove(-1);
    currentLine(0);
    current.at = null;
    find("clock").textContent = "live";
    find("reading").textContent = "";
    if (live.to) stand(live.to);
  } else setTime(now);
}
/** Goes on towards the joints that were told last, as fast as these come. */
function led(gone) {
  if (!live.on || !live.to || live.part >= 1) return;
  live.part = Math.min(1, live.part + gone / live.seconds);
  stand(live.to.map((value, i) => live.from[i] + live.part * (value - live.from[i])));
}
function told(sample) {
  const before = live.to && live.from.map((value, i) => value + live.part * (live.to[i] - value));
  live.from = before ?? sample.joints;
  live.to = sample.joints;
  live.part = before ? 0 : 1;
  live.seconds = Math.max(0.02, sample.interval);
  find("state").textContent = sample.state;
  if (!before && live.on) stand(live.to);
  trail(sample.joints);
}
function trail(joints) {
  const at = frames(joints)[flange];
  const tip = new THREE.Vector3(...(data.motion.held && data.tips.length === 1 ? data.tips[0].slice(0, 3) : [0, 0, 0]));
  tip.applyMatrix4(at);
  const places = live.line.geometry.getAttribute("position");
  if (live.count === TRAIL) places.array.copyWithin(0, 3), live.count--;
  tip.toArray(places.array, 3 * live.count++);
  places.needsUpdate = true;
  live.line.geometry.setDrawRange(0, live.count);
  dirty = true;
}

if (data.live !== null) {
  live.line = line(new Float32Array(3 * TRAIL), "#c2185b");
  live.line.geometry.setDrawRange(0, 0);
  live.line.frustumCulled = false;
  toggle("where it has been", "#c2185b", (on) => { live.line.visible = on; });
  find("live").hidden = find("state").hidden = false;
  find("live").addEventListener("click", () => follow(!live.on));
  find("state").textContent = `${data.live}: waiting for it`;
  const events = new EventSource("events");
  events.addEventListener("sample", (event) => told(JSON.parse(event.data)));
  const over = (text) => {
    events.close();
    notice(text);
    find("state").textContent = `${data.live}: not followed any more`;
  };
  events.addEventListener("lost", (event) => over(JSON.parse(event.data).text));
  events.addEventListener("error", () => over("The command that this page came from has ended; what is shown stands still."));
}
