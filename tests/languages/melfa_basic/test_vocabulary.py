"""The tables of words: what the versions have, and what to write where one lacks it."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from tests.tables import every_row


@every_row(
    ("word", "spelled", "levels"),
    [
        ("mvs", "Mvs", {4, 5, 6}),
        ("END IF", "EndIf", {5, 6}),
        ("reset  err", "Reset Err", {4, 5, 6}),
        ("end select", "End Select", {4, 5, 6}),
        ("def long", "Def Long", {5, 6}),
        ("EHSERVO", "EHServo", {5}),
        ("function", "Function", {6}),
        ("#include", "#Include", {6}),
    ],
)
def test_statements_are_found_in_any_case(word: str, spelled: str, levels: set[int]) -> None:
    found = vocabulary.statement(word)
    assert found is not None
    assert (found.word, found.dialects) == (spelled, levels)


def test_numbers_of_arguments() -> None:
    move, call, track = map(vocabulary.statement, ("Mvr", "CallP", "Trk"))
    assert move is not None and (move.least, move.most) == (3, 4)
    assert call is not None and (call.least, call.most) == (1, 17)
    assert track is not None and track.most is None and track.words == ("On", "Off")


def test_effects_of_commands() -> None:
    speed = vocabulary.statement("spd")
    assert speed is not None and speed.effects == {"reads", "sets", "stays"}
    assert vocabulary.commands("needs") == {"Mxt", "EHMov", "JRC", "Fsc"}
    assert not vocabulary.commands("reads") & vocabulary.commands("gives")
    setters = {row.setter.split()[0] for row in vocabulary.variables().values() if row.setter}
    assert all(vocabulary.statement(word) is not None for word in setters)
    assert "Ovrd" in setters


def test_functions_are_found_with_and_without_their_mark() -> None:
    left = vocabulary.function("LEFT$")
    assert left is not None and left == vocabulary.function("left")
    assert (left.name, left.result, [a.types for a in left.arguments]) == ("Left$", "C", ["C", "M"])
    arc = vocabulary.function("CalArc")
    assert arc is not None and [a.assigned for a in arc.arguments] == [False] * 3 + [True] * 4
    most = vocabulary.function("max")
    assert most is not None and (most.least, most.most) == (2, None)
    place = vocabulary.function("SetPos")
    assert place is not None and (place.least, place.most, place.dialects) == (1, 8, {5, 6})


def test_status_variables() -> None:
    timer, vision, date = map(vocabulary.status, ("m_timer", "P_NvS1", "C_Date$"))
    assert timer is not None and timer.writable and timer.index == ("timer",)
    assert vision is not None and vision.type == "P" and vision.dialects == {5, 6}
    assert date is not None and not date.writable and date.index == ()
    assert len(vocabulary.variables()) == 264


@pytest.mark.parametrize("look_up", [vocabulary.statement, vocabulary.function, vocabulary.status])
def test_what_is_not_there(look_up: object) -> None:
    assert callable(look_up)
    assert look_up("") is None
    assert look_up("MoveL") is None


def test_what_a_version_lacks_names_words_that_another_version_has() -> None:
    rows = [row for row in vocabulary.statements().values() if row.instead]
    assert rows
    for row in rows:
        for word in row.instead.replace(",", " ").split():
            known = vocabulary.statement(word)
            assert known is None or known.role == "part" or known.dialects - row.dialects, row


@pytest.mark.parametrize("name", DIALECTS)
def test_every_command_and_move_is_read(name: str) -> None:
    language = languages.get(name)
    for row in vocabulary.statements().values():
        if row.role in ("motion", "command"):
            text = f"10 {row.word} " + ",".join(["1"] * row.least)
            assert not language.parse(text.rstrip()).findings, text
