// Mouse, touch and keyboard on the view. One finger or the left button turns, two fingers or another button (or
// Shift) pan, pinching and the wheel zoom.
const kTurnPerPx = 0.006;
const kTurnPerKey = 0.07;
const kPanPerKey_px = 25;
const kZoomPerKey = 1.12;
const kZoomPerWheelPx = 0.0015;
const kClick_px = 4; // a pointer that moved less than this was a click

// orbit: an OrbitCamera; changed() is called after each change of it, clicked(x, y) with px of the element.
export function listen(element, orbit, changed, clicked) {
  const pointers = new Map(); // id -> {x, y}
  let travelled = 0;

  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
  };

  element.addEventListener('pointerdown', (event) => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    if (pointers.size === 1) travelled = 0;
  });

  element.addEventListener('pointermove', (event) => {
    const pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    const x = event.offsetX - pointer.x;
    const y = event.offsetY - pointer.y;
    const before = pointers.size === 2 ? spread() : 1;
    Object.assign(pointer, { x: event.offsetX, y: event.offsetY });
    travelled += Math.hypot(x, y);
    if (travelled < kClick_px) return;
    if (pointers.size === 2) {
      orbit.pan(x / 2, y / 2);
      orbit.zoom(spread() / before);
    } else if (event.shiftKey || event.buttons > 1) orbit.pan(x, y);
    else if (pointers.size === 1) orbit.turn(-x * kTurnPerPx, y * kTurnPerPx);
    changed();
  });

  const release = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    const isClick = event.type === 'pointerup' && pointers.size === 0 && travelled < kClick_px && event.button === 0;
    if (isClick) clicked(event.offsetX, event.offsetY);
  };
  element.addEventListener('pointerup', release);
  element.addEventListener('pointercancel', release);
  element.addEventListener('contextmenu', (event) => event.preventDefault());

  element.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    orbit.zoom(Math.exp(-event.deltaY * lines * kZoomPerWheelPx));
    changed();
  }, { passive: false });

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  element.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key in arrows) {
      const [x, y] = arrows[event.key];
      if (event.shiftKey) orbit.pan(-x * kPanPerKey_px, y * kPanPerKey_px);
      else orbit.turn(x * kTurnPerKey, y * kTurnPerKey);
    } else if (event.key === '+' || event.key === '=') orbit.zoom(kZoomPerKey);
    else if (event.key === '-') orbit.zoom(1 / kZoomPerKey);
    else return;
    event.preventDefault();
    changed();
  });
}
