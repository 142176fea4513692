// The pointer over the picture: drag to orbit, with the right button or Shift to pan, wheel to zoom, click to select.

const CLICK_PIXELS = 4; // a pointer that moved less has clicked
const WHEEL = 0.0012; // of the logarithm of the distance, for one pixel of scrolling

// ask(wish) sends; place(event) returns the parts of the picture's width and height, and the picture's height on screen.
export function follow(canvas, ask, place) {
  let waiting = null;
  const pointers = new Map();
  let moved = 0;
  let apart = 0;

  // One message for each frame of the screen, however many events there are.
  function later(kind, x, y) {
    if (waiting && waiting.do !== kind) send();
    if (!waiting) requestAnimationFrame(send);
    waiting ??= { do: kind, by: kind === "zoom" ? 1 : [0, 0] };
    if (kind === "zoom") waiting.by *= x;
    else waiting.by = [waiting.by[0] + x, waiting.by[1] + y];
  }
  function send() {
    if (waiting) ask(waiting);
    waiting = null;
  }

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("dragging");
    pointers.set(event.pointerId, event);
    if (pointers.size === 1) moved = 0;
    apart = distance();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const x = event.clientX - before.clientX;
    const y = event.clientY - before.clientY;
    pointers.set(event.pointerId, event);
    moved += Math.hypot(x, y);
    if (moved < CLICK_PIXELS && pointers.size === 1) return;
    const height = place(event).height;
    if (pointers.size > 1) {
      const now = distance();
      if (apart > 0 && now > 0) later("zoom", apart / now);
      apart = now;
    } else if (event.shiftKey || event.buttons & 6) later("move", x / height, y / height);
    else later("turn", -x / height, y / height);
  });
  const end = (event) => {
    if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved < CLICK_PIXELS && event.button === 0) {
      const at = place(event).at;
      if (at) ask({ do: "pick", at });
    }
    if (!pointers.size) canvas.classList.remove("dragging");
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaMode ? event.deltaY * 30 : event.deltaY;
    later("zoom", Math.exp(Math.max(-300, Math.min(300, pixels)) * WHEEL));
  }, { passive: false });

  function distance() {
    const [a, b] = [...pointers.values()];
    return b ? Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) : 0;
  }
}
