// Panes: their borders are pulled by mouse, finger or arrow keys, and stay where they were put.
import { find } from "./words.js";

const KEPT = "panes", STEP = 16; // px of an arrow key
const shares = JSON.parse(localStorage.getItem(KEPT) ?? "{}"); // of the window or of what two panes share, 0 to 1
const percent = (share) => `${(100 * share).toFixed(2)}%`;
/** What each border is between, and which sizes of the page a share sets. */
const BORDERS = {
  "split-side": { across: true, of: () => document.body.getBoundingClientRect(), sets: (share) => ({ "--side-wide": `${(100 * share).toFixed(2)}vw` }) },
  "split-work": { across: true, of: () => between("work", "machine"), sets: (share) => ({ "--work-part": `${share}fr`, "--machine-part": `${1 - share}fr` }) },
  "split-scene": { across: false, of: () => between("panel-scene", "panel-run"), sets: (share) => ({ "--scene-high": percent(share) }) },
  "split-foot": { across: false, of: () => document.body.getBoundingClientRect(), sets: (share) => ({ "--foot-high": `${(100 - 100 * share).toFixed(2)}vh` }) },
};
function between(first, last) {
  const [one, other] = [first, last].map((id) => find(id).getBoundingClientRect());
  return { left: one.left, top: one.top, width: other.right - one.left, height: other.bottom - one.top };
}
function put(id, share) {
  for (const [name, value] of Object.entries(BORDERS[id].sets(share))) document.body.style.setProperty(name, value);
}
function move(id, share) {
  shares[id] = Math.min(0.9, Math.max(0.1, share));
  put(id, shares[id]);
  localStorage.setItem(KEPT, JSON.stringify(shares));
}
function reset(id) {
  for (const name of Object.keys(BORDERS[id].sets(0.5))) document.body.style.removeProperty(name);
  delete shares[id];
  localStorage.setItem(KEPT, JSON.stringify(shares));
}
export function beginPanes() {
  for (const [id, { across, of }] of Object.entries(BORDERS)) {
    const border = find(id);
    const shareAt = (place) => { const { left, top, width, height } = of(); return across ? (place - left) / width : (place - top) / height; };
    const here = () => { const box = border.getBoundingClientRect(); return across ? box.left + box.width / 2 : box.top + box.height / 2; };
    if (Number.isFinite(shares[id])) put(id, shares[id]);
    border.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      border.setPointerCapture(event.pointerId);
      document.body.classList.add("dragging"); // frames would take the pointer
    });
    border.addEventListener("pointermove", (event) => { if (border.hasPointerCapture(event.pointerId)) move(id, shareAt(across ? event.clientX : event.clientY)); });
    border.addEventListener("lostpointercapture", () => document.body.classList.remove("dragging"));
    border.addEventListener("dblclick", () => reset(id));
    border.addEventListener("keydown", (event) => {
      const step = across ? { ArrowLeft: -1, ArrowRight: 1 }[event.key] : { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      move(id, shareAt(here() + step * STEP));
    });
  }
}
