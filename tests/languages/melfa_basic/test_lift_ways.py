"""Settings that differ with the way that leads to a place: what runs is what was written."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import cast

from hypothesis import given
from hypothesis import strategies as st

from assistant import languages
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program
from tests.tables import every_row

POSITIONS = "".join(f"P{i}=({i}00,0,300,180,0,180)(7,0)\n" for i in range(1, 4))
MOST = 60
"""Moves that are compared of one run."""

STEPS = 1500
"""Lines that a run may take; what has not moved so often by then turns in a circle."""

Trace = list[tuple[str, float, float | None]]
"""Moves: the target, its speed in mm/s and the radius of its corner."""


def lifted(text: str, level: int = 5) -> Program:
    language = languages.get(f"melfa-basic-{level}")
    tree = language.parse(text + POSITIONS)
    assert not tree.findings
    program = language.lift(tree)
    assert language.lower(program) == tree
    return program


# ------------------------------------------------------------------ both sides, step by step


def as_written(text: str, answers: Sequence[bool]) -> Trace:
    """What the controller does with lines of the forms below, each question answered in turn."""
    tree = languages.get("melfa-basic-5").parse(text)
    lines = [item for item in tree.items if isinstance(item, s.Line)]
    labels = {line.label: at for at, line in enumerate(lines) if line.label}
    asked, trace, calls = iter(answers), Trace(), list[int]()
    speed, radius = float("inf"), None
    at = 0
    for _ in range(STEPS):
        if at >= len(lines) or len(trace) >= MOST:
            break
        node = lines[at].statement
        at += 1
        match node:
            case s.Command("Spd", (s.Number(value),)):
                speed = value
            case s.Command("Cnt", (s.Number(0),)):
                radius = None
            case s.Command("Cnt", (s.Number(), s.Number(value))):
                radius = value
            case s.Motion("Mvs", (s.Variable(name),)):
                trace.append((name, speed, radius))
            case s.Jump("GoTo", s.Target(place)):
                at = labels[place]
            case s.Jump("GoSub", s.Target(place)):
                calls.append(at)
                at = labels[place]
            case s.If(_, s.Target(place)):
                answer = next(asked, None)
                if answer is None:
                    break
                at = labels[place] if answer else at
            case s.Command("Return"):
                at = calls.pop()
            case s.Command("End"):
                break
            case _:
                assert node is None
    return trace


class _Ended(Exception):
    pass


class Run:
    """What a pseudo-program does; a procedure's labels stand in none of its blocks."""

    def __init__(self, program: Program, answers: Sequence[bool]) -> None:
        self.program, self.asked, self.trace = program, iter(answers), Trace()
        self.steps = 0
        self.speed, self.radius = float("inf"), cast("float | None", None)

    def all(self) -> Trace:
        with contextlib.suppress(_Ended):
            self.procedure(self.program.procedures[0])
        return self.trace

    def procedure(self, procedure: Procedure) -> None:
        labels = {n.name: k for k, n in enumerate(procedure.body) if isinstance(n, p.Label)}
        assert len(labels) == sum(isinstance(n, p.Label) for n in procedure.body)
        at = 0
        while at < len(procedure.body):
            goes = self.statement(procedure.body[at])
            if goes == "":
                return
            at = at + 1 if goes is None else labels[goes]

    def statement(self, node: p.Statement) -> str | None:
        """The label that it goes to, empty for a return."""
        self.steps += 1
        if self.steps > 3 * STEPS:
            raise _Ended
        match node:
            case p.Move("linear", e.Name(target), p.Motion(Speed(tcp=tcp), Blend(radius=radius))):
                self.moved(target, tcp, radius)
            case p.Goto(label):
                return label
            case p.Return():
                return ""
            case p.Call(name):
                called = self.program.procedure(name)
                assert called is not None
                self.procedure(called)
            case p.If((p.Branch(_, body),), ()):
                answer = next(self.asked, None)
                if answer is None:
                    raise _Ended
                return next((g for n in body if (g := self.statement(n))), None) if answer else None
            case p.Opaque(text="End"):
                raise _Ended
            case p.Opaque(text=text):
                self.kept(*text.split())
            case _:
                assert isinstance(node, p.Label | p.Comment)
        return None

    def kept(self, word: str, argument: str) -> None:
        """A line that stays as its text: a setting, or a move under what was set so."""
        if word == "Spd":
            self.speed = float(argument)
        elif word == "Cnt":
            self.radius = None if argument == "0" else float(argument.split(",")[1])
        else:
            assert word == "Mvs"
            self.moved(argument, self.speed, self.radius)

    def moved(self, target: str, speed: float, radius: float | None) -> None:
        self.trace.append((target, speed, radius))
        if len(self.trace) >= MOST:
            raise _Ended


def lines(labels: Sequence[str], subroutines: Sequence[str]) -> st.SearchStrategy[str]:
    settings = st.sampled_from(("Spd 10", "Spd 20", "Cnt 0", "Cnt 1,5"))
    moves = st.sampled_from(("Mvs P1", "Mvs P2", "Mvs P3"))
    to = st.sampled_from(labels)
    jumps = st.one_of(
        to.map("If M_In(1)=1 Then *{}".format), to.map("If M_In(1)=1 Then *{}".format),
        to.map("GoTo *{}".format), st.just("End"),
    )  # fmt: skip
    calls = st.sampled_from(subroutines).map("GoSub *{}".format)
    return st.one_of(settings, moves, moves, jumps, calls)


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Lines with labels and jumps, and two subroutines of the same kind."""
    made = []
    for name in ("", "S", "T"):
        labels = [f"{name or 'M'}L{k}" for k in range(3)]
        calls = {"": ("S", "T"), "S": ("T",), "T": ()}[name]
        line = lines(labels, calls) if calls else lines(labels, ("S",)).filter(_calls_nothing)
        made += [f"*{name}"] * bool(name)
        for label in labels:
            made += [f"*{label}", *draw(st.lists(line, min_size=1, max_size=4))]
        made.append("Return" if name else "End")
    return "\n".join(made) + "\n"


def _calls_nothing(line: str) -> bool:
    return "GoSub" not in line


@given(programs(), st.lists(st.booleans(), max_size=20))
def test_what_is_lifted_runs_as_it_is_written(text: str, answers: list[bool]) -> None:
    assert Run(lifted(text), answers).all() == as_written(text, answers)


def reasons(text: str, level: int = 5) -> dict[str, tuple[str, str]]:
    """Why statements stay as their text, and what to do."""
    found = [node for node in lifted(text, level).statements() if isinstance(node, p.Opaque)]
    return {n.text: (n.reason.why, n.reason.cure) for n in found if n.reason is not None}


def test_a_loop_that_begins_under_other_settings_is_read_once_for_each() -> None:
    program = lifted("Spd 100\n*TOP\nMvs P1\nSpd 200\nIf M_In(1)=1 Then *TOP\nMvs P2\nEnd\n")
    (main,) = program.procedures
    assert [m.motion.speed for m in main.body if isinstance(m, p.Move)] == [
        Speed(100.0), Speed(200.0), Speed(200.0), Speed(200.0),
    ]  # fmt: skip
    assert [n.name for n in main.body if isinstance(n, p.Label)] == ["TOP", "TOP_2"]


def test_a_procedure_is_read_once_for_each_of_eight_settings() -> None:
    def calls(count: int) -> str:
        lines = "".join(f"Spd {10 * k}\nGoSub *S\n" for k in range(1, count + 1))
        return f"{lines}End\n*S\nMvs P1\nReturn\n"

    assert len(lifted(calls(8)).procedures) == 9
    assert not reasons(calls(8))
    assert "Mvs P1" in reasons(calls(9))


def test_lines_that_no_way_leads_to_stay() -> None:
    live = "Spd 100\n*TOP\nMvs P1\nSpd 200\nIf M_In(1)=1 Then *TOP\nEnd\n"
    dead = "*NEVER\nMvs P2\nSpd 50\nIf M_In(2)=1 Then *NEVER\nSpd 60\nGoTo *NEVER\n"
    (main,) = lifted(live + dead + "End\n").procedures
    labels = [node.name for node in main.body if isinstance(node, p.Label)]
    assert "NEVER" in labels
    assert any(isinstance(node, p.Opaque) and node.text == "Mvs P2" for node in main.body)


def test_a_text_that_jumps_keeps_the_labels_that_it_names() -> None:
    text = "Spd 100\n*TOP\nMvs P1\nSpd 200\nOn M1 GoTo *TOP,,*TOP\nMvs P2\nEnd\n"
    main = lifted(text).procedures[0]
    assert [n.name for n in main.body if isinstance(n, p.Label)] == ["TOP"]


def test_a_setting_that_a_subroutine_makes_on_some_ways_only_may_be_the_callers() -> None:
    sub = "End\n*S\nIf M_In(1)=1 Then Cnt 0\nReturn\n"
    assert not reasons(f"GoSub *S\nMvs P1\n{sub}")
    assert not reasons(f"Cnt 1,5\nCnt 0\nGoSub *S\nGoSub *S\nMvs P1\n{sub}")
    assert "Mvs P1" in reasons(f"Cnt 1,5\nGoSub *S\nMvs P1\n{sub}")
    deeper = f"{sub}*T\nGoSub *S\nIf M_In(2)=1 Then Cnt 1,5\nReturn\n"
    assert "Mvs P1" in reasons(f"GoSub *T\nMvs P1\n{deeper}")
    assert not reasons(f"GoSub *S\nGoSub *T\nCnt 0\nMvs P1\n{deeper}")


def test_a_move_tells_which_settings_meet() -> None:
    text = "10 SPD 100\n20 IF M1=1 THEN SPD 50\n30 MVS P1\n40 END\n"
    why, cure = reasons(text, 4)["MVS P1"]
    assert why == (
        "the speed may be 100 mm/s or 50 mm/s here, by 10 `SPD 100` and 20 `IF M1=1 THEN SPD 50`"
    )
    assert cure == "set Spd where the ways meet, below the label or the end of the block"
    assert reasons("Spd M_01\nMvs P1\n")["Mvs P1"] == (
        "the speed is worked out by the program, `Spd M_01` in line 1",
        "give Spd a plain value",
    )


@every_row(
    ("line", "word"),
    [
        ("Def Act 1,M_In(1)=1 GoTo *L", "interrupt"),
        ("Mvs P1 WthIf M_In(1)=1,M_Out(1)=1", "Wth"),
        ("Mvs P1 Wth M1=1", "Wth"),
        ("Mvs P1 Wth Hlt", "Wth"),
        ("XRun 2", "beside"),
        ("Cmp Tool,1", "soft"),
        ("NVClose", "camera"),
        ("CallP C1$", "worked out"),
        ("Print #1,M1,M2", "line"),
        ("Trk On,P1", "conveyor"),
    ],
)
def test_what_other_languages_lack_is_told(line: str, word: str) -> None:
    (found,) = reasons(f"*L\n{line}\n").values()
    assert word in found[0]
    assert found[1]
