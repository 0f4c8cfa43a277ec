"""Forms of programs made from drawings and tables: constants, offsets and arrays.

    [style]                       # in the process file or assistant.toml
    points = "offsets"            # or "targets", "arrays"
    constants = true

A program gets its form last, because its arm is solved with plain targets. Heights, speeds and
blends that are used often get names; the targets of a contour become offsets of its start, or the
targets of a path an array. `unfolded` reverses the form independently: it follows the program as a
controller does, so that the written program is compared with the plain one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Diagnostic, Severity, error, warning
from assistant.compiler.unfolding import NotUnfolded, unfolded
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.uses import declared
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Target
from assistant.program.motion import Blend, Kind, Path, Speed, configuration_row
from assistant.program.passes.paths import COLUMNS, move_at
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier, walk
from assistant.program.rewriting import map_expressions, records
from assistant.sources.contours.contour_shapes import number_text
from assistant.sources.contours.layer_program import CONTOURS_SUFFIX
from assistant.sources.process import ProgramStyle

if TYPE_CHECKING:
    from assistant.languages import Language

STAYS_PLAIN: Final = warning(
    "CO621",
    "the points of {paths} stay targets instead of {points}: {why}",
    '{cure}, or write points = "targets" in [style]',
)
FORM_REFUSED: Final = warning(
    "CO622",
    "the form that [style] states is left out: {language} cannot express it ({reason})",
    'write points = "targets" in [style], or constants = false if the points are targets',
)
FORM_DIFFERS: Final = error(
    "CO623",
    "the program in the form of [style] differs from the one with plain targets: {message}",
    'write points = "targets" and constants = false in [style]; report this with the input',
)

_OFTEN: Final = 4
"""Uses of a height from which on it has a name."""
_SEVERAL: Final = 2
"""Uses of a speed or blend from which on it has a name."""
_MOST_HEIGHTS: Final = 2
"""Heights of a subject up to which they have names: of an approach and of a retract."""
_LONG: Final = 8
"""Rows of a path from which on it is an array."""
_LOOP: Final = 3
"""Rows under the same settings from which on they are a loop."""
_MOST_POINTS: Final = 5000
"""Rows up to which a path gets another form; nobody reads longer ones."""
_START: Final = "_start"
"""End of the name of the target where a contour begins."""
_SAME: Final = 1e-9
"""Difference of external axes that counts as none."""
_DECIMALS: Final = 4
"""Decimals of mm of offsets."""
_NEAR: Final = 1e-6
"""Difference of quaternions, 1 - |a·b|, that counts as none."""
_NEIGHBOURS: Final = 12
"""Statements before and after a move among which the path of its contour is."""
_TOO_LONG: Final = f"it has more than {_MOST_POINTS} points", "divide it"
"""Why a path keeps its targets, and the cure."""


@dataclass(frozen=True, slots=True)
class Formed:
    """A program in the form of a style, the given one if nothing changed, and findings."""

    program: Program
    findings: tuple[Diagnostic, ...] = ()


def with_structure(program: Program, style: ProgramStyle) -> Program:
    """Return a program with procedures for paths of tables, and comments for these and locations.

    Its moves stay as they are.
    """
    program = _with_path_procedures(program, style)
    return _with_location_notes(program) if style.commented else program


def with_form(program: Program, style: ProgramStyle, language: Language[Any]) -> Formed:
    """Return a program with the points and constants of a style."""
    findings: tuple[Diagnostic, ...] = ()
    if style.points == "offsets":
        program, findings = OffsetForm(program).program()
    elif style.points == "arrays":
        program, findings = ArrayForm(program).program()
    if style.constants is not False:
        program = NamedConstants(program, language, commented=style.commented).program()
    return Formed(program, findings)


def form_refused(found: Iterable[Diagnostic], language: Language[Any]) -> Diagnostic:
    """Return the finding that a language cannot express a form. found: findings with its errors."""
    reason = next(one.message for one in found if one.severity is Severity.ERROR)
    return FORM_REFUSED(language=language.title, reason=reason)


def form_differences(
    plain: Program, written: Program, language: Language[Any]
) -> Iterator[Diagnostic]:
    """Yield the differences, move by move, between a plain program and the text in its form."""
    precision = language.precision
    # A sum of two rounded positions has twice the rounding error.
    tolerance = Tolerance(2.0 * precision.position, precision.angle, precision.number)
    try:
        comparison = compare(unfolded(plain), unfolded(written), tolerance)
    except NotUnfolded as unknown:
        yield FORM_DIFFERS(message=str(unknown))
        return
    for one in comparison.mismatches:
        yield FORM_DIFFERS(message=one.message, about=one.about)


# ------------------------------------------------------------------- procedures of tables


def _with_path_procedures(program: Program, style: ProgramStyle) -> Program:
    """Return a program of paths alone, as of a table, with a procedure and a comment for each."""
    if len(program.procedures) != 1 or style.procedures == "none":
        return program
    (main,) = program.procedures
    paths = [node.path for node in main.body if isinstance(node, p.Follow)]
    if not paths or any(not isinstance(node, p.Follow | p.Move) for node in main.body):
        return program
    taken = TakenNames((program.name, main.name, *declared(program)))
    made: list[Procedure] = []
    body: list[p.Statement] = []
    for node in main.body:
        if not isinstance(node, p.Follow):
            body.append(node)
            continue
        # The path keeps its name, which its rows have; a single path often has the program's.
        own = node.path.name.lower() not in {one.lower() for one in taken}
        name = node.path.name if own else identifier(f"{FOLLOWING}{node.path.name}", taken)
        taken.add(name)
        notes = (p.Comment(p.OwnText(_path_text(node.path))),) if style.commented else ()
        made.append(Procedure(name, (*notes, node)))
        body.append(p.Call(name, span=node.span))
    return replace(program, procedures=(replace(main, body=tuple(body)), *made))


def _with_location_notes(program: Program) -> Program:
    """Return a program with the number of locations in a comment of each of their procedures."""
    entry = program.procedure(program.entry or "")
    called = {
        x.procedure.lower() for x in walk(entry.body if entry else ()) if isinstance(x, p.Call)
    }

    def noted(procedure: Procedure) -> Procedure:
        body = procedure.body
        moves = [node for node in body if isinstance(node, p.Move)]
        if procedure.name.lower() not in called or len(moves) < len(body):
            return procedure
        names = list(dict.fromkeys(x.target.name for x in moves if isinstance(x.target, e.Name)))
        if not names:
            return procedure
        text = f"{len(names)} location{'s' * (len(names) != 1)}: {names[0]}"
        text += f" to {names[-1]}" if len(names) > 1 else ""
        return replace(procedure, body=(p.Comment(p.OwnText(text)), *body))

    procedures = tuple(map(noted, program.procedures))
    changed = any(a is not b for a, b in zip(procedures, program.procedures, strict=True))
    return replace(program, procedures=procedures) if changed else program


def _path_text(path: Path) -> str:
    """Describe a path for people: `seam: 35 points, 412 mm`."""
    text = f"{path.name}: {len(path)} point{'s' * (len(path) != 1)}"
    rows = np.flatnonzero(path.kinds[1:] == Kind.LINEAR) + 1
    # Arcs and joint moves are not as long as their chords.
    if len(rows) and not ((path.kinds == Kind.VIA) | (path.kinds == Kind.END)).any():
        steps = np.linalg.norm(path.positions[rows] - path.positions[rows - 1], axis=1)
        text += f", {number_text(round(float(steps.sum()), 1))} mm"
    return text


# ------------------------------------------------------------------------------- offsets


class _Points:
    """Base of the forms of points.

    left: names of the paths that keep targets, by the reason and its cure.
    """

    form: str

    def __init__(self, given: Program) -> None:
        self.given = given
        self.taken = taken_names(given)
        self.left: dict[tuple[str, str], list[str]] = {}

    def keep(self, path: Path, why: str, cure: str) -> None:
        """Note that a path keeps its targets."""
        self.left.setdefault((why, cure), []).append(path.name)

    def findings(self) -> tuple[Diagnostic, ...]:
        return tuple(
            STAYS_PLAIN(
                paths=_in_words(names), points=self.form, why=why, cure=cure,
                about=Declared(names[0], "paths"),
            )
            for (why, cure), names in self.left.items()
        )  # fmt: skip


def _in_words(paths: list[str]) -> str:
    more = len(paths) - 1
    return f"`{paths[0]}`" + (f" and {more} more path{'s' * (more != 1)}" if more else "")


class OffsetForm(_Points):
    """Targets of contours as offsets of their starts."""

    form = "offsets"

    def program(self) -> tuple[Program, tuple[Diagnostic, ...]]:
        uses = Counter(
            name
            for procedure in self.given.procedures
            for name in {x.name.lower() for x in records(procedure) if isinstance(x, e.Name)}
        )
        self.targets = {name.lower(): one for name, one in self.given.targets.items()}
        self.once = {name for name in self.targets if uses[name] == 1}
        self.gone: set[str] = set()
        procedures = tuple(
            replace(one, body=tuple(self.body(one.body))) for one in self.given.procedures
        )
        kept = {n: t for n, t in self.given.targets.items() if n.lower() not in self.gone}
        program = replace(self.given, procedures=procedures, targets=kept)
        return (program if self.gone or self.changed else self.given), self.findings()

    changed = False

    def body(self, body: tuple[p.Statement, ...]) -> Iterator[p.Statement]:
        start = ""
        for at, node in enumerate(body):
            # The approach above a start is the first statement that names it.
            begun = _start_named(node)
            start = begun or start
            if isinstance(node, p.Follow):
                why = self.unfit(node.path, start)
                if why is None:
                    self.changed = True
                    yield from self.moves(node, start)
                    continue
                self.keep(node.path, *why)
            elif start and not begun and isinstance(node, p.Move | p.MoveCircular):
                if not self.keeps_targets(body, at, start):
                    node = map_expressions(node, partial(self.target, start))
            yield node

    def keeps_targets(self, body: tuple[p.Statement, ...], at: int, start: str) -> bool:
        """True if the path of the contour of a move keeps its targets."""
        around = body[max(at - _NEIGHBOURS, 0) : at + _NEIGHBOURS]
        near = [x for x in around if isinstance(x, p.Follow)]
        return any(
            _is_of(x.path.name, start) and self.unfit(x.path, start) is not None for x in near
        )

    def unfit(self, path: Path, start: str) -> tuple[str, str] | None:
        """Return why a path cannot be offsets, and the cure; None if it can."""
        if not start:
            return "no target has a name where it starts, as contours of a drawing have one", (
                "follow contours of a drawing"
            )
        if len(path) > _MOST_POINTS:
            return _TOO_LONG
        base = self.targets[start.lower()]
        turn = np.array(base.pose.quaternion)
        if np.abs(np.abs(path.quaternions @ turn) - 1.0).max(initial=0.0) > _NEAR:
            return "the tool turns on the path, and offsets only shift", "leave out `tangential`"
        wanted = configuration_row(base.configuration)
        if (path.configurations != np.array(wanted, dtype=np.int8)).any():
            return "the arm changes its configuration on the path, and offsets keep it", (
                "place the work where one configuration reaches all of the path"
            )
        mine = np.array([np.nan if x is None else x for x in base.external], dtype=np.float64)
        if not np.isclose(path.external, mine, rtol=0.0, atol=_SAME, equal_nan=True).all():
            return "external axes move on the path, and offsets keep them", "keep them still"
        return None

    def moves(self, node: p.Follow, start: str) -> Iterator[p.Statement]:
        path = node.path
        base = np.array(self.targets[start.lower()].pose.position)
        shifts = np.round(path.positions - base, _DECIMALS) + 0.0
        via: e.Expression | None = None
        for row, (kind, shift) in enumerate(zip(path.kinds.tolist(), shifts.tolist(), strict=True)):
            point = _offset(start, shift)
            if kind == Kind.VIA:
                via = point
            elif kind == Kind.END and via is not None:
                motion = move_at(path, row, point).motion
                yield p.MoveCircular(via, point, motion, span=node.span)
            else:
                yield replace(move_at(path, row, point), span=node.span)

    def target(self, start: str, value: e.Expression) -> e.Expression:
        """Return another target of a contour as an offset of its start, if it is only shifted."""
        if not isinstance(value, e.Name) or value.name.lower() not in self.once - {start.lower()}:
            return value
        if not value.name.lower().startswith(start.lower().removesuffix(_START) + "_"):
            return value
        base, other = self.targets[start.lower()], self.targets[value.name.lower()]
        if not _is_shifted(base, other):
            return value
        self.changed = True
        self.gone.add(value.name.lower())
        shift = np.array(other.pose.position) - np.array(base.pose.position)
        return _offset(start, (np.round(shift, _DECIMALS) + 0.0).tolist())


def _is_of(path: str, start: str) -> bool:
    """True if a path, or a part of one, belongs to the contour that has a start."""
    return f"{path.lower()}_".startswith(start.lower().removesuffix(_START) + "_")


def _start_named(node: p.Statement) -> str:
    """Return the start of a contour that a move goes to, or to a position above it; else empty."""
    target = node.target if isinstance(node, p.Move) else None
    while isinstance(target, e.Apply) and target.arguments:
        target = target.arguments[0]
    named = isinstance(target, e.Name) and target.name.lower().endswith(_START)
    return target.name if named and isinstance(target, e.Name) else ""


def _offset(start: str, shift: list[float]) -> e.Expression:
    if not any(shift):
        return e.Name(start)
    return e.Apply("offset", (e.Name(start), *map(e.number_of, shift)))


def _is_shifted(one: Target, other: Target) -> bool:
    """True if two targets differ by their positions alone."""
    turned = abs(float(np.dot(one.pose.quaternion, other.pose.quaternion)))
    return (
        abs(turned - 1.0) <= _NEAR
        and one.configuration == other.configuration
        and np.array_equal(np.array(one.external), np.array(other.external), equal_nan=True)
    )


# -------------------------------------------------------------------------------- arrays


class ArrayForm(_Points):
    """Long paths as arrays of targets, with loops along rows under the same settings."""

    form = "arrays"

    def program(self) -> tuple[Program, tuple[Diagnostic, ...]]:
        self.made: dict[str, Variable] = {}
        procedures = tuple(
            replace(one, body=tuple(x for node in one.body for x in self.statement(node)))
            for one in self.given.procedures
        )
        if not self.made:
            return self.given, self.findings()
        variables = {**self.given.variables, **self.made}
        program = replace(self.given, procedures=procedures, variables=variables)
        return program, self.findings()

    def statement(self, node: p.Statement) -> Iterator[p.Statement]:
        if not isinstance(node, p.Follow) or len(node.path) < _LONG:
            yield node
            return
        path = node.path
        if len(path) > _MOST_POINTS:
            self.keep(path, *_TOO_LONG)
            yield node
            return
        name = identifier(f"{path.name}_points", self.taken)
        self.taken.add(name)
        values = tuple(e.TargetValue(path.target(row)) for row in range(len(path)))
        self.made[name] = Variable("position", e.Aggregate(values), (len(path),), "constant")
        yield from self.moves(node, name)

    def moves(self, node: p.Follow, name: str) -> Iterator[p.Statement]:
        path = node.path

        def element(index: e.Expression) -> e.Expression:
            return e.Index(e.Name(name), (index,))

        row = 0
        while row < len(path):
            if path.kinds[row] == Kind.VIA:
                via, end = element(e.Number(row + 1)), element(e.Number(row + 2))
                motion = move_at(path, row + 1, end).motion
                yield p.MoveCircular(via, end, motion, span=node.span)
                row += 2
                continue
            stop = _same_until(path, row)
            # The target before an arc is written out: after a loop, its index is not known.
            if stop < len(path) and path.kinds[stop] == Kind.VIA:
                stop -= 1
            if stop - row >= _LOOP:
                body = (replace(move_at(path, row, element(e.Name(_COUNTER))), span=node.span),)
                first, last = e.Number(row + 1), e.Number(stop)
                yield p.For(_COUNTER, first, last, body, p.ONE, span=node.span)
                row = stop
            else:
                yield replace(move_at(path, row, element(e.Number(row + 1))), span=node.span)
                row += 1


_COUNTER: Final = "i"


def _same_until(path: Path, row: int) -> int:
    """Return the first row after one that is another kind of move, or has other settings."""
    same = path.kinds[row:] == path.kinds[row]
    for column in COLUMNS:
        values = getattr(path, column)
        same = same & (values[row:] == values[row])
    other = np.flatnonzero(~same)
    return row + int(other[0]) if len(other) else len(path)


# ----------------------------------------------------------------------------- constants


Role = Literal["approach", "retract"]


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
                down = isinstance(below, p.Move) and below.target == base
                roles.setdefault(height, set()).add("approach" if down else "retract")
        often = [height for height, count in uses.items() if count >= _OFTEN]
        if not often or len(uses) > _MOST_HEIGHTS:
            return {}
        # Of two heights one is for approaches and one for retracts, or neither has a name.
        if len(uses) > 1 and any(len(roles[height]) > 1 for height in often):
            return {}
        named: dict[float, str] = {}
        for height in often:
            name = self.new(subject, next(iter(roles[height])) if len(uses) > 1 else "height")
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


_LONGEST_STEM: Final = 20
"""Letters of a subject that names of its constants begin with."""
FOLLOWING: Final = "follow_"
"""Prefix for the procedure of a path whose name is taken by something else."""


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


def taken_names(program: Program) -> TakenNames:
    """Return the names of a program that no constant or array may have."""
    taken = TakenNames((program.name, *declared(program)))
    taken.update(one.name for one in program.procedures)
    for node in program.statements():
        if isinstance(node, p.Follow):
            taken.add(node.path.name)
    return taken
