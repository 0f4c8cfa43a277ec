"""Scripts of simulated runs: what they say, what they do to a run, and what is wrong in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages, robots
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.compiler.simulated_run import parse_script, programs
from assistant.virtual.events import Moved, Run, Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.script import InputChange, follow
from assistant.virtual.melfa import start_slot
from assistant.virtual.program_run import Settings, prepared
from assistant.virtual.rapid.interpreter import start_task

RAPID = """MODULE cell
PROC main()
  WaitDI diStart,1;
  Set doGrip;
  WaitDI diClosed,1;
  Reset doGrip;
  WaitDI diClosed,0;
  WaitTime 1;
ENDPROC
ENDMODULE
"""
MELFA = """10 WAIT M_IN(3)=1
20 M_OUT(8)=1
30 WAIT M_IN(4)=1
40 M_OUT(8)=0
50 WAIT M_IN(4)=0
60 DLY 1
70 END
"""
SCRIPT = """
[[set]]
input = {start}
at = 2.5

[[set]]
input = {closed}
when = "{grip} = 1"
after = 0.25
for = 0.5
"""


def scripted(text: str, program: str) -> tuple[Run, list[InputChange]]:
    kernel = Kernel(most_time=100.0, most_steps=2000)
    language = languages.get("rapid" if program.startswith("MODULE") else "melfa-basic-4")
    tree = language.parse(program)
    (start_task if language.family == "RA" else start_slot)(kernel, [tree])
    given = follow(kernel, parse_script(SourceText(text, "cell.toml")), [SourceText(program)])
    return kernel.run(), given


@pytest.mark.parametrize(
    ("program", "names"),
    [(RAPID, ('"diStart"', '"DICLOSED"', "doGrip")), (MELFA, ("3", '"4"', "8"))],
)
def test_inputs_change_at_times_and_after_outputs(
    program: str, names: tuple[str, str, str]
) -> None:
    start, closed, grip = names
    run, given = scripted(SCRIPT.format(start=start, closed=closed, grip=grip), program)
    assert run.ended == "end"
    assert [row.value for row in given] == [1.0, 1.0, 0.0]
    assert [row.time for row in given] == pytest.approx([2.5, 2.75, 3.25], abs=0.01)
    on_off = [(x.time, x.what.value) for x in run.log if isinstance(x.what, Switched)]
    assert [value for _, value in on_off] == [1.0, 0.0]
    assert [time for time, _ in on_off] == pytest.approx([2.5, 2.75], abs=0.01)
    assert run.seconds == pytest.approx(4.25, abs=0.01)


MOVES = """10 P1=(400,0,500,180,0,180)(7,0)
20 P2=(400,50,500,180,0,180)(7,0)
30 FOR M1=1 TO 3
40 MVS P1
50 MVS P2
55 DLY 0.1
60 NEXT M1
70 END
"""


@pytest.mark.parametrize(
    ("when", "lines"),
    [
        ("visit P2", [50, 50, 50]),
        ("Visit 2 of p2", [50]),
        ("visit 3", [40]),
        ("visit 4 of P2", []),
        ("visit P3", []),
    ],
)
def test_an_input_comes_with_a_motion(when: str, lines: list[int]) -> None:
    text = f'[[set]]\ninput = 3\nwhen = "{when}"\nfor = 0.001\nafter = 0\n'
    run, given = scripted(text, MOVES)
    before = [run.log[one.row - 1] for one in given if one.value == 1.0]
    assert [10 * row.place[1] for row in before if row.place] == lines
    assert all(isinstance(row.what, Moved) for row in before)


def test_a_program_sees_an_input_of_a_visit_while_its_arm_is_on_its_way(tmp_path: Path) -> None:
    path = tmp_path / "MOVES.mb4"
    path.write_text(MOVES.replace("55 DLY 0.1", "55 IF M_IN(3)=1 THEN M_OUT(9)=1"))
    found = programs([str(path)])
    kernel = prepared(found, Settings(robot=robots.get("rv-4frl"), most_time=60.0))
    script = parse_script(SourceText('[[set]]\ninput = 3\nwhen = "visit 2 of P2"\n', "cell.toml"))
    follow(kernel, script, found.sources())
    run = kernel.run()
    assert run.ended == "end", run.message
    moved = [one for one in run.events if isinstance(one, Moved | Switched)]
    assert isinstance(moved[4], Switched), moved


def test_a_comment_names_no_place() -> None:
    text = '[[set]]\ninput = 3\nwhen = "visit P2"\n'
    _, given = scripted(text, MOVES.replace("50 MVS P2", "50 MVS P1 ' P2"))
    assert not given


def test_an_input_comes_again_and_again() -> None:
    text = '[[set]]\ninput = "diStart"\nat = 1\nfor = 0.5\nevery = 2\n'
    waits = "WaitDI diStart,1;\nWaitDI diStart,0;\n" * 3
    run, given = scripted(text, f"MODULE a\nPROC main()\n{waits}ENDPROC\nENDMODULE\n")
    assert run.ended == "end"
    assert [row.time for row in given] == [1.0, 1.5, 3.0, 3.5, 5.0, 5.5]


def test_inputs_that_set_each_other_for_ever_end_at_the_limit() -> None:
    text = (
        '[[set]]\ninput = "a"\n[[set]]\ninput = "a"\nvalue = 0\nwhen = "input a = 1"\n'
        '[[set]]\ninput = "a"\nwhen = "input a = 0"\n'
    )
    run, _ = scripted(text, "MODULE a\nPROC main()\nWaitDI b,1;\nENDPROC\nENDMODULE\n")
    assert run.ended == "steps"


@pytest.mark.parametrize(
    ("text", "code", "line", "says"),
    [
        ("[[set]\n", "CT301", 1, "no TOML"),
        ("[[sets]]\ninput = 1\n", "CT302", 1, "write `set`"),
        ("[[set]]\ninputs = 1\n", "CO032", 1, "input"),
        ("[[set]]\ninput = 1\nuntil = 3\n", "CT302", 3, "use one of"),
        ("[[set]]\ninput = 1\nevry = 3\n", "CT302", 3, "write `every`"),
        ("[set]\ninput = 1\n", "CO031", 1, "a table"),
        ("set = 3\n", "CO031", 1, "a number"),
        ("[[set]]\ninput = 1.5\n", "CT303", 2, "text"),
        ('[[set]]\ninput = "a b"\n', "CT303", 2, "name of a signal"),
        ('[[set]]\ninput = 1\nvalue = "on"\n', "CT303", 3, "without quotes"),
        ("[[set]]\ninput = 1\nat = -1\n", "CT303", 3, "0 or more"),
        ("[[set]]\ninput = 1\nfor = 0\n", "CT303", 3, "over 0"),
        ('[[set]]\ninput = 1\nwhen = "do1"\n', "CT303", 3, "NAME = VALUE"),
        ('[[set]]\ninput = 1\nwhen = "do1 = nan"\n', "CT303", 3, "NAME = VALUE"),
        ('[[set]]\ninput = 1\nwhen = "do1 = 1"\nat = 2\n', "CO033", 4, "keep one"),
        ("[[set]]\ninput = 1\nafter = 2\n", "CO032", 3, "when"),
        ('[[set]]\ninput = 1\nwhen = "visit 0 of p1"\n', "CT303", 3, "from 1"),
        ('[[set]]\ninput = 1\nwhen = "visit 1 p1"\n', "CT303", 3, "visit 3 of NAME"),
        ("[[set]]\ninput = 1\nfor = 2\nevery = 2\n", "CO034", 3, "shorter"),
        ('[[answer]]\nto = "x"\n', "CO032", 1, "value"),
        ("[[answer]]\nvalue = true\n", "CT303", 2, "a text in quotes"),
    ],
)
def test_what_is_wrong_has_its_place_and_cure(text: str, code: str, line: int, says: str) -> None:
    with pytest.raises(Refused) as caught:
        parse_script(SourceText(text, "cell.toml"))
    found = {(f.code, f.path, f.line): f"{f.message} {f.cure}" for f in caught.value.findings}
    assert says in found[code, "cell.toml", line]
    assert caught.value.exit_status == 2
