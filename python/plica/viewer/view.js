"use strict";
/* The page of a run: `page` has its data (plica/viewer/page.py), `vendor` three.js and uPlot. Lengths are in mm. */

const by = id => document.getElementById(id);
const PHASES = page.time.length;
const LASTING = 2000, SLOWEST = 250, FASTEST = 30;  // ms: of all phases when they are played, and of one of them
const SAME = 1e-5;  // ms, round-off of times
const FINER = 2;  // pixels drawn for one shown: smooths edges, also those of a cut
const MARGIN = 1.12;  // of the view around the tissue
const HIDDEN_WITHIN = 30;  // px from the middle, where the name of a direction says nothing
const BENEATH = 0x9a5a50, STEADY = 0.4;  // colour of what is cut; share of light that comes from all sides
const AXES = ["x", "y", "z"];
let phase = 0, playing = 0, chosen = 0;
let larynx = null;  // what is drawn in three dimensions, once there is something

/** A number with three digits, without powers of ten where it is of usual size. */
function said(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e5 ? String(+value.toPrecision(3)) : value.toExponential(2);
}

// ---- The phase

function show(k) {
  phase = Math.min(Math.max(k, 0), PHASES - 1);
  by("phase").value = phase;
  const t = page.time[phase], [begin, end] = page.cycle ?? [];
  const share = page.cycle ? `, ${((t - begin) / (end - begin)).toFixed(2)} of the period` : "";
  by("label").textContent = `${t.toFixed(2)} ms${share}`;
  curves.forEach(curve => curve.mark());
  larynx?.move();
}

function play(on) {
  clearInterval(playing);
  const each = Math.min(Math.max(LASTING / PHASES, FASTEST), SLOWEST);
  playing = on ? setInterval(() => show((phase + 1) % PHASES), each) : 0;
  by("play").textContent = on ? "Stop" : "Play";
  by("play").setAttribute("aria-pressed", String(on));
}

// ---- Waveforms

/** The place of the largest entry of rising numbers that is not above a value. */
function before(numbers, value) {
  let [low, high] = [0, numbers.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (numbers[middle] <= value) low = middle; else high = middle - 1;
  }
  return low;
}

/** The place of the entry of rising numbers that is nearest to a value. */
function nearest(numbers, value) {
  const k = before(numbers, value);
  return k + 1 < numbers.length && numbers[k + 1] - value < value - numbers[k] ? k + 1 : k;
}

class Curve {
  constructor({ name, unit, values }, last) {
    Object.assign(this, { name, unit, values });
    const figure = document.createElement("div"), ink = getComputedStyle(document.body).color;
    this.text = document.createElement("p");
    figure.className = "curve";
    figure.append(this.text);
    by("curves").append(figure);
    const grid = { stroke: "rgba(128, 128, 128, 0.25)" };
    const axis = { stroke: ink, grid, ticks: grid };
    this.plot = new vendor.uPlot({
      ...this.size(last),
      cursor: { show: false },
      legend: { show: false },
      scales: { x: { time: false, range: [page.time[0], page.time[PHASES - 1]] } },
      series: [{}, { stroke: "#3b82c4", width: 1.5, points: { show: false } }],
      axes: [{ ...axis, size: last ? 44 : 8, label: last ? "time (ms)" : undefined, labelSize: 18,
        values: (plot, places) => places.map(place => last ? String(+place.toFixed(4)) : "") },
        { ...axis, size: 70, label: unit, labelSize: 20 }],
      hooks: { draw: [plot => this.line(plot)] },
    }, [page.waves.time, values], figure);
    this.last = last;
    const go = event => show(nearest(page.time, this.timeAt(event)));
    this.plot.over.addEventListener("pointerdown", event => {
      if (event.button) return;
      this.plot.over.setPointerCapture(event.pointerId);
      go(event);
    });
    this.plot.over.addEventListener("pointermove", event => { if (event.buttons & 1) go(event); });
  }

  size(last) { return { width: by("curves").clientWidth, height: last ? 150 : 114 }; }

  timeAt(event) { return this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x"); }

  line(plot) {
    const x = plot.valToPos(page.time[phase], "x", true), { top, height } = plot.bbox, pen = plot.ctx;
    pen.save();
    pen.strokeStyle = "#d2603a";
    pen.lineWidth = 2 * devicePixelRatio;
    pen.beginPath(); pen.moveTo(x, top); pen.lineTo(x, top + height); pen.stroke();
    pen.restore();
  }

  mark() {
    const at = nearest(page.waves.time, page.time[phase]), value = this.values[at];
    const has = value !== null && Math.abs(page.waves.time[at] - page.time[phase]) < SAME;  // none is of t = 0
    this.text.textContent = `${this.name}: ${has ? `${said(value)} ${this.unit}` : "–"}`;
    this.plot.redraw(false);
  }
}

const curves = page.waves.curves.map((curve, k, all) => new Curve(curve, k === all.length - 1));

// ---- What was packed (plica/viewer/packing.py)

/** Bytes of an array that was compressed. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Sums from phase to phase of differences, that wrap round. */
function summed(values, each) {
  for (let k = each; k < values.length; k++) values[k] += values[k - each];
  return values;
}

async function unpackedMotion() {
  const halves = new Uint8Array(await unpacked(page.motion)), count = halves.length / 2;
  const found = new Int16Array(count);
  for (let k = 0; k < count; k++) found[k] = halves[k] | halves[count + k] << 8;
  return summed(found, 3 * page.nodes);
}

async function unpackedLevels({ levels }) {
  return summed(new Uint8Array(await unpacked(levels)), page.nodes);
}

// ---- The surface

class Larynx {
  constructor(points, triangles, motion, levels) {
    const { AmbientLight, BackSide, BufferAttribute, BufferGeometry, Color, DirectionalLight, Mesh,
      MeshBasicMaterial, MeshLambertMaterial, OrbitControls, OrthographicCamera, Scene, Vector3, WebGLRenderer } = vendor;
    Object.assign(this, { points, motion, levels });
    this.renderer = new WebGLRenderer({ canvas: by("picture"), alpha: true });
    this.renderer.localClippingEnabled = true;
    this.colours = new Float32Array(page.colours.length);  // linear, as three.js reckons
    for (let k = 0; k < page.colours.length; k += 3) {
      const [red, green, blue] = page.colours.slice(k, k + 3).map(value => value / 255);
      new Color().setRGB(red, green, blue, "srgb").toArray(this.colours, k);
    }
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute("position", new BufferAttribute(points.slice(), 3));
    this.geometry.setAttribute("color", new BufferAttribute(new Float32Array(points.length), 3));
    this.geometry.setIndex(new BufferAttribute(triangles, 1));
    this.low = [0, 1, 2].map(axis => points.reduce((least, x, k) => k % 3 === axis ? Math.min(least, x) : least, Infinity));
    this.high = [0, 1, 2].map(axis => points.reduce((most, x, k) => k % 3 === axis ? Math.max(most, x) : most, -Infinity));
    // The skin is closed: where its inside is seen there is tissue that was cut, and it is filled with one colour.
    this.front = new MeshLambertMaterial({ vertexColors: true });
    this.inside = new MeshBasicMaterial({ color: BENEATH, side: BackSide });
    this.scene = new Scene();
    for (const material of [this.front, this.inside]) {
      const mesh = new Mesh(this.geometry, material);
      mesh.frustumCulled = false;  // its nodes move
      this.scene.add(mesh);
    }
    this.lamp = new DirectionalLight(0xffffff, Math.PI * (1 - STEADY));
    this.scene.add(new AmbientLight(0xffffff, Math.PI * STEADY), this.lamp, this.lamp.target);
    this.camera = new OrthographicCamera();
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.middle = new Vector3(...this.low.map((low, axis) => (low + this.high[axis]) / 2));
    if (page.canal) this.middle.z = (page.canal[0] + page.canal[1]) / 2;
    this.names = this.directions().map(([text, x, y, z]) => {
      const span = document.createElement("span");
      span.textContent = text;
      by("stage").append(span);
      return { span, at: new Vector3(x, y, z) };
    });
    new ResizeObserver(() => this.fit()).observe(by("stage"));
  }

  /** The size of the tissue along an axis, mm. */
  extent(axis) { return this.high[axis] - this.low[axis]; }

  /** Names of directions and the places where they stand: beside the tissue. */
  directions() {
    const s = page.sides, reach = axis => 0.5 * MARGIN * this.extent(axis), { x, y, z } = this.middle;
    const names = s ? [["right", "left"], ["front", "back"], ["top", "bottom"]] : AXES.map(axis => [axis, `−${axis}`]);
    const sign = [s || 1, s || 1, 1];
    return names.flatMap((pair, axis) => pair.map((text, k) => {
      const place = [x, y, z];
      place[axis] += (k ? -1 : 1) * sign[axis] * reach(axis);
      return [text, ...place];
    }));
  }

  look(x, y, z) {
    const far = 4 * Math.max(...[0, 1, 2].map(axis => this.extent(axis)));
    Object.assign(this.camera, { near: 0.1 * far, far: 3 * far, zoom: 1 });
    this.camera.position.set(x, y, z).normalize().multiplyScalar(far).add(this.middle);
    this.controls.target.copy(this.middle);
    this.fit();
    this.controls.update();
    this.draw();
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = by("stage");
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.max(devicePixelRatio, FINER));
    this.renderer.setSize(width, height, false);
    const sizes = [0, 1, 2].map(axis => this.extent(axis));
    if (page.canal) sizes.pop();  // a larynx is higher than what vibrates in it
    const half = 0.5 * MARGIN * Math.max(...sizes) * Math.max(1, height / width);
    const wide = half * width / height;
    Object.assign(this.camera, { left: -wide, right: wide, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** To the phase that is shown. */
  move() {
    const position = this.geometry.attributes.position, { array } = position, first = phase * array.length;
    for (let k = 0; k < array.length; k++) array[k] = this.points[k] + page.level * this.motion[first + k];
    position.needsUpdate = true;
    this.geometry.computeVertexNormals();
    this.colour();
  }

  /** Both folds, or one; the triangles of the left come first. */
  only(fold) {
    const left = 3 * page.left;
    this.geometry.setDrawRange(fold === "right" ? left : 0, fold === "left" ? left : Infinity);
    this.draw();
  }

  colour() {
    const colour = this.geometry.attributes.color, { array } = colour, first = phase * page.nodes;
    const levels = this.levels[chosen];
    for (let k = 0; k < page.nodes; k++) {
      const at = 3 * levels[first + k];
      array.set(this.colours.subarray(at, at + 3), 3 * k);
    }
    colour.needsUpdate = true;
    this.draw();
  }

  draw() {
    this.lamp.position.set(-0.3, 0.4, 1).applyQuaternion(this.camera.quaternion).add(this.controls.target);
    this.lamp.target.position.copy(this.controls.target);
    this.renderer.render(this.scene, this.camera);
    const { clientWidth: width, clientHeight: height } = by("stage");
    for (const { span, at } of this.names) {
      const { x, y } = at.clone().project(this.camera);
      const [right, down] = [0.5 * width * Math.min(Math.max(x, -0.93), 0.93), -0.5 * height * Math.min(Math.max(y, -0.95), 0.95)];
      span.hidden = Math.hypot(right, down) < HIDDEN_WITHIN;
      span.style.left = `${0.5 * width + right}px`;
      span.style.top = `${0.5 * height + down}px`;
    }
    const pixels = this.camera.zoom * width / (this.camera.right - this.camera.left);  // of a mm
    const length = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find(mm => mm * pixels > 60) ?? 200;
    by("bar").style.width = `${length * pixels}px`;
    by("bar").textContent = `${length} mm`;
  }
}

// ---- What the user does

function choose(k) {
  chosen = k;
  const { largest, unit, meaning } = page.quantities[k];
  by("least").textContent = `0 ${unit}`;
  by("middle").textContent = largest ? `${said(largest / 2)} ${unit}` : "";
  by("largest").textContent = largest ? `${said(largest)} ${unit}` : "nowhere any";
  by("meaning").textContent = meaning;
  larynx?.colour();
}

function addQuantities() {
  page.quantities.forEach(({ name }, k) => {
    const label = document.createElement("label"), button = document.createElement("input");
    Object.assign(button, { type: "radio", name: "quantity", value: name, checked: !k });
    button.addEventListener("change", () => choose(k));
    label.append(button, ` ${name}`);
    by("quantities").append(label);
  });
  const stops = [];
  for (let k = 0; k < page.colours.length; k += 3) stops.push(`rgb(${page.colours.slice(k, k + 3)})`);
  by("colours").style.background = `linear-gradient(to right, ${stops})`;
  choose(0);
  by("folds")?.addEventListener("change", event => larynx.only(event.target.value));
}

/** The rows of the planes that cut; what is on the far side of the place is cut away, or flipped, on the near one. */
function addCuts() {
  const rows = AXES.map((axis, k) => {
    const row = document.createElement("div"), [low, high] = [larynx.low[k], larynx.high[k]];
    row.className = "row cut";
    row.innerHTML = `<label><input type="checkbox" id="cut-${axis}"> ${axis} <span>&gt;</span></label>`
      + `<input type="range" id="at-${axis}" min="${low}" max="${high}" step="${(high - low) / 400}" aria-label="place of the cut in ${axis}">`
      + `<output></output> <label><input type="checkbox" id="flip-${axis}"> flip</label>`;
    by("cuts").append(row);
    row.addEventListener("input", event => {
      if (event.target.type === "range") by(`cut-${axis}`).checked = true;
      cut();
    });
    return row;
  });
  const start = page.canal ? 2 * page.canal[1] - page.canal[0] : larynx.high[2];  // above the glottal canal, by its height
  AXES.forEach((axis, k) => { by(`at-${axis}`).value = k === 2 ? start : larynx.middle.getComponent(k); });
  by("cut-z").checked = Boolean(page.canal);
  const cut = () => {
    const planes = [];
    AXES.forEach((axis, k) => {
      const place = +by(`at-${axis}`).value, keep = by(`flip-${axis}`).checked ? 1 : -1;
      rows[k].querySelector("label span").textContent = keep > 0 ? "<" : ">";
      rows[k].querySelector("output").textContent = `${place.toFixed(2)} mm`;
      const normal = [0, 0, 0];
      normal[k] = keep;
      if (by(`cut-${axis}`).checked) planes.push(new vendor.Plane(new vendor.Vector3(...normal), -keep * place));
    });
    larynx.front.clippingPlanes = larynx.inside.clippingPlanes = planes;
    larynx.draw();
  };
  cut();
}

function addLooks() {
  const s = page.sides || 1, tilt = 1e-4 * s;  // so that the front is up in views from above
  const looks = [["above", 0, -tilt, 1], ["aslant", -0.35 * s, -0.8 * s, 1], ["front", 0, s, 0], ["back", 0, -s, 0],
    ["left", -s, 0, 0], ["right", s, 0, 0], ["below", 0, -tilt, -1]];
  const names = page.sides ? {} : { front: "+y", back: "−y", left: "−x", right: "+x" };
  for (const [name, x, y, z] of looks) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", id: `from-${name}`, textContent: names[name] ?? name });
    button.addEventListener("click", () => larynx.look(x, y, z));
    by("looks").append(button);
  }
  larynx.look(...looks[1].slice(1));
}

by("phase").addEventListener("input", () => show(+by("phase").value));
by("play").addEventListener("click", () => play(!playing));
document.addEventListener("keydown", event => {
  if (event.altKey || event.ctrlKey || event.metaKey || ["range", "radio"].includes(event.target.type)) return;
  const keys = { ArrowLeft: () => show(phase - 1), ArrowRight: () => show(phase + 1) };
  if (event.target.tagName !== "BUTTON" && event.target.type !== "checkbox") keys[" "] = () => play(!playing);
  if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
});
window.addEventListener("resize", () => curves.forEach(curve => curve.plot.setSize(curve.size(curve.last))));

// ---- At the beginning

/** What this browser lacks; empty where it can draw the surface. */
function missing() {
  const needs = "The waveforms below work without it.";
  if (!document.createElement("canvas").getContext("webgl2"))
    return `The surface is not shown: this browser has no WebGL 2, or it is turned off. Turn it on, or use another browser. ${needs}`;
  if (!("DecompressionStream" in window))
    return `The surface is not shown: this browser has no DecompressionStream, as those before 2023. Use a newer one. ${needs}`;
  return "";
}

function giveUp(text) {
  by("missing").textContent = text;
  by("missing").hidden = false;
  by("stage").hidden = by("tools").hidden = true;
}

async function begin() {
  show(0);
  const lacks = missing();
  if (lacks) return giveUp(lacks);
  const [points, triangles, motion, ...levels] = await Promise.all([
    unpacked(page.points), unpacked(page.triangles), unpackedMotion(), ...page.quantities.map(unpackedLevels)]);
  larynx = new Larynx(new Float32Array(points), new Uint32Array(triangles), motion, levels);
  larynx.fit();
  addQuantities();
  addLooks();
  addCuts();
  show(0);
}

const ready = begin().catch(error => giveUp(`The surface is not shown: ${error.message}. The waveforms below work.`));
