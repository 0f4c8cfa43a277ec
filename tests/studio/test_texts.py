"""Texts in the studio: opened, typed in, asked about and saved, by the server that people start."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from assistant.editing import service
from assistant.studio.studio import Studio
from assistant.studio.texts import KIND, desk
from tests.studio.serving import Answer, Page

PROGRAM = """\
program part

target home [400, 0, 300] [0, 0, 1, 0]
variable count number = 0

procedure main
  move joint home speed 200 mm/s blend fine
  count = count + 1
end
"""
MODULE = "MODULE Main\r\n  PROC main()\r\n    other;\r\n  ENDPROC\r\nENDMODULE\r\n"
OTHER = "MODULE Parts\r\n  PROC other()\r\n  ENDPROC\r\nENDMODULE\r\n"


class Typing:
    """A text that is open in a window."""

    def __init__(self, page: Page, path: str) -> None:
        self.page, self.path, self.version = page, path, 0
        opened = page.post("text/open_text", path=path)
        assert opened.status == 200, opened.value
        self.opened: dict[str, Any] = opened.value
        self.stamp = self.opened["stamp"]

    def type(self, at: tuple[int, int], text: str, to: tuple[int, int] | None = None) -> Any:
        self.version += 1
        made = [{"from": list(at), "to": list(to or at), "text": text}]
        answer = self.page.post(
            "text/change",
            path=self.path,
            version=self.version,
            changes=made,
            first=0,
            last=40,
        )
        assert answer.status == 200, answer.value
        return answer.value

    def ask(self, what: str, **values: Any) -> Answer:
        return self.page.post(f"text/{what}", path=self.path, version=self.version, **values)

    def save(self, text: str) -> Answer:
        return self.page.post("text/save", path=self.path, text=text, stamp=self.stamp)


@pytest.fixture
def typing(page: Page, folder: Path) -> Typing:
    (folder / "part.pseudo").write_text(PROGRAM)
    return Typing(page, "part.pseudo")


def test_a_fault_is_found_as_it_is_typed_and_its_cure_takes_it_away(typing: Typing) -> None:
    assert typing.opened["text"] == PROGRAM
    assert "rapid" in [one["name"] for one in typing.opened["languages"]]
    assert typing.ask("settled").value["findings"] == []
    typed = typing.type((6, 0), "  move lineer home speed 50 mm/s blend fine\n")
    assert [one["code"] for one in typed["findings"]] == ["PS101"]
    assert [6, 2, 4, "keyword", 0] in typed["words"]
    (found,) = typing.ask("fixes", first=0, last=9).value["found"]
    fix = found["fixes"][0]
    assert (fix["title"], fix["preferred"]) == ("Change `lineer` to `linear`", True)
    (edit,) = fix["changes"]["part.pseudo"]
    cured = typing.type(tuple(edit["from"]), edit["text"], tuple(edit["to"]))
    assert cured["findings"] == []


def test_what_an_editor_asks_is_answered(typing: Typing) -> None:
    outline = typing.ask("settled").value["outline"]
    assert [one["name"] for one in outline[0]["children"]] == ["home", "count", "main"]
    said = typing.ask("hover", at=[6, 14]).value["text"]
    assert "400.00 mm" in said
    assert typing.ask("definition", at=[6, 14]).value["from"] == [2, 7]
    words = typing.ask("completions", at=[6, 4]).value["words"]
    assert "move" in [one["label"] for one in words]
    assert typing.ask("renameable", at=[6, 14]).value["name"] == "home"
    changed = typing.ask("rename", at=[6, 14], name="away").value["changes"]
    assert [one["from"] for one in changed["part.pseudo"]] == [[2, 7], [6, 13]]
    refused = typing.ask("rename", at=[6, 14], name="count")
    assert (refused.status, refused.value["findings"][0]["code"]) == (422, "ED002")
    typing.type((6, 0), "      ")
    (edit,) = typing.ask("formatted").value["edits"]
    assert edit["text"].startswith("  move")


def test_a_translation_has_its_lines_beside_those_of_the_text(typing: Typing) -> None:
    done = typing.ask("translation", language="rapid").value
    lines = done["text"].splitlines()
    (written,) = [one["written"] for one in done["pairs"] if one["source"] == [6]]
    assert "MoveJ" in lines[written[0]]
    assert any(word[3] == "instruction" for word in done["words"])
    unknown = typing.ask("translation", language="nothing")
    assert unknown.status == 422


def test_what_was_asked_of_an_older_text_is_not_answered(typing: Typing) -> None:
    typing.type((0, 0), "# first\n")
    typing.version -= 1
    assert typing.ask("hover", at=[6, 14]).value == {"stale": True}


def test_a_name_is_changed_over_files_and_lines_keep_their_ends(page: Page, folder: Path) -> None:
    (folder / "main.mod").write_bytes(MODULE.encode())
    (folder / "other.mod").write_bytes(OTHER.encode())
    text = Typing(page, "main.mod")
    changed = text.ask("rename", at=[2, 6], name="second").value["changes"]
    assert sorted(changed) == ["main.mod", "other.mod"]
    text.type((2, 4), "second", (2, 9))
    shown = MODULE.replace("other", "second")
    assert text.save(shown.replace("\r\n", "\n")).status == 200
    assert (folder / "main.mod").read_bytes() == shown.encode()


def test_a_file_that_changed_on_the_disk_is_not_written_over(typing: Typing, folder: Path) -> None:
    file = folder / "part.pseudo"
    file.write_text("program theirs\n")
    refused = typing.save(PROGRAM)
    assert (refused.status, refused.value["findings"][0]["code"]) == (422, "ST024")
    assert file.read_text() == "program theirs\n"
    theirs = typing.ask("on_disk", stamp=typing.stamp).value
    assert theirs["text"] == "program theirs\n"
    typing.stamp = theirs["stamp"]  # that state was seen
    assert typing.save(PROGRAM).status == 200
    assert file.read_text() == PROGRAM
    typing.stamp = typing.ask("on_disk", stamp="").value["stamp"]
    file.unlink()
    gone = typing.save(PROGRAM)
    assert gone.value["findings"][0]["code"] == "ST026"
    assert not file.exists()


def test_of_texts_that_are_saved_at_once_one_is_written(typing: Typing, folder: Path) -> None:
    texts = [f"{PROGRAM}# {number}\n" for number in range(6)]
    with ThreadPoolExecutor(len(texts)) as every:
        done = [answer.status for answer in every.map(typing.save, texts)]
    assert sorted(done) == [200, *[422] * 5]
    assert (folder / "part.pseudo").read_text() == texts[done.index(200)]


def test_a_folder_that_is_not_there_leaves_the_texts_as_they_are(
    typing: Typing, folder: Path
) -> None:
    page = typing.page
    assert page.post("project/open", folder=str(folder / "nowhere")).status == 422
    assert "findings" in typing.ask("settled").value


def test_a_window_that_only_looks_saves_nothing_and_has_texts_of_its_own(
    typing: Typing, folder: Path
) -> None:
    typing.type((0, 0), "# not saved\n")
    second = Page(typing.page.address)
    with second.line():
        other = Typing(second, "part.pseudo")
        assert other.opened["text"] == PROGRAM
        assert other.save("# nothing\n").value["findings"][0]["code"] == "ST010"
    assert (folder / "part.pseudo").read_text() == PROGRAM


def test_what_cannot_be_opened_says_why(page: Page, folder: Path) -> None:
    (folder / "odd.toml").write_bytes(b"name = '\xe4'\n")
    odd = page.post("text/open_text", path="odd.toml").value["findings"]
    assert [(one["code"], one["path"]) for one in odd] == [("IN006", "odd.toml")]
    for path, code in (("../elsewhere", "ST023"), ("none.pseudo", "ST026"), (7, "ST011")):
        asked = page.post("text/open_text", path=path)
        assert (asked.status, asked.value["findings"][0]["code"]) == (422, code)


def test_what_a_page_asks_wrongly_is_told(typing: Typing) -> None:
    for what, values in (
        ("hover", {"at": "here"}),
        ("hover", {"at": [1, True]}),
        ("hover", {}),
        ("change", {"changes": [1]}),
        ("change", {"changes": "all"}),
        ("fixes", {}),
    ):
        asked = typing.ask(what, **values)
        assert (asked.status, asked.value["findings"][0]["code"]) == (422, "ST011"), what
    nobody = Page(typing.page.address)
    assert nobody.post("text/open_text", path="part.pseudo").status == 422
    closed = typing.ask("close")
    assert closed.value == {}
    assert typing.ask("hover", at=[0, 0]).status == 422


def test_a_character_that_the_file_cannot_hold_is_told_and_nothing_is_written(
    page: Page, folder: Path
) -> None:
    said = MODULE.replace("other;", "other; ! f\u00fcr")
    (folder / "main.mod").write_bytes(said.encode("latin-1"))
    text = Typing(page, "main.mod")
    assert text.opened["text"] == said
    wrong = text.save(said.replace("\r\n", "\n").replace("\u00fc", "\N{SNOWMAN}"))
    assert (wrong.status, wrong.value["findings"][0]["path"]) == (422, "main.mod")
    assert (folder / "main.mod").read_bytes() == said.encode("latin-1")


def test_a_process_apart_looks_at_whole_programs_and_ends_with_the_studio(tmp_path: Path) -> None:
    (tmp_path / "Main.mod").write_text(MODULE)
    studio = Studio(tmp_path)
    try:
        one = desk(studio, studio.windows.opened(lambda _: None))
        one.open(tmp_path / "Main.mod", "Main.mod")
        found = service.settled(one.document(tmp_path / "Main.mod"))
        process = studio.live[KIND].checker._worker._process
        assert "RA401" in [each.diagnostic.code for each in found]
        assert process.poll() is None
    finally:
        studio.end()
    assert process.poll() is not None
