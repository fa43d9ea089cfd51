// A part on the plate that can be turned: WebGL, or a 2-D canvas where there is none.
"use strict";
(function () {
  const canvas = document.getElementById("view");
  const source = document.getElementById("part-data");
  if (!canvas || !source) return;
  const data = JSON.parse(source.textContent);
  const CREASE = Math.cos(25 * Math.PI / 180), WIDTH = 3.1;
  const LIGHT = unit([-0.25, -0.5, 0.8]), PART = [0.42, 0.64, 0.92];
  const state = { pose: 0, azimuth: -62, elevation: 22, zoom: 1 };

  function bytes(text) {
    const raw = atob(text), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }
  function unit(v) { const n = Math.hypot(v[0], v[1], v[2]) || 1; return v.map(x => x / n); }
  function cross(a, b) {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  }
  function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  const points = Float32Array.from(new Int16Array(bytes(data.vertices)), x => x / 32767);
  const corners = new (data.wide ? Uint32Array : Uint16Array)(bytes(data.triangles));
  const count = corners.length / 3;
  const point = i => [points[3 * i], points[3 * i + 1], points[3 * i + 2]];
  const normals = [];
  for (let t = 0; t < count; t++) {
    const a = point(corners[3 * t]), b = point(corners[3 * t + 1]), c = point(corners[3 * t + 2]);
    normals.push(unit(cross(b.map((x, k) => x - a[k]), c.map((x, k) => x - a[k]))));
  }
  const lines = creases();

  // Edges between triangles that meet at an angle, or that only one triangle has.
  function creases() {
    const seen = new Map(), found = [];
    for (let t = 0; t < count; t++) {
      for (let k = 0; k < 3; k++) {
        const i = corners[3 * t + k], j = corners[3 * t + (k + 1) % 3];
        const key = Math.min(i, j) * 4194304 + Math.max(i, j);
        const other = seen.get(key);
        if (other === undefined) { seen.set(key, t); continue; }
        seen.delete(key);
        if (dot(normals[t], normals[other]) < CREASE) found.push(i, j);
      }
    }
    for (const key of seen.keys()) found.push(Math.floor(key / 4194304), key % 4194304);
    return found;
  }

  function turning(pose) {
    const [x, y, z, w] = pose.turn;
    return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
  }
  // Rows: right and up in the picture, and towards the viewer.
  function looking() {
    const e = state.elevation * Math.PI / 180, a = state.azimuth * Math.PI / 180;
    const towards = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const right = [-Math.sin(a), Math.cos(a), 0];
    return [right, cross(towards, right), towards];
  }
  const middle = () => Math.max(0.55, data.poses[state.pose].height * 0.8);
  const scales = () => {
    const wide = WIDTH / state.zoom, ratio = canvas.height / canvas.width;
    const span = Math.max(wide, 2.35 / state.zoom / ratio);
    return [2 / span, 2 / (span * ratio)];
  };

  function withGl() {
    const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) return null;
    const program = gl.createProgram();
    const parts = [[gl.VERTEX_SHADER, `
      attribute vec3 place; attribute vec3 facing;
      uniform mat3 turn; uniform mat3 look; uniform vec2 scale;
      uniform float height; uniform float middle; uniform float flat_; uniform vec3 light;
      uniform vec3 color; uniform float shaded; varying vec3 tint;
      void main() {
        vec3 p = turn * place + vec3(0.0, 0.0, height);
        if (flat_ > 0.5) p.z = 0.003;
        vec3 q = look * (p - vec3(0.0, 0.0, middle));
        gl_Position = vec4(q.xy * scale, -q.z * 0.2, 1.0);
        float bright = 0.38 + 0.68 * pow(0.5 + 0.5 * dot(turn * facing, light), 1.5);
        tint = color * mix(1.0, bright, shaded);
      }`], [gl.FRAGMENT_SHADER, `
      precision mediump float; varying vec3 tint;
      void main() { gl_FragColor = vec4(tint, 1.0); }`]];
    for (const [kind, text] of parts) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) return null;
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    gl.useProgram(program);
    const at = name => gl.getUniformLocation(program, name);
    const names = ["turn", "look", "scale", "height", "middle", "flat_", "light", "color", "shaded"];
    const uniform = Object.fromEntries(names.map(name => [name, at(name)]));
    const faces = [], up = [0, 0, 1];
    for (let t = 0; t < count; t++)
      for (let k = 0; k < 3; k++) faces.push(...point(corners[3 * t + k]), ...normals[t]);
    const rims = [];
    for (const i of lines) rims.push(...point(i), ...up);
    const plate = [];
    for (const [x, y] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]])
      plate.push(1.05 * x, 1.05 * y, 0, ...up);
    const meshes = [faces, rims, plate].map(list => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STATIC_DRAW);
      return { buffer, size: list.length / 6 };
    });
    const attributes = ["place", "facing"].map(name => gl.getAttribLocation(program, name));
    function draw(mesh, mode, color, shaded, flat, turn, height) {
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
      attributes.forEach((where, k) => {
        gl.enableVertexAttribArray(where);
        gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 24, 12 * k);
      });
      gl.uniform3fv(uniform.color, color);
      gl.uniform1f(uniform.shaded, shaded);
      gl.uniform1f(uniform.flat_, flat);
      gl.uniform1f(uniform.height, height);
      gl.uniformMatrix3fv(uniform.turn, false, columns(turn));
      gl.drawArrays(mode, 0, mesh.size);
    }
    const columns = m => [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];
    const still = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(1, 1, 1, 1);
    return function () {
      const pose = data.poses[state.pose], turn = turning(pose);
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(uniform.look, false, columns(looking().flat()));
      gl.uniform2fv(uniform.scale, scales());
      gl.uniform1f(uniform.middle, middle());
      gl.uniform3fv(uniform.light, LIGHT);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 1);
      draw(meshes[2], gl.TRIANGLES, [0.925, 0.925, 0.925], 0, 0, still, 0);
      draw(meshes[0], gl.TRIANGLES, [0.7, 0.7, 0.7], 0, 1, turn, pose.height);
      draw(meshes[0], gl.TRIANGLES, PART, 1, 0, turn, pose.height);
      draw(meshes[1], gl.LINES, [0.13, 0.2, 0.3], 0, 0, turn, pose.height);
    };
  }

  function withPaint() {
    const pen = canvas.getContext("2d");
    if (!pen) return null;
    return function () {
      const pose = data.poses[state.pose], turn = turning(pose), look = looking();
      const [sx, sy] = scales(), low = middle();
      const map = p => {
        const q = [p[0], p[1], p[2] - low];
        return [canvas.width * (0.5 + 0.5 * sx * dot(look[0], q)),
          canvas.height * (0.5 - 0.5 * sy * dot(look[1], q)), dot(look[2], q)];
      };
      const lay = v => [dot(turn.slice(0, 3), v), dot(turn.slice(3, 6), v),
        dot(turn.slice(6, 9), v) + pose.height];
      pen.fillStyle = "#fff";
      pen.fillRect(0, 0, canvas.width, canvas.height);
      fill([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => map([1.05 * x, 1.05 * y, 0])),
        "#ececec");
      const laid = [], seen = [];
      for (let i = 0; i < points.length / 3; i++) laid.push(lay(point(i)));
      const shadow = laid.map(p => map([p[0], p[1], 0])), spots = laid.map(map);
      const three = (list, t) => [0, 1, 2].map(k => list[corners[3 * t + k]]);
      for (let t = 0; t < count; t++) {
        const facing = [0, 3, 6].map(k => dot(turn.slice(k, k + 3), normals[t]));
        if (facing[2] > 0) fill(three(shadow, t), "#b8b8b8");
        if (dot(facing, look[2]) <= 0) continue;
        const bright = 0.38 + 0.68 * Math.pow(0.5 + 0.5 * dot(facing, LIGHT), 1.5);
        const spot = three(spots, t);
        seen.push([spot[0][2] + spot[1][2] + spot[2][2], spot,
          `rgb(${PART.map(x => Math.min(255, Math.round(255 * x * bright))).join()})`]);
      }
      seen.sort((a, b) => a[0] - b[0]);
      for (const [, spot, color] of seen) fill(spot, color);
    };
    function fill(spots, color) {
      pen.beginPath();
      spots.forEach((p, k) => (k ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = color;
      pen.fill();
      pen.stroke();
    }
  }

  const forced = location.hash === "#2d";
  const gl = forced ? null : withGl();
  const paint = gl || withPaint();
  canvas.dataset.renderer = gl ? "webgl" : paint ? "2d" : "none";
  if (!paint) return;
  let asked = false;
  function redraw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      const dense = Math.min(window.devicePixelRatio || 1, 2);
      const wide = Math.round(canvas.clientWidth * dense);
      const high = Math.round(canvas.clientHeight * dense);
      if (canvas.width !== wide || canvas.height !== high) {
        canvas.width = wide;
        canvas.height = high;
      }
      paint();
      canvas.dataset.azimuth = state.azimuth.toFixed(1);
      canvas.dataset.elevation = state.elevation.toFixed(1);
      canvas.dataset.pose = data.poses[state.pose].index;
    });
  }
  function turn(across, up) {
    state.azimuth -= 0.5 * across;
    state.elevation = Math.max(2, Math.min(89, state.elevation + 0.5 * up));
    redraw();
  }
  function choose(place) {
    state.pose = place;
    buttons.forEach((one, k) => one.setAttribute("aria-pressed", String(k === place)));
    redraw();
  }
  const buttons = Array.from(document.querySelectorAll("#poses-of-view button"));
  buttons.forEach((one, k) => one.addEventListener("click", () => choose(k)));
  for (const card of document.querySelectorAll("[data-show]"))
    card.addEventListener("click", () => choose(Number(card.dataset.show)));
  let held = null;
  canvas.addEventListener("pointerdown", event => {
    held = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", event => {
    if (!held) return;
    turn(event.clientX - held[0], event.clientY - held[1]);
    held = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, () => { held = null; });
  canvas.addEventListener("keydown", event => {
    const step = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, 20],
      ArrowDown: [0, -20] }[event.key];
    if (step) { event.preventDefault(); turn(step[0], step[1]); }
  });
  canvas.addEventListener("dblclick", () => {
    state.azimuth = -62;
    state.elevation = 22;
    redraw();
  });
  window.addEventListener("resize", redraw);
  choose(0);
}());
