"""The studio for people: by keys alone, named for who cannot see, large, dark, in languages."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import pytest

from assistant.studio.app import words
from tests.cli.test_commands import SAMPLES
from tests.studio.browsing import TABLET, clean, studio_page, until
from tests.studio.test_whole_way import GREETING

UNNAMED: Final = """() => {
  const named = (one) => one.getAttribute("aria-label") || one.labels?.length
    || one.textContent.trim() || one.title
    || document.getElementById(one.getAttribute("aria-labelledby") ?? "");
  return [...document.querySelectorAll("button, input, select, textarea, [role], summary, iframe")]
    .filter((one) => one.offsetParent && !one.closest(".cm-editor") && one.role !== "status")
    .filter((one) => !["none", "alert"].includes(one.getAttribute("role")) && !named(one))
    .map((one) => one.outerHTML.slice(0, 200));
}"""
"""What is seen and has no name for a screen reader."""
FOCUS: Final = "document.activeElement.id || document.activeElement.dataset.path"
TABS: Final = ("tab-text", "tab-drawing", "tab-scene", "tab-run", "tab-controller")
CONTRAST: Final = """() => {
  const light = ([r, g, b]) => [r, g, b].map((one) => one / 255)
    .map((one) => one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4)
    .reduce((sum, one, i) => sum + one * [0.2126, 0.7152, 0.0722][i], 0);
  const colour = (text) => text.match(/[\\d.]+/g).map(Number);
  const behind = (one) => {
    for (; one; one = one.parentElement) {
      const seen = colour(getComputedStyle(one).backgroundColor);
      if (seen.length === 3 || seen[3] > 0) return seen;
    }
    return [255, 255, 255];
  };
  const texts = "button, h1, h2, h3, p, td, th, label, legend, small, option";
  return [...document.querySelectorAll(texts)]
    .filter((one) => one.offsetParent && one.textContent.trim() && !one.disabled)
    .map((one) => {
      const both = [light(colour(getComputedStyle(one).color)), light(behind(one))];
      const [a, b] = both.sort((x, y) => y - x);
      return [(a + 0.05) / (b + 0.05), one.outerHTML.slice(0, 120)];
    }).filter(([ratio]) => ratio < 4.5);
}"""
"""Text on its ground with less than what WCAG 2.2 wants of it (1.4.3, level AA)."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A project with a drawing and a program."""
    made = tmp_path / "cell"
    made.mkdir()
    (made / "plate.dxf").write_bytes((SAMPLES / "plate.dxf").read_bytes())
    (made / "plate.process.toml").write_bytes((SAMPLES / "plate.process.toml").read_bytes())
    (made / "greeting.pseudo").write_text(GREETING.replace("mve", "move"), encoding="utf-8")
    text = '[controllers.cell1]\naddress = "virtual:irc5"\nrobot = "irb1200-7-0.7"\n'
    (made / "assistant.toml").write_text(text, encoding="utf-8")
    return made


def walked(page: Any) -> list[str]:
    """Where Tab leads, once around the page."""
    seen: list[str] = []
    page.evaluate("document.activeElement.blur()")
    for _ in range(200):
        page.keyboard.press("Tab")
        now = page.evaluate(FOCUS)
        if now and now in seen:
            return seen
        seen.append(now)
    raise AssertionError(seen)


@pytest.mark.slow
def test_everything_is_reached_by_keys(browser: Any, address: str, folder: Path) -> None:
    with studio_page(browser, address) as page, clean(page):
        found = walked(page)
        for wanted in ("theme", "languages", "open-path", "drop", "check", "build", "tab-text"):
            assert wanted in found, found
        assert found.index("check") < found.index("tab-text") < found.index("tab-scene")
        for key, tab in enumerate(TABS, 1):
            page.keyboard.press(f"Alt+{key}")
            assert page.evaluate(FOCUS) == tab
            panel = page.get_attribute(f"#{tab}", "aria-controls")
            assert page.locator(f"#{panel}").is_visible()
        page.keyboard.press("Alt+6")
        assert page.evaluate(FOCUS) == "drop"
        page.keyboard.press("Alt+3")
        page.keyboard.press("ArrowRight")
        assert page.evaluate(FOCUS) == "tab-run"


@pytest.mark.slow
def test_a_file_is_opened_changed_and_saved_by_keys(
    browser: Any, address: str, folder: Path
) -> None:
    with studio_page(browser, address) as page, clean(page):
        assert "plate.dxf" in walked(page)  # the first file of the list: settings are the last
        page.locator("#files button").first.focus()
        page.keyboard.press("ArrowDown")
        page.keyboard.press("ArrowDown")
        assert page.evaluate(FOCUS) == "greeting.pseudo"
        page.keyboard.press("Enter")
        page.wait_for_selector("#editor .word-keyword")
        assert page.evaluate("document.querySelector('main #editor .cm-scroller').tabIndex") == 0
        page.locator("#editor .cm-content").focus()
        page.keyboard.press("Control+End")
        page.keyboard.type("# by keys")
        until(page, "document.querySelector('#file-state').dataset.word === 'unsaved'")
        page.keyboard.press("Control+s")
        until(page, "document.querySelector('#file-state').dataset.word === 'saved'")
    assert (folder / "greeting.pseudo").read_text("utf-8").endswith("# by keys")


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_that_is_seen_is_named_and_readable(
    browser: Any, address: str, folder: Path, scheme: str
) -> None:
    with studio_page(browser, address, color_scheme=scheme) as page, clean(page):
        page.locator("#files [data-path='plate.dxf']").click()
        page.wait_for_selector("#panel-drawing polyline", state="attached")
        for tab in TABS:
            page.click(f"#{tab}")
            assert page.evaluate(UNNAMED) == [], tab
            assert page.evaluate(CONTRAST) == [], tab


@pytest.mark.slow
@pytest.mark.parametrize("language", sorted(set(words()) - {"en"}))
def test_the_page_speaks_the_language_of_its_reader(
    browser: Any, address: str, folder: Path, language: str
) -> None:
    with studio_page(browser, address, TABLET, locale=language) as page, clean(page):
        page.locator("#files [data-path='plate.dxf']").click()
        page.wait_for_selector("#panel-drawing polyline", state="attached")
        assert page.get_attribute("html", "lang") == language
        ours, english = words()[language], words()["en"]
        for tab in TABS:
            page.click(f"#{tab}")
            shown = page.locator("[data-word]:visible")
            for key, text in shown.evaluate_all(
                "(all) => all.map((one) => [one.dataset.word, one.textContent])"
            ):
                assert text == ours.get(key, ""), key
        page.select_option("#languages", "en")
        assert page.inner_text("#build") == english["build"]


@pytest.mark.slow
def test_nothing_is_cut_off_at_twice_the_size(browser: Any, address: str, folder: Path) -> None:
    half = {"width": 640, "height": 400}  # of 1280 by 800, which is what zooming to 200 % leaves
    with studio_page(browser, address, half) as page, clean(page):
        page.locator("#files [data-path='plate.dxf']").click()
        page.wait_for_selector("#panel-drawing polyline", state="attached")
        for tab in TABS:
            page.click(f"#{tab}")
            wide = "document.documentElement.scrollWidth <= window.innerWidth"
            assert page.evaluate(wide), tab
