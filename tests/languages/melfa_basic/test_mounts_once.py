"""`Tool` and `Base` are written once where all callers of a procedure have the same ones."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.program.pseudo import parse

from .programs import differences
from .test_translation import DIALECTS, there_and_back

ONE_TOOL = """program job

tool torch tip [0, 0, 120]

signal go digital input 3

target a [300, 0, 300] [0, 1, 0, 0]
target b [300, 50, 300] [0, 1, 0, 0]

procedure main
  # begins with a comment
  wait for go = 1
  call weld
  move linear b speed 50 mm/s blend fine tool torch
  call seam
end

procedure weld
  call seam
  call seam
end

procedure seam
  # along the edge
  if go = 1
    move linear a speed 50 mm/s blend fine tool torch
  else
    move linear b speed 50 mm/s blend fine tool torch
  end
end
"""
TWO_TOOLS = ONE_TOOL.replace(
    "  move linear b speed 50 mm/s blend fine tool torch\n  call seam\n",
    "  call cut\n  move linear b speed 50 mm/s blend fine tool cutter\n  call cut\n",
    1,
).replace("signal go", "tool cutter tip [10, 0, 60]\n\nsignal go") + (
    """
procedure cut
  move linear a speed 50 mm/s blend fine tool cutter
  call edge
end

procedure edge
  move linear b speed 50 mm/s blend fine tool cutter
end
"""
)


def lines(text: str) -> list[str]:
    """The code lines without step numbers and indents."""
    return [re.sub(r"^\d+\s+", "", line).strip() for line in text.splitlines()]


def code_of(text: str, name: str) -> str:
    program = parse(text)
    adapted, back, texts = there_and_back(program, name)
    assert differences(back, adapted) == []
    return texts[0]


@pytest.mark.parametrize("name", DIALECTS)
def test_a_program_with_one_tool_sets_it_in_its_first_lines(name: str) -> None:
    found = lines(code_of(ONE_TOOL, name))
    at = [index for index, line in enumerate(found) if re.match("(?i)tool |base ", line)]
    assert [found[index].split()[0].lower() for index in at] == ["tool", "base"]
    assert found[at[0] - 1].startswith("' begins")
    speed, below = (found[at[1] + n].lower() for n in (1, 2))
    assert speed.startswith("spd ") and below.startswith("wait")
    assert sum(line.lower().startswith("spd ") for line in found) == 1


@pytest.mark.parametrize("name", DIALECTS)
def test_procedures_with_another_tool_set_it_where_they_begin(name: str) -> None:
    found = lines(code_of(TWO_TOOLS, name))
    tools = [line for line in found if re.match("(?i)tool ", line)]
    # Of `weld`, of the move in `main`, and of `cut`; `seam` and `edge` keep theirs.
    assert sorted(line.split()[1].upper() for line in tools) == ["PCUTTER", "PCUTTER", "PTORCH"]
    assert len([line for line in found if re.match("(?i)base ", line)]) == 1


def test_a_call_with_another_tool_is_seen(tmp_path: Path) -> None:
    program = parse(TWO_TOOLS)
    adapted, _, texts = there_and_back(program, "melfa-basic-5")
    before, after = "GoSub *EDGE", "Tool P_NTool\n{} GoSub *EDGE"
    number = re.search(rf"(\d+) {re.escape(before)}", texts[0])
    assert number is not None
    other = texts[0].replace(before, after.format(int(number[1]) + 1), 1)
    language = languages.get("melfa-basic-5")
    parsed = language.parse(renumbered(other))
    assert differences(language.lift([parsed], None), adapted) != []
    for file, text in (("one.prg", texts[0]), ("other.prg", renumbered(other))):
        (tmp_path / file).write_text(text, "ascii")
    names = str(tmp_path / "one.prg"), str(tmp_path / "other.prg")
    same = assistant.compare(names[0], names[0], robot="rv-4frl", from_robot="rv-4frl", text=True)
    done = assistant.compare(*names, robot="rv-4frl", from_robot="rv-4frl", text=True)
    assert same.equal and not done.equal


def renumbered(text: str) -> str:
    """Steps counted anew."""
    count = 0
    out = []
    for line in text.splitlines():
        if re.match(r"\d+ ", line):
            count += 1
            line = re.sub(r"^\d+", str(count), line)
        out.append(line)
    return "\r\n".join(out) + "\r\n"


def test_a_frame_that_a_program_moves_is_set_again() -> None:
    text = ONE_TOOL.replace(
        "tool torch tip", "frame table user [10, 0, 0]\ntool torch tip"
    ).replace("tool torch\n", "tool torch frame table\n")
    moved = text.replace("  call weld\n", "  call weld\n  table = a\n", 1)
    code_of(text, "melfa-basic-5")
    assert len(re.findall("(?i) base ", code_of(moved, "melfa-basic-5"))) > 1


def test_procedures_that_nothing_calls_set_what_they_call() -> None:
    dead = ONE_TOOL + "\nprocedure unused\n  call other\nend\n\nprocedure other\n"
    dead += "  move linear a speed 50 mm/s blend fine tool torch\n  call seam\nend\n"
    found = lines(code_of(dead, "melfa-basic-5"))
    # In `main`, in `other`, and in `seam`, which is called by it.
    assert len([line for line in found if line.startswith("Tool ")]) == 3


def test_procedures_set_what_they_need_after_a_stop_of_a_draft() -> None:
    text = ONE_TOOL.replace("procedure weld\n", "procedure weld\n  stop\n", 1)
    found = lines(code_of(text, "melfa-basic-5"))
    seam = found[found.index("*SEAM") :]
    assert [line.split()[0] for line in seam if line.startswith(("Tool ", "Base "))].count(
        "Tool"
    ) == 2


BETWEEN = """program job

tool torch tip [0, 0, 120]
tool cutter tip [10, 0, 60]

signal go digital input 3
signal clamp digital output 4

variable count number

target a [300, 0, 300] [0, 1, 0, 0]
target b [300, 50, 300] [0, 1, 0, 0]

procedure main
  move linear a speed 50 mm/s blend fine tool torch
  {between}
  move linear b speed 50 mm/s blend fine tool torch
  stop
  call other
end

procedure other
  move linear a speed 50 mm/s blend fine tool cutter
  call close
  move linear b speed 50 mm/s blend fine tool cutter
end

procedure close
  {inside}
  wait for go = 1
end

procedure cut
  move linear a speed 50 mm/s blend fine tool cutter
end
"""
KEPT = {
    "a call": "call close",
    "two calls": "call close\n  call close",
    "a branch": "if go = 1\n    set clamp = 1\n  else\n    call close\n  end",
    "a loop": "while go = 1\n    call close\n    count = count + 1\n  end",
    "a wait": "wait for go = 1 or clamp = 1",
}
SET_AGAIN = {
    "a call of another tool": "call cut",
    "a branch with another tool": "if go = 1\n    call cut\n  end",
    "a stop in a branch": "if go = 1\n    stop\n  end",
    "a label": "if go = 1\n    goto again\n  end\n  label again",
}


def tools_of_main(between: str, inside: str = "set clamp = 1") -> list[str]:
    """The tools that the text sets before its first stop."""
    found = lines(code_of(BETWEEN.format(between=between, inside=inside), "melfa-basic-5"))
    main = found[: found.index("GoSub *OTHER")]
    return [line.split()[1] for line in main if line.startswith("Tool ")]


@pytest.mark.parametrize("between", KEPT.values(), ids=list(KEPT))
def test_what_sets_no_tool_between_two_moves_leaves_it(between: str) -> None:
    assert tools_of_main(between) == ["PTORCH"]


@pytest.mark.parametrize("between", SET_AGAIN.values(), ids=list(SET_AGAIN))
def test_the_tool_is_set_again_where_it_may_be_another(between: str) -> None:
    assert tools_of_main(between) == ["PTORCH", "PTORCH"]


@pytest.mark.parametrize("inside", ["stop", "call cut"])
def test_so_it_is_after_a_call_that_may_change_it(inside: str) -> None:
    assert tools_of_main("call close", inside) == ["PTORCH", "PTORCH"]


@pytest.mark.parametrize(
    ("answer", "times"), [("set clamp = 1", 1), ("call close", 1), ("stop", 2)]
)
def test_an_interrupt_that_may_change_it_makes_nothing_certain(answer: str, times: int) -> None:
    text = BETWEEN.format(between="call close", inside="set clamp = 1")
    begin = "procedure main\n"
    interrupt = "  interrupt late when go = 1 calls note\n"
    text = text.replace(begin, begin + interrupt, 1) + f"\nprocedure note\n  {answer}\nend\n"
    found = lines(code_of(text, "melfa-basic-5"))
    main = found[: found.index("GoSub *OTHER")]
    assert [line for line in main if line.startswith("Tool ")] == ["Tool PTORCH"] * times


@pytest.mark.parametrize("name", DIALECTS)
def test_an_end_for_good_and_a_plain_interrupt_leave_one_tool_at_the_begin(name: str) -> None:
    """Nothing runs after such an end but the program from its first line."""
    text = ONE_TOOL.replace(
        "procedure main\n", "procedure main\n  interrupt late when go = 0 calls note\n", 1
    )
    text = text.replace("  if go = 1\n", "  if go = 0\n    exit\n  end\n  if go = 1\n", 1)
    text += "\nprocedure note\n  set clamp = 1\nend\n"
    text = text.replace("\ntarget a", "signal clamp digital output 4\n\ntarget a", 1)
    found = lines(code_of(text, name))
    assert "HLT" in (line.upper() for line in found)
    for word in ("tool ", "base "):
        assert len([line for line in found if line.lower().startswith(word)]) == 1


def test_a_loop_that_stops_and_goes_on_sets_it_again() -> None:
    """The user may set another tool at a stop that the program continues after."""
    assert tools_of_main("while go = 1\n    stop\n  end") == ["PTORCH", "PTORCH"]
    assert tools_of_main("while 1\n    stop\n    call close\n  end") == ["PTORCH", "PTORCH"]
