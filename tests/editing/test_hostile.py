"""Whatever is typed, and wherever somebody asks, there is an answer or a reason."""

from __future__ import annotations

import random

import pytest

from assistant.base.diagnostics import Refused
from assistant.editing import service
from assistant.editing.service import Change, Place, Range, Workspace
from tests.editing.typing import kept, made
from tests.tables import every_row

PIECES = (
    *("(", ")", '"', "'", "!", "#", ";", "\n", "\r\n", "\r", "\t", "\0", "🤖", "ä", "\u2028", "`"),
    *("[", "]", "*", ".", "\\", "|", "end", "ENDPROC", "PROC x()", "EndIf", "If ", "9" * 40, "%%%"),
    *("MODULE m", "procedure p", "Function M F()", "opaque rapid", "((((((((((", "<EXP>", "\ufeff"),
)


def asked(document, draws):
    """Asks all that can be asked, at some place."""
    place = Place(draws.randrange(-1, len(document.lines) + 2), draws.randrange(90))
    found = service.findings(document)
    end = document.lines.place(len(document.text))
    assert all(Place(0, 0) <= one.range.start <= one.range.end <= end for one in found)
    service.tokens(document)
    service.outline(document)
    service.completions(document, place)
    service.hover(document, place)
    service.definition(document, place)
    for one in service.references(document, place):
        assert one.range.start < one.range.end
    service.renameable(document, place)
    for risky in (
        lambda: service.rename(document, place, "other7"),
        lambda: service.formatted(document),
    ):
        try:
            risky()
        except Refused as refused:
            assert refused.findings
    if found and draws.random() < 0.1:
        for fix in service.fixes(document, found[0]):
            assert fix.changes


def hurt(document, draws):
    """A change somewhere: something put in, or taken out."""
    lines = document.lines
    start = draws.randrange(len(document.text) + 1)
    end = min(start + draws.choice((0, 0, 1, 3, 40)), len(document.text))
    whole = Range(lines.place(start), lines.place(end))
    return Change(whole, draws.choice(PIECES) if draws.random() < 0.8 else "")


def tried(name, text, draws, states):
    workspace = Workspace()
    document = workspace.open(f"/nowhere/{name}", text)
    for number in range(states):
        if number % 12 == 0:
            document = workspace.change(document.path, text, number)
            service.settled(document)
        document = workspace.change(document.path, [hurt(document, draws)], number)
        asked(document, draws)
    service.settled(document)
    service.translation(document, "pseudo")


@pytest.mark.parametrize("name", ["samples-PALLET.prg", "rapid-records.mod"])
def test_any_text_and_place_has_an_answer(name):
    tried(name, kept()[name], random.Random(name), states=8)


@pytest.mark.slow
def test_any_text_and_place_of_all_files_has_an_answer(tell):
    texts, states = {**kept(), **made()}, 60
    for name, text in texts.items():
        tried(name, text, random.Random(name), states)
    tell(f"{len(texts) * states:,} damaged states of {len(texts)} files asked about: all answered")


@every_row(
    "text",
    ["", "\n" * 5000, "(" * 20_000, '"' * 20_000, "\0", "🤖" * 5000, "\r" * 300, "a" * 100_000],
)
@every_row("suffix", ["mod", "mb5", "pseudo"])
def test_odd_texts_have_answers(text, suffix):
    document = Workspace().open(f"/nowhere/odd.{suffix}", text)
    asked(document, random.Random(1))


@pytest.mark.parametrize(
    "path", ["", "a\0b", "/" + "x" * 5000, "untitled:a b", "../../etc/passwd.mod", "http://x/y.mod"]
)
def test_odd_paths_have_answers(path):
    document = Workspace().open(path, "MODULE a\nENDMODULE\n", language="rapid")
    assert service.settled(document) is not None
    asked(document, random.Random(1))
