"""The editor of the studio in a real browser, by keys as people use it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.studio.browsing import studio_page, until
from tests.studio.test_texts import PROGRAM

SOURCE = "#editor .cm-content"


@pytest.fixture
def edited(browser: Any, address: str, folder: Path) -> Iterator[Any]:
    """A window in which a program is open, with its cursor in the first line."""
    (folder / "part.pseudo").write_text(PROGRAM)
    with studio_page(browser, address) as page:
        page.get_by_role("treeitem", name="part.pseudo").click()
        page.wait_for_selector("#outline button")
        page.wait_for_selector(".cm-focused .word-keyword")
        yield page


@contextmanager
def sound(page: Any) -> Iterator[None]:
    """Nothing fails on the page; a browser also tells of what the studio refuses to do."""
    yield
    assert [one for one in page.wrong if "422" not in one] == []


def go(page: Any, line: int) -> None:
    """To the end of a line, from 1."""
    page.keyboard.press("Control+Home")
    for _ in range(line - 1):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("End")


def text_of(page: Any) -> str:
    lines = page.locator(f"{SOURCE} .cm-line").all_inner_texts()
    return "".join(f"{line}\n".replace("\n\n", "\n") for line in lines)


def test_of_many_declarations_and_findings_few_are_listed_at_once(
    browser: Any, address: str, folder: Path
) -> None:
    rest = "[[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]".removeprefix("[")
    targets = [f"  CONST robtarget p{i}:=[[400,{i},300],{rest};" for i in range(310)]
    moves = [f"    MoveJ p{i},v{11_000 + i},fine,tool0;" for i in range(310)]
    code = ["  PROC main()", *moves, "  ENDPROC", "ENDMODULE"]
    (folder / "many.mod").write_text("\n".join(["MODULE many", *targets, *code, ""]))
    with studio_page(browser, address) as page:
        page.get_by_role("treeitem", name="many.mod").click()
        fold = page.locator("#outline details")
        fold.wait_for()
        assert fold.locator("summary").inner_text() == "p0 … p309 (310)"
        assert page.locator("#outline button").count() < 10
        page.locator("#outline button", has_text="main").wait_for()
        fold.locator("summary").click()
        fold.get_by_role("button", name="p210 ").click()
        page.wait_for_selector(".cm-activeLine:has-text('robtarget p210:')")
        page.keyboard.press("End")
        page.keyboard.type("  ! here")
        until(page, "document.querySelector('#finding-count').textContent === '300+'")
        until(page, "document.querySelectorAll('#outline details button').length === 310")
        assert page.locator("#findings li").count() == 300
        assert page.wrong == []


def test_a_fault_is_found_cured_and_undone_by_keys(edited: Any) -> None:
    page = edited
    with sound(page):
        go(page, 6)
        page.keyboard.press("Enter")
        page.keyboard.type("  mve joint home speed 50 mm/s blend fine")
        page.keyboard.press("Escape")
        fix = page.locator("#findings .fix", has_text="move")
        fix.wait_for()
        assert page.locator("#findings li.error").count() == 1
        assert page.locator(".cm-lintRange-error").count() == 1
        page.keyboard.press("Control+.")
        page.locator(".cures button", has_text="move").wait_for()
        page.keyboard.press("Enter")
        until(page, "!document.querySelector('#findings li.error')")
        assert "  move joint home speed 50" in text_of(page)
        page.keyboard.press("Control+z")
        until(page, "document.querySelector('#findings li.error') !== null")
        assert "mve joint home" in text_of(page)
        fix.wait_for()
        fix.click()
        until(page, "!document.querySelector('#findings li.error')")
        assert page.locator("#file-state").inner_text() == "not saved"


@pytest.mark.slow
def test_words_are_completed_named_anew_and_saved_by_keys(edited: Any, folder: Path) -> None:
    page = edited
    with sound(page):
        go(page, 8)
        page.keyboard.press("Enter")
        page.keyboard.type("mes")
        page.wait_for_selector(".cm-tooltip-autocomplete li[aria-selected]")
        page.wait_for_timeout(100)  # what is offered is taken only when it has been seen
        page.keyboard.press("Enter")
        page.keyboard.type(' "done"')
        go(page, 4)
        for _ in range(len("t number = 0")):
            page.keyboard.press("ArrowLeft")
        page.keyboard.press("F2")
        page.wait_for_selector("#rename-name:focus")
        page.keyboard.type("parts")
        page.keyboard.press("Enter")
        until(page, "document.getElementById('rename-form').hidden")
        until(page, f"document.querySelector('{SOURCE}').textContent.includes('parts number')")
        page.keyboard.press("F12")
        page.keyboard.press("Control+s")
        page.locator("#file-state", has_text="saved").wait_for()
        until(page, "document.getElementById('file-state').dataset.word === 'saved'")
    written = PROGRAM.replace("count", "parts").replace("+ 1\n", '+ 1\n  message "done"\n')
    assert (folder / "part.pseudo").read_text() == written


@pytest.mark.slow
def test_what_changes_on_the_disk_is_taken_in_or_asked_about(edited: Any, folder: Path) -> None:
    page, file = edited, folder / "part.pseudo"
    theirs = PROGRAM.replace("200", "300")
    file.write_text(theirs)
    until(page, f"document.querySelector('{SOURCE}').textContent.includes('300 mm/s')")
    assert page.locator("#file-state").inner_text() == "saved"
    go(page, 1)
    page.keyboard.press("Enter")
    page.keyboard.type("# mine")
    file.write_text(PROGRAM)
    page.wait_for_selector("#conflict:not([hidden])")
    page.keyboard.press("Control+s")
    page.locator("#findings", has_text="ST024").wait_for()
    assert file.read_text() == PROGRAM
    page.locator("#take-theirs").click()
    assert "# mine" not in text_of(page)
    page.locator(SOURCE).click()
    page.keyboard.press("Control+z")
    assert "# mine" in text_of(page)
    page.keyboard.press("Control+s")
    until(page, "document.getElementById('file-state').dataset.word === 'saved'")
    assert "# mine" in file.read_text()
    page.keyboard.type("# more")
    file.write_text(PROGRAM)
    page.wait_for_selector("#conflict:not([hidden])")
    page.locator("#keep-mine").click()
    page.locator("#save").click()
    until(page, "document.getElementById('file-state').dataset.word === 'saved'")
    assert "# more" in file.read_text()


@pytest.mark.slow
def test_lines_of_a_translation_are_shown_both_ways(edited: Any) -> None:
    page = edited
    with sound(page):
        page.locator("#translate").select_option("rapid")
        page.wait_for_selector("#translation .word-instruction")
        page.locator(f"{SOURCE} .cm-line", has_text="move joint").click()
        written = page.locator("#translation .linked")
        written.wait_for()
        assert "MoveJ" in written.inner_text()
        page.locator("#translation .cm-line", has_text="count+1").click()
        until(page, "document.querySelector('#editor .linked')?.textContent.includes('+ 1')")


@pytest.mark.slow
def test_other_parts_of_the_page_edit_and_mark_a_text(edited: Any) -> None:
    page = edited
    with sound(page):
        go(page, 7)
        page.keyboard.press("F9")
        lines = page.evaluate(
            """async () => {
            const editor = await import(document.querySelector("script[src]").src
              .replace("start.js", "editor.js"));
            window.heard = [];
            editor.onLine((where) => window.heard.push(where));
            await editor.openText("part.pseudo", 3);
            editor.markLine("part.pseudo", 4);
            editor.markLine("part.pseudo", 8, "break");
            const edits = [
              { from: [2, 0], to: [2, 0], text: "# one\\n" },
              { from: [3, 0], to: [3, 0], text: "# two\\n" },
            ];
            await editor.applied("part.pseudo", edits);
            return editor.breakPoints("part.pseudo");
        }"""
        )
        assert lines == [9, 10]
        assert page.evaluate("window.heard")[0] == {"path": "part.pseudo", "line": 3}
        assert page.locator(".arm-here").inner_text().startswith("variable")
        assert page.locator(".point-mark").count() >= 2
        page.keyboard.press("Control+z")  # both edits are one step
        assert "# one" not in text_of(page)
        assert "# two" not in text_of(page)


@pytest.mark.slow
def test_a_second_window_reads_only_and_follows_the_disk(
    edited: Any, browser: Any, folder: Path, address: str
) -> None:
    context = browser.new_context(locale="en")
    second = context.new_page()
    second.goto(address)
    second.wait_for_selector("body.reads")
    second.get_by_role("treeitem", name="part.pseudo").click()
    second.wait_for_selector(f"{SOURCE} .word-keyword")
    second.keyboard.type("nothing")
    assert "nothing" not in text_of(second)
    assert second.locator("#save").is_disabled()
    go(edited, 1)
    edited.keyboard.type("s")
    edited.keyboard.press("Control+s")
    until(second, f"document.querySelector('{SOURCE}').textContent.includes('program parts')")
    context.close()


@pytest.mark.slow
def test_a_file_that_cannot_be_read_shows_its_finding_in_place(edited: Any, folder: Path) -> None:
    (folder / "odd.toml").write_bytes(b"name = '\xe4'\n")
    edited.get_by_role("treeitem", name="odd.toml").click()
    edited.locator("#editor .unreadable", has_text="IN006").wait_for()
    assert edited.locator("#save").is_disabled()
    edited.get_by_role("treeitem", name="part.pseudo").click()
    edited.wait_for_selector(".cm-focused .word-keyword")
