// The part on the plate, to be turned by finger, mouse or keys.
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
function zoom(factor) {
  state.zoom = Math.max(0.5, Math.min(12, state.zoom * factor));
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
  if ("+-=".includes(event.key)) zoom(event.key === "-" ? 0.8 : 1.25);
});
// A wheel over a view that nobody has touched scrolls the page.
canvas.addEventListener("wheel", event => {
  if (document.activeElement !== canvas) return;
  event.preventDefault();
  zoom(Math.exp(-0.002 * event.deltaY));
}, { passive: false });
canvas.addEventListener("dblclick", () => {
  state.azimuth = -62;
  state.elevation = 22;
  state.zoom = 1;
  redraw();
});
window.addEventListener("resize", redraw);
choose(0);
