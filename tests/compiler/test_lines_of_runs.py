"""Lines of long runs of moves: where findings of the whole program are, and rows of reports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from assistant.api.analysis import simulate
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.compiler.checker import check_files, check_text
from assistant.compiler.translation import Translation, translate
from assistant.editing.service import Workspace, findings
from tests.cli.test_commands import run

EAX = "[9E9,9E9,9E9,9E9,9E9,9E9]"
SIZES = (3, 7, 8, 9, 50)
PLACES = {"first": lambda _: 0, "middle": lambda size: size // 2, "last": lambda size: size - 1}
BY_NAME, WRITTEN, NUMBERED = FORMS = ("by name", "written out", "numbered")


def target(number: int, *, far: bool = False) -> str:
    return f"[[{2400 if far else 350 + number},0,400],[0,0,1,0],[0,0,0,0],{EAX}]"


def module(form: str, size: int, bad: int, *, far: bool = False, tool: str = "tool0") -> str:
    """A run of moves to targets, one of which is out of reach or has another tool."""
    names = [f"s_{k + 1}" if form == NUMBERED else f"q{k}" for k in range(size)]
    targets = [target(k, far=far and k == bad) for k in range(size)]
    data = [f"CONST robtarget {n}:={t};\n" for n, t in zip(names, targets, strict=True)]
    goals = targets if form == WRITTEN else names
    moves = [
        f"MoveL {goal},v100,fine,{tool if k == bad else 'tool0'};\n" for k, goal in enumerate(goals)
    ]
    declared = "" if form == WRITTEN else "".join(data)
    return f"MODULE m\n{declared}PROC main()\n{''.join(moves)}ENDPROC\nENDMODULE\n"


def line_of(form: str, size: int, row: int) -> int:
    """The line of a move of such a module."""
    return 3 + row + size * (form != WRITTEN)


@pytest.mark.parametrize(
    ("form", "size", "place"),
    [
        *((form, size, "middle") for form in FORMS for size in SIZES),
        *((NUMBERED, 50, place) for place in ("first", "last")),
    ],
)
def test_a_target_out_of_reach_is_reported_at_its_move(form: str, size: int, place: str) -> None:
    bad = PLACES[place](size)
    lines = module(form, size, bad, far=True).replace("tool0;", "tool0; ! seen", size // 2)
    text = SourceText(lines, "m.mod", newline="\n")
    found = check_text(text, language="rapid", robot="irb120-3-0.58").findings
    told = [(f.code, f.line, f.column) for f in found if f.code.startswith("RB")]
    assert told == [("RB102", line_of(form, size, bad), 1)]


@pytest.mark.parametrize("size", SIZES)
def test_positions_out_of_reach_are_reported_at_their_moves(size: int) -> None:
    bad = size // 2
    moves = "".join(f"{k + 2} MVS P{k + 1}\n" for k in range(size))
    x = [2400 if k == bad else 350 + k for k in range(size)]
    data = "".join(
        f"P{k + 1}=({x[k]}.00,0.00,400.00,180.00,0.00,180.00)(7,0)\n" for k in range(size)
    )
    text = SourceText(f"1 TOOL (0,0,0,0,0,0)\n{moves}900 END\n{data}", "M.prg", newline="\n")
    found = check_text(text, language="melfa-basic-4", robot="rv-4frl").findings
    assert [(f.line, f.column) for f in found if f.code == "RB102"] == [(bad + 2, 1)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", SIZES)
def test_what_no_arm_runs_is_refused_at_its_line(tmp_path: Path, form: str, size: int) -> None:
    file = tmp_path / "m.mod"
    file.write_text(module(form, size, size - 2, far=True))
    with pytest.raises(Refused) as refused:
        simulate(file, robot="irb120-3-0.58")
    found = [f.line for f in refused.value.findings if f.code == "RB102"]
    assert found == [line_of(form, size, size - 2)]


def translated(tmp_path: Path, text: str, to: str = "melfa-basic-5") -> Translation:
    file = tmp_path / "m.mod"
    file.write_text(text)
    return translate(file, to=to, draft=True)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", SIZES)
def test_each_move_is_a_row_of_the_report(tmp_path: Path, form: str, size: int) -> None:
    done = translated(tmp_path, module(form, size, size // 2, tool="nowhere"))
    declared = size * (form != WRITTEN)
    assert done.totals == {"supported": declared + size, "partial": 0, "not": 1}
    levels = {row.place.line: row.level for row in done.rows}
    moves = range(line_of(form, size, 0), line_of(form, size, size))
    bad = line_of(form, size, size // 2)
    assert [line for line in moves if levels[line] == "not"] == [bad]
    assert len(done.rows) == sum(done.totals.values())
    assert [row.place.line for row in done.rows] == [*range(2, 2 + declared), 2 + declared, *moves]
    assert all(row.count == 1 for row in done.rows)
    assert done.rows[-1].text.startswith("MoveL ")
    (written,) = done.files.values()
    assert written.count(b"Mvs ") == size - 1, "a draft has all other moves"


def test_where_each_move_of_a_path_went(tmp_path: Path) -> None:
    done = translated(tmp_path, module(NUMBERED, 20, -1))
    ((name, data),) = done.files.items()
    lines = data.decode().splitlines()
    went = [row.went[0] for row in done.rows if row.text.startswith("MoveL")]
    assert [lines[place.line - 1].split()[1:] for place in went] == [
        ["Mvs", f"P{k}"] for k in range(1, 21)
    ], name


def test_a_remark_on_joint_moves_is_at_those_alone(tmp_path: Path) -> None:
    text = module(NUMBERED, 12, -1).replace("MoveL s_4,", "MoveJ s_4,")
    done = translated(tmp_path, text)
    changed = [row.text for row in done.rows if row.level == "partial"]
    assert changed == ["MoveJ s_4,v100,fine,tool0"]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("place", PLACES)
def test_an_editor_shows_an_undeclared_target_in_a_run(
    tmp_path: Path, size: int, place: str
) -> None:
    bad = PLACES[place](size)
    text = module(BY_NAME, size, bad).replace(f"MoveL q{bad},", "MoveL nowhere,")
    workspace = Workspace(tmp_path)
    document = workspace.open(str(tmp_path / "m.mod"), text, version=1)
    told = [
        (f.diagnostic.code, f.range.start.line, f.range.start.column) for f in findings(document)
    ]
    assert ("RA403", line_of(BY_NAME, size, bad) - 1, 6) in told


def told(file: Path, *codes: str, robot: str | None = None) -> list[tuple[str, int | None]]:
    found = check_files([file], robot=robot).findings
    return [(f.code, f.line) for f in found if f.code in codes]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("size", SIZES)
def test_a_speed_that_cannot_be_meant_is_reported_at_its_move(
    tmp_path: Path, form: str, size: int
) -> None:
    """Also one in a run, and those of two moves at both."""
    at, file = size // 2, tmp_path / "m.mod"
    lines = module(form, size, -1).split("\n")
    bad = [line_of(form, size, row) for row in (at, size - 1)]
    for line in bad:
        lines[line - 1] = lines[line - 1].replace("v100", "[0.001,500,5000,1000]")
    file.write_text("\n".join(lines))
    assert told(file, "CK201") == [("CK201", line) for line in bad]


def test_declared_data_are_reported_at_their_lines(tmp_path: Path) -> None:
    joints = f"[[0,0,0,0,300,0],{EAX}]"
    file = tmp_path / "m.mod"
    file.write_text(
        f"""MODULE m
CONST jointtarget j1:={joints};
CONST speeddata fast:=[100000,500,5000,1000];
CONST zonedata wide:=[FALSE,90000,90000,90000,9000,90000,9000];
PROC main()
MoveAbsJ j1,v100,fine,tool0;
MoveAbsJ {joints},v100,fine,tool0;
MoveL {target(1)},fast,wide,tool0;
MoveAbsJ {joints},v100,fine,tool0;
ENDPROC
ENDMODULE
"""
    )
    found = told(file, "CK201", "CK202", "RB109", robot="irb120-3-0.58")
    assert sorted(found) == [
        ("CK201", 3), ("CK202", 4), ("RB109", 2), ("RB109", 7), ("RB109", 9),
    ]  # fmt: skip


def contacts(form: str, size: int, at: Sequence[int]) -> str:
    """A run of moves, some of which lead the wrist into the base; far apart without a form."""
    places = [(400, -300 + 600 * k / size, 300) for k in range(size)]
    for k in at:
        places[k] = (100, 60, 60 + k)
    between = "TPErase;\n" if form == "apart" else ""
    moves = "".join(
        f"{between}MoveJ [[{x:g},{y:g},{z:g}],[0,0,1,0],[0,0,0,0],{EAX}],v200,fine,tool0;\n"
        for x, y, z in places
    )
    return f"MODULE m\nPROC main()\n{moves}ENDPROC\nENDMODULE\n"


@pytest.mark.parametrize("form", ["run", "apart"])
def test_contacts_are_at_each_move_and_shown_by_pairs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, form: str
) -> None:
    """Two stretches of moves: what reads each line has them all, a user one finding."""
    file, step = tmp_path / "m.mod", 1 + (form == "apart")
    file.write_text(contacts(form, 13, (2, 3, 4, 10)))
    lines = [2 + step * (k + 1) for k in (2, 3, 4, 5, 10, 11)]
    found = check_files([file], robot="irb1200-7-0.7").findings
    into = [f for f in found if f.code == "CK421" and "`robot.base`" in f.message]
    into = [f for f in into if "`robot.J4`" in f.message]
    assert [f.line for f in into] == lines
    for command in ("check", "simulate"):
        status, *both = run(capsys, command, file, "-r", "irb1200-7-0.7")
        assert status == 1
        said = "".join(both)
        shown = [x for x in said.splitlines() if x.startswith("CK421") and "`robot.J4`" in x]
        shown = [x.split(": ")[0].split(" ", 3)[-1] for x in shown if "`robot.base`" in x]
        assert shown == [f"6 moves, lines {lines[0]} to {lines[-1]}"]
