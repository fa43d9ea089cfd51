// The part on the plate, to be turned by finger, mouse or keys.
function painter(canvas) {
  const forced = location.hash === "#2d";
  return (forced ? null : withGl(canvas)) || withPaint(canvas);
}

// What shows a part in the canvas; a click on what has `data-show` chooses its pose.
function startViewer(canvas) {
  const paint = painter(canvas);
  canvas.dataset.renderer = paint ? paint.kind : "none";
  if (!paint) return null;
  const view = { ...USUAL };
  let part = null, place = 0, asked = false, held = null;
  function redraw() {
    if (asked || !part) return;
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
      paint.draw(part.poses[place], view);
      canvas.dataset.azimuth = view.azimuth.toFixed(1);
      canvas.dataset.elevation = view.elevation.toFixed(1);
      canvas.dataset.pose = part.poses[place].index;
    });
  }
  function turn(across, up) {
    view.azimuth -= 0.5 * across;
    view.elevation = Math.max(2, Math.min(89, view.elevation + 0.5 * up));
    redraw();
  }
  function zoom(factor) {
    view.zoom = Math.max(0.5, Math.min(12, view.zoom * factor));
    redraw();
  }
  function choose(number) {
    place = number;
    for (const button of document.querySelectorAll("button[data-show]"))
      button.setAttribute("aria-pressed", String(Number(button.dataset.show) === place));
    redraw();
  }
  document.addEventListener("click", event => {
    const shown = event.target.closest("[data-show]");
    if (shown) choose(Number(shown.dataset.show));
  });
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
    Object.assign(view, USUAL);
    redraw();
  });
  window.addEventListener("resize", redraw);
  return {
    chosen: () => place,
    // Colours of the triangles; null for that of all parts.
    color(colors) {
      part.colors = colors;
      paint.load(part);
      redraw();
    },
    show(shown, number) {
      part = shown;
      paint.load(part);
      choose(number);
    },
  };
}
