"""Programs of MELFA-BASIC that grow: jumps, subroutines, blocks in each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.growth.construct import Lines


def _ring(n: int) -> Iterator[str]:
    yield from ("GoSub *S0", "End")
    for k in range(n):
        yield from (f"*S{k}", f"GoSub *S{(k + 1) % n}", "Return")


def _ring_with_jumps(n: int) -> Iterator[str]:
    yield from ("GoSub *S0", "End")
    for k in range(n):
        other = (k + 1) % n
        yield from (f"*S{k}", f"If M1=1 Then GoTo *S{other}", f"GoSub *S{other}", "Return")


def _chain(n: int) -> Iterator[str]:
    yield from ("Ovrd 50", "Mov P1", "GoSub *S0", "End")
    for k in range(n):
        yield from (f"*S{k}", "Mov P1", f"GoSub *S{min(k + 1, n - 1)}", "Return")


def _ladder(n: int) -> Iterator[str]:
    """Each subroutine is called in two ways."""
    yield from ("Spd 10", "GoSub *S0", "Spd 20", "GoSub *S0", "End")
    for k in range(n):
        yield from (f"*S{k}", "Mvs P1", f"GoSub *S{k + 1}", "Spd 30", f"GoSub *S{k + 1}", "Return")
    yield from (f"*S{n}", "Return")


def _called_from_one(n: int) -> Iterator[str]:
    yield from (f"GoSub *S{k}" for k in range(n))
    yield "End"
    for k in range(n):
        yield from (f"*S{k}", "Mov P1", "Return")


def _one_called(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"Ovrd {k % 100 + 1}", "GoSub *S")
    yield from ("End", "*S", "Mov P1", "Return")


def _fallen_through(n: int) -> Iterator[str]:
    yield from (f"GoSub *S{k}" for k in range(n))
    yield "End"
    for k in range(n):
        yield from (f"*S{k}", "Mov P1")
    yield "Return"


def _fallen_through_numbered(n: int) -> Iterator[str]:
    yield from (f"GoSub *S{k}" for k in range(n))
    yield "End"
    for k in range(n):
        yield from (f"*S{k}", "If M1=1 Then Return 1")
    yield "Return"


def _jumps(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"*L{k}", f"GoTo *L{(7 * k + 1) % n}")
    yield "End"


def _jumps_on_conditions(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"*L{k}", f"Spd {k % 9 + 1}", "Mvs P1")
        yield f"If M1={k} Then GoTo *L{(7 * k + 3) % n}"
    yield "End"


def _jumps_back(n: int) -> Iterator[str]:
    yield from (f"*L{k}" for k in range(n))
    yield from (f"If M1={k} Then GoTo *L{k}" for k in range(n))
    yield "End"


def _to_one_label(n: int) -> Iterator[str]:
    yield from (f"If M1={k} Then GoTo *L" for k in range(n))
    yield from ("Mov P1", "*L", "End")


def _on_jump(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"*L{k}", f"On M1 GoTo *L0,*L{k},*L{n - 1}")
    yield "End"


def _interrupts(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (
            f"Def Act {k % 8 + 1},M_In({k % 200})=1 GoSub *S{k}",
            f"Act {k % 8 + 1}=1",
            "Mov P1",
        )
    yield "End"
    for k in range(n):
        yield from (f"*S{k}", "Spd 10", "Return 0")


def _interrupts_and_calls(n: int) -> Iterator[str]:
    yield from ("Def Act 1,M_In(1)=1 GoSub *I", "Act 1=1")
    yield from (f"GoSub *S{k}" for k in range(n))
    yield from ("End", "*I", "Spd 10", "Return 0")
    for k in range(n):
        yield from (f"*S{k}", "Mvs P1", "Return")


def _for_nested(n: int) -> Iterator[str]:
    yield from (f"For M{k}=1 To 2" for k in range(n))
    yield from (f"Next M{k}" for k in reversed(range(n)))
    yield "End"


def _for_same(n: int) -> Iterator[str]:
    yield from ("For M1=1 To 2" for _ in range(n))
    yield from ("Next M1" for _ in range(n))
    yield "End"


def _if_nested(n: int) -> Iterator[str]:
    yield from ("If M1=1 Then" for _ in range(n))
    yield "Mov P1"
    yield from ("EndIf" for _ in range(n))
    yield "End"


def _if_open(n: int) -> Iterator[str]:
    yield from ("If M1=1 Then" for _ in range(n))


def _while_nested(n: int) -> Iterator[str]:
    yield from ("While M1=1" for _ in range(n))
    yield from ("WEnd" for _ in range(n))
    yield "End"


def _cases(n: int) -> Iterator[str]:
    yield "Select M1"
    for k in range(n):
        yield from (f"Case {k}", "Mov P1", "Break")
    yield from ("End Select", "End")


def _else_ifs(n: int) -> Iterator[str]:
    yield "If M1=0 Then"
    for k in range(n):
        yield from (f"ElseIf M1={k} Then", "Mov P1")
    yield from ("EndIf", "End")


def _moves(n: int) -> Iterator[str]:
    yield from (f"Mov P{k}" for k in range(n))
    yield "End"


def _settings(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (
            f"Spd {k % 90 + 1}",
            f"Ovrd {k % 90 + 1}",
            f"Cnt 1,{k % 9},{k % 9}",
            f"Mvs P{k}",
        )
    yield "End"


def _settings_on_conditions(n: int) -> Iterator[str]:
    yield from (f"If M1={k} Then Spd {k % 90 + 1}" for k in range(n))
    yield from ("Mvs P1", "End")


def _functions(n: int) -> Iterator[str]:
    yield "End"
    for k in range(n):
        yield from (f"Function M F{k}(M1)", f"F{k}=M1+{k}", "Exit Function", "FEnd")


def _long_functions(n: int) -> Iterator[str]:
    """Functions that work their result out in more than one place, each with its own variables."""
    yield "End"
    for k in range(n):
        yield from (
            f"Function M F{k}(M1)",
            f"M{k + 2}=M1",
            f"If M1=1 Then F{k}=M{k + 2}",
            f"F{k}=2",
            "FEnd",
        )


def _expressions(n: int) -> Iterator[str]:
    yield from (f"Def FNA{k}(M1)=M1+{k}" for k in range(n))
    yield "End"


def _arrays(n: int) -> Iterator[str]:
    yield from (f"Dim M{k}Q(10)" for k in range(n))
    yield "End"


def _long_name(n: int) -> Iterator[str]:
    yield from (f"M{'A' * n}=1", "End")


def _long_comment(n: int) -> Iterator[str]:
    yield from (f"' {'a ' * n}", "End")


def _blank_lines(n: int) -> Iterator[str]:
    yield from ("" for _ in range(n))


MELFA_BASIC: Final[Mapping[str, Lines]] = {
    "subroutines in a ring": _ring,
    "subroutines in a ring, with jumps": _ring_with_jumps,
    "subroutines in a chain": _chain,
    "subroutines in a ladder": _ladder,
    "subroutines of one program": _called_from_one,
    "calls of one subroutine": _one_called,
    "subroutines that fall through": _fallen_through,
    "subroutines that fall through, numbered returns": _fallen_through_numbered,
    "labels and jumps": _jumps,
    "labels, settings and jumps on conditions": _jumps_on_conditions,
    "jumps back": _jumps_back,
    "jumps to one label": _to_one_label,
    "On GoTo": _on_jump,
    "interrupts": _interrupts,
    "an interrupt and subroutines": _interrupts_and_calls,
    "For in each other": _for_nested,
    "For in each other with one variable": _for_same,
    "If in each other": _if_nested,
    "If without EndIf": _if_open,
    "While in each other": _while_nested,
    "cases": _cases,
    "ElseIf": _else_ifs,
    "moves": _moves,
    "settings": _settings,
    "settings on conditions": _settings_on_conditions,
    "functions": _functions,
    "functions with variables": _long_functions,
    "functions of one expression": _expressions,
    "arrays": _arrays,
    "a long name": _long_name,
    "a long comment": _long_comment,
    "lines with nothing": _blank_lines,
}
