"""Settings that an interrupt may change between any two lines, while it is switched on."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.compiler import Translation, load
from assistant.program import statements as p
from assistant.program.statements import Reason
from tests.tables import every_row

MELFA = "melfa-basic-5"
POSITIONS = "".join(f"P{i}=({i}00,0,300,180,0,180)(7,0)\n" for i in range(1, 9))
INTERRUPT = "Def Act 1,M_In(1)=1 GoSub *H\n"
HANDLER = "End\n*H\nSpd 50\nReturn 1\n"


def translated(folder: Path, text: str, to: str) -> Translation:
    file = folder / "cell.prg"
    file.write_text(text + POSITIONS)
    return assistant.translate(file, to=to, language=MELFA)


def uncertain(*texts: str) -> dict[str, Reason]:
    """The moves whose settings differ with the way that leads to them, and why."""
    language = languages.get(MELFA)
    program = language.lift([language.parse(text + POSITIONS) for text in texts])
    return {
        one.text: one.reason
        for one in program.statements()
        if isinstance(one, p.Opaque) and one.text[:2] in ("Mv", "Mo") and one.reason is not None
    }


def interrupted(text: str) -> str:
    """The targets of moves whose settings an interrupt may change, in their order."""
    return " ".join(
        move.removeprefix("Mvs ")
        for move, reason in uncertain(text).items()
        if "an interrupt may set the speed at any time" in reason.why
    )


def code_of(made: Translation) -> list[str]:
    """The lines of code that were written, below the heading."""
    assert made.ok
    (text,) = made.files.values()
    lines = [line.split(" ", 1)[1] for line in text.decode().splitlines() if line[0].isdigit()]
    return [line for line in lines if not line.startswith("'")]


@pytest.mark.parametrize(
    ("setting", "move"),
    [
        ("Spd 50", "Mvs"),
        ("JOvrd 50", "Mov"),
        ("Cnt 1", "Mvs"),
        ("Tool P8", "Mov"),
        ("Base P8", "Mvs"),
        ("M_Tool=2", "Mov"),
    ],
)
def test_what_an_interrupt_sets_stays_and_so_do_the_moves(
    tmp_path: Path, setting: str, move: str
) -> None:
    before = ["Def Act 1,M_In(1)=1 GoSub *H", "JOvrd 80", "Spd 100", "Cnt 0", "Tool P6"]
    behind = ["Act 1=1", f"{move} P1", f"{move} P2", "End", "*H", setting, "Return 1"]
    made = translated(tmp_path, "\n".join([*before, *behind, ""]), MELFA)
    code = code_of(made)
    assert code[code.index("Act 1=1") :] == [*behind, "End"]
    word = setting.split()[0]
    assert [line for line in before if line.startswith(word)] == [
        line for line in code[: code.index("Act 1=1")] if line.startswith(word)
    ]


def test_what_an_interrupt_sets_nothing_of_is_written_as_ever(tmp_path: Path) -> None:
    handler = "End\n*H\nM_Out(1)=1\nReturn 1\n"
    text = f"{INTERRUPT}Spd 100\nAct 1=1\nMvs P1\nM_Out(2)=1\nMvs P2\n{handler}"
    assert code_of(translated(tmp_path, text, MELFA)) == [
        "Def Act 1,M_In(1)=1 GoSub *H", "Act 1=1", "Tool P_NTool", "Base P_NBase", "Spd 100",
        "Cnt 0", "Mvs P1", "M_Out(2)=1", "Mvs P2", "End", "*H", "M_Out(1)=1", "Return 1", "End",
    ]  # fmt: skip
    assert interrupted(text) == ""


def test_a_move_tells_which_line_of_an_interrupt_it_is() -> None:
    found = uncertain(f"{INTERRUPT}Act 1=1\nMvs P1\n{HANDLER}")["Mvs P1"]
    assert found.why == "an interrupt may set the speed at any time, by `Spd 50` in line 6"
    assert found.cure == (
        "leave Spd out of what the interrupt calls, or switch the interrupt off and set Spd above "
        "the move"
    )


WHERE = {
    "behind the line that switches it on": (
        f"{INTERRUPT}Spd 100\nMvs P1\nAct 1=1\nMvs P2\nSpd 90\nMvs P3\n{HANDLER}", "P2 P3",
    ),
    "not behind the one that switches it off, once it is set again": (
        f"{INTERRUPT}Act 1=1\nMvs P1\nAct 1=0\nMvs P2\nSpd 90\nMvs P3\n{HANDLER}", "P1 P2",
    ),
    "all off": (f"{INTERRUPT}Act 1=1\nAct 0=0\nSpd 9\nMvs P3\n{HANDLER}", ""),
    "another off": (f"{INTERRUPT}Act 1=1\nAct 2=0\nSpd 9\nMvs P3\n{HANDLER}", "P3"),
    "perhaps off": (
        f"{INTERRUPT}Act 1=1\nIf M1=1 Then Act 1=0\nSpd 9\nMvs P3\n{HANDLER}", "P3",
    ),
    "worked out": (f"{INTERRUPT}Act 1=1\nAct 1=M1\nSpd 9\nMvs P3\n{HANDLER}", "P3"),
    "on if a variable says so": (f"{INTERRUPT}Act 1=M1\nMvs P1\n{HANDLER}", "P1"),
    "on in a branch": (f"{INTERRUPT}If M1=1 Then Act 1=1\nMvs P1\n{HANDLER}", "P1"),
    "all on": (f"{INTERRUPT}Act 0=1\nMvs P1\n{HANDLER}", "P1"),
    "any on": (f"{INTERRUPT}Act M1=1\nMvs P1\n{HANDLER}", "P1"),
    "never on": (f"{INTERRUPT}Spd 100\nMvs P1\n{HANDLER}", ""),
    "another on": (f"{INTERRUPT}Spd 100\nAct 2=1\nMvs P1\n{HANDLER}", ""),
    "a loop": (
        f"{INTERRUPT}Spd 100\n*L\nSpd 90\nMvs P1\nAct 1=1\nMvs P2\nGoTo *L\n{HANDLER}", "P1 P2",
    ),
    "in a subroutine": (
        f"{INTERRUPT}Spd 100\nAct 1=1\nGoSub *S\n{HANDLER}*S\nSpd 90\nMvs P1\nReturn\n", "P1",
    ),
    "on in a subroutine": (
        f"{INTERRUPT}Spd 100\nGoSub *S\nSpd 90\nMvs P1\n{HANDLER}*S\nAct 1=1\nReturn\n", "P1",
    ),
    "on in what a subroutine calls": (
        f"{INTERRUPT}GoSub *S\nSpd 90\nMvs P1\n{HANDLER}*S\nGoSub *T\nReturn\n*T\nAct 1=1\n"
        "Return\n",
        "P1",
    ),
    "set by what the interrupt calls": (
        f"{INTERRUPT}Spd 100\nAct 1=1\nMvs P1\nEnd\n*H\nGoSub *S\nReturn 1\n*S\nSpd 50\nReturn\n",
        "P1",
    ),
    "set on the way of a move": (
        f"{INTERRUPT}Spd 9\nAct 1=1\nMvs P1\nEnd\n*H\nMvs P2 WthIf M_In(2)=1,M_Tool=2\nReturn 1\n",
        "",
    ),
    "on in another interrupt": (
        f"{INTERRUPT}Def Act 2,M_In(2)=1 GoSub *K\nSpd 9\nAct 2=1\nMvs P1\n{HANDLER}"
        "*K\nAct 1=1\nReturn 1\n",
        "P1",
    ),
    "left for good": (
        "Def Act 1,M_In(1)=1 GoTo *H\nSpd 9\nAct 1=1\nMvs P1\nEnd\n*H\nSpd 50\nMvs P2\nEnd\n", "",
    ),
    "a line of communication": (
        f"On Com(1) GoSub *H\nSpd 9\nMvs P1\nCom(1) On\nMvs P2\nCom(1) Off\nSpd 9\nMvs P3\n"
        f"{HANDLER}",
        "P2",
    ),
    "its only line, by another name": (f"On Com GoSub *H\nCom(1) On\nMvs P2\n{HANDLER}", "P2"),
    "another line": (f"On Com(2) GoSub *H\nSpd 9\nCom(1) On\nMvs P2\n{HANDLER}", ""),
}  # fmt: skip


@every_row("name", list(WHERE))
def test_moves_that_an_interrupt_may_come_before(name: str) -> None:
    text, targets = WHERE[name]
    assert interrupted(text) == targets


def test_other_languages_take_such_a_speed_from_a_variable(tmp_path: Path) -> None:
    rows = translated(tmp_path, f"{INTERRUPT}Act 1=1\nMvs P1\n{HANDLER}", "rapid").rows
    levels = {row.text: row.level for row in rows}
    assert (levels["Mvs P1"], levels["Spd 50"], levels["Act 1=1"]) == (
        "partial",  # it is at full speed if no interrupt came
        "supported",
        "not",
    )


def test_an_interrupt_in_a_subroutine_that_it_calls_itself() -> None:
    """What `GoSub` calls as well may begin with anything: its moves stay as their text."""
    text = f"{INTERRUPT}Spd 100\nGoSub *H\nAct 1=1\nEnd\n*H\nMvs P1\nReturn\n"
    assert "Mvs P1" in uncertain(text)


def test_what_comes_with_a_move_holds_behind_it(tmp_path: Path) -> None:
    text = "Spd 100\nMvs P1 Wth M_Tool=2\nMvs P2\nEnd\n"
    assert code_of(translated(tmp_path, text, MELFA)) == text.splitlines()


@pytest.mark.parametrize(("on", "comes"), [("GoSub", True), ("GoTo", False)])
def test_an_interrupt_may_come_while_another_program_runs(
    tmp_path: Path, on: str, comes: bool
) -> None:
    main = f'Def Act 1,M_In(1)=1 {on} *H\nSpd 100\nAct 1=1\nCallP "PART"\n{HANDLER}{POSITIONS}'
    (tmp_path / "MAIN.prg").write_text(main)
    part = "Tool P6\nBase P7\nCnt 0\nSpd 90\nMvs P1\nMvs P2\nEnd\n"
    (tmp_path / "PART.prg").write_text(part + POSITIONS)
    program = load(tmp_path / "MAIN.prg", language=MELFA).program
    kept = {one.text: one.reason for one in program.statements() if isinstance(one, p.Opaque)}
    assert ("Mvs P1" in kept) is comes
    if comes:
        reason = kept["Mvs P1"]
        assert reason is not None
        assert reason.why == "an interrupt may set the speed at any time, in another program"
