"""Projects from elsewhere, in a real browser: their names and contents are shown, and never run."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

import pytest
from ezdxf.document import Drawing

from tests.studio.browsing import clean, studio_page, until

MARKUP: Final = '<img src=x onerror="window.hacked=1">'
SCRIPT: Final = "</script><script>window.hacked=1</script>"
LINK: Final = "[a](javascript:window.hacked=1)"
BREAKING: Final = "';window.hacked=1;//\u2028${window.hacked=1}"
EVERY: Final = (MARKUP, SCRIPT, LINK, BREAKING)
LAYER: Final = "HOSTILE"
"""Has the markup as its name in the file, which no library writes."""
PROGRAM: Final = """MODULE hostile
  ! {0}
  CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    TPWrite "{0}";
    MoveJ p1, v100, fine, tool0;
    no_such_routine "{0}";
  ENDPROC
ENDMODULE
"""
TABLE: Final = "x,y,z\n1,2,3\n{0}\n"
PROJECT: Final = """
[controllers."{0}"]
address = "virtual:irc5"
robot = "{0}"

[programs."{0}"]
source = "{1}"

[targets."{0}"]
programs = ["{0}"]
"""


def hostile(folder: Path) -> list[str]:
    """A project of hostile names and contents; the names of its files."""
    names = []
    for i, text in enumerate(EVERY):
        name = text.replace("/", "\u2215")[:120]
        plain = text.replace('"', "'")
        for file, content in (
            (f"{name}.mod", PROGRAM.format(plain)),
            (f"{i}{name}.csv", TABLE.format(text)),
            (f"{i}{name}.process.toml", f'unit = "{plain}"\n["{plain}"]\n"{plain}" = 1\n'),
        ):
            (folder / file).write_text(content, encoding="utf-8")
            names.append(file)
    document = Drawing.new()
    for layer in (LAYER, "__proto__", "constructor"):
        document.layers.add(layer)
        document.modelspace().add_line((0, 0), (50, 10), dxfattribs={"layer": layer})
    document.modelspace().add_text(MARKUP)
    drawing = f"{MARKUP}.dxf"
    document.saveas(folder / drawing)
    written = (folder / drawing).read_text(encoding="utf-8")
    (folder / drawing).write_text(written.replace(LAYER, MARKUP), encoding="utf-8")
    said = MARKUP.replace('"', '\\"')
    text = PROJECT.format(said, drawing.replace('"', '\\"'))
    (folder / "assistant.toml").write_text(text, encoding="utf-8")
    (folder / "\u202emod.live").write_text("x", encoding="utf-8")
    (folder / os.fsdecode(b"\xff<b>.mod")).write_text(PROGRAM.format(SCRIPT), "utf-8")
    (folder / ("x" * 200 + ".csv")).write_text(TABLE.format("1,2,3"), encoding="utf-8")
    return [*names, drawing, "\u202emod.live", "assistant.toml", "x" * 200 + ".csv"]


def sound(page: Any) -> None:
    """Nothing of a file has run, and none of its markup is on the page."""
    assert page.evaluate("window.hacked") is None
    theirs = "img:not(.cm-widgetBuffer), script:not([src]):not([type]), a[href^=javascript]"
    assert page.locator(theirs).count() == 0
    assert page.evaluate("Object.keys(Object.prototype).length") == 0
    for frame in page.frames[1:]:
        assert frame.evaluate("window.hacked") is None


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Whose own name is hostile as well."""
    made = tmp_path / "<b onclick=x>&amp;cell"
    made.mkdir()
    return made


def test_hostile_names_are_texts(browser: Any, address: str, folder: Path) -> None:
    names = hostile(folder)
    with studio_page(browser, address) as page, clean(page):
        listed = page.locator("#files bdi").all_inner_texts()
        assert any(MARKUP in one for one in listed)
        assert not any("\u202e" in one or "\udcff" in one for one in listed)
        assert "<b onclick=x>&amp;cell" in page.inner_text("#folder")
        assert page.locator("#files button").count() >= len(names)
        sound(page)


@pytest.mark.slow
def test_hostile_contents_are_texts(browser: Any, address: str, folder: Path) -> None:
    """Each file is opened, shown in the scene and checked; then the project is."""
    names = hostile(folder)
    with studio_page(browser, address) as page:
        dialogs: list[str] = []

        def asked(dialog: Any) -> None:
            dialogs.append(dialog.message)
            dialog.dismiss()

        page.on("dialog", asked)
        for name in names:
            page.evaluate(
                "(name) => [...document.querySelectorAll('#files button')]"
                ".find((one) => one.dataset.path === name).click()",
                name,
            )
            page.wait_for_timeout(300)
            page.click("#show-scene")
            page.wait_for_timeout(500)
            sound(page)
        for button in ("#check", "#build", "#tab-run", "#tab-controller"):
            page.click(button)
            page.wait_for_timeout(500)
            sound(page)
        assert dialogs == []
        assert page.wrong == []


@pytest.mark.slow
def test_a_layer_of_any_name_gets_its_process(browser: Any, address: str, folder: Path) -> None:
    document = Drawing.new()
    document.layers.add("__proto__")
    document.modelspace().add_line((0, 0), (50, 10), dxfattribs={"layer": "__proto__"})
    document.units = 4  # mm
    document.saveas(folder / "odd.dxf")
    with studio_page(browser, address) as page, clean(page):
        page.click("#files button")
        page.get_by_label("__proto__: speed, mm/s").fill("33")
        page.get_by_role("button", name="Write the process file").click()
        until(page, "document.querySelector('[data-layer] [data-key=speed]')?.value === '33'")
        for _ in range(100):
            if (folder / "odd.process.toml").is_file():
                break
            page.wait_for_timeout(50)
        assert "speed = 33" in (folder / "odd.process.toml").read_text("utf-8")
        sound(page)
