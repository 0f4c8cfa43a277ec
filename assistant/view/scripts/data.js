// The data of the page, see assistant/view/page.py: columns of numbers and plain records.
const whole = JSON.parse(document.getElementById("data").textContent);
const chosen = Number(location.hash.slice(1)) || 0; // of several programs
const other = document.getElementById(`data-${chosen}`);
const data = other ? JSON.parse(other.textContent) : whole;
const find = (id) => document.getElementById(id);
const made = (tag, text, name) => {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  if (name) element.className = name;
  return element;
};
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const numbers = (text) => new Float32Array(bytes(text));
const rows = (text) => new Uint32Array(bytes(text));
const COLOURS = ["#2c3e9e", "#1f9aa8", "#69b764", "#f0b429", "#d7301f"].map((c) => new THREE.Color(c));
const SEVERITIES = { error: "#c4361f", warning: "#d98a00", info: "#2667c9" };
const STEP = 0.1; // seconds of an arrow key

const motion = {
  times: numbers(data.motion.times), joints: numbers(data.motion.joints),
  places: numbers(data.motion.places), speeds: numbers(data.motion.speeds),
  room: numbers(data.motion.room), nearest: rows(data.motion.nearest),
};
const axes = data.motion.axes, count = motion.times.length;
const seconds = count ? motion.times[count - 1] : 0;
const played = {
  times: numbers(data.played.times), moves: rows(data.played.moves),
  lines: rows(data.played.lines), until: data.played.until,
};

/** How many of a sorted column are not behind a time. */
function begun(times, time) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time + 1e-4) low = middle + 1; else high = middle;
  }
  return low;
}

/** The sample before a time, and how far it is from there to the next one, 0 to 1. */
function sampleAt(time) {
  let low = 0, high = count - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (motion.times[middle] <= time) low = middle; else high = middle;
  }
  const span = motion.times[high] - motion.times[low];
  return [low, high, span > 0 ? Math.min(1, Math.max(0, (time - motion.times[low]) / span)) : 0];
}

/** Joints at a time, straight between two samples. */
function jointsAt(time) {
  if (!count) return arms.find((arm) => arm.moves)?.home ?? [];
  const [low, high, part] = sampleAt(time), out = [];
  for (let i = 0; i < axes; i++) {
    const from = motion.joints[low * axes + i];
    out.push(from + part * (motion.joints[high * axes + i] - from));
  }
  return out;
}

const matrix = ([x, y, z, qw, qx, qy, qz]) => new THREE.Matrix4().compose(
  new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), new THREE.Vector3(1, 1, 1));
const arms = data.robots.map((robot) => ({
  ...robot,
  base: matrix(robot.base),
  flange: matrix(robot.flange),
  joints: robot.joints.map((j) => ({ rest: matrix(j.pose), axis: new THREE.Vector3(...j.axis), sliding: j.sliding })),
}));

/** Matrices of all carriers for joints of the robot that moves, in the order of the data. */
function frames(joints) {
  const found = [new THREE.Matrix4()];
  for (const arm of arms) {
    const values = arm.moves ? joints : arm.home;
    let at = arm.base.clone();
    found.push(at);
    arm.joints.forEach((joint, i) => {
      const turn = new THREE.Matrix4();
      if (joint.sliding) turn.makeTranslation(...joint.axis.clone().multiplyScalar(values[i]).toArray());
      else turn.makeRotationAxis(joint.axis, values[i]);
      at = at.clone().multiply(joint.rest).multiply(turn);
      found.push(at);
    });
    found.push(at.clone().multiply(arm.flange));
  }
  return found;
}
