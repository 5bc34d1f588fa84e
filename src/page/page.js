// The panel, the pointer and the keys. Texts of the mesh are set as text, never as HTML.

const told = JSON.parse(document.getElementById("told").textContent);
const $ = (id) => document.getElementById(id);

function make(tag, name, text) {
  const e = document.createElement(tag);
  if (name) e.className = name;
  if (text !== undefined) e.textContent = text;
  return e;
}

const FACES = [
  [125, 171, 222], [245, 184, 115], [145, 201, 143], [199, 163, 219], [242, 219, 128], [122, 201, 201],
  [240, 168, 179], [196, 176, 148], [168, 212, 237], [196, 217, 120], [158, 161, 224], [222, 158, 207],
];
// Where on the scale, and the color there.
const ANGLES = [[0, 191, 13, 38], [10, 242, 115, 51], [20, 252, 217, 115], [30, 158, 214, 148], [60, 64, 133, 204]];
const LENGTHS = [[0, 54, 62, 149], [0.5, 116, 173, 209], [1, 240, 240, 225], [1.5, 244, 140, 80], [2, 165, 20, 38]];
// A list of more rows than this is cut; the filter finds the others.
const ROWS = 500;

const camera = { target: [0, 0, 0], yaw: 0.6, pitch: 0.5, reach: 1.1 };
const state = {
  mode: MODE.face, range: [0, 1], wire: false, sharp: true, cutting: false, plane: [0, 0, 0, 1],
  ink: [0.1, 0.12, 0.16], inside: [0.66, 0.61, 0.6], hot: [0.76, 0.09, 0.36], marks: [], mark: -1, ratio: 1,
};
const shown = told.faces.map(() => true);
const boxes = new Map();
let scene, mesh, values, hot = -1, waiting = false;

const unit = told.units ? " " + told.units : "";
const short = (x) => (x === 0 ? "0" : Math.abs(x) >= 1e-3 && Math.abs(x) < 1e6 ? String(+x.toPrecision(4)) : x.toExponential(2));

// ---- what is told in words

function words() {
  document.title = told.title;
  $("title").textContent = $("title").title = told.title;
  const bad = told.lines.filter((l) => l.kind === "shortfall").length;
  const verdict = $("verdict");
  if (told.sound !== null) {
    verdict.textContent = (told.sound ? "Sound" : "Not sound") + (bad ? `; falls short in ${bad} ${bad > 1 ? "ways" : "way"}` : told.sound ? ", nothing falls short" : "");
    verdict.className = told.sound && !bad ? "good" : "bad";
  }
  for (const line of told.lines) $("places").append(lineOf(line));
  $("places-box").hidden = !told.lines.length;
  for (const sentence of told.certificate) $("certificate").append(make("li", "", sentence));
  $("certificate-box").hidden = !told.certificate.length;
  for (const { name, value } of told.facts) {
    const row = $("facts").insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
  }
}

// Coordinates in a text, as warnings have them: three numbers in parentheses.
function coordinates(text) {
  const number = "(-?\\d[\\d.]*(?:e[-+]?\\d+)?)";
  const found = text.matchAll(new RegExp(`\\(${number}, ${number}, ${number}\\)`, "gi"));
  return [...found].map((m) => m.slice(1).map(Number)).filter((p) => p.every(Number.isFinite));
}

function lineOf(line) {
  const places = line.places.length ? line.places : coordinates(line.text);
  const item = make("li", line.kind), e = make(places.length ? "button" : "div", "line");
  e.append(make("span", "what", line.kind), make("span", "", line.text));
  if (places.length) {
    const go = make("span", "go", places.length > 1 ? ` → ${places.length} places` : " → show");
    e.append(go);
    let next = 0;
    e.addEventListener("click", () => {
      if (!scene) return;
      for (const c of document.querySelectorAll("#places .current")) c.classList.remove("current");
      e.classList.add("current");
      state.marks = places.map(mesh.drawn);
      state.mark = next;
      flyTo(state.marks[next]);
      next = (next + 1) % places.length;
      if (places.length > 1) go.textContent = ` → place ${state.mark + 1} of ${places.length}`;
    });
  }
  item.append(e);
  return item;
}

// ---- faces and groups

const colorOf = (f) => FACES[f % FACES.length];

function look() {
  if (!scene) return;
  const out = new Uint8Array(4 * told.faces.length);
  told.faces.forEach((_, f) => out.set([...colorOf(f), !shown[f] ? 0 : f === hot ? 128 : 255], 4 * f));
  scene.setLook(out);
  redraw();
}

function row(name, triangles, area, color, change) {
  const item = make("li"), label = make("label"), box = make("input");
  box.type = "checkbox";
  box.checked = true;
  box.addEventListener("change", () => change(box.checked));
  const swatch = make("span", "swatch");
  if (color) swatch.style.background = `rgb(${color})`; else swatch.style.visibility = "hidden";
  const text = make("span", "name", name), count = make("span", "count", String(triangles));
  text.title = name;
  count.title = `${triangles} triangles`;
  const size = make("span", "area", short(area));
  size.title = `area ${area}${told.units ? ` ${told.units}²` : ""}`;
  label.append(box, swatch, text, count, size);
  item.append(label);
  return { item, box };
}

function listFaces() {
  const filter = $("filter").value.toLowerCase(), list = $("faces");
  list.textContent = "";
  boxes.clear();
  let left = 0;
  told.faces.forEach((face, f) => {
    if (!face.name.toLowerCase().includes(filter)) return;
    if (boxes.size >= ROWS) { left++; return; }
    const { item, box } = row(face.name, face.triangles, face.area, colorOf(f), (on) => { shown[f] = on; look(); });
    box.checked = shown[f];
    item.addEventListener("pointerenter", () => { hot = f; look(); });
    item.addEventListener("pointerleave", () => { hot = -1; look(); });
    boxes.set(f, box);
    list.append(item);
  });
  if (left) list.append(make("li", "count", `${left} more; type part of a name`));
  $("face-count").textContent = `${told.faces.length}, with triangles and area`;
}

function setFaces(faces, on) {
  for (const f of faces) {
    shown[f] = on;
    if (boxes.has(f)) boxes.get(f).checked = on;
  }
  look();
}

function listGroups() {
  $("groups-box").hidden = !told.groups.length;
  for (const g of told.groups) {
    const sum = (what) => g.faces.reduce((s, f) => s + told.faces[f][what], 0);
    $("groups").append(row(g.name, sum("triangles"), sum("area"), null, (on) => setFaces(g.faces, on)).item);
  }
}

// ---- colors

function rampOf(stops) {
  const out = new Uint8Array(4 * 256), last = stops.length - 1;
  for (let i = 0; i < 256; i++) {
    const x = stops[0][0] + (stops[last][0] - stops[0][0]) * i / 255;
    const k = Math.min(last - 1, Math.max(0, stops.findIndex((s) => s[0] > x) - 1)), [a, b] = [stops[k], stops[k + 1]];
    const s = x >= stops[last][0] ? 1 : (x - a[0]) / (b[0] - a[0]);
    const at = x >= stops[last][0] ? stops[last] : a.map((v, j) => v + s * (b[j] - v));
    out.set([at[1], at[2], at[3], 255], 4 * i);
  }
  return out;
}

function colorBy(what) {
  const legend = $("legend");
  legend.hidden = what === "face";
  state.mode = what === "face" ? MODE.face : MODE.value;
  if (what !== "face") {
    let stops = ANGLES, title = "smallest angle of a triangle", ticks = ["0°", "20°", "40°", "60°"];
    state.range = [0, 60];
    let data = values.angles;
    if (what === "length") {
      stops = LENGTHS;
      data = values.lengths;
      if (told.size) {
        title = "longest edge / size asked for";
        state.range = [0, 2 * told.size];
        ticks = ["0", "0.5", "1", "1.5", "≥ 2"];
      } else {
        const most = data.reduce((m, x) => Math.max(m, x), 0) || 1;
        title = `longest edge${unit}`;
        state.range = [0, most];
        ticks = ["0", short(most / 2), short(most)];
      }
    }
    scene.setValues(data);
    scene.setRamp(rampOf(stops));
    const [lo, hi] = [stops[0][0], stops[stops.length - 1][0]], ramp = make("div", "ramp"), row = make("div", "ticks");
    const colors = stops.map((s) => `rgb(${s.slice(1)}) ${100 * (s[0] - lo) / (hi - lo)}%`);
    ramp.style.background = `linear-gradient(90deg, ${colors})`;
    row.append(...ticks.map((t) => make("span", "", t)));
    legend.replaceChildren(make("div", "", title), ramp, row);
  }
  redraw();
}

function histogram() {
  const bins = new Array(12).fill(0);
  for (const a of values.angles) bins[Math.min(11, Math.floor(a / 5))]++;
  const most = Math.max(1, ...bins), ramp = rampOf(ANGLES);
  bins.forEach((n, i) => {
    const column = make("div"), bar = make("i"), at = 4 * Math.round(255 * (5 * i + 2.5) / 60);
    column.title = `${5 * i}° to ${5 * i + 5}°: ${n} triangles`;
    // few triangles are what one looks for: they are never less than two pixels high
    bar.style.height = n ? `max(2px, ${78 * n / most}px)` : "0";
    bar.style.background = `rgb(${ramp.slice(at, at + 3)})`;
    column.append(bar, make("span", "", i % 2 ? "" : `${5 * i}°`));
    $("histogram").append(column);
  });
}

// ---- drawing

function resize() {
  const canvas = $("view");
  state.ratio = Math.min(2, window.devicePixelRatio || 1);
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * state.ratio));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * state.ratio));
  redraw();
}

function draw() { scene.draw(camera, state); }

function redraw() {
  if (waiting || !scene) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; draw(); });
}

function fit() {
  const { clientWidth: w, clientHeight: h } = $("view");
  return 1.06 * Math.max(1, h / Math.max(1, w));
}

let flight = 0, at_once = false;
function move(to) {
  const from = { ...camera, target: [...camera.target] }, mine = ++flight, start = performance.now();
  // the short way around
  if (to.yaw !== undefined) to.yaw = from.yaw + Math.atan2(Math.sin(to.yaw - from.yaw), Math.cos(to.yaw - from.yaw));
  const set = (s) => {
    for (const k of ["yaw", "pitch"]) if (to[k] !== undefined) camera[k] = from[k] + s * (to[k] - from[k]);
    if (to.reach) camera.reach = from.reach * (to.reach / from.reach) ** s;
    if (to.target) camera.target = from.target.map((x, k) => x + s * (to.target[k] - x));
  };
  if (at_once || matchMedia("(prefers-reduced-motion: reduce)").matches) { set(1); return redraw(); }
  const step = (now) => {
    if (mine !== flight) return;
    const s = Math.min(1, Math.max(0, (now - start) / 400));
    set(s * s * (3 - 2 * s));
    draw();
    if (s < 1) requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
  // a window that is not drawn gets there all the same
  setTimeout(() => { if (mine === flight) { flight++; set(1); redraw(); } }, 500);
}

// Goes to a place, looks at the nearest triangle from outside, a little askew, and shows some triangles around it.
function flyTo(p) {
  const { nodes, corners, labels } = mesh;
  let best = Infinity, near = -1;
  for (let t = 0; t < labels.length; t++) {
    let d = 0;
    for (let k = 0; k < 3; k++) {
      const x = (nodes[3 * corners[3 * t] + k] + nodes[3 * corners[3 * t + 1] + k] + nodes[3 * corners[3 * t + 2] + k]) / 3 - p[k];
      d += x * x;
    }
    if (d < best) { best = d; near = t; }
  }
  const to = { target: p, reach: 0.1 };
  if (near >= 0) {
    const [a, b, c] = [0, 1, 2].map((k) => nodes.subarray(3 * corners[3 * near + k], 3 * corners[3 * near + k] + 3));
    const u = [0, 1, 2].map((k) => b[k] - a[k]), v = [0, 1, 2].map((k) => c[k] - a[k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]], flat = Math.hypot(n[0], n[1]);
    if (flat > 0 || n[2] !== 0) {
      to.pitch = Math.max(-1.4, Math.min(1.4, Math.atan2(n[2], flat) + (n[2] > 0.9 * Math.hypot(...n) ? -0.35 : 0.25)));
      if (flat > 1e-3 * Math.abs(n[2])) to.yaw = Math.atan2(n[1], n[0]) + 0.3;
    }
    to.reach = Math.min(fit(), Math.max(8 * values.lengths[near] / mesh.unit, 2 * Math.sqrt(best), 1e-4));
  }
  move(to);
}

const VIEWS = { iso: [0.6, 0.5], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };
function goto(name) {
  const to = { target: [0, 0, 0], reach: fit() };
  if (VIEWS[name]) [to.yaw, to.pitch] = VIEWS[name];
  move(to);
}

// ---- pointer, touch, keys

const pan = (dx, dy) => {
  const m = turnOf(camera), s = 2 * camera.reach / Math.max(1, $("view").clientHeight);
  camera.target = camera.target.map((x, k) => x - s * (dx * m[3 * k] - dy * m[3 * k + 1]));
};
const turn = (dx, dy) => {
  camera.yaw -= 0.008 * dx;
  camera.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, camera.pitch + 0.008 * dy));
};
// Zooms so that what is under the point stays there.
const zoom = (factor, x, y) => {
  const { clientWidth: w, clientHeight: h } = $("view"), before = camera.reach;
  camera.reach = Math.max(1e-5, Math.min(20, camera.reach * factor));
  const s = 1 - before / camera.reach;
  pan((x - w / 2) * s, (y - h / 2) * s);
};

function pointer() {
  const view = $("view"), down = new Map();
  let asked = null;
  view.addEventListener("contextmenu", (e) => e.preventDefault());
  view.addEventListener("pointerdown", (e) => {
    view.setPointerCapture(e.pointerId);
    down.set(e.pointerId, [e.offsetX, e.offsetY]);
    flight++;
  });
  for (const end of ["pointerup", "pointercancel"]) view.addEventListener(end, (e) => down.delete(e.pointerId));
  view.addEventListener("pointermove", (e) => {
    const before = down.get(e.pointerId), here = [e.offsetX, e.offsetY];
    if (!before) {
      if (!asked) requestAnimationFrame(() => { point(...asked); asked = null; });
      asked = here;
      return;
    }
    const [dx, dy] = [here[0] - before[0], here[1] - before[1]];
    down.set(e.pointerId, here);
    if (down.size === 2) {
      // two fingers: the way of their middle moves, their distance zooms
      const other = [...down].find(([id]) => id !== e.pointerId)[1], gap = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      pan(dx / 2, dy / 2);
      if (gap(here) > 0) zoom(gap(before) / gap(here), (here[0] + other[0]) / 2, (here[1] + other[1]) / 2);
    } else if (e.shiftKey || e.buttons & 6) pan(dx, dy);
    else turn(dx, dy);
    redraw();
  });
  view.addEventListener("pointerleave", () => { $("tip").textContent = ""; });
  view.addEventListener("wheel", (e) => {
    e.preventDefault();
    flight++;
    zoom(Math.exp(Math.max(-100, Math.min(100, e.deltaY)) * 0.002), e.offsetX, e.offsetY);
    redraw();
  }, { passive: false });
  view.addEventListener("keydown", (e) => {
    const way = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[e.key];
    const name = { 0: "iso", 1: "x", 2: "y", 3: "z", f: "fit", F: "fit" }[e.key];
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    if (way) (e.shiftKey ? pan : turn)(...way);
    else if (name) goto(name);
    else if ("+=-".includes(e.key)) zoom(e.key === "-" ? 1.15 : 1 / 1.15, view.clientWidth / 2, view.clientHeight / 2);
    else return;
    e.preventDefault();
    redraw();
  });
}

// Tells the face under a point of the canvas, with its triangle.
function point(x, y) {
  const t = scene.pick(camera, state, Math.floor(x * state.ratio), Math.floor(y * state.ratio));
  const tip = $("tip");
  tip.textContent = t < 0 ? "" : `${told.faces[mesh.labels[t]].name} · triangle ${t} · smallest angle ${values.angles[t].toFixed(1)}°`;
  tip.title = tip.textContent;
  draw();
}

// ---- the rest of the panel

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  state.inside = dark ? [0.5, 0.46, 0.46] : [0.66, 0.61, 0.6];
  // edges lie on light faces in both
  state.ink = [0.1, 0.12, 0.16];
  state.hot = dark ? [1, 0.2, 0.55] : [0.76, 0.05, 0.36];
  redraw();
}

function cut() {
  const axis = $("axis").value, on = axis !== "", sign = $("flip").checked ? -1 : 1;
  $("cut").disabled = $("flip").disabled = !on;
  state.cutting = on;
  state.plane = [0, 0, 0, 1];
  if (on) {
    const half = mesh.half[axis] / mesh.radius * 1.001;
    state.plane[axis] = sign;
    state.plane[3] = sign * half * (2 * $("cut").value / 1000 - 1);
    $("cut").title = short(mesh.told([0, 1, 2].map((k) => (k === +axis ? sign * state.plane[3] : 0)))[axis]) + unit;
  }
  redraw();
}

function panel() {
  const all = told.faces.map((_, f) => f);
  $("all").addEventListener("click", () => setFaces(all, true));
  $("none").addEventListener("click", () => setFaces(all, false));
  $("filter").addEventListener("input", listFaces);
  $("color").addEventListener("change", (e) => colorBy(e.target.value));
  $("sharp").addEventListener("change", (e) => { state.sharp = e.target.checked; redraw(); });
  $("wire").addEventListener("change", (e) => { state.wire = e.target.checked; redraw(); });
  for (const id of ["axis", "cut", "flip"]) $(id).addEventListener("input", cut);
  for (const b of document.querySelectorAll("[data-view]")) b.addEventListener("click", () => goto(b.dataset.view));
  $("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme !== "dark"));
  new ResizeObserver(resize).observe($("view"));
}

// ---- a test of all this in the browser itself, which the project's tests ask for

function selftest() {
  const out = { triangles: mesh.labels.length, edges: scene.edgeCount }, drawn = (r, g, b, a) => a > 0;
  const near = (c) => (r, g, b) => [r, g, b].every((x, k) => Math.abs(x - 255 * c[k]) < 3);
  const count = (what) => { draw(); return scene.count(what); };
  out.pixels = count(drawn);
  out.canvas = $("view").width * $("view").height;
  const middle = [Math.floor($("view").clientWidth / 2), Math.floor($("view").clientHeight / 2)];
  point(...middle);
  out.tip = $("tip").textContent;
  const under = scene.pick(camera, state, ...middle.map((x) => x * state.ratio));
  $("none").click();
  out.none = count(drawn);
  if (under >= 0) {
    boxes.get(mesh.labels[under])?.click();
    out.one = count(drawn);
  }
  $("all").click();
  out.all = count(drawn);
  $("axis").value = "0";
  cut();
  out.cut = count(drawn);
  $("axis").value = "";
  cut();
  out.inks = {};
  state.sharp = false;
  out.inks.without = count(near(state.ink));
  state.sharp = true;
  out.inks.with = count(near(state.ink));
  for (const what of ["angle", "length"]) { colorBy(what); out[what] = count(drawn); }
  colorBy("face");
  out.marks_before = count(near(state.hot));
  const line = document.querySelector("#places button.line");
  if (line) {
    line.click();
    out.target = mesh.told(camera.target);
    out.marks = count(near(state.hot));
  }
  out.error = scene.gl.getError();
  const pre = make("pre", "", JSON.stringify(out));
  pre.id = "selftest";
  document.body.append(pre);
}

// Settings in the address, as in `page.html#?color=angle&wire&dark`: for links and pictures of a page. The question mark
// keeps browsers from scrolling to an element of that name.
function settings() {
  if (!location.hash.startsWith("#?")) return;
  const asked = new URLSearchParams(location.hash.slice(2));
  if (asked.has("dark") || asked.has("light")) theme(asked.has("dark"));
  for (const id of ["color", "axis", "cut"]) if (asked.has(id)) $(id).value = asked.get(id);
  for (const id of ["wire", "flip"]) if (asked.has(id)) $(id).checked = true;
  state.wire = $("wire").checked;
  cut();
  colorBy($("color").value);
  if (asked.has("place")) document.querySelectorAll("#places button.line")[asked.get("place") - 1]?.click();
}

async function start() {
  words();
  const dark = matchMedia("(prefers-color-scheme: dark)");
  theme(dark.matches);
  dark.addEventListener("change", () => theme(dark.matches));
  listFaces();
  listGroups();
  try {
    if (!window.DecompressionStream) throw new Error("no DecompressionStream");
    mesh = await readMesh(told, $("mesh").textContent);
    values = measure(mesh);
    histogram();
    scene = new Scene($("view"), mesh, told.faces.length);
  } catch (e) {
    // The words and figures stay readable without a picture.
    $("trouble").hidden = false;
    $("trouble").textContent = `The mesh cannot be drawn here: this takes a browser with WebGL2 and graphics switched on (${e.message}).`;
    $("tools").hidden = true;
    return;
  }
  panel();
  pointer();
  resize();
  camera.reach = fit();
  look();
  // what is asked for in the address is there from the beginning
  at_once = true;
  settings();
  if (location.hash === "#selftest") selftest();
  at_once = false;
}
const started = start();
