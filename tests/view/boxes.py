"""Boxes of a page: nothing that people use is cut off, and nothing stands over another."""

from __future__ import annotations

from typing import Any, Final

SIZES: Final = ((1280, 800), (1920, 1080))
_WRONG: Final = """() => {
  const used = "button, input, select, textarea, th, td, legend, summary, h1, h2, h3, label, "
    + "#names span";
  const free = ".cm-editor, .cm-editor *, pre, svg, svg *, [type=file]"; // scroll, or are not seen
  const seen = (one) => {
    let { left, top, right, bottom } = one.getBoundingClientRect();
    for (let up = one.parentElement; up; up = up.parentElement) {
      if (getComputedStyle(up).overflow === "visible") continue;
      const box = up.getBoundingClientRect();
      [left, top] = [Math.max(left, box.left), Math.max(top, box.top)];
      [right, bottom] = [Math.min(right, box.right), Math.min(bottom, box.bottom)];
    }
    return { left, top, right, bottom };
  };
  const named = (one) => {
    const text = (one.textContent || one.value || "").trim().slice(0, 30);
    return `${one.tagName.toLowerCase()}#${one.id} ${text}`;
  };
  const found = [], whole = document.documentElement;
  if (whole.scrollWidth > innerWidth) found.push("the page scrolls sideways");
  if (whole.scrollHeight > innerHeight) found.push("the page scrolls");
  const shown = [...document.querySelectorAll(used)]
    .filter((one) => one.checkVisibility() && !one.matches(free) && one.offsetWidth);
  for (const one of shown) {
    const box = one.getBoundingClientRect(), part = seen(one);
    const cut = part.left > box.left + 1 || part.right < box.right - 1;
    if (cut && part.bottom > part.top) found.push(`cut off: ${named(one)}`);
    const wider = one.clientWidth && one.scrollWidth > one.clientWidth + 1;
    if (wider && !one.matches("input, select, label")) found.push(`too wide: ${named(one)}`);
  }
  const boxes = shown.filter((one) => one.matches("button, input, select, textarea, #names span"))
    .map((one) => [one, seen(one)]);
  boxes.forEach(([one, a], i) => {
    for (const [other, b] of boxes.slice(i + 1)) {
      if (one.contains(other) || other.contains(one)) continue;
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 1 && high > 1) found.push(`one over another: ${named(one)}, ${named(other)}`);
    }
  });
  return found;
}"""


def _wrong_by_frame(page: Any) -> list[list[str]]:
    """What is wrong in each frame of a page.

    On a slow machine the page may put a new scene in the place of a frame that is looked at; then
    all of them are looked at again.
    """
    from playwright.sync_api import Error

    while True:
        frames = page.frames
        try:
            return [frame.evaluate(_WRONG) for frame in frames]
        except Error:
            if not any(frame.is_detached() for frame in frames):
                raise


def wrong_boxes(page: Any) -> dict[str, list[str]]:
    """By size and frame, what is cut off or stands over another on a page."""
    found = {}
    before = page.viewport_size
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(300)
        for number, wrong in enumerate(_wrong_by_frame(page)):
            if wrong:
                found[f"{width} x {height}, frame {number}"] = wrong
    page.set_viewport_size(before)
    return found
