"""A target more in a file, or one taught anew: what else the file says stays to the letter."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.base.toml_edits import toml_value
from assistant.sources.process import NO_PROCESS
from assistant.sources.tables.taught import (
    TaughtTarget,
    new_file_text,
    with_target,
)
from tests.tables import every_row

SAMPLE = Path(__file__).parents[3] / "samples" / "taught.toml"
POSE = {"position": [1.0, 2.0, 3.5], "quaternion": [0.0, 1.0, 0.0, 0.0]}
BRANCH = {"configuration": {"back": False, "down": True, "flip": False, "quadrants": [0, 0, 0]}}
JOINTS = {"joints": [1, 2, 3, 4, 5, 6]}


def target(name: str, values: dict[str, Any], robot: str | None = None, **more: str):
    return TaughtTarget(name, values, more, robot)


def changes(before: str, after: str) -> list[str]:
    lines = difflib.ndiff(before.splitlines(), after.splitlines())
    return sorted(line for line in lines if line[0] in "+-")


def others(text: str, name: str) -> str:
    content = tomllib.loads(text)
    targets = [one for one in content["targets"] if one["name"].lower() != name]
    return repr({**content, "targets": targets})


def test_a_new_file():
    source = SourceText(new_file_text("rv-2aj"), "x.toml", "utf-8", "\n")
    text, reading = with_target(source, "x", target("above", POSE, "rv-2aj"))
    assert text.text == (
        'robot = "rv-2aj"\n\n[[targets]]\nname = "above"\nposition = [1, 2, 3.5]\n'
        "quaternion = [0, 1, 0, 0]\n"
    )
    assert list(reading.program.targets) == ["above"] and reading.program.robot == "rv-2aj"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("end", ["", "\n", "\n\n# the end"])
def test_a_target_behind_all_others(newline, end):
    before = (SAMPLE.read_text("utf-8").rstrip() + end).replace("\n", newline)
    source = SourceText(before, str(SAMPLE), "utf-8", newline)
    text, reading = with_target(source, "taught", target("last", POSE, tool="gripper"))
    assert text.text.startswith(before) and text.text.count("\n") == text.text.count(newline)
    assert list(reading.program.targets)[-1] == "last"
    assert others(before, "last") == others(text.text, "last")
    assert reading.program.targets["last"].pose.position == (1.0, 2.0, 3.5)


def test_taught_anew_only_its_place_changes():
    before = SAMPLE.read_text("utf-8")
    source = SourceText(before, str(SAMPLE), "utf-8", "\n")
    text, reading = with_target(source, "taught", target("Above", {**POSE, **BRANCH}), again=True)
    assert changes(before, text.text) == [
        "+ configuration = {back = false, down = true, flip = false, quadrants = [0, 0, 0]}",
        "+ position = [1, 2, 3.5]      # mm",
        "+ quaternion = [0, 1, 0, 0]",
        "- euler_zyx = [0, 0, 180]     # degrees: the tool points down",
        "- position = [420, -60, 360]  # mm",
    ]
    assert others(before, "above") == others(text.text, "above")
    program = reading.program
    assert program.targets["above"].configuration.down and len(program.targets) == 5


@pytest.mark.parametrize(
    ("name", "values", "wanted"),
    [
        ("home", JOINTS, ["+ joints = [1, 2, 3, 4, 5, 6]   # degrees",
                          "- joints = [0, 0, 0, 0, 30, 0]  # degrees"]),
        ("home", POSE, ["+ position = [1, 2, 3.5]",
                        "+ quaternion = [0, 1, 0, 0]",
                        "- joints = [0, 0, 0, 0, 30, 0]  # degrees"]),
        ("down", JOINTS, ["+ joints = [1, 2, 3, 4, 5, 6]",
                          "- euler_zyx = [0, 0, 180]",
                          "- position = [420, -60, 300]"]),
    ],
)  # fmt: skip
def test_joints_for_a_pose_and_a_pose_for_joints(name, values, wanted):
    before = SAMPLE.read_text("utf-8")
    source = SourceText(before, str(SAMPLE), "utf-8", "\n")
    text, reading = with_target(source, "taught", target(name, values), again=True)
    assert changes(before, text.text) == wanted
    assert name in (
        reading.program.joint_targets if "joints" in values else reading.program.targets
    )
    assert others(before, name) == others(text.text, name)


def test_an_old_branch_goes_with_its_place():
    entry = {"name": "a", **POSE, **BRANCH, "speed": 5}
    lines = (f"{key} = {toml_value(value)}\n" for key, value in entry.items())
    source = SourceText("[[targets]]\n" + "".join(lines), "x.toml")
    other = {**POSE, "position": [9.0, 9.0, 9.0]}
    text, reading = with_target(source, "x", target("a", other), again=True)
    assert "configuration" not in text.text and "speed = 5" in text.text
    assert reading.program.targets["a"].configuration is None


@every_row(
    ("text", "one", "again", "code"),
    [
        ('[[targets]]\nname = "A"\njoints = [1]\n', target("a", POSE), False, "TB509"),
        ("", target("1a", POSE), False, "TB507"),
        ("", target('a"\nb', POSE), False, "TB507"),
        ('targets = [{name = "a", joints = [1]}]', target("b", POSE), False, "TB508"),
        ('targets = [{name = "a", joints = [1]}]', target("a", POSE), True, "TB508"),
        ('robot = "rv-2aj"\n', target("a", POSE, "irb1200-7-0.7"), False, "TB510"),
        ('[[targets]]\nname = "a"\njoints = [1]\nexternal = [5]', target("a", POSE), True, "TB511"),
        ("", target("a", JOINTS, "rv-2aj"), False, "TB512"),
        ("", target("a", POSE, tool="none"), False, "TB301"),
        ("[[targets]\n", target("a", POSE), False, "CT301"),
        ("[motion]\nspeed = -1\n", target("a", POSE), False, "CT303"),
    ],
)  # fmt: skip
def test_what_is_refused(text, one, again, code):
    with pytest.raises(Refused) as refused:
        with_target(SourceText(text, "x.toml", "utf-8", "\n"), "x", one, again=again)
    assert [finding.code for finding in refused.value.findings] == [code]


@pytest.mark.parametrize(
    ("entry", "after"),
    [
        # A branch in dotted keys goes with its place; CRLF and tabs stay.
        (
            "\tjoints=[1]\r\nconfiguration.back = false\r\nconfiguration.down = true\r\nwait = 5 #",
            "\tposition = [1, 2, 3.5]\r\nquaternion = [0, 1, 0, 0]\r\nwait = 5 #",
        ),
        (
            "position = [\n1,\n2, # y\n9]\neuler_zyx = [0, 0, 0]",
            "position = [1, 2, 3.5]\nquaternion = [0, 1, 0, 0]",
        ),
        (
            "position = [1, 2.0, 3.5]\nquaternion = [0, 1, 0, 0.0]",
            "position = [1, 2.0, 3.5]\nquaternion = [0, 1, 0, 0.0]",
        ),
        # It cannot be taken out of a table of its own.
        ("joints = [1]\n[targets.configuration]\nback = false", None),
    ],
)
def test_layouts_of_an_entry(entry, after):
    newline = "\r\n" if "\r" in entry else "\n"
    head, rest = (
        f'[[targets]]{newline}name = "a"{newline}',
        f'{newline}[[targets]]{newline}name = "b"{newline}joints = [nan, 1]',
    )
    source = SourceText(head + entry + rest, "x.toml", "utf-8", newline)
    if after is None:
        with pytest.raises(Refused) as refused:
            with_target(source, "x", target("a", POSE, "rv-2aj"), again=True)
        assert [finding.code for finding in refused.value.findings] == ["TB513"]
        return
    text, _ = with_target(
        source, "x", target("a", POSE), replace(NO_PROCESS, robot="rv-2aj"), again=True
    )
    assert text.text == head + after + rest
