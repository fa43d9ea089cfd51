// How the part lies, and from where it is looked at.
const WIDTH = 3.1, HEIGHT = 2.35;  // of the view at least, in radii
const LIGHT = unit([-0.25, -0.5, 0.8]), PART = [0.42, 0.64, 0.92];
const USUAL = { azimuth: -62, elevation: 22, zoom: 1 };

function turning(pose) {
  const [x, y, z, w] = pose.turn;
  return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
}
// Rows: right and up in the picture, and towards the viewer.
function looking(view) {
  const e = view.elevation * Math.PI / 180, a = view.azimuth * Math.PI / 180;
  const towards = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  const right = [-Math.sin(a), Math.cos(a), 0];
  return [right, cross(towards, right), towards];
}
const middle = pose => Math.max(0.55, pose.height * 0.8);
const scales = (canvas, view) => {
  const ratio = canvas.height / canvas.width;
  const span = Math.max(WIDTH, HEIGHT / ratio) / view.zoom;
  return [2 / span, 2 / (span * ratio)];
};
