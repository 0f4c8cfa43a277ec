"""Random programs of robot cells in which every statement has an effect that can be observed.

Each output is switched on and off again, the branches of a condition differ, and each counter
reaches the value that it is compared with. A fault in any line changes what the cell does.

    text = drawn("rapid", seed)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Final, Literal

Language = Literal["rapid", "melfa-basic-5"]

INPUTS: Final = range(1, 6)
OUTPUTS: Final = range(8, 14)
TARGETS: Final = {
    1: ((350, 20, 250), (180, 0, 180), (0, 0, 1, 0)),
    2: ((330, -60, 220), (180, 0, 150), (0, 0.258819045, 0.965925826, 0)),
    3: ((300, 60, 200), (180, 0, 180), (0, 0, 1, 0)),
    4: ((370, 90, 230), (180, 0, 120), (0, 0.5, 0.866025404, 0)),
    5: ((310, -90, 260), (180, 0, 180), (0, 0, 1, 0)),
}
"""Place (mm), angles A, B, C (degrees), and quaternion of the same orientation."""
TOOLS: Final = {1: (0, 0, 100), 2: (15, -5, 80)}
SPEEDS: Final = (50, 100, 200, 300)
CORNERS: Final = (0, 0, 10, 20)
"""Distances (mm) that a corner may be cut by; 0 stops there."""

WORDS: Final[Mapping[Language, Mapping[str, str]]] = {
    "rapid": {
        "move": "{how} p{target},v{speed},{zone},tTool{tool};",
        "above": "MoveL Offs(p{target},0,0,{z}),v{speed},{zone},tTool{tool};",
        "raised": "MoveL Offs(p{target},0,0,{count}*{z}),v{speed},{zone},tTool{tool};",
        "output": "SetDO do{signal},{value};",
        "pulse": "PulseDO\\PLength:={seconds},do{signal};",
        "wait": "WaitDI di{signal},{value};",
        "wait for": "WaitUntil {condition};",
        "limited": "WaitDI di{signal},1\\MaxTime:={seconds}\\TimeFlag:=bLate;\nIF bLate THEN",
        "shared": "nTotal:=nTotal+{step};",
        "watch": "CONNECT i{number} WITH tWatch{number};\nISignalDI di{signal},1,i{number};",
        "end of watch": "IDelete i{number};",
        "alarm": "  TRAP tWatch{number}\n    SetDO do{signal},1;\n  ENDTRAP",
        "delay": "WaitTime {seconds};",
        "set": "{count}:={value};",
        "if": "IF {condition} THEN",
        "else": "ELSE",
        "end if": "ENDIF",
        "come": "ENDIF",
        "for": "FOR {count} FROM {first} TO {last} DO",
        "next": "ENDFOR",
        "while": "WHILE {condition} DO",
        "wend": "ENDWHILE",
        "select": "TEST {count}",
        "case": "CASE {value}:",
        "default": "DEFAULT:",
        "end select": "ENDTEST",
        "call": "rPart{number};",
        "input": "di{signal}={value}",
        "and": "AND",
        "or": "OR",
    },
    "melfa-basic-5": {
        "move": "Tool PT{tool}\nSpd {speed}\n{corner}\nMvs P{target}",
        "above": "Tool PT{tool}\nSpd {speed}\n{corner}\nMvs P{target}+(0,0,{z},0,0,0)",
        "raised": (
            "Tool PT{tool}\nSpd {speed}\n{corner}\nP9=P{target}\nP9.Z=P9.Z+{count}*{z}\nMvs P9"
        ),
        "output": "M_Out({signal})={value}",
        "pulse": "M_Out({signal})=1 Dly {seconds}",
        "wait": "Wait M_In({signal})={value}",
        "wait for": "Wait {condition}",
        "limited": (
            "M_Timer(1)=0\n*LATE{number}\nIf M_In({signal})=1 Then GoTo *COME{number}\n"
            "If M_Timer(1)<{seconds}000 Then GoTo *LATE{number}"
        ),
        "come": "*COME{number}",
        "shared": "M_01=M_01+{step}",
        "watch": "Def Act {number},M_In({signal})=1 GoSub *WATCH{number}\nAct {number}=1",
        "end of watch": "Act {number}=0",
        "alarm": "*WATCH{number}\nM_Out({signal})=1\nAct {number}=0\nReturn 0",
        "delay": "Dly {seconds}",
        "set": "{count}={value}",
        "if": "If {condition} Then",
        "else": "Else",
        "end if": "EndIf",
        "for": "For {count}={first} To {last}",
        "next": "Next {count}",
        "while": "While {condition}",
        "wend": "WEnd",
        "select": "Select {count}",
        "case": "Case {value}",
        "default": "Default",
        "end select": "End Select",
        "call": "GoSub *PART{number}",
        "input": "M_In({signal})={value}",
        "and": "And",
        "or": "Or",
    },
}


@dataclass
class Draft:
    """A program while it is drawn. parts: the lines of each routine. on: outputs that are on.

    alarms: the output that each interrupt sets.
    """

    language: Language
    rng: Random
    lines: list[str] = field(default_factory=list)
    parts: list[list[str]] = field(default_factory=list)
    counts: int = 0
    on: list[int] = field(default_factory=list)
    alarms: list[int] = field(default_factory=list)
    tool: int = 1

    def said(self, word: str, **given: object) -> str:
        return WORDS[self.language][word].format(**given)

    def say(self, word: str, **given: object) -> None:
        self.lines += self.said(word, **given).split("\n")

    def count(self) -> str:
        """A new counter."""
        self.counts += 1
        return ("n{}" if self.language == "rapid" else "M{}").format(self.counts)

    def move(self, word: str = "move", **given: object) -> None:
        corner = self.rng.choice(CORNERS)
        self.say(
            word,
            how=self.rng.choice(("MoveL", "MoveJ")),
            target=given.pop("target", self.rng.choice(list(TARGETS))),
            speed=self.rng.choice(SPEEDS),
            zone=f"z{corner}" if corner else "fine",
            corner=f"Cnt 1,{corner},{corner}" if corner else "Cnt 0",
            tool=self.tool,
            **given,
        )

    def input(self) -> str:
        signal, value = self.rng.choice(INPUTS), self.rng.choice((0, 1))
        return self.said("input", signal=signal, value=value)

    def inputs(self) -> str:
        """A condition of two or three inputs."""
        chosen = self.rng.sample(INPUTS, self.rng.choice((2, 2, 3)))
        terms = [self.said("input", signal=n, value=self.rng.choice((0, 1))) for n in chosen]
        joins = [self.said(self.rng.choice(("and", "or"))) for _ in terms[1:]]
        made = f"{terms[0]} {joins[0]} {terms[1]}"
        return f"({made}) {joins[1]} {terms[2]}" if len(terms) > 2 else made

    def switched(self, inside: Callable[[], None]) -> None:
        """An output that is on while something happens."""
        signal = self.rng.choice([n for n in OUTPUTS if n not in self.on])
        self.on.append(signal)
        self.say("output", signal=signal, value=1)
        inside()
        self.say("output", signal=signal, value=0)
        self.on.remove(signal)


# --------------------------------------------------------------------------- what a cell does


def _visit(draft: Draft) -> None:
    """To a place, a gripper, and away."""
    target = draft.rng.choice(list(TARGETS))
    draft.move("above", target=target, z=draft.rng.choice((40, 60, 80)))
    draft.move(target=target)
    draft.switched(lambda: _delay(draft))
    draft.move("above", target=target, z=draft.rng.choice((40, 60, 80)))


def _delay(draft: Draft) -> None:
    draft.say("delay", seconds=draft.rng.choice((0.2, 0.5, 1, 2)))


def _handshake(draft: Draft) -> None:
    """An order that is acknowledged, and withdrawn."""
    signal = draft.rng.choice(INPUTS)

    def acknowledged() -> None:
        draft.say("wait", signal=signal, value=1)

    draft.switched(acknowledged)
    draft.say("wait", signal=signal, value=0)


def _pulse(draft: Draft) -> None:
    draft.say("pulse", signal=draft.rng.choice(OUTPUTS), seconds=draft.rng.choice((0.5, 1, 2)))
    draft.move()


def _together(draft: Draft) -> None:
    """Waits for several inputs."""
    draft.say("wait for", condition=draft.inputs())
    draft.move()


def _limited(draft: Draft) -> None:
    """Waits for an input, a few seconds at most."""
    draft.counts += 1
    signal, seconds = draft.rng.choice(INPUTS), draft.rng.choice((2, 3))
    draft.say("limited", signal=signal, seconds=seconds, number=draft.counts)
    draft.switched(lambda: _delay(draft))
    draft.say("come", number=draft.counts)
    draft.move()


def _shared(draft: Draft) -> None:
    """A counter in shared data."""
    draft.say("shared", step=draft.rng.choice((1, 2)))
    draft.move()


def _watched(draft: Draft) -> None:
    """An input that interrupts a few moves; its output tells of it."""
    signal = draft.rng.choice(OUTPUTS)
    draft.alarms.append(signal)
    number = len(draft.alarms)
    draft.say("watch", number=number, signal=draft.rng.choice(INPUTS))
    draft.move()
    _delay(draft)
    draft.move()
    draft.say("end of watch", number=number)
    draft.move()
    draft.say("output", signal=signal, value=0)


def _row(draft: Draft) -> None:
    """A row or a stack of places; some of them get a different treatment."""
    count, last = draft.count(), draft.rng.choice((3, 4))
    draft.say("for", count=count, first=draft.rng.choice((0, 1)), last=last)
    draft.move("raised", count=count, z=draft.rng.choice((5, 10)))
    if draft.rng.random() < 0.6:
        relation = draft.rng.choice(("<", "<=", ">", ">=", "=", "<>"))
        draft.say("if", condition=f"{count}{relation}2")
        draft.switched(lambda: draft.move())
        draft.say("end if")
    else:
        draft.switched(lambda: _delay(draft))
    draft.say("next", count=count)


def _counted(draft: Draft) -> None:
    """A loop until a counter reaches its limit."""
    count = draft.count()
    draft.say("set", count=count, value=draft.rng.choice((0, 1)))
    draft.say("while", condition=f"{count}{draft.rng.choice(('<', '<='))}{3}")
    draft.move()
    draft.switched(lambda: _delay(draft))
    draft.say("set", count=count, value=f"{count}+1")
    draft.say("wend")


def _retried(draft: Draft) -> None:
    """Again and again until an input comes, a few times at most."""
    count = draft.count()
    join = draft.said("and")
    draft.say("set", count=count, value=0)
    draft.say("while", condition=f"{draft.input()} {join} {count}<3")
    draft.switched(lambda: draft.move())
    draft.say("set", count=count, value=f"{count}+1")
    draft.say("wend")
    draft.say("if", condition=f"{count}>=3")
    draft.switched(lambda: _handshake(draft))
    draft.say("end if")


def _chosen(draft: Draft) -> None:
    """One of two places, as inputs say."""
    one, other = draft.rng.sample(list(TARGETS), 2)
    draft.say("if", condition=draft.inputs())
    draft.move(target=one)
    draft.switched(lambda: _delay(draft))
    draft.say("else")
    draft.move(target=other)
    draft.say("end if")


def _sorted(draft: Draft) -> None:
    """A loop whose iterations do different things."""
    count = draft.count()
    draft.say("for", count=count, first=1, last=3)
    draft.say("select", count=count)
    first, second = draft.rng.sample((1, 2, 3), 2)
    draft.say("case", value=first)
    draft.switched(lambda: draft.move(target=1))
    draft.say("case", value=second)
    draft.move(target=2)
    draft.say("default")
    draft.move(target=3)
    _delay(draft)
    draft.say("end select")
    draft.say("next", count=count)


def _called(draft: Draft) -> None:
    """A routine, called between places."""
    if not draft.parts or (len(draft.parts) < 2 and draft.rng.random() < 0.5):
        lines, draft.lines = draft.lines, []
        draft.rng.choice((_visit, _handshake, _chosen))(draft)
        draft.parts.append(draft.lines)
        draft.lines = lines
    draft.say("call", number=draft.rng.randint(1, len(draft.parts)))
    draft.move()


def _changed_tool(draft: Draft) -> None:
    draft.tool = 3 - draft.tool
    draft.move()


DOES: Final = (
    *(_visit, _handshake, _pulse, _together, _row, _counted, _retried, _chosen, _sorted, _called),
    *(_changed_tool, _limited, _shared, _watched),
)


def drawn(language: Language, seed: int, parts: int = 5) -> str:
    """The text of a program of some parts; the same for a seed everywhere."""
    draft = Draft(language, Random(f"cell {seed}"))
    draft.move(target=1)
    for part in draft.rng.sample(DOES, parts):
        part(draft)
    draft.move(target=1)
    return (_rapid if language == "rapid" else _melfa)(draft)


def _rapid(draft: Draft) -> str:
    data = [
        f"  CONST robtarget p{n}:=[{_list(place)},{_list(turn)},[0,0,0,0],"
        "[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for n, (place, _, turn) in TARGETS.items()
    ]
    data += [
        f"  PERS tooldata tTool{n}:=[TRUE,[{_list(place)},[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];"
        for n, place in TOOLS.items()
    ]
    text = "\n".join([*draft.lines, *(line for part in draft.parts for line in part)])
    counters = [f"n{n}" for n in range(1, draft.counts + 1) if f"n{n}:=" in text]
    data += [f"  VAR num {name};" for name in counters]
    data += ["  VAR bool bLate;"] if "bLate" in text else []
    data += ["  PERS num nTotal:=0;"] if "nTotal" in text else []
    alarms = [*enumerate(draft.alarms, 1)]
    data += [f"  VAR intnum i{number};" for number, _ in alarms]
    routines = {"main": draft.lines}
    routines |= {f"rPart{n}": lines for n, lines in enumerate(draft.parts, 1)}
    bodies = []
    for name, lines in routines.items():
        bodies += [f"  PROC {name}()", *(f"    {line}" for line in lines), "  ENDPROC"]
    bodies += [draft.said("alarm", number=number, signal=signal) for number, signal in alarms]
    return "\n".join(["MODULE Cell", *data, *bodies, "ENDMODULE", ""])


def _melfa(draft: Draft) -> str:
    lines = [*draft.lines, "End"]
    for n, part in enumerate(draft.parts, 1):
        lines += [f"*PART{n}", *part, "Return"]
    for n, signal in enumerate(draft.alarms, 1):
        lines += draft.said("alarm", number=n, signal=signal).split("\n")
    data = [
        f"P{n}=({_numbers(place)},{_numbers(angles)})(7,0)"
        for n, (place, angles, _) in TARGETS.items()
    ]
    data += [f"PT{n}=({_numbers(place)},0,0,0)(0,0)" for n, place in TOOLS.items()]
    return "\n".join([*(f"{n} {line}" for n, line in enumerate(lines, 1)), *data, ""])


def _list(numbers: Sequence[float]) -> str:
    return f"[{_numbers(numbers)}]"


def _numbers(numbers: Sequence[float]) -> str:
    return ",".join(f"{number:g}" if number == int(number) else str(number) for number in numbers)


def process_file() -> str:
    """The signals of the cell."""
    lines = []
    for n in OUTPUTS:
        lines += [f"[signals.do{n}]", f"number = {n}"]
    for n in INPUTS:
        lines += [f"[signals.di{n}]", 'direction = "input"', f"number = {n}"]
    return "\n".join([*lines, ""])
