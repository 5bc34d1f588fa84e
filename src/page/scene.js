"use strict";
// Reads the mesh and draws it. Nothing here knows the panel.

// Reads the element's base64, inflates it and gives nodes, corners, labels and edges in flat arrays. Nodes are moved to
// the middle of the box and scaled to a radius of one, as graphics cards count in 32 bits.
async function readMesh(told, text) {
  const packed = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let at = 0;
  const number = () => {
    let n = 0, scale = 1;
    for (;;) {
      const b = bytes[at++];
      n += (b & 127) * scale;
      if (b < 128) return n;
      scale *= 128;
    }
  };
  // the sign is the lowest bit; no shifts, as differences may need more than 31 bits
  const signed = () => { const n = number(); return n % 2 ? -(n + 1) / 2 : n / 2; };
  const mesh = {
    nodes: new Float32Array(3 * told.node_count),
    corners: new Uint32Array(3 * told.triangle_count),
    labels: new Uint32Array(told.triangle_count),
    edges: new Uint32Array(5 * told.edge_count),
  };
  const steps = new Float64Array(3 * told.node_count), most = [0, 0, 0];
  for (let axis = 0; axis < 3; axis++) {
    for (let i = 0, last = 0; i < told.node_count; i++) {
      last += signed();
      steps[3 * i + axis] = last;
      if (last > most[axis]) most[axis] = last;
    }
  }
  mesh.half = most.map((m) => m / 2);
  mesh.radius = Math.hypot(...mesh.half) || 1;
  for (let i = 0; i < steps.length; i++) mesh.nodes[i] = (steps[i] - mesh.half[i % 3]) / mesh.radius;
  // a length of the part, and a place in it, as they are drawn
  mesh.unit = told.step * mesh.radius;
  mesh.drawn = (p) => p.map((x, k) => ((x - told.lo[k]) / told.step - mesh.half[k]) / mesh.radius);
  mesh.told = (p) => p.map((x, k) => (x * mesh.radius + mesh.half[k]) * told.step + told.lo[k]);
  for (let i = 0, last = 0; i < mesh.corners.length; i++) mesh.corners[i] = last += signed();
  for (let t = 0; t < told.triangle_count;) {
    const label = number(), run = number();
    mesh.labels.fill(label, t, t += run);
  }
  for (let e = 0, last = 0; e < told.edge_count; e++) {
    mesh.edges[5 * e] = last += signed();
    mesh.edges[5 * e + 1] = last += signed();
    for (let k = 2; k < 5; k++) mesh.edges[5 * e + k] = number();
  }
  return mesh;
}

// Smallest angle in degrees and longest edge in the part's unit of every triangle.
function measure(mesh) {
  const n = mesh.labels.length, angles = new Float32Array(n), lengths = new Float32Array(n);
  const p = mesh.nodes, c = mesh.corners;
  const side = (i, j) => Math.hypot(p[3 * i] - p[3 * j], p[3 * i + 1] - p[3 * j + 1], p[3 * i + 2] - p[3 * j + 2]);
  for (let t = 0; t < n; t++) {
    const [x, y, z] = [side(c[3 * t], c[3 * t + 1]), side(c[3 * t + 1], c[3 * t + 2]), side(c[3 * t + 2], c[3 * t])].sort((a, b) => a - b);
    const cosine = (y * y + z * z - x * x) / (2 * y * z);
    angles[t] = y > 0 ? Math.acos(Math.min(1, Math.max(-1, cosine))) * 180 / Math.PI : 0;
    lengths[t] = z * mesh.unit;
  }
  return { angles, lengths };
}

// All vertex data lie in textures and are fetched by number: a triangle costs 16 bytes and a node 12, and every corner
// knows its whole triangle, which flat shading and edges need.
const FETCH = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D; precision highp sampler2D;
uniform sampler2D nodes, values, faceLook; uniform usampler2D corners, edges;
uniform vec3 target; uniform mat3 turn; uniform vec2 scale, shift; uniform float depth; uniform vec4 plane;
vec4 at(sampler2D s, int i) { int w = textureSize(s, 0).x; return texelFetch(s, ivec2(i % w, i / w), 0); }
uvec4 at(usampler2D s, int i) { int w = textureSize(s, 0).x; return texelFetch(s, ivec2(i % w, i / w), 0); }
vec4 placed(vec3 p) { vec3 v = turn * (p - target); return vec4(v.xy * scale + shift, -v.z * depth, 1.0); }
const vec4 NOWHERE = vec4(2.0, 2.0, 2.0, 1.0);
`;
const FACES_VERTEX = FETCH + `
flat out vec3 normal; flat out vec4 look; flat out float value; flat out uint number; out vec3 weights; out float beyond;
void main() {
  int t = gl_VertexID / 3, k = gl_VertexID % 3;
  uvec4 c = at(corners, t);
  look = at(faceLook, int(c.w)); // color of the face; alpha 0 is hidden, 1 is shown, half is pointed at
  vec3 a = at(nodes, int(c.x)).xyz, b = at(nodes, int(c.y)).xyz, d = at(nodes, int(c.z)).xyz;
  vec3 p = k == 0 ? a : k == 1 ? b : d;
  normal = turn * cross(b - a, d - a);
  value = at(values, t).x; number = uint(t) + 1u;
  weights = vec3(k == 0, k == 1, k == 2);
  beyond = dot(plane.xyz, p) - plane.w;
  gl_Position = look.a == 0.0 ? NOWHERE : placed(p);
}`;
const FACES_FRAGMENT = `#version 300 es
precision highp float; precision highp int;
flat in vec3 normal; flat in vec4 look; flat in float value; flat in uint number; in vec3 weights; in float beyond;
uniform sampler2D ramp; uniform vec2 range; uniform int mode; uniform bool wire, cutting; uniform vec3 inside, ink;
out vec4 color;
void main() {
  if (beyond > 0.0) discard;
  if (mode == 2) { color = vec4(number & 255u, number >> 8 & 255u, number >> 16 & 255u, number >> 24) / 255.0; return; }
  vec3 base = mode == 0 ? look.rgb : texture(ramp, vec2(clamp((value - range.x) / (range.y - range.x), 0.0, 1.0), 0.5)).rgb;
  vec3 n = dot(normal, normal) > 0.0 ? normalize(normal) : vec3(0.0, 0.0, 1.0);
  if (!gl_FrontFacing) { n = -n; base = inside; }
  // a key light from above left, a weak one from the right, and light from all around that is weaker below
  float light = 0.54 + 0.07 * n.y + 0.42 * max(dot(n, normalize(vec3(-0.4, 0.5, 0.8))), 0.0) + 0.16 * max(dot(n, normalize(vec3(0.8, -0.1, 0.4))), 0.0);
  // what is seen through a cut is the inside: with little light of its own it looks like the section
  if (!gl_FrontFacing && cutting) light = 0.78 + 0.2 * n.z;
  vec3 shade = base * light;
  if (look.a < 0.9) shade = mix(shade, vec3(1.0, 1.0, 1.0), 0.28);
  if (wire) {
    vec3 w = weights / max(fwidth(weights), vec3(1e-6));
    // triangles of a few pixels would be all edge
    float fine = max(fwidth(weights.x), max(fwidth(weights.y), fwidth(weights.z)));
    shade = mix(shade, ink, 0.55 * clamp(1.4 - 2.0 * fine, 0.25, 1.0) * (1.0 - smoothstep(0.3, 1.1, min(w.x, min(w.y, w.z)))));
  }
  color = vec4(shade, 1.0);
}`;
// Lines of more than one pixel are not to be had, so each is a narrow rectangle of two triangles.
const LINES_VERTEX = FETCH + `
uniform vec2 pixel; uniform float width; uniform vec3 ink;
flat out vec3 tint; out float beyond;
void main() {
  int e = gl_VertexID / 6, k = gl_VertexID % 6;
  uvec4 l = at(edges, e);
  uint why = l.w >> 30;
  tint = why >= 2u ? vec3(0.86, 0.08, 0.12) : ink;
  bool seen = at(faceLook, int(l.z)).a > 0.0 || at(faceLook, int(l.w & 0x3fffffffu)).a > 0.0;
  vec3 a = at(nodes, int(l.x)).xyz, b = at(nodes, int(l.y)).xyz;
  bool end = k == 1 || k == 2 || k == 4;
  vec4 p = placed(a), q = placed(b), here = end ? q : p;
  vec2 along = (q.xy - p.xy) / pixel;
  vec2 across = length(along) > 0.0 ? normalize(vec2(-along.y, along.x)) : vec2(0.0);
  here.xy += across * pixel * (why >= 2u ? 2.0 : 1.0) * width * (k == 0 || k == 1 || k == 3 ? 0.5 : -0.5);
  here.z -= 0.0006;
  beyond = dot(plane.xyz, end ? b : a) - plane.w;
  gl_Position = seen ? here : NOWHERE;
}`;
const LINES_FRAGMENT = `#version 300 es
precision highp float;
flat in vec3 tint; in float beyond; out vec4 color;
void main() { if (beyond > 0.0) discard; color = vec4(tint, 1.0); }`;
const MARKS_VERTEX = FETCH + `
uniform vec3 mark; uniform float size;
void main() { gl_Position = placed(mark); gl_Position.z = -0.999; gl_PointSize = size; }`;
const MARKS_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 ink; out vec4 color;
void main() {
  float r = length(gl_PointCoord - 0.5) * 2.0;
  if (r > 1.0 || (r > 0.25 && r < 0.66)) discard;
  // a white rim keeps it apart from any color
  color = vec4(r > 0.88 ? vec3(1.0) : ink, 1.0);
}`;

const MODE = { face: 0, value: 1, pick: 2 };

class Scene {
  constructor(canvas, mesh, faceCount) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: false });
    if (!gl) throw new Error("no WebGL2");
    Object.assign(this, { gl, canvas, mesh, width: Math.min(4096, gl.getParameter(gl.MAX_TEXTURE_SIZE)) });
    this.faces = this.program(FACES_VERTEX, FACES_FRAGMENT);
    this.lines = this.program(LINES_VERTEX, LINES_FRAGMENT);
    this.marks = this.program(MARKS_VERTEX, MARKS_FRAGMENT);
    const n = mesh.labels.length, corners = new Uint32Array(4 * n);
    for (let t = 0; t < n; t++) corners.set([mesh.corners[3 * t], mesh.corners[3 * t + 1], mesh.corners[3 * t + 2], mesh.labels[t]], 4 * t);
    this.edgeCount = mesh.edges.length / 5;
    const edges = new Uint32Array(4 * this.edgeCount);
    for (let e = 0; e < this.edgeCount; e++) {
      const [a, b, f, g, why] = mesh.edges.subarray(5 * e, 5 * e + 5);
      edges.set([a, b, f, (g | why << 30) >>> 0], 4 * e);
    }
    this.textures = {
      nodes: this.texture(mesh.nodes, 3, gl.RGB32F, gl.RGB, gl.FLOAT),
      corners: this.texture(corners, 4, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT),
      edges: this.texture(edges, 4, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT),
      values: this.texture(new Float32Array(n), 1, gl.R32F, gl.RED, gl.FLOAT),
      faceLook: this.texture(new Uint8Array(4 * faceCount), 4, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE),
      ramp: this.texture(new Uint8Array(4), 4, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE),
    };
    // picking draws the one pixel under the pointer, numbers for colors
    this.picked = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.picked);
    for (const [where, what] of [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]]) {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, what, 1, 1);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, where, gl.RENDERBUFFER, buffer);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindVertexArray(gl.createVertexArray());
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const u = gl.getActiveUniform(program, i);
      uniforms[u.name] = { type: u.type, place: gl.getUniformLocation(program, u.name) };
    }
    return { program, uniforms };
  }

  // A row of numbers in lines of one width: a texture cannot be as long as the row.
  texture(data, parts, inner, format, type) {
    const gl = this.gl, texture = gl.createTexture(), count = data.length / parts;
    const width = Math.max(1, Math.min(this.width, count)), height = Math.max(1, Math.ceil(count / width));
    const whole = new data.constructor(width * height * parts);
    whole.set(data);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, format, type, whole);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) {
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
    return texture;
  }

  replace(name, ...args) {
    this.gl.deleteTexture(this.textures[name]);
    this.textures[name] = this.texture(...args);
  }

  setValues(values) { this.replace("values", values, 1, this.gl.R32F, this.gl.RED, this.gl.FLOAT); }
  setLook(look) { this.replace("faceLook", look, 4, this.gl.RGBA8, this.gl.RGBA, this.gl.UNSIGNED_BYTE); }
  setRamp(ramp) { this.replace("ramp", ramp, 4, this.gl.RGBA8, this.gl.RGBA, this.gl.UNSIGNED_BYTE); }

  use({ program, uniforms }, given) {
    const gl = this.gl;
    gl.useProgram(program);
    let unit = 0;
    for (const [name, { type, place }] of Object.entries(uniforms)) {
      const value = given[name];
      if (name in this.textures) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, this.textures[name]);
        gl.uniform1i(place, unit++);
      } else if (type === gl.FLOAT) gl.uniform1f(place, value);
      else if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, value);
      else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, value);
      else if (type === gl.FLOAT_VEC4) gl.uniform4fv(place, value);
      else if (type === gl.FLOAT_MAT3) gl.uniformMatrix3fv(place, false, value);
      else gl.uniform1i(place, value);
    }
  }

  // What all programs are given. Half a window's height shows `camera.reach`; the projection is parallel.
  given(camera, state) {
    const { width, height } = this.canvas, aspect = width / height, y = 1 / camera.reach;
    // Everything within the model's radius around its middle has to be in front and behind.
    return { ...state, target: camera.target, turn: turnOf(camera), scale: [y / aspect, y], shift: [0, 0], depth: 1 / (1.05 + Math.hypot(...camera.target)) };
  }

  draw(camera, state) {
    const gl = this.gl, given = this.given(camera, state);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    this.use(this.faces, given);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * this.mesh.labels.length);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (state.sharp && this.edgeCount) {
      const pixel = [2 / this.canvas.width, 2 / this.canvas.height];
      this.use(this.lines, { ...given, pixel, width: 1.4 * state.ratio });
      gl.drawArrays(gl.TRIANGLES, 0, 6 * this.edgeCount);
    }
    gl.disable(gl.DEPTH_TEST);
    for (const [i, mark] of state.marks.entries()) {
      this.use(this.marks, { ...given, mark, ink: state.hot, size: (i === state.mark ? 26 : 14) * state.ratio });
      gl.drawArrays(gl.POINTS, 0, 1);
    }
  }

  // The number of the triangle under a pixel of the canvas, or -1.
  pick(camera, state, x, y) {
    const gl = this.gl, given = this.given(camera, { ...state, mode: MODE.pick, wire: false });
    const { width, height } = this.canvas;
    given.scale = [given.scale[0] * width, given.scale[1] * height];
    given.shift = [width - 2 * x - 1, 2 * y + 1 - height];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.picked);
    gl.viewport(0, 0, 1, 1);
    gl.clearColor(0, 0, 0, 0);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.use(this.faces, given);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * this.mesh.labels.length);
    const p = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return p[0] + 256 * (p[1] + 256 * (p[2] + 256 * p[3])) - 1;
  }

  // How many pixels of the last drawing satisfy `what`; to be asked in the same task as the drawing.
  count(what) {
    const gl = this.gl, { width, height } = this.canvas, p = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, p);
    let n = 0;
    for (let i = 0; i < p.length; i += 4) if (what(p[i], p[i + 1], p[i + 2], p[i + 3])) n++;
    return n;
  }
}

// The rotation of a camera, columns first: z is up, `yaw` turns around it, `pitch` is how far one looks down.
function turnOf({ yaw, pitch }) {
  const [s, c, t, d] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  const right = [-s, c, 0], up = [-c * t, -s * t, d], back = [c * d, s * d, t];
  return [0, 1, 2].flatMap((k) => [right[k], up[k], back[k]]);
}
