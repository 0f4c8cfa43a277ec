"""Frames located by cameras: set from a sight, or by a question that the program asks.

A program with such a frame is written with the pose of a sight, or with a procedure at its
beginning that asks for it. The usual pose that the program declares is never written instead.

The question consists of statements that every language with channels can express: the program sends
`see NAME` and takes seven numbers, each on a separate line: 1 if the object is found (0 if it is
not, 2 if that is doubtful), x, y, z in mm, and the degrees about x, y and z of R = Rz·Ry·Rx, all in
the robot's base. Only then is the frame set; otherwise the program ends.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import reduce
from typing import Final

from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Findings,
    Refused,
    error,
    has_errors,
    info,
)
from assistant.compiler.arms import Arms
from assistant.compiler.work_locations import robot_in_cell
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.geometry import IDENTITY, Frame, Pose
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.undeclared_names import channels
from assistant.sources.seen_settings import PoseServer
from assistant.sources.sights import FOUND, QUESTION, Sight, doubts

_POSITION_NAMES: Final = ("x", "y", "z")
_ANSWER_NAMES: Final = ("state", *_POSITION_NAMES, *e.ANGLES)
"""Values of an answer, in this order."""


def _with_vision_query(
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
        self.names = {key: name(f"seen_{key}") for key in (*_ANSWER_NAMES, "off", "place")}
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
        for key in _ANSWER_NAMES:
            yield p.Assign(self.named(key), answer)
        missed = e.Binary("<>", self.named("state"), e.Number(FOUND))
        yield self.ends(missed, f"{object} is not found, or not surely")
        squares = (
            _square_of(self.named(k), c)
            for k, c in zip(_POSITION_NAMES, usual.position, strict=True)
        )
        yield p.Assign(self.named("off"), reduce(lambda a, b: e.Binary("+", a, b), squares))
        far = e.Binary(">", self.named("off"), e.number_of(round(self.within**2, 6)))
        yield self.ends(far, f"{object} is too far from where it usually is")
        yield p.Assign(self.named("place"), e.PoseValue(IDENTITY))
        for key in (*_POSITION_NAMES, *e.ANGLES):
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


_NO_SIGHT_SOURCE: Final = error(
    "CO350",
    "frame `{frame}` is where `{name}` is seen, and nothing says where that is",
    "name a file of what was found with --seen, or have the program ask for it as it runs, with "
    "--ask-at or `ask` under [seen] in the process file",
)
_OBJECT_NOT_FOUND: Final = error(
    "CO351",
    "`{name}`, where frame `{frame}` is seen, is not among what was found: {found}",
    "look anew with it in sight, or write its name as it was found",
)
_NO_WORLD_POSE: Final = error(
    "CO352",
    "`{name}` was found in the world of the cell, and nothing says where the robot stands in it",
    "name the cell with --cell and its robot with --robot, or have it found in the robot's base",
)
_FRAME_NOT_SEEABLE: Final = error(
    "CO353",
    "frame `{frame}` cannot be seen: {why}",
    "see one that stands still, and declare this one in it",
)
_NO_USUAL_POSE: Final = error(
    "CO354",
    "nothing says where `{name}` usually is, so that reach and limits of what is done there cannot "
    "be looked at before the program asks",
    "give frame `{frame}` the place where it usually is, or name a file with --seen that says "
    "where it was found once",
)
_NO_ENTRY_TO_ASK: Final = error(
    "CO355",
    "the program has no procedure that it begins with, so nowhere to ask where `{name}` is",
    "give it a main procedure, or name a file of what was found with --seen",
)
_NAME_NOT_SENDABLE: Final = error(
    "CO356",
    "a program cannot ask for `{name}`: a line takes {most} letters, digits, blanks, `-`, `_`, `.`",
    "call the object otherwise",
)
_FRAME_SEEN: Final = info(
    "CO357",
    "frame `{frame}` is where `{name}` was seen: {pose}, with {sigma_mm:g} mm and {sigma_deg:g} "
    "degrees (one standard deviation)",
)
_FRAME_ASKED: Final = info(
    "CO358",
    "the program asks {whom} where `{name}` is, once at its beginning, and ends without a move if "
    "it is not found or is more than {within:g} mm from {pose}; reach, limits and contacts are "
    "looked at there alone",
    "try it slowly where the object lies otherwise",
)
_SENDABLE: Final = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9 _.\-]{0,38}[A-Za-z0-9_.\-])?")
_MOST_LETTERS: Final = 40


def with_seen_frames(program: Program, arms: Arms) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program with its seen frames where they were seen, or asking for them.

    The findings hold errors where that is not known, or doubtful; the program is the same then,
    without a word of what is seen.
    """
    seen = {name: frame for name, frame in program.frames.items() if frame.seen}
    if not seen:
        return program, ()
    plain = {name: replace(frame, seen="") for name, frame in seen.items()}
    found, there = Findings(_not_seeable_findings(seen)), arms.seeing
    if found:
        return replace(program, frames={**program.frames, **plain}), tuple(found)
    if there.found is None and there.ask is None:
        found += (_about_frame(_NO_SIGHT_SOURCE(frame=n, name=f.seen), n) for n, f in seen.items())
    if there.found is not None:
        for name, frame in seen.items():
            pose = _seen_pose(name, frame, program, arms, found)
            if pose is not None:
                plain[name] = replace(plain[name], user=pose, object=IDENTITY)
    changed = replace(program, frames={**program.frames, **plain})
    if there.ask is not None and not has_errors(found):
        found += _query_faults(program, seen, plain)
        if not has_errors(found):
            usual = {name: (frame.seen, plain[name].pose) for name, frame in seen.items()}
            found += _query_findings(usual, there.ask, there.trust.within)
            changed = _with_vision_query(changed, usual, there.ask, there.trust.within)
    return changed, tuple(found)


def with_located_frames(program: Program, arms: Arms) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The same; raises Refused where it is not known, or doubtful, where something was seen."""
    known, found = with_seen_frames(program, arms)
    if has_errors(found):
        raise Refused(*found)
    return known, found


def _about_frame(finding: Diagnostic, name: str) -> Diagnostic:
    return replace(finding, about=Declared(name, "frames"))


def _not_seeable_findings(seen: Mapping[str, Frame]) -> Iterator[Diagnostic]:
    for name, frame in seen.items():
        if frame.held or frame.mechanism:
            why = "the robot carries it" if frame.held else f"`{frame.mechanism}` moves it"
            yield _about_frame(_FRAME_NOT_SEEABLE(frame=name, why=why), name)


def _seen_pose(
    name: str, frame: Frame, program: Program, arms: Arms, found: Findings
) -> Pose | None:
    """Return the pose of a frame as seen, in the robot's base; None with findings if unknown."""
    from assistant.program.settings_tables import listed, shown

    sights = {key.casefold(): sight for key, sight in (arms.seeing.found or {}).items()}
    sight = sights.get(frame.seen.casefold())
    if sight is None:
        names = listed([f"`{shown(one)}`" for one in arms.seeing.found or ()][:8])
        found.append(
            _about_frame(_OBJECT_NOT_FOUND(frame=name, name=shown(frame.seen), found=names), name)
        )
        return None
    doubted = [_about_frame(one, name) for one in doubts(sight, arms.seeing.trust)]
    found += doubted
    pose = _sight_in_base(sight, program, arms)
    if pose is None:
        found.append(_about_frame(_NO_WORLD_POSE(name=sight.name), name))
    if pose is None or doubted:
        return None
    if arms.seeing.ask is None:
        said, mm, deg = _shown_pose(pose), sight.sigma_mm, sight.sigma_deg
        taken = _FRAME_SEEN(frame=name, name=sight.name, pose=said, sigma_mm=mm, sigma_deg=deg)
        found.append(_about_frame(taken, name))
    return pose


def _sight_in_base(sight: Sight, program: Program, arms: Arms) -> Pose | None:
    if sight.frame == "base":
        return sight.pose
    placed = robot_in_cell(program, arms)
    return None if placed is None else placed.base.inverse() @ sight.pose


def _query_faults(
    program: Program, seen: Mapping[str, Frame], plain: Mapping[str, Frame]
) -> Iterator[Diagnostic]:
    from assistant.program.settings_tables import shown

    for name, frame in seen.items():
        if program.entry is None or program.procedure(program.entry) is None:
            yield _about_frame(_NO_ENTRY_TO_ASK(name=frame.seen), name)
        if plain[name].pose == IDENTITY:
            yield _about_frame(_NO_USUAL_POSE(name=frame.seen, frame=name), name)
        if _SENDABLE.fullmatch(frame.seen) is None:
            yield _about_frame(_NAME_NOT_SENDABLE(name=shown(frame.seen), most=_MOST_LETTERS), name)


def _query_findings(
    usual: Mapping[str, tuple[str, Pose]], ask: PoseServer, within: float
) -> Iterator[Diagnostic]:
    for name, (object, pose) in usual.items():
        where = _shown_pose(pose)
        yield _about_frame(
            _FRAME_ASKED(name=object, whom=ask.spoken, within=within, pose=where), name
        )


def _shown_pose(pose: Pose) -> str:
    """For people, as the pseudo-program writes it."""
    # Loads lark, which checking a program of another language needs not.
    from assistant.program.pseudo.expressions import pose_text

    x, y, z = (round(value, 2) + 0.0 for value in pose.position)
    w, i, j, k = (round(value, 4) + 0.0 for value in pose.quaternion)
    return pose_text(Pose((x, y, z), (w, i, j, k)))
