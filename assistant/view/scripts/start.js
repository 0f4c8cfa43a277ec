// Beginning: what the page is given, and keys.
document.querySelector("h1").textContent = data.title;
find("robot").textContent = data.robot;
for (const note of data.notes) find("notes").append(made("li", note, "where"));
(whole.chosen ?? []).forEach((title, i) => {
  const choice = made("option", title);
  choice.value = String(i);
  choice.selected = i === (other ? chosen : 0);
  find("program").append(choice);
  find("program").hidden = false;
});
find("program").addEventListener("change", (event) => {
  location.hash = event.target.value;
  location.reload();
});
document.body.classList.toggle("still", data.still !== null);
document.body.classList.toggle("bare", data.bare);
if (data.motion.whole > seconds + 1) {
  find("robot").textContent += ` · the first ${Math.round(seconds)} of ${Math.round(data.motion.whole)} s are played`;
}
find("time").max = String(seconds);
find("time").addEventListener("input", (event) => go(Number(event.target.value)));
find("play").addEventListener("click", () => play(!playing));
find("before").addEventListener("click", before);
find("after").addEventListener("click", after);
find("by").addEventListener("change", (event) => colourBy(event.target.value));
document.addEventListener("keydown", (event) => {
  const keys = {
    " ": () => play(!playing), PageUp: before, PageDown: after,
    ArrowLeft: () => go(now - STEP), ArrowRight: () => go(now + STEP),
    Home: () => go(0), End: () => go(seconds),
  };
  if (!keys[event.key] || ["SELECT", "BUTTON"].includes(event.target.tagName)) return;
  event.preventDefault();
  keys[event.key]();
});
colourBy("speed");
setTime(0);
if (data.beside) listing.scrollTop = 0; // read from the top, wherever the arm begins
scene.updateMatrixWorld(true);
beginLook();
themed();
if (renderer) beginPlan();
if (renderer) beginPicking();
if (renderer && data.plan) { fitted(); flat(true); } else flat(false);
if (live.line) scene.add(live.line); // it is nowhere at first
follow(true);
resized();
requestAnimationFrame(tick);
// What tests and other scripts on the page may ask.
window.view = {
  setTime, play, seconds,
  theme: (name) => { document.documentElement.className = name; themed(); }, // "light", "dark", or as the system has it
  aim: (place, far) => aim(new THREE.Vector3(...place), far),
  choose: (i) => findingButtons[i].click(),
  time: () => now,
  carriers: () => shown.map((at) => Array.from(at.toArray())),
  body: (name) => {
    const { group, known } = bodies.find((one) => one.name === name);
    scene.updateMatrixWorld(true);
    return known ? Array.from(group.matrixWorld.toArray()) : null;
  },
  line: () => lineNow,
  flat: () => plan.on,
  following: () => live.on,
  told: () => live.count,
  host: null, movable: false, // see picking.js
  handles: () => handles.map((one) => one.name),
  take, drag: (place) => drag(new THREE.Vector3(...place)), drop, leave,
  held: () => (held.handle ? { at: handles.indexOf(held.handle), place: held.handle.place.toArray() } : null),
  goLine, goTarget: (name) => goMove(moveTo(name)), lineAt,
  stand: (joints) => { // it stands at no time of this program
    play(false);
    document.body.classList.add("led");
    find("clock").textContent = "–";
    stand(joints);
  },
  seen: (place) => {
    const at = new THREE.Vector3(...place).project(camera);
    return [((at.x + 1) / 2) * stage.clientWidth, ((1 - at.y) / 2) * stage.clientHeight];
  },
  camera: () => [camera.position.toArray(), controls ? controls.target.toArray() : [0, 0, 0]],
  look: ([from, to]) => {
    camera.position.set(...from);
    camera.lookAt(...to);
    if (controls) controls.target.set(...to);
    dirty = true;
  },
  pathPoints: count,
  drawn: () => (renderer ? renderer.info.render.triangles + renderer.info.render.lines : 0),
};
