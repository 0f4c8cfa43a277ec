"""Names for the heights, speeds and blends that a program uses often."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Literal

from assistant.compiler.point_forms import taken_names
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Variable, identifier, walk
from assistant.sources.contours.layer_program import CONTOURS_SUFFIX

if TYPE_CHECKING:
    from assistant.languages import Language


FOLLOWING: Final = "follow_"
"""Prefix for the procedure of a path whose name is taken by something else."""
Role = Literal["approach", "retract"]
_OFTEN: Final = 4
"""Uses of a height from which on it has a name."""
_SEVERAL: Final = 2
"""Uses of a speed or blend from which on it has a name."""
_MOST_HEIGHTS: Final = 2
"""Heights of a subject up to which they have names: of an approach and of a retract."""
_LONGEST_STEM: Final = 20
"""Letters of a subject that names of its constants begin with."""


class NamedConstants:
    """Names for heights, speeds and blends that are used often.

    The procedures that the entry calls are the subjects, such as layers. What they call belongs to
    them, to the last of several; names begin with that of the subject.
    """

    def __init__(self, given: Program, language: Language[Any], *, commented: bool) -> None:
        self.given, self.language, self.commented = given, language, commented
        self.taken = taken_names(given)
        self.subjects = _subjects(given)
        self.variables: dict[str, Variable] = {}
        self.speeds: dict[str, Speed] = {}
        self.blends: dict[str, Blend] = {}

    def program(self) -> Program:
        groups: dict[str, list[Procedure]] = {}
        for procedure in self.given.procedures:
            groups.setdefault(self.subjects[procedure.name.lower()], []).append(procedure)
        made: dict[str, Procedure] = {}
        for subject, procedures in groups.items():
            # The few moves of the entry, such as those to home, are no subject beside others.
            alone = subject or len(groups) == 1
            made |= (
                self.named(subject, procedures) if alone else {one.name: one for one in procedures}
            )
        if not (self.variables or self.speeds or self.blends):
            return self.given
        comments = self.given.comments
        if self.variables and self.commented:
            comments = (*comments, f"{', '.join(self.variables)}: mm above the targets")
        return replace(
            self.given,
            comments=comments,
            procedures=tuple(made[one.name] for one in self.given.procedures),
            variables={**self.given.variables, **self.variables},
            speeds={**self.given.speeds, **self.speeds},
            blends={**self.given.blends, **self.blends},
        )

    def named(self, subject: str, procedures: list[Procedure]) -> dict[str, Procedure]:
        heights = self.heights(subject, procedures)
        travel, work, blends = self.motions(subject, procedures)

        def statement(node: p.Statement) -> p.Statement:
            match node:
                case p.Move() | p.MoveCircular() | p.MoveJoints():
                    away = isinstance(node, p.Move) and _height(node) is not None
                    speeds = travel if away else work
                    motion = replace(
                        node.motion,
                        speed=_known(speeds, node.motion.speed),
                        blend=_known(blends, node.motion.blend),
                    )
                    node = replace(node, motion=motion)
                    height = _height(node) if isinstance(node, p.Move) else None
                    if height is not None and height in heights:
                        assert isinstance(node, p.Move) and isinstance(node.target, e.Apply)
                        raised = e.Unary("-", e.Name(heights[height]))
                        given = (*node.target.arguments[:3], raised)
                        node = replace(node, target=replace(node.target, arguments=given))
                case p.Follow(path):
                    path = replace(
                        path,
                        speeds=tuple(_known(work, one) for one in path.speeds),
                        blends=tuple(_known(blends, one) for one in path.blends),
                    )
                    node = replace(node, path=path)
                case p.For():
                    node = replace(node, body=tuple(map(statement, node.body)))
            return node

        return {one.name: replace(one, body=tuple(map(statement, one.body))) for one in procedures}

    def heights(self, subject: str, procedures: list[Procedure]) -> dict[float, str]:
        """Declare the heights above the work that are used often; return their names."""
        uses: Counter[float] = Counter()
        roles: dict[float, set[Role]] = {}
        for procedure in procedures:
            for node, below in zip(procedure.body, (*procedure.body[1:], None), strict=True):
                height = _height(node)
                if height is None:
                    continue
                uses[height] += 1
                assert isinstance(node, p.Move) and isinstance(node.target, e.Apply)
                base = node.target.arguments[0]
                down = isinstance(below, p.Move) and _base(below) == base
                down = down and (_height(below) or 0.0) < height
                roles.setdefault(height, set()).add("approach" if down else "retract")
        often = [height for height, count in uses.items() if count >= _OFTEN]
        if not often or len(uses) > _MOST_HEIGHTS:
            return {}
        words = {
            height: "height" if len(uses) == 1 or len(roles[height]) > 1 else min(roles[height])
            for height in often
        }
        # Names have to tell what each of two heights is for, or neither has one.
        if len(set(words.values())) < len(words):
            return {}
        named: dict[float, str] = {}
        for height, word in words.items():
            name = self.new(subject, word)
            named[height] = name
            value = e.number_of(height)
            self.variables[name] = Variable("number", value, (), "constant")
        return named

    def motions(
        self, subject: str, procedures: list[Procedure]
    ) -> tuple[dict[Speed, str], dict[Speed, str], dict[Blend, str]]:
        """Declare speeds of travel and of work, and blends; return the names of each."""
        travel: Counter[Speed] = Counter()
        work: Counter[Speed] = Counter()
        blends: Counter[Blend] = Counter()
        for procedure in procedures:
            for node in walk(procedure.body):
                motions: list[tuple[Any, Any]] = []
                away = _height(node) is not None
                match node:
                    case p.Move(motion=one) | p.MoveCircular(motion=one) | p.MoveJoints(motion=one):
                        motions = [(one.speed, one.blend)]
                    case p.Follow(path):
                        motions = [(speed, None) for speed in path.speeds]
                        # A path uses its blends at each of its points.
                        motions += [(None, blend) for blend in path.blends] * _SEVERAL
                for speed, blend in motions:
                    if isinstance(speed, Speed) and self.language.declares_motion(speed):
                        (travel if away else work)[speed] += 1
                    if isinstance(blend, Blend) and self.language.declares_motion(blend):
                        blends[blend] += 1
        zones = self.only(subject, "zone", blends, self.blends)
        if travel.keys() == work.keys():
            same = self.only(subject, "speed", travel + work, self.speeds)
            return same, same, zones
        return (
            self.only(subject, "travel", travel, self.speeds),
            self.only(subject, "speed", work, self.speeds),
            zones,
        )

    def only(
        self, subject: str, word: str, uses: Counter[Any], table: dict[str, Any]
    ) -> dict[Any, str]:
        """Declare the value of a kind that a subject uses, and uses several times."""
        # Names would not tell two values of one kind apart.
        if len(uses) != 1 or next(iter(uses.values())) < _SEVERAL:
            return {}
        name = self.new(subject, word)
        value = next(iter(uses))
        table[name] = value
        return {value: name}

    def new(self, subject: str, word: str) -> str:
        stem = subject.lower().removeprefix(FOLLOWING).removesuffix(CONTOURS_SUFFIX)
        if not stem:
            interface = self.given.interface
            stem = f"{interface.prefix if interface else ''}work"
        name = identifier(f"{stem[:_LONGEST_STEM].rstrip('_')}_{word}", self.taken)
        self.taken.add(name)
        return name


def _known(names: Mapping[Any, str], value: Any) -> Any:
    computed = isinstance(value, p.ComputedSpeed | p.ComputedBlend | e.Name)
    return e.Name(names[value]) if not computed and value in names else value


def _height(node: p.Statement | None) -> float | None:
    """Return the height (mm) above a target, along the tool, that a move goes to; else None."""
    if not isinstance(node, p.Move):
        return None
    match node.target:
        case e.Apply("relative", (_, x, y, z)):
            number = e.plain_number(z)
            level = e.plain_number(x) == 0 and e.plain_number(y) == 0
            return -number if level and number is not None and number < 0 else None
    return None


def _base(node: p.Move) -> e.Expression:
    """Return the target that a move goes to or goes above."""
    match node.target:
        case e.Apply("relative", (base, *_)):
            return base
    return node.target


def _subjects(program: Program) -> dict[str, str]:
    """Return the subject of each procedure by its name in lower case, see `NamedConstants`.

    A subject is a procedure that the entry calls; without an entry, one that none calls. Empty for
    the entry.
    """
    calls = {
        one.name.lower(): {x.procedure.lower() for x in walk(one.body) if isinstance(x, p.Call)}
        for one in program.procedures
    }
    entry = (program.entry or "").lower()
    found = dict.fromkeys(calls, "")
    called = calls[entry] if entry in calls else calls.keys() - set().union(*calls.values())
    for one in program.procedures:
        if one.name.lower() not in called:
            continue
        for name in reachable([one.name.lower()], lambda key: calls[key] & calls.keys()):
            found[name] = one.name
    return found
