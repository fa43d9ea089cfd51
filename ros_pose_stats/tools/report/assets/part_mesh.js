// The part as triangles, their normals, and the edges that are drawn; lengths in radii.
const CREASE = Math.cos(25 * Math.PI / 180);

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

// The part that a page tells of, with its poses and all that is drawn of it.
function readPart(data) {
  const points = new Float32Array(bytes(data.vertices));
  const corners = new (data.wide ? Uint32Array : Uint16Array)(bytes(data.triangles));
  const count = corners.length / 3;
  const point = i => [points[3 * i], points[3 * i + 1], points[3 * i + 2]];
  const normals = [];
  for (let t = 0; t < count; t++) {
    const [a, b, c] = [0, 1, 2].map(k => point(corners[3 * t + k]));
    const ab = b.map((x, k) => x - a[k]), ac = c.map((x, k) => x - a[k]), n = cross(ab, ac);
    // Triangles thinner than their coordinates are exact have no direction.
    const thin = dot(n, n) < 1e-12 * Math.max(dot(ab, ab), dot(ac, ac));
    normals.push(thin ? [0, 0, 0] : unit(n));
  }
  const lines = creases(corners, normals);
  return { poses: data.poses, points, corners, count, point, normals, lines, colors: null };
}

// Colours of the triangles, red, green and blue from 0 to 1, of three bytes each.
function readColors(text) {
  const levels = new Uint8Array(bytes(text)), colors = [];
  for (let i = 0; i < levels.length; i += 3)
    colors.push([0, 1, 2].map(k => levels[i + k] / 255));
  return colors;
}

// Edges between triangles that meet at an angle, or that only one triangle has.
function creases(corners, normals) {
  const seen = new Map(), edges = [];
  for (let t = 0; t < normals.length; t++) {
    for (let k = 0; k < 3; k++) {
      const i = corners[3 * t + k], j = corners[3 * t + (k + 1) % 3];
      const key = Math.min(i, j) * 4194304 + Math.max(i, j);
      const other = seen.get(key);
      if (other === undefined) { seen.set(key, t); continue; }
      seen.delete(key);
      const [m, n] = [normals[t], normals[other]];
      if (dot(m, n) < CREASE && dot(m, m) > 0 && dot(n, n) > 0) edges.push(i, j);
    }
  }
  for (const key of seen.keys()) edges.push(Math.floor(key / 4194304), key % 4194304);
  return edges;
}
