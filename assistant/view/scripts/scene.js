// The scene: what carries, bodies with what they ride on, and pieces to draw with.
const stage = find("stage");
const notice = (text) => { find("notice").textContent = text; find("notice").hidden = !text; };
const scene = new THREE.Scene();
scene.background = new THREE.Color();
scene.add(new THREE.HemisphereLight("#ffffff", "#8a8f98", 2.2));
const sun = new THREE.DirectionalLight("#ffffff", 1.6);
sun.position.set(0.5, -1, 1.5);
scene.add(sun);
let dirty = true; // whether what is drawn has changed

const inked = []; // materials that have a colour of the page, each with whose
/** Ground and ink are those of the page, light or dark. */
function themed() {
  const colours = getComputedStyle(stage);
  scene.background.set(colours.backgroundColor);
  for (const [material, whose] of inked) material.color.set(colours[whose]);
  dirty = true;
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", themed);

const carriers = frames(jointsAt(0)).map(() => {
  const group = new THREE.Group();
  group.matrixAutoUpdate = false;
  scene.add(group);
  return group;
});
const mover = arms.findIndex((arm) => arm.moves);
let flange = 0; // of the robot that moves, among the carriers
for (let i = 0; i <= mover; i++) flange += arms[i].joints.length + 2;

function attribute(shape, name, values) {
  shape.setAttribute(name, new THREE.BufferAttribute(values, 3));
}
function surface(points, triangles, flat, material) {
  const shape = new THREE.BufferGeometry();
  attribute(shape, "position", points);
  shape.setIndex(new THREE.BufferAttribute(triangles, 1));
  if (!flat) shape.computeVertexNormals();
  return new THREE.Mesh(shape, new THREE.MeshStandardMaterial({
    flatShading: flat, roughness: 0.75, metalness: 0.05, side: THREE.DoubleSide, ...material }));
}
function line(points, colour) {
  const shape = new THREE.BufferGeometry();
  attribute(shape, "position", points);
  return new THREE.Line(shape, new THREE.LineBasicMaterial({ color: colour }));
}
function ink(points) {
  const one = line(points, "#1d2733");
  inked.push([one.material, "color"]);
  return one;
}
/** Axes of frames as one object, however many there are: each object that is drawn takes its time. */
function crosses(places, size) {
  const points = [], colours = [], end = new THREE.Vector3();
  for (const at of places) [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis) => {
    for (const far of [0, size]) points.push(...end.set(...axis).multiplyScalar(far).applyMatrix4(at).toArray());
    colours.push(...axis.map((v) => v * 0.85), ...axis.map((v) => v * 0.85));
  });
  const shape = new THREE.BufferGeometry();
  attribute(shape, "position", new Float32Array(points));
  attribute(shape, "color", new Float32Array(colours));
  return new THREE.LineSegments(shape, new THREE.LineBasicMaterial({ vertexColors: true }));
}
const cross = (size) => crosses([new THREE.Matrix4()], size);
function framed(pose, size) {
  const lines = cross(size);
  lines.applyMatrix4(matrix(pose));
  return lines;
}

const named = []; // {element, object: whose place it stands at, on: what must be seen, wide: px}
const ruler = document.createElement("canvas").getContext("2d");
ruler.font = "12px system-ui, sans-serif"; // as in the style
function name(text, object, on) {
  const element = made("span", text);
  find("names").append(element);
  named.push({ element, object, on, wide: Math.ceil(ruler.measureText(text).width) + 2 });
}

const bodies = data.bodies.map((body) => {
  const group = new THREE.Group();
  group.matrixAutoUpdate = false;
  for (const part of body.parts) {
    group.add(surface(numbers(part.points), rows(part.triangles), part.flat, { color: body.colour }));
  }
  for (const location of body.locations) {
    const lines = framed(location.pose, 30);
    group.add(lines);
    name(location.name, lines, group);
  }
  const one = { ...body, group, wanted: true, ride: -1 };
  put(one, body.carrier, body.pose);
  return one;
});
/** Lets a body ride on a carrier; on none it is not shown, as nobody knows where it is. */
function put(body, carrier, pose) {
  body.known = carrier !== null;
  body.group.visible = body.known && body.wanted;
  if (!body.known) return;
  carriers[carrier].add(body.group);
  body.group.matrix.copy(matrix(pose));
  body.group.matrixWorldNeedsUpdate = true;
}
function want(body, on) {
  body.wanted = on;
  body.group.visible = body.known && on;
}
/** Bodies that the arm takes and lets go, as they are at a time. */
function ride(time) {
  for (const body of bodies) {
    if (!body.rides.length) continue;
    let at = 0;
    while (at + 1 < body.rides.length && body.rides[at + 1].time <= time + 1e-4) at++;
    if (at !== body.ride) put(body, body.rides[at].carrier, body.rides[at].pose);
    body.ride = at;
  }
}

let shown = [];
/** Poses the arm that moves. */
function stand(joints) {
  shown = frames(joints);
  shown.forEach((at, i) => { carriers[i].matrix.copy(at); carriers[i].matrixWorldNeedsUpdate = true; });
  dirty = true;
}
