// Picking: targets and places of the path are clicked on, and what a host lets move is dragged.
// A host is a page of the same origin that shows this one inside of it. It gives `data.handles`, what
// can be moved, and sets `view.host`: picked, chosen, dragged, dropped and left are called there.
const NEAR = 14; // px from a target or the path that still mean it
const CLICK = 4; // px that a click may move
const FINE = 1, COARSE = 10; // mm of an arrow key, and with Shift
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1],
};
const handles = (data.handles ?? []).map((one) => ({ ...one, place: new THREE.Vector3(...one.position) }));
const held = { handle: null, from: new THREE.Vector3(), drags: false, moved: 0 };
const host = (what, ...values) => window.view?.host?.[what]?.(...values);

const heldBall = ball([0, 0, 0], "#1f5fae", 13);
heldBall.renderOrder = 2;
heldBall.visible = false;
const heldLine = line(new Float32Array(6), "#1f5fae");
heldLine.frustumCulled = false;
heldLine.visible = false;
const grips = handles.length ? ball(handles.flatMap((one) => one.position), "#a4480b", 6) : null;
scene.add(heldBall, heldLine);
if (grips) scene.add(grips);

/** The camera that draws what is under a point of the canvas, and that point in its view, -1 to 1. */
function under(x, y) {
  if (!plan.on) return { eye: camera, width: stage.clientWidth, height: stage.clientHeight, x, y };
  const places = halves(), [left, top, width, height] = places[1], second = x >= left && y >= top;
  return { eye: plan.views[Number(second)].camera, width, height, x: second ? x - left : x, y: second ? y - top : y };
}
/** px from a point of a view to a place, Infinity for one that is not seen. */
function away({ eye, width, height, x, y }, place) {
  const seen = place.clone().project(eye);
  if (seen.z < -1 || seen.z > 1) return Infinity;
  return Math.hypot(((seen.x + 1) / 2) * width - x, ((1 - seen.y) / 2) * height - y);
}
function nearest(view, places, count) {
  let best = -1, least = NEAR;
  for (let i = 0; i < count; i++) {
    const far = away(view, places(i));
    if (far < least) [best, least] = [i, far];
  }
  return best;
}
const spot = new THREE.Vector3();
function pick(x, y) {
  const view = under(x, y);
  const handle = nearest(view, (i) => handles[i].place, handles.length);
  if (handle >= 0) return { handle };
  const target = nearest(view, (i) => spot.fromArray(data.targets[i].pose), data.targets.length);
  if (target >= 0) return { target };
  const sample = path.visible ? nearest(view, (i) => spot.fromArray(motion.places, 3 * i), count) : -1;
  return sample >= 0 ? { sample } : {};
}
/** Goes to where a click leads: a target by the first move to it, a place of the path by its time. */
function picked({ handle, target, sample }) {
  if (sample !== undefined) go(motion.times[sample]);
  const name = handle !== undefined ? handles[handle].name : target !== undefined ? data.targets[target].name : null;
  if (name !== null) goMove(moveTo(name));
  host("picked", { handle, name, line: lineAt() });
}
const moveTo = (name) => {
  const at = data.moves.findIndex((move) => move.label.toLowerCase() === name.toLowerCase());
  return at < 0 ? null : at;
};
/** The file and line that the arm is at, from 1; null for none. */
function lineAt() {
  if (!lineNow) return null;
  const text = data.texts.findLast((one) => one.first <= lineNow);
  return text ? { path: text.path, line: lineNow - text.first + 1 } : null;
}
/** Goes to the first move of a line of a file; whether there is one. */
function goLine(path, number) {
  const text = data.texts.find((one) => one.path === path);
  const time = text && firstTime.get(text.first + number - 1);
  if (time === undefined) return false;
  go(time);
  return true;
}

/** Takes hold of something; of nothing by -1. */
function take(i) {
  if (held.handle) leave(false);
  held.handle = i >= 0 ? handles[i] : null;
  heldBall.visible = held.handle !== null;
  if (held.handle) {
    held.from.copy(held.handle.place);
    shownAt(held.handle.place);
  }
  dirty = true;
  host("chosen", i);
}
function shownAt(place) {
  heldBall.position.copy(place);
  const points = heldLine.geometry.getAttribute("position");
  held.from.toArray(points.array, 0);
  place.toArray(points.array, 3);
  points.needsUpdate = true;
  heldLine.visible = held.handle !== null && held.from.distanceTo(place) > 0.01;
  const by = held.handle?.kind === "drawing" ? place.clone().sub(held.from) : new THREE.Vector3();
  for (const one of [drawn, path, zones]) one.position.copy(by);
  dirty = true;
}
/** Where it would be; nothing is changed before it is dropped. */
function drag(place) {
  if (!held.handle) return;
  held.handle.place.copy(place);
  shownAt(place);
  host("dragged", handles.indexOf(held.handle), place.toArray());
}
/** Back to where it was, and out of hand. */
function leave(tells = true) {
  if (!held.handle) return;
  const i = handles.indexOf(held.handle);
  held.handle.place.copy(held.from);
  shownAt(held.from);
  held.handle = null;
  held.drags = false;
  heldBall.visible = heldLine.visible = false;
  if (controls) controls.enabled = !plan.on;
  follow(data.live !== null);
  setTime(now);
  if (tells) host("left", i);
}
function drop() {
  if (!held.handle || held.from.distanceTo(held.handle.place) < 1e-6) return;
  host("dropped", handles.indexOf(held.handle), held.handle.place.toArray());
}
/** The place under a point, in the plane that faces the view and holds what is dragged. */
function inPlane(x, y, through) {
  const { eye, width, height, x: left, y: top } = under(x, y);
  const out = eye.getWorldDirection(new THREE.Vector3()), depth = through.clone().project(eye).z;
  const at = new THREE.Vector3((2 * left) / width - 1, 1 - (2 * top) / height, depth).unproject(eye);
  if (plan.on) return at.addScaledVector(out, through.clone().sub(at).dot(out));
  const ray = at.clone().sub(eye.position).normalize();
  return eye.position.clone().addScaledVector(ray, through.clone().sub(eye.position).dot(out) / ray.dot(out));
}
function beginPicking() {
  const canvas = renderer.domElement, pressed = { x: 0, y: 0, id: null };
  const at = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    [pressed.x, pressed.y] = at(event);
    pressed.id = event.pointerId;
    const { handle } = handles.length ? pick(pressed.x, pressed.y) : {};
    if (handle === undefined) return;
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
    if (held.handle !== handles[handle]) take(handle);
    held.drags = window.view.movable;
    if (controls) controls.enabled = false;
  }, true);
  canvas.addEventListener("pointermove", (event) => {
    if (!held.drags || !held.handle) return;
    event.stopImmediatePropagation();
    const [x, y] = at(event);
    if (held.moved || Math.hypot(x - pressed.x, y - pressed.y) > CLICK) {
      held.moved = 1;
      drag(inPlane(x, y, held.handle.place));
    }
  }, true);
  const up = (event) => {
    if (pressed.id !== event.pointerId) return;
    pressed.id = null;
    const [x, y] = at(event), dragged = held.moved;
    held.drags = false;
    held.moved = 0;
    if (controls) controls.enabled = !plan.on;
    if (dragged) drop();
    else if (event.type === "pointerup" && Math.hypot(x - pressed.x, y - pressed.y) <= CLICK) picked(pick(x, y));
  };
  canvas.addEventListener("pointerup", up, true);
  canvas.addEventListener("pointercancel", (event) => { pressed.id = null; held.moved = 0; leave(); event.stopPropagation(); });
}
/** Keys of what is in hand come before those of the time line. */
document.addEventListener("keydown", (event) => {
  if (!held.handle || ["SELECT", "INPUT"].includes(event.target.tagName)) return;
  if (event.key === "Escape") leave();
  else if (event.key === "Enter") drop();
  else if (KEYS[event.key] && window.view.movable) {
    const step = event.shiftKey ? COARSE : FINE;
    drag(held.handle.place.clone().add(new THREE.Vector3(...KEYS[event.key]).multiplyScalar(step)));
  } else return;
  event.preventDefault();
  event.stopImmediatePropagation();
}, true);
if (data.handles) {
  document.body.classList.add("hosted");
  find("beside").hidden = false;
  find("beside").addEventListener("click", () => document.body.classList.toggle("lists"));
}
