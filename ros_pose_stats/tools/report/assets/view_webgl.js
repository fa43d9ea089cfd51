// Draws with WebGL.
function withGl(canvas) {
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = gl.createProgram();
  const parts = [[gl.VERTEX_SHADER, `
    attribute vec3 place; attribute vec3 facing; attribute vec3 own;
    uniform mat3 turn; uniform mat3 look; uniform vec2 scale;
    uniform float height; uniform float middle; uniform float flat_; uniform vec3 light;
    uniform vec3 color; uniform float shaded; uniform float lift; varying vec3 tint;
    void main() {
      vec3 p = turn * place + vec3(0.0, 0.0, height);
      if (flat_ > 0.5) p.z = 0.003;
      vec3 q = look * (p - vec3(0.0, 0.0, middle));
      gl_Position = vec4(q.xy * scale, -0.2 * (q.z + lift), 1.0);
      float bright = 0.38 + 0.68 * pow(0.5 + 0.5 * dot(turn * facing, light), 1.5);
      tint = color * own * mix(1.0, bright, shaded);
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
  const names = ["turn", "look", "scale", "height", "middle", "flat_", "light", "color", "shaded",
    "lift"];
  const uniform = Object.fromEntries(names.map(name => [name, at(name)]));
  const [faces, rims, plate] = [0, 1, 2].map(() => ({ buffer: gl.createBuffer(), size: 0 }));
  const up = [0, 0, 1], white = [1, 1, 1];
  const paint = gl.createBuffer(), own = gl.getAttribLocation(program, "own");
  let painted = false;
  function fill(mesh, list) {
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STATIC_DRAW);
    mesh.size = list.length / 6;
  }
  fill(plate, [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]
    .flatMap(([x, y]) => [1.05 * x, 1.05 * y, 0, ...up]));
  function load(part) {
    const list = [];
    for (let t = 0; t < part.count; t++)
      for (let k = 0; k < 3; k++)
        list.push(...part.point(part.corners[3 * t + k]), ...part.normals[t]);
    fill(faces, list);
    fill(rims, part.lines.flatMap(i => [...part.point(i), ...up]));
    painted = part.colors !== null;
    if (!painted) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, paint);
    gl.bufferData(gl.ARRAY_BUFFER,
      new Float32Array(part.colors.flatMap(color => [...color, ...color, ...color])), gl.STATIC_DRAW);
  }
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
  gl.vertexAttrib3fv(own, white);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(1, 1, 1, 1);
  return { canvas, kind: "webgl", load, draw: drawAll };
  function drawAll(pose, view) {
    const turn = turning(pose);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix3fv(uniform.look, false, columns(looking(view).flat()));
    gl.uniform2fv(uniform.scale, scales(canvas, view));
    gl.uniform1f(uniform.middle, middle(pose));
    gl.uniform3fv(uniform.light, LIGHT);
    gl.uniform1f(uniform.lift, 0);
    draw(plate, gl.TRIANGLES, [0.925, 0.925, 0.925], 0, 0, still, 0);
    draw(faces, gl.TRIANGLES, [0.7, 0.7, 0.7], 0, 1, turn, pose.height);
    if (painted) {
      gl.bindBuffer(gl.ARRAY_BUFFER, paint);
      gl.enableVertexAttribArray(own);
      gl.vertexAttribPointer(own, 3, gl.FLOAT, false, 12, 0);
    }
    draw(faces, gl.TRIANGLES, painted ? white : PART, 1, 0, turn, pose.height);
    gl.disableVertexAttribArray(own);
    // A polygon offset would push thin triangles far back, and lines behind them would show.
    gl.uniform1f(uniform.lift, 0.004);
    draw(rims, gl.LINES, [0.13, 0.2, 0.3], 0, 0, turn, pose.height);
  }
}
