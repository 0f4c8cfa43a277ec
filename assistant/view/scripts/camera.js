// What is looked at, and drawing it.
const camera = new THREE.PerspectiveCamera(40, 1, 1, 1e5);
camera.up.set(0, 0, 1);
let renderer = null;
/** Whether a processor draws, and no card: smooth edges would take most of its time. */
function drawnByHand() {
  const one = document.createElement("canvas").getContext("webgl2"), told = one?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? String(one.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  one?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
try {
  renderer = new THREE.WebGLRenderer({ antialias: !drawnByHand() });
} catch {
  notice("This browser draws no scenes, as it has no WebGL; the lists beside this place work all the same.");
}
const controls = renderer && new THREE.OrbitControls(camera, renderer.domElement);
if (renderer) stage.prepend(renderer.domElement);

/** Turns the view to a place, from a distance. */
function aim(place, far) {
  if (plan.on) flat(false);
  camera.position.copy(place).add(new THREE.Vector3(0.75, -1, 0.6).normalize().multiplyScalar(far));
  camera.lookAt(place);
  if (controls) controls.target.copy(place);
  dirty = true;
}
/** Turns the view about a place, as it looked before, and near enough to see it. */
function approach(place) {
  if (!controls) return;
  if (plan.on) {
    plan.centre.copy(place);
    plan.scale = Math.min(plan.scale, plan.fit / 3);
    dirty = true;
    return;
  }
  const back = camera.position.clone().sub(controls.target);
  back.setLength(Math.min(back.length(), look.far / 2));
  camera.position.copy(place).add(back);
  controls.target.copy(place);
  dirty = true;
}
const LEAST_SHARE = 0.35; // of the size of the arm and all, so that a small part is seen with the tool that works it
const boxOf = (objects) => {
  const around = new THREE.Box3();
  for (const object of objects) {
    const box = new THREE.Box3().setFromObject(object);
    if (!box.isEmpty()) around.expandByPoint(box.min).expandByPoint(box.max);
  }
  return around;
};
/** Frames the work: the lines of its drawing, or what the program goes through; or the arms and all. */
function look(all) {
  const size = look.all.getBoundingSphere(new THREE.Sphere()).radius, least = LEAST_SHARE * size;
  plan.box.copy(all ? look.all : look.work);
  const ball = plan.box.getBoundingSphere(new THREE.Sphere());
  if (!all) {
    ball.radius = Math.max(Math.min(1.3 * ball.radius, size), least);
    const half = plan.box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    plan.box.expandByVector(half.set(...half.toArray().map((one) => Math.max(0, 0.6 * least - one))));
  }
  look.far = ball.radius / Math.sin((camera.fov * Math.PI) / 360) / Math.min(1, camera.aspect);
  camera.near = ball.radius / 500;
  camera.far = look.far + 40 * size;
  camera.updateProjectionMatrix();
  if (plan.on) { fitted(); dirty = true; } else aim(ball.center, look.far);
}
function beginLook() {
  look.all = boxOf([...carriers.slice(1), path, targets, drawn]);
  if (look.all.isEmpty()) look.all = boxOf([scene]);
  if (look.all.isEmpty()) look.all.set(new THREE.Vector3(-500, -500, 0), new THREE.Vector3(500, 500, 1000));
  const work = drawn.children.filter((one) => !one.userData.left);
  look.work = boxOf(work.length ? work : [path, targets]);
  if (look.work.isEmpty()) look.work = look.all;
  const ball = look.all.getBoundingSphere(new THREE.Sphere());
  const cells = 20, size = Math.pow(10, Math.ceil(Math.log10(ball.radius * 2)));
  const grid = new THREE.GridHelper(size, cells, "#c8c8c8", "#ffffff");
  inked.push([grid.material, "borderTopColor"]);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = Math.min(boxOf([scene]).union(look.all).min.z, 0) - 0.5;
  scene.add(grid);
  look(false);
}

const MANY = 500 * 22; // characters of zones: 22 a ball
const SLOW = 40, REST = 150, OFTEN = 5; // ms of a frame, ms of rest, and how many slow frames make it coarse
const pace = { last: 0, slow: 0, coarse: false };
/** What moves is drawn coarser where it would jerk otherwise, and sharp again as soon as it rests. */
function paced(at) {
  const gone = at - pace.last;
  if (dirty) {
    pace.last = at;
    if (gone < REST * 4) pace.slow = Math.min(OFTEN, Math.max(0, pace.slow + (gone > SLOW ? 1 : -1)));
    if (pace.slow === OFTEN && !pace.coarse) sharpen(false);
  } else if (pace.coarse && gone > REST) sharpen(true);
}
function sharpen(on) {
  pace.coarse = !on;
  renderer.setPixelRatio(window.devicePixelRatio * (on ? 1 : 0.5));
  zones.material.visible = on || data.zones.length < MANY; // thousands of balls take longest
  dirty = true;
}
function draw(at) {
  if (!renderer) return;
  if (controls.update()) dirty = true;
  paced(at);
  if (!dirty) return;
  dirty = false;
  const whole = [0, 0, stage.clientWidth, stage.clientHeight];
  if (!plan.on) renderer.render(scene, camera);
  const [eye, pane] = plan.on ? drawPlan() : [camera, whole];
  const place = new THREE.Vector3(), wanted = find("with-names").checked;
  const taken = [...keptFree]; // boxes of names that are shown, and of buttons: others would stand over them
  for (const { element, object, on, wide } of named) {
    place.setFromMatrixPosition(object.matrixWorld).project(eye);
    const box = wanted && on.visible && nameBox(place, pane, wide);
    const free = box && !taken.some((one) => box.x < one.x + one.w && one.x < box.x + box.w && box.y < one.y + one.h && one.y < box.y + box.h);
    element.style.display = free ? "" : "none";
    if (!free) continue;
    element.style.transform = `translate(${box.x}px, ${box.y}px)`;
    taken.push(box);
  }
}
const NAME_HIGH = 17, NAME_GAP = 6; // px of a name, and from its place
let keptFree = [];
/** Where a name stands, in its pane: on the right of its place, or on the left where there is no room; null where it cannot. */
function nameBox({ x, y, z }, [left, top, width, height], wide) {
  if (!(Math.max(Math.abs(x), Math.abs(y), Math.abs(z)) < 1)) return null;
  const at = left + ((x + 1) / 2) * width, right = at + NAME_GAP + wide <= left + width;
  const from = right ? at + NAME_GAP : at - NAME_GAP - wide;
  const high = Math.max(top, Math.min(top + ((1 - y) / 2) * height - 18, top + height - NAME_HIGH));
  return from < left ? null : { x: from, y: high, w: wide, h: NAME_HIGH };
}
function keepFree() {
  keptFree = ["views", "above", "side"].map(find).filter((one) => one.offsetWidth).map((one) => {
    const { left, top } = stage.getBoundingClientRect(), box = one.getBoundingClientRect();
    return { x: box.left - left, y: box.top - top, w: box.width, h: one.id === "side" ? 30 : box.height };
  });
}
function resized() {
  if (!renderer) return;
  camera.aspect = stage.clientWidth / Math.max(1, stage.clientHeight);
  camera.updateProjectionMatrix();
  renderer.setPixelRatio(window.devicePixelRatio * (pace.coarse ? 0.5 : 1));
  renderer.setSize(stage.clientWidth, stage.clientHeight);
  if (plan.on) flat(true);
  keepFree();
  dirty = true;
}
if (controls) controls.addEventListener("change", () => { dirty = true; });
new ResizeObserver(resized).observe(stage);
