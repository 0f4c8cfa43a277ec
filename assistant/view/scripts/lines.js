// What is drawn about the program: path, zones, lines of the drawing, targets, and places of findings.
let fastest = 1e-9;
for (const speed of motion.speeds) fastest = Math.max(fastest, speed);
const ramp = (part) => {
  const at = Math.min(Math.max(part, 0), 1) * (COLOURS.length - 1);
  const low = Math.min(Math.floor(at), COLOURS.length - 2);
  return COLOURS[low].clone().lerp(COLOURS[low + 1], at - low);
};
/** What the path is coloured by: of a sample 0 to 1, and what stands at the ends of the key. */
const COLOURED = {
  speed: { part: (i) => motion.speeds[i] / fastest, ends: ["0", `${fastest < 1e-6 ? 0 : Math.round(fastest)} mm/s`] },
  room: { part: (i) => 1 - motion.room[i], ends: ["far from limits", "at a limit"] },
};
const STRAIGHT = new THREE.Color("#d7301f"), JOINT = new THREE.Color("#2667c9");
/** The path of a program that no arm goes through: a piece to each target. */
function pieces(still) {
  const places = numbers(still.places), joint = rows(still.joint), points = [], colours = [];
  for (let i = 1; i < joint.length; i++) {
    points.push(...places.subarray(3 * i - 3, 3 * i + 3));
    for (let end = 0; end < 2; end++) colours.push(...(joint[i] ? JOINT : STRAIGHT).toArray());
  }
  const shape = new THREE.BufferGeometry();
  attribute(shape, "position", new Float32Array(points));
  attribute(shape, "color", new Float32Array(colours));
  return new THREE.LineSegments(shape, new THREE.LineBasicMaterial({ vertexColors: true }));
}
const path = data.still ? pieces(data.still) : line(motion.places, "#ffffff");
if (!data.still) {
  path.material.vertexColors = true;
  attribute(path.geometry, "color", new Float32Array(3 * count));
}
scene.add(path);
function colourBy(what) {
  if (!count) return;
  const colours = path.geometry.getAttribute("color"), { part, ends } = COLOURED[what];
  for (let i = 0; i < count; i++) ramp(part(i)).toArray(colours.array, 3 * i);
  colours.needsUpdate = true;
  [find("least").textContent, find("most").textContent] = ends;
  dirty = true;
}

const tips = new THREE.Group();
for (const tip of data.tips) {
  tips.add(ink(new Float32Array([0, 0, 0, ...tip.slice(0, 3)])), framed(tip, 40));
}
if (!data.tips.length && mover >= 0) tips.add(cross(40));
carriers[flange].add(tips);

const targets = new THREE.Group();
const stood = data.targets.map((target) => {
  const at = new THREE.Group();
  at.applyMatrix4(matrix(target.pose));
  targets.add(at);
  name(target.name, at, targets);
  return matrix(target.pose);
});
if (stood.length) targets.add(crosses(stood, 30));
scene.add(targets);

const FINEST = 10, CORNERS = 60000; // parts around a ball, and corners of all of them
/** Balls about centres, (x, y, z, radius) each, as one surface; of many each is the coarser. */
function balls(places, material) {
  const count = Math.max(1, places.length / 4);
  const around = Math.max(4, Math.min(FINEST, Math.floor(Math.sqrt(CORNERS / count))));
  const up = Math.max(2, Math.round(0.6 * around)), one = around * (up + 1);
  const points = new Float32Array((places.length / 4) * one * 3);
  const triangles = new Uint32Array((places.length / 4) * around * (up - 1) * 6);
  let p = 0, t = 0;
  for (let i = 0; i < places.length; i += 4) {
    const first = p / 3, [x, y, z, r] = places.subarray(i, i + 4);
    for (let k = 0; k <= up; k++) for (let j = 0; j < around; j++) {
      const a = (2 * Math.PI * j) / around, b = (Math.PI * k) / up;
      points[p++] = x + r * Math.sin(b) * Math.cos(a);
      points[p++] = y + r * Math.sin(b) * Math.sin(a);
      points[p++] = z + r * Math.cos(b);
    }
    for (let k = 0; k < up; k++) for (let j = 0; j < around; j++) {
      const a = first + k * around + j, b = first + k * around + ((j + 1) % around);
      const upper = k ? [a, a + around, b] : [], lower = k < up - 1 ? [b, a + around, b + around] : [];
      for (const corner of [...upper, ...lower]) triangles[t++] = corner;
    }
  }
  return surface(points, triangles, false, material);
}
const zones = balls(numbers(data.zones), { color: "#7a4fb5", transparent: true, opacity: 0.28, depthWrite: false, forceSinglePass: true });
scene.add(zones);

const drawn = new THREE.Group();
for (const one of data.drawn) {
  const curve = ink(numbers(one.points));
  if (one.left) Object.assign(curve.material, { transparent: true, opacity: 0.25 }); // no work
  curve.userData.left = one.left;
  drawn.add(curve);
}
scene.add(drawn);

const marks = new THREE.Group();
const ARROW = { least: 30, most: 150, head: 9 }; // mm
const ball = (place, colour, size) => {
  const shape = new THREE.BufferGeometry();
  attribute(shape, "position", new Float32Array(place));
  return new THREE.Points(shape, new THREE.PointsMaterial({ color: colour, size, sizeAttenuation: false, depthTest: false }));
};
/** Of a contact both points, and the vector along which the first body comes out of it, five times as long as it is deep. */
for (const finding of data.findings) {
  if (finding.at) {
    const dot = ball(finding.at, SEVERITIES[finding.severity], 9);
    dot.renderOrder = 1;
    marks.add(dot);
  }
  if (!finding.mark) continue;
  const colour = SEVERITIES[finding.severity], [one, other] = finding.mark.points;
  const long = Math.min(ARROW.most, Math.max(ARROW.least, 5 * finding.mark.deep));
  const arrow = new THREE.ArrowHelper(new THREE.Vector3(...finding.mark.out), new THREE.Vector3(...one), long, colour, ARROW.head, ARROW.head / 2);
  arrow.line.material.depthTest = arrow.cone.material.depthTest = false;
  const group = new THREE.Group();
  group.add(ball(one, colour, 9), ball(other, colour, 6), arrow);
  group.renderOrder = 1;
  marks.add(group);
}
scene.add(marks);
