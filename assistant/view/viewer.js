// The page of a program in its cell. The data are columns of numbers and plain records, see
// assistant/view/record.py; the arm is posed here from its joints.
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("data").textContent);
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
  };
  const axes = data.motion.axes, count = motion.times.length;
  const seconds = count ? motion.times[count - 1] : 0;

  // ---- where things are ------------------------------------------------------------------------
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

  /** Joints at a time, straight between two samples. */
  function jointsAt(time) {
    if (!count) return arms.find((arm) => arm.moves).home;
    let low = 0, high = count - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (motion.times[middle] <= time) low = middle; else high = middle;
    }
    const span = motion.times[high] - motion.times[low];
    const part = span > 0 ? Math.min(1, Math.max(0, (time - motion.times[low]) / span)) : 0;
    const out = [];
    for (let i = 0; i < axes; i++) {
      const from = motion.joints[low * axes + i];
      out.push(from + part * (motion.joints[high * axes + i] - from));
    }
    return out;
  }

  // ---- the scene -------------------------------------------------------------------------------
  const stage = find("stage");
  const notice = (text) => { find("notice").textContent = text; find("notice").hidden = !text; };
  const scene = new THREE.Scene();
  scene.background = new THREE.Color("#eef1f4");
  scene.add(new THREE.HemisphereLight("#ffffff", "#8a8f98", 2.2));
  const sun = new THREE.DirectionalLight("#ffffff", 1.6);
  sun.position.set(0.5, -1, 1.5);
  scene.add(sun);
  const camera = new THREE.PerspectiveCamera(40, 1, 1, 1e5);
  camera.up.set(0, 0, 1);
  let renderer = null;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true });
  } catch {
    notice("This browser draws no scenes, as it has no WebGL; the lists beside this place work all the same.");
  }
  const controls = renderer && new THREE.OrbitControls(camera, renderer.domElement);
  if (renderer) stage.prepend(renderer.domElement);

  const carriers = frames(jointsAt(0)).map(() => {
    const group = new THREE.Group();
    group.matrixAutoUpdate = false;
    scene.add(group);
    return group;
  });
  const bodies = data.bodies.map((body) => {
    const group = new THREE.Group();
    const material = (flat) => new THREE.MeshStandardMaterial({
      color: body.colour, flatShading: flat, roughness: 0.75, metalness: 0.05, side: THREE.DoubleSide });
    for (const part of body.parts) {
      const shape = new THREE.BufferGeometry();
      shape.setAttribute("position", new THREE.BufferAttribute(numbers(part.points), 3));
      shape.setIndex(new THREE.BufferAttribute(rows(part.triangles), 1));
      if (!part.flat) shape.computeVertexNormals();
      group.add(new THREE.Mesh(shape, material(part.flat)));
    }
    carriers[body.carrier].add(group);
    return { ...body, group };
  });

  function cross(size) {
    const points = [], colours = [];
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis) => {
      points.push(0, 0, 0, ...axis.map((v) => v * size));
      colours.push(...axis.map((v) => v * 0.85), ...axis.map((v) => v * 0.85));
    });
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    shape.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colours), 3));
    return new THREE.LineSegments(shape, new THREE.LineBasicMaterial({ vertexColors: true }));
  }
  function framed(pose, size) {
    const lines = cross(size);
    lines.applyMatrix4(matrix(pose));
    return lines;
  }

  let fastest = 1e-9;
  for (const speed of motion.speeds) fastest = Math.max(fastest, speed);
  const ramp = (part) => {
    const at = Math.min(part, 1) * (COLOURS.length - 1), low = Math.min(Math.floor(at), COLOURS.length - 2);
    return COLOURS[low].clone().lerp(COLOURS[low + 1], at - low);
  };
  const path = (() => {
    const colours = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) ramp(motion.speeds[i] / fastest).toArray(colours, 3 * i);
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(motion.places, 3));
    shape.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    return new THREE.Line(shape, new THREE.LineBasicMaterial({ vertexColors: true }));
  })();
  scene.add(path);

  const mover = arms.findIndex((arm) => arm.moves);
  let flange = 0;
  for (let i = 0; i <= mover; i++) flange += arms[i].joints.length + 2;
  const tips = new THREE.Group();
  for (const tip of data.tips) {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array([0, 0, 0, ...tip.slice(0, 3)]), 3));
    tips.add(new THREE.Line(shape, new THREE.LineBasicMaterial({ color: "#1d2733" })), framed(tip, 40));
  }
  if (!data.tips.length) tips.add(cross(40));
  carriers[flange].add(tips);

  const named = []; // {element, place (a vector), on: what must be seen}
  const targets = new THREE.Group();
  scene.add(targets);
  const name = (text, object, on) => {
    const element = made("span", text);
    find("names").append(element);
    named.push({ element, object, on });
  };
  for (const target of data.targets) {
    const lines = framed(target.pose, 30);
    targets.add(lines);
    name(target.name, lines, targets);
  }
  for (const body of bodies) for (const location of body.locations) {
    const lines = framed(location.pose, 30);
    body.group.add(lines);
    name(location.name, lines, body.group);
  }

  const marks = new THREE.Group();
  scene.add(marks);
  const ball = (place, colour, size) => {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(place), 3));
    return new THREE.Points(shape, new THREE.PointsMaterial({ color: colour, size, sizeAttenuation: false, depthTest: false }));
  };
  for (const finding of data.findings) {
    if (!finding.mark) continue;
    const colour = SEVERITIES[finding.severity], [one, other] = finding.mark.points;
    const group = new THREE.Group();
    group.add(ball(one, colour, 9), ball(other, colour, 6));
    const arrow = new THREE.ArrowHelper(new THREE.Vector3(...finding.mark.normal), new THREE.Vector3(...one), 80, colour, 22, 12);
    arrow.line.material.depthTest = arrow.cone.material.depthTest = false;
    group.add(arrow);
    group.renderOrder = 1;
    marks.add(group);
  }

  // ---- what is looked at -----------------------------------------------------------------------
  const around = new THREE.Box3();
  function look() {
    around.setFromObject(scene);
    if (around.isEmpty()) around.set(new THREE.Vector3(-500, -500, 0), new THREE.Vector3(500, 500, 1000));
    const ball = around.getBoundingSphere(new THREE.Sphere());
    const far = ball.radius / Math.sin((camera.fov * Math.PI) / 360);
    camera.position.copy(ball.center).add(new THREE.Vector3(0.75, -1, 0.6).normalize().multiplyScalar(far));
    camera.near = ball.radius / 500;
    camera.far = far + 20 * ball.radius;
    camera.updateProjectionMatrix();
    camera.lookAt(ball.center);
    if (controls) controls.target.copy(ball.center);
    const cells = 20, size = Math.pow(10, Math.ceil(Math.log10(ball.radius * 2)));
    const grid = new THREE.GridHelper(size, cells, "#aab4bf", "#d3d9df");
    grid.rotation.x = Math.PI / 2;
    grid.position.z = Math.min(around.min.z, 0) - 0.5;
    scene.add(grid);
  }

  let dirty = true;
  function draw() {
    if (!renderer) return;
    if (controls.update()) dirty = true;
    if (!dirty) return;
    dirty = false;
    renderer.render(scene, camera);
    const width = stage.clientWidth, height = stage.clientHeight, place = new THREE.Vector3();
    for (const { element, object, on } of named) {
      place.setFromMatrixPosition(object.matrixWorld).project(camera);
      const seen = on.visible && place.z > -1 && place.z < 1 && find("with-names").checked;
      element.style.display = seen ? "" : "none";
      if (seen) element.style.transform = `translate(${((place.x + 1) / 2) * width + 6}px, ${((1 - place.y) / 2) * height - 18}px)`;
    }
  }
  function resized() {
    if (!renderer) return;
    camera.aspect = stage.clientWidth / Math.max(1, stage.clientHeight);
    camera.updateProjectionMatrix();
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(stage.clientWidth, stage.clientHeight);
    dirty = true;
  }
  if (controls) controls.addEventListener("change", () => { dirty = true; });
  new ResizeObserver(resized).observe(stage);

  // ---- time ------------------------------------------------------------------------------------
  let now = 0, playing = false, last = 0, shown = [];
  const played = { times: numbers(data.played.times), moves: rows(data.played.moves) };

  function stand(joints) {
    shown = frames(joints);
    shown.forEach((at, i) => { carriers[i].matrix.copy(at); carriers[i].matrixWorldNeedsUpdate = true; });
    dirty = true;
  }
  function setTime(time) {
    now = Math.min(seconds, Math.max(0, time));
    find("time").value = String(now);
    find("clock").textContent = `${now.toFixed(2)} of ${seconds.toFixed(2)} s`;
    stand(jointsAt(now));
    current();
  }
  /** How many of the moves that are played have begun. */
  function begun() {
    let low = 0, high = played.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (played.times[middle] <= now + 1e-4) low = middle + 1; else high = middle;
    }
    return low;
  }
  function current() {
    const at = begun() - 1;
    const move = at >= 0 && now <= data.played.until ? played.moves[at] : -1;
    if (move === current.move) return;
    current.move = move;
    moveButtons.forEach((button, i) => button.classList.toggle("now", i === move));
    const button = moveButtons[move];
    if (button) {
      const list = button.closest("ol"), top = button.parentElement.offsetTop - list.offsetTop;
      if (top < list.scrollTop || top > list.scrollTop + list.clientHeight - 40) list.scrollTop = top - list.clientHeight / 2;
    }
  }
  function play(on) {
    playing = on;
    find("play").textContent = on ? "❚❚" : "▶";
    if (on && now >= seconds) setTime(0);
  }
  function before() {
    const at = begun() - 1;
    const start = at >= 0 ? played.times[at] : 0;
    setTime(now - start > 0.05 ? start : at > 0 ? played.times[at - 1] : 0);
  }
  function after() {
    const at = begun();
    setTime(at < played.times.length ? played.times[at] : seconds);
  }
  function tick(at) {
    if (playing) {
      const rate = Number(find("rate").value);
      setTime(now + ((at - last) / 1000) * rate);
      if (now >= seconds) play(false);
    }
    last = at;
    draw();
    requestAnimationFrame(tick);
  }

  // ---- lists -----------------------------------------------------------------------------------
  function highlight(names) {
    for (const body of bodies) for (const mesh of body.group.children) {
      if (mesh.material.emissive) mesh.material.emissive.set(names.includes(body.name) ? "#7a1c0c" : "#000000");
    }
    dirty = true;
  }
  function choose(finding, button) {
    findingButtons.forEach((one) => one.classList.toggle("now", one === button));
    const mark = finding.mark;
    if (!mark) { highlight([]); return; }
    play(false);
    if (mark.time === null) stand(mark.joints); else setTime(mark.time);
    notice(mark.time === null ? "This place is not on the way that is played: another branch of the program leads there." : "");
    highlight([mark.one, mark.other]);
    if (controls) controls.target.set(...mark.points[0]);
  }
  const findingButtons = [], moveButtons = [];
  const place = (one) => [one.path, one.line].filter((part) => part !== null).join(":");
  const more = (list, left, what) => { if (left) list.append(made("li", `${left} more ${what}`, "where")); };
  {
    const list = find("findings").querySelector("ol");
    for (const finding of data.findings) {
      const item = made("li"), button = made("button", undefined, finding.severity);
      button.append(made("strong", `${finding.code} `), finding.message);
      if (finding.cure) button.append(made("div", finding.cure, "where"));
      if (finding.where) button.append(made("div", finding.where, "where"));
      button.disabled = !finding.mark && finding.move === null;
      button.addEventListener("click", () => {
        choose(finding, button);
        if (!finding.mark && finding.move !== null) go(finding.move);
      });
      findingButtons.push(button);
      item.append(button);
      list.append(item);
      if (finding.mark && finding.mark.time !== null && seconds > 0) {
        const tick = made("i");
        tick.style.left = `${(100 * finding.mark.time) / seconds}%`;
        tick.style.background = SEVERITIES[finding.severity];
        find("marks").append(tick);
      }
    }
    if (!data.findings.length) list.append(made("li", "none", "where"));
    more(list, data.left.findings, "findings");
  }
  const go = (move) => { if (data.moves[move].time !== null) { play(false); setTime(data.moves[move].time); } };
  {
    const list = find("moves").querySelector("ol");
    data.moves.forEach((move, i) => {
      const item = made("li"), button = made("button");
      button.append(made("div", move.text || move.label, "text"));
      const when = move.time === null ? "not on the way that is played" : `${move.time.toFixed(2)} s`;
      button.append(made("div", [`${move.procedure} move ${move.number}`, place(move), when].filter(Boolean).join(" · "), "where"));
      button.disabled = move.time === null;
      button.addEventListener("click", () => go(i));
      moveButtons.push(button);
      item.append(button);
      list.append(item);
    });
    if (!data.moves.length) list.append(made("li", "none", "where"));
    more(list, data.left.moves, "moves");
  }
  {
    const list = find("bodies").querySelector("ul");
    const toggle = (text, colour, set, id) => {
      const item = made("li"), label = made("label"), box = made("input");
      box.type = "checkbox";
      box.checked = true;
      if (id) box.id = id;
      box.addEventListener("change", () => { set(box.checked); dirty = true; });
      label.append(box);
      if (colour) { const swatch = made("i"); swatch.style.background = colour; label.append(swatch); }
      label.append(text);
      item.append(label);
      list.append(item);
    };
    toggle(data.motion.held ? "path of the tool" : "path of the flange", null, (on) => { path.visible = on; });
    toggle(data.left.targets ? `targets (${data.left.targets} more are not shown)` : "targets", null, (on) => { targets.visible = on; });
    toggle("names", null, () => {}, "with-names");
    toggle("contacts", null, (on) => { marks.visible = on; });
    for (const body of bodies) toggle(body.name, body.colour, (on) => { body.group.visible = on; });
  }

  // ---- beginning -------------------------------------------------------------------------------
  document.querySelector("h1").textContent = data.title;
  find("robot").textContent = data.robot;
  find("fastest").textContent = `${fastest < 1e-6 ? 0 : Math.round(fastest)} mm/s`;
  find("time").max = String(seconds);
  find("time").addEventListener("input", (event) => { play(false); setTime(Number(event.target.value)); });
  find("play").addEventListener("click", () => play(!playing));
  find("before").addEventListener("click", () => { play(false); before(); });
  find("after").addEventListener("click", () => { play(false); after(); });
  document.addEventListener("keydown", (event) => {
    const keys = {
      " ": () => play(!playing), PageUp: before, PageDown: after,
      ArrowLeft: () => setTime(now - STEP), ArrowRight: () => setTime(now + STEP),
      Home: () => setTime(0), End: () => setTime(seconds),
    };
    if (!keys[event.key] || ["SELECT", "BUTTON"].includes(event.target.tagName)) return;
    event.preventDefault();
    keys[event.key]();
  });
  setTime(0);
  scene.updateMatrixWorld(true);
  look();
  resized();
  requestAnimationFrame(tick);
  // What tests and other scripts on the page may ask.
  window.view = {
    setTime, play, seconds, choose: (i) => findingButtons[i].click(),
    time: () => now,
    carriers: () => shown.map((at) => Array.from(at.toArray())),
    pathPoints: count,
    drawn: () => (renderer ? renderer.info.render.triangles : 0),
  };
})();
