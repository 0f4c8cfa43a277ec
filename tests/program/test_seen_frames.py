"""Frames that are seen in the text of a pseudo-program."""

from __future__ import annotations

import pytest

from assistant.base.diagnostics import Refused
from assistant.program import pseudo
from assistant.program.geometry import Frame, Pose


def read(line: str) -> Frame:
    (frame,) = pseudo.parse(f"program p\n\n{line}\n\nprocedure main\nend\n").frames.values()
    return frame


def test_a_frame_says_which_object_it_is_seen_with():
    assert read("frame part seen bracket") == Frame(seen="bracket")


def test_it_may_say_where_that_usually_is():
    frame = read("frame part user [300, 0, 20] object [0, 0, 5] seen bracket")
    assert frame == Frame(Pose((300.0, 0.0, 20.0)), Pose((0.0, 0.0, 5.0)), seen="bracket")


@pytest.mark.parametrize("name", ["seen", "`M6 bolt`", "`end`", "frame"])
def test_any_name_of_an_object_is_read_as_it_is_printed(name: str):
    program = pseudo.parse(f"program p\n\nframe seen seen {name}\n\nprocedure main\nend\n")
    assert pseudo.parse(pseudo.print_program(program).text) == program
    assert program.frames["seen"].seen == name.strip("`")


def test_what_is_seen_needs_a_name():
    with pytest.raises(Refused) as refused:
        read("frame part seen")
    assert [finding.code for finding in refused.value.findings] == ["PS102"]
