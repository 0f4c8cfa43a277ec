"""Spread long programs over units, as a controller limits the targets of one unit.

Statements that follow several short paths move to a unit together, see `_Packer`: loading a unit
takes time, and one load serves all of them. What is still too long is split path by path.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Ints
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Rule
from assistant.program import statements as p
from assistant.program.analysis.uses import called
from assistant.program.motion import Blend, Kind, Path
from assistant.program.passes.paths import COLUMNS, table_of
from assistant.program.program import Procedure, Program, TakenNames, identifier, walk
from assistant.program.rewriting import Body, map_bodies

if TYPE_CHECKING:
    from assistant.program.passes.legalisation import Legalisation, Units

_FEWEST_PATHS: Final = 2
"""Paths of a run that moves to a unit, at least; `_Splitter` moves single ones."""
_SINGLE_MOVES: Final = (p.Move, p.MoveCircular, p.MoveJoints)
_JUMPING: Final = (p.Label, p.Goto, p.Return, p.Opaque, p.Interrupt)
"""Statements of a procedure that cannot be divided."""


def _packed(job: Legalisation, units: Units) -> Program:
    """Return the program with runs of short paths in units, each as full as possible."""
    program = job.program
    # Vendor text, and programs lifted from it, may call procedures by their names.
    if units.packed is None or program.origin is not None or program.declarations:
        return program
    if any(isinstance(node, p.Opaque) for node in program.statements()):
        return program
    packer = _Packer(job, units, units.packed)
    return packer.packed() if packer.total > packer.most else program


@dataclass(frozen=True, slots=True)
class _Run:
    """Statements of a body from start up to stop, and the paths that they follow.

    targets: of these paths, None if the statements cannot move to a unit. paths: their number.
    """

    start: int
    stop: int
    targets: int | None = 0
    paths: int = 0


class _Packer:
    """Moves runs of statements to units, with the procedures that they alone call.

    A run begins and ends where the arm stands still, because loading a unit takes time. total:
    targets that remain in the main unit.
    """

    def __init__(self, job: Legalisation, units: Units, rule: Rule) -> None:
        self.program, self.findings, self.units, self.rule = job.program, job.findings, units, rule
        self.most = max(units.most, units.least_most)
        self.calls = Counter(name.lower() for q in self.program.procedures for name in called(q))
        self.total = len(self.program.targets) + sum(
            size
            for q in self.program.procedures
            if q.unit is None
            for size in _path_sizes(q)
            if size <= self.most
        )
        self.taken = _taken_names(self.program)
        self.moved: dict[str, str] = {}
        """The unit of each procedure that moves, by its name in lower case."""
        self.new: dict[str, list[Procedure]] = {}
        """The rest of each divided procedure and those with its runs, by its name."""

    def packed(self) -> Program:
        """Return the program with its runs in units."""
        entry = (self.program.entry or "").lower()
        # The entry comes last, so that what another procedure calls stays together.
        for procedure in sorted(self.program.procedures, key=lambda q: q.name.lower() == entry):
            if self.total > self.most and self._may_be_divided(procedure):
                self._pack(procedure)
        made: list[Procedure] = []
        for procedure in self.program.procedures:
            low = procedure.name.lower()
            if low in self.moved:
                procedure = replace(procedure, unit=self.moved[low])
            first, *parts = self.new.get(procedure.name, [procedure])
            made += [first, *parts]
        # The procedure that is called from outside comes first in its unit.
        heads = {q.name for parts in self.new.values() for q in parts[1:]}
        made.sort(key=lambda q: q.unit is not None and q.name not in heads)
        return replace(self.program, procedures=tuple(made))

    def _may_be_divided(self, procedure: Procedure) -> bool:
        signature = procedure.parameters or procedure.variables or procedure.result is not None
        if signature or procedure.unit is not None or procedure.name.lower() in self.moved:
            return False
        return not any(isinstance(node, _JUMPING) for node in walk(procedure.body))

    def _pack(self, procedure: Procedure) -> None:
        made: list[p.Statement] = []
        parts: list[Procedure] = []
        paths = 0
        for run in self._runs(procedure):
            body = procedure.body[run.start : run.stop]
            if run.targets is None or run.paths < _FEWEST_PATHS or self.total <= self.most:
                made += body
                continue
            number = len(parts) + 1
            name = identifier(self.units.part.format(procedure.name, number), self.taken)
            self.taken.add(name)
            unit = identifier(self.units.unit.format(procedure.name, number), self.taken)
            self.taken.add(unit)
            parts.append(Procedure(name, body, unit=unit))
            called_here = (one.procedure.lower() for one in body if isinstance(one, p.Call))
            self.moved |= dict.fromkeys(called_here, unit)
            self.total -= run.targets
            paths += run.paths
            made.append(p.Call(name, unit=unit, span=body[0].span))
        if parts:
            self.new[procedure.name] = [replace(procedure, body=tuple(made)), *parts]
            about = Declared(procedure.name, "procedures")
            self.findings.append(
                self.rule(name=procedure.name, count=paths, parts=len(parts), about=about)
            )

    def _runs(self, procedure: Procedure) -> Iterator[_Run]:
        """Yield the body of a procedure in runs, each with as many targets as fit a unit."""
        run = _Run(0, 0)
        for piece in self._pieces(procedure.body):
            fits = (
                run.targets is not None
                and piece.targets is not None
                and run.targets + piece.targets <= self.most
                # What comes before the first path of a body stays there.
                and (run.paths > 0 or piece.paths == 0)
            )
            if fits:
                assert run.targets is not None and piece.targets is not None
                paths = run.paths + piece.paths
                run = _Run(run.start, piece.stop, run.targets + piece.targets, paths)
            else:
                yield run
                run = piece
        yield run

    def _pieces(self, body: Body) -> Iterator[_Run]:
        """Yield the parts of a body between which it can be cut."""
        start = 0
        for at in range(1, len(body) + 1):
            if at == len(body) or self._is_cut(body, at):
                sizes = [self._sizes(node) for node in body[start:at]]
                known = [size for one in sizes if one is not None for size in one]
                movable = None not in sizes and sum(known) <= self.most
                yield _Run(start, at, sum(known) if movable else None, len(known))
                start = at

    def _is_cut(self, body: Body, at: int) -> bool:
        """True if the arm stands still before a statement that begins something new."""
        before, here = body[at - 1], body[at]
        if isinstance(before, p.Comment):
            # The heading of a procedure stays in it.
            heading = all(isinstance(one, p.Comment) for one in body[:at])
            return heading and isinstance(here, p.Comment | p.Call)
        begins = isinstance(here, p.Comment | p.Call) or isinstance(before, p.Call)
        # Without comments the next contour begins with its approach, after the last retract.
        moving = isinstance(before, _SINGLE_MOVES) and isinstance(here, _SINGLE_MOVES)
        commented = any(isinstance(one, p.Comment) for one in body)
        return (begins or (moving and not commented)) and self._ends_at_stop(body[:at])

    def _ends_at_stop(self, body: Sequence[p.Statement]) -> bool:
        """True if the last move of statements ends at a stop point, or they have no move."""
        for node in reversed(body):
            match node:
                case (
                    p.Move(motion=motion)
                    | p.MoveCircular(motion=motion)
                    | p.MoveJoints(motion=motion)
                ):
                    return self._is_stop(motion.blend)
                case p.Follow(path) if len(path):
                    return self._is_stop(path.blends[path.blend[-1]])
                case p.Call(name):
                    callee = self.program.procedure(name)
                    return callee is None or self._ends_at_stop(callee.body)
                case p.Comment() | p.SetSignal() | p.Wait():
                    continue
                case _:
                    return False
        return True

    def _is_stop(self, blend: Any) -> bool:
        if not isinstance(blend, Blend):
            name = getattr(blend, "name", "").lower()
            known = {n.lower(): value for n, value in self.program.blends.items()}
            blend = known.get(name)
        return isinstance(blend, Blend) and blend.fine

    def _sizes(self, node: p.Statement) -> list[int] | None:
        """Return the targets of each path that a statement follows; None if it cannot move."""
        match node:
            case p.Follow(path):
                return [len(path)]
            case p.Call(name, arguments, unit):
                callee = self.program.procedure(name)
                if callee is None or arguments or unit is not None or callee.unit is not None:
                    return None
                low, sizes = name.lower(), _path_sizes(callee)
                alone = self.calls[low] == 1 and low != (self.program.entry or "").lower()
                calling = any(self.program.procedure(one) for one in called(callee))
                leaf = self._may_be_divided(callee) and not calling
                return sizes if alone and leaf and callee.name not in self.new else None
        inner = [one for one in walk((node,)) if isinstance(one, p.Follow | p.Call)]
        return None if inner else []


def _taken_names(program: Program) -> TakenNames:
    taken = TakenNames((program.name, *(q.name for q in program.procedures)))
    taken.update(q.unit for q in program.procedures if q.unit is not None)
    taken.update(program.targets, program.variables, program.signals, program.tools)
    return taken


def split(job: Legalisation) -> Program:
    """Return the program with the paths that exceed the limit of a unit in further units."""
    units = job.can.units
    if units is None:
        return job.program
    job = replace(job, program=_packed(job, units))
    splitter = _Splitter(job, units)
    procedures = tuple(map(splitter.procedure, job.program.procedures))
    if not splitter.new:
        return job.program
    return replace(job.program, procedures=(*procedures, *splitter.new))


class _Splitter:
    """Splits paths and moves them to units.

    count: targets that remain in each unit. new: procedures of the pieces.
    """

    def __init__(self, job: Legalisation, units: Units) -> None:
        program = job.program
        self.findings, self.units = job.findings, units
        self.most = max(units.most, units.least_most)
        self.new: list[Procedure] = []
        self.taken = _taken_names(program)
        self.count: dict[str | None, int] = {None: len(program.targets)}
        for q in program.procedures:
            # Longer paths move to units in any case, and do not count.
            kept = sum(size for size in _path_sizes(q) if size <= self.most)
            self.count[q.unit] = self.count.get(q.unit, 0) + kept

    def procedure(self, procedure: Procedure) -> Procedure:
        return replace(procedure, body=self.body(procedure.body, procedure))

    def body(self, body: Body, owner: Procedure) -> Body:
        made: list[p.Statement] = []
        for node in body:
            if isinstance(node, p.Follow):
                made += self.follow(node, owner)
            else:
                made.append(map_bodies(node, lambda inner: self.body(inner, owner)))
        return tuple(made)

    def follow(self, node: p.Follow, owner: Procedure) -> Iterator[p.Statement]:
        """Yield a path, or a call for each piece of it, which is in a new procedure and unit."""
        pieces = _unit_ranges(node.path, self.units, self.most)
        if len(pieces) < 2 and self.stays(len(node.path), owner):
            yield node
            return
        by_procedure = self.units.counted == "procedure"
        about = Declared(owner.name, "procedures") if by_procedure else None
        name, count = node.path.name, len(node.path)
        self.findings.append(
            self.units.split(name=name, count=count, parts=len(pieces), about=about)
        )
        for number, (start, stop) in enumerate(pieces, 1):
            procedure = identifier(self.units.part.format(name, number), self.taken)
            self.taken.add(procedure)
            unit = procedure
            if self.units.unit:
                unit = identifier(self.units.unit.format(name, number), self.taken)
                self.taken.add(unit)
            rows = node.path.rows(start, stop, self.units.path.format(procedure))
            self.new.append(Procedure(procedure, (p.Follow(_with_used_entries(rows)),), unit=unit))
            yield p.Call(procedure, unit=unit, span=node.span)

    def stays(self, size: int, owner: Procedure) -> bool:
        """True if a path in one piece stays in its unit; the last one of a unit does."""
        if self.units.counted == "procedure":
            sizes = _path_sizes(owner)
            lone = owner.unit is not None and len(owner.body) == 1
            return lone or len(sizes) < 2 or sum(sizes) <= self.most
        left = self.count[owner.unit] - size
        if self.count[owner.unit] <= self.most or (owner.unit is not None and left == 0):
            return True
        self.count[owner.unit] = left
        return False


def _path_sizes(procedure: Procedure) -> list[int]:
    return [len(node.path) for node in walk(procedure.body) if isinstance(node, p.Follow)]


def _with_used_entries(path: Path) -> Path:
    """The path with only those table rows that it uses, in the order of their first use."""
    made: dict[str, Any] = {}
    for column in COLUMNS:
        table: tuple[Any, ...] = getattr(path, column + "s")
        made[column + "s"], made[column] = table_of(getattr(path, column), table.__getitem__)
    return replace(path, **made)


def _unit_ranges(path: Path, units: Units, most: int) -> list[tuple[int, int]]:
    """Ranges of rows that fit one unit each; an arc's two rows stay together."""
    n = len(path)
    costs, most_steps = _row_steps(path, units), units.most_steps or np.iinfo(np.int64).max
    total = np.concatenate([[0], np.cumsum(costs)])
    if n <= most and total[-1] <= most_steps:
        return [(0, n)]
    pieces, start = [], 0
    while start < n:
        room = min(int(total[start]) + most_steps, int(total[-1]))
        stop = int(np.searchsorted(total, room, side="right")) - 1
        # At least two rows, so that an arc fits.
        stop = min(n, start + most, max(stop, start + 2))
        if stop < n:
            # A short rest would be a unit of its own: the cut moves back.
            stop -= units.least if n - stop < units.least else 0
            stop = _good_cut(path, start, stop, units.straight)
        pieces.append((start, stop))
        start = stop
    return pieces


def _good_cut(path: Path, start: int, stop: int, straight: bool) -> int:
    """The last row up to `stop` that a piece may begin with.

    straight: it begins with a straight move where one is near, so that no arc starts unknown.
    """
    # At most a quarter of the piece is given up for a straight start.
    least = max(start + 1, stop - (stop - start) // 4)
    kinds = path.kinds[least : stop + 1]
    straights = np.flatnonzero((kinds != Kind.VIA) & (kinds != Kind.END))
    if straight and len(straights):
        return least + int(straights[-1])
    # An END must not begin a piece: its VIA would be in the one before.
    whole = np.flatnonzero(path.kinds[start + 1 : stop + 1] != Kind.END)
    return start + 1 + int(whole[-1]) if len(whole) else stop


def _row_steps(path: Path, units: Units) -> Ints:
    """Steps that each row takes at most: its move, and its settings where they change."""
    # The two rows of an arc are one move.
    costs = (path.kinds != Kind.VIA).astype(np.int64)
    costs[:1] += units.first
    for column, lines in units.steps.items():
        values = getattr(path, column)
        costs[1:] += lines * (values[1:] != values[:-1])
    return np.asarray(costs)
