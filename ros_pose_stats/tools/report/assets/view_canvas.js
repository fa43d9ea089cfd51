// Draws on a 2-D canvas, triangle by triangle from the back, where there is no WebGL.
function withPaint(canvas) {
  const pen = canvas.getContext("2d");
  if (!pen) return null;
  let part = null;
  return { canvas, kind: "2d", load(loaded) { part = loaded; }, draw };
  function draw(pose, view) {
    const { points, corners, count, point, normals, colors } = part;
    const turn = turning(pose), look = looking(view);
    const [sx, sy] = scales(canvas, view), low = middle(pose);
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
        `rgb(${(colors ? colors[t] : PART).map(x => Math.min(255, Math.round(255 * x * bright))).join()})`]);
    }
    seen.sort((a, b) => a[0] - b[0]);
    for (const [, spot, color] of seen) fill(spot, color);
  }
  function fill(spots, color) {
    pen.beginPath();
    spots.forEach((p, k) => (k ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
    pen.closePath();
    pen.fillStyle = pen.strokeStyle = color;
    pen.fill();
    pen.stroke();
  }
}
