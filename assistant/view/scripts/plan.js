// Plan and side view: the scene from above and from the side, to one scale and without perspective.
const DEEP = 1e5; // mm that are seen in front of a place and behind it
const plan = {
  on: false, centre: new THREE.Vector3(), scale: 1, fit: 1, box: new THREE.Box3(), // scale: mm of a pixel
  views: [
    { up: new THREE.Vector3(0, 1, 0), back: new THREE.Vector3(0, 0, 1) },
    { up: new THREE.Vector3(0, 0, 1), back: new THREE.Vector3(0, -1, 0) },
  ],
};
for (const view of plan.views) {
  view.camera = new THREE.PerspectiveCamera();
  view.right = view.up.clone().cross(view.back);
}

/** Left, top, width and height of each view in pixels of the page: beside each other, or below. */
function halves() {
  const width = stage.clientWidth, height = stage.clientHeight, wide = width > height;
  const w = wide ? width / 2 : width, h = wide ? height : height / 2;
  return [[0, 0, w, h], wide ? [w, 0, w, h] : [0, h, w, h]];
}
/** Shows all of what the camera in space is turned to. */
function fitted() {
  const size = plan.box.getSize(new THREE.Vector3()), [[, , w, h]] = halves();
  plan.box.getCenter(plan.centre);
  plan.fit = plan.scale = 1.15 * Math.max(size.x / w, size.y / h, size.z / h, 0.01);
}
function placeCameras() {
  halves().forEach(([, , w, h], i) => {
    const { camera: eye, up, back } = plan.views[i], x = (plan.scale * w) / 2, y = (plan.scale * h) / 2;
    eye.up.copy(up);
    eye.position.copy(plan.centre).addScaledVector(back, DEEP);
    eye.lookAt(plan.centre);
    eye.projectionMatrix.makeOrthographic(-x, x, y, -y, 1, 2 * DEEP);
    eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert();
  });
}
/** Draws both views; gives the camera of the plan, and where it is on the page. */
function drawPlan() {
  placeCameras();
  const height = stage.clientHeight, places = halves();
  renderer.setScissorTest(true);
  places.forEach(([left, top, w, h], i) => {
    renderer.setViewport(left, height - top - h, w, h);
    renderer.setScissor(left, height - top - h, w, h);
    renderer.render(scene, plan.views[i].camera);
  });
  renderer.setScissorTest(false);
  renderer.setViewport(0, 0, stage.clientWidth, height);
  return [plan.views[0].camera, places[0]];
}
/** Plan and side view, or the view in space. */
function flat(on) {
  plan.on = on;
  if (controls) controls.enabled = !on;
  for (const lines of [path, ...drawn.children]) { // from above the arm would hide them
    lines.material.depthTest = !on;
    lines.renderOrder = on ? 1 : 0;
  }
  find("plan").classList.toggle("now", on);
  find("space").classList.toggle("now", !on);
  for (const id of ["above", "side"]) find(id).hidden = !on;
  const [, [left, top]] = halves();
  find("side").style.left = `${left}px`;
  find("side").style.top = `${top}px`;
  find("side").style.borderLeftWidth = left ? "1px" : "0";
  keepFree();
  dirty = true;
}
function beginPlan() {
  const canvas = renderer.domElement;
  canvas.addEventListener("wheel", (event) => {
    if (!plan.on) return;
    event.preventDefault();
    plan.scale = Math.min(20 * plan.fit, Math.max(plan.fit / 500, plan.scale * Math.exp(event.deltaY / 500)));
    dirty = true;
  }, { passive: false });
  canvas.addEventListener("pointermove", (event) => {
    if (!plan.on || !event.buttons) return;
    const { left, top } = canvas.getBoundingClientRect(), [, [x, y]] = halves();
    const { right, up } = plan.views[Number(event.clientX - left >= x && event.clientY - top >= y)];
    plan.centre.addScaledVector(right, -event.movementX * plan.scale).addScaledVector(up, event.movementY * plan.scale);
    dirty = true;
  });
  find("plan").addEventListener("click", () => { fitted(); flat(true); });
  find("space").addEventListener("click", () => { if (!plan.on) look(false); flat(false); });
  find("all").addEventListener("click", () => look(true));
}
