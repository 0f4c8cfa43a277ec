"""A question for where objects are, in statements that every language with channels can say.

The program sends `see NAME` and takes seven numbers, each a line of its own: 1 where the object is
found (0 if it is not, 2 if that is doubtful), x, y, z in mm, and the degrees about x, y and z of
R = Rz·Ry·Rx, all in the robot's base. Only then is the frame set; else the program ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import reduce
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.undeclared_names import channels
from assistant.sources.process.seen import PoseServer
from assistant.sources.sights import FOUND, QUESTION

POSITION_NAMES: Final = ("x", "y", "z")
ANSWER_NAMES: Final = ("state", *POSITION_NAMES, *e.ANGLES)
"""What is answered, in this order."""


def with_vision_query(
    program: Program, usual: Mapping[str, tuple[str, Pose]], whom: PoseServer, within: float
) -> Program:
    """The program with a procedure that asks for frames, called where it begins.

    usual: of each frame its object and the place that it is checked at. within: mm from there.
    """
    taken = TakenNames((*declared(program), *channels(program)))

    def name(wanted: str) -> str:
        free = identifier(wanted, taken)
        taken.add(free)
        return free

    own = _VisionQuery(name, whom, within)
    looks = Procedure(name("look_for_frames"), tuple(own.body(usual)))
    procedures = tuple(
        replace(one, body=(p.Call(looks.name), *one.body)) if _is_entry(program, one) else one
        for one in program.procedures
    )
    return replace(
        program,
        procedures=(*procedures, looks),
        variables={**program.variables, **own.variables},
    )


def _is_entry(program: Program, procedure: Procedure) -> bool:
    entry = program.entry
    return entry is not None and program.procedure(entry) is procedure


class _VisionQuery:
    def __init__(self, name: Callable[[str], str], whom: PoseServer, within: float) -> None:
        self.whom, self.within = whom, within
        self.channel = name("eyes")
        self.names = {key: name(f"seen_{key}") for key in (*ANSWER_NAMES, "off", "place")}
        kinds = {one: Variable("number") for key, one in self.names.items() if key != "place"}
        self.variables = {**kinds, self.names["place"]: Variable("pose")}

    def named(self, key: str) -> e.Name:
        return e.Name(self.names[key])

    def body(self, usual: Mapping[str, tuple[str, Pose]]) -> Iterator[p.Statement]:
        whom, channel = self.whom, e.Text(self.channel)
        places: dict[str, tuple[e.Expression, ...]] = {
            "client": (e.Text(whom.address), e.Number(whom.number)),
            "server": (e.Number(whom.number), e.Text(whom.address)),
            "line": (e.Number(whom.number),),
        }
        yield p.Attach(self.channel, whom.kind, places[whom.kind])
        yield p.WaitUntil(e.Binary("=", e.Apply("connected", (channel,)), e.Number(1)))
        for frame, (object, place) in usual.items():
            yield from self.question(frame, object, place)
        yield p.Detach(self.channel)

    def question(self, frame: str, object: str, usual: Pose) -> Iterator[p.Statement]:
        yield p.Send(self.channel, "line", (e.Text(f"{QUESTION} {object}"),))
        answer = e.Apply("received_number", (e.Text(self.channel),))
        for key in ANSWER_NAMES:
            yield p.Assign(self.named(key), answer)
        missed = e.Binary("<>", self.named("state"), e.Number(FOUND))
        yield self.ends(missed, f"{object} is not found, or not surely")
        squares = (
            _square_of(self.named(k), c)
            for k, c in zip(POSITION_NAMES, usual.position, strict=True)
        )
        yield p.Assign(self.named("off"), reduce(lambda a, b: e.Binary("+", a, b), squares))
        far = e.Binary(">", self.named("off"), e.number_of(round(self.within**2, 6)))
        yield self.ends(far, f"{object} is too far from where it usually is")
        yield p.Assign(self.named("place"), e.PoseValue(IDENTITY))
        for key in (*POSITION_NAMES, *e.ANGLES):
            yield p.Assign(e.Member(self.named("place"), key), self.named(key))
        yield p.Assign(e.Name(frame), self.named("place"))

    def ends(self, condition: e.Expression, why: str) -> p.If:
        """Ends the program for good, with a message, where a condition holds."""
        ending = p.Detach(self.channel), p.Message((e.Text(why),)), p.Stop(end=True)
        return p.If((p.Branch(condition, ending),))


def _square_of(value: e.Expression, centre: float) -> e.Expression:
    centre = round(centre, 3)
    off = e.Binary("+" if centre < 0.0 else "-", value, e.number_of(abs(centre)))
    side: e.Expression = off if centre else value
    return e.Binary("*", side, side)
