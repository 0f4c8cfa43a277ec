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
  back.setLength(Math.min(back.length(), look.far / 3));
  camera.position.copy(place).add(back);
  controls.target.copy(place);
  dirty = true;
}
/** Turns the view to the arms and what the program goes through. */
function look() {
  const around = new THREE.Box3();
  const grow = (object) => {
    const box = new THREE.Box3().setFromObject(object);
    if (!box.isEmpty()) around.expandByPoint(box.min).expandByPoint(box.max);
  };
  [...carriers.slice(1), path, targets, drawn].forEach(grow);
  if (around.isEmpty()) grow(scene);
  if (around.isEmpty()) around.set(new THREE.Vector3(-500, -500, 0), new THREE.Vector3(500, 500, 1000));
  plan.box.copy(around);
  const ball = around.getBoundingSphere(new THREE.Sphere());
  const far = ball.radius / Math.sin((camera.fov * Math.PI) / 360);
  look.far = far;
  camera.near = ball.radius / 500;
  camera.far = far + 40 * ball.radius;
  camera.updateProjectionMatrix();
  aim(ball.center, far);
  grow(scene);
  const cells = 20, size = Math.pow(10, Math.ceil(Math.log10(ball.radius * 2)));
  const grid = new THREE.GridHelper(size, cells, "#c8c8c8", "#ffffff");
  inked.push([grid.material, "borderTopColor"]);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = Math.min(around.min.z, 0) - 0.5;
  scene.add(grid);
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
  const [eye, [left, top, width, height]] = plan.on ? drawPlan() : [camera, whole];
  const place = new THREE.Vector3(), inside = (value) => value > -1 && value < 1;
  const taken = []; // left and top of names that are shown: others would stand over them
  for (const { element, object, on } of named) {
    place.setFromMatrixPosition(object.matrixWorld).project(eye);
    const seen = on.visible && inside(place.z) && (!plan.on || (inside(place.x) && inside(place.y))) && find("with-names").checked;
    const x = left + ((place.x + 1) / 2) * width + 6, y = top + ((1 - place.y) / 2) * height - 18;
    const long = 7 * element.textContent.length;
    const free = seen && !taken.some((one) => Math.abs(one.y - y) < 14 && one.x < x + long && x < one.x + one.long);
    element.style.display = free ? "" : "none";
    if (!free) continue;
    element.style.transform = `translate(${x}px, ${y}px)`;
    taken.push({ x, y, long });
  }
}
function resized() {
  if (!renderer) return;
  camera.aspect = stage.clientWidth / Math.max(1, stage.clientHeight);
  camera.updateProjectionMatrix();
  renderer.setPixelRatio(window.devicePixelRatio * (pace.coarse ? 0.5 : 1));
  renderer.setSize(stage.clientWidth, stage.clientHeight);
  if (plan.on) flat(true);
  dirty = true;
}
if (controls) controls.addEventListener("change", () => { dirty = true; });
new ResizeObserver(resized).observe(stage);
