"""Proof by motion: the source and what was written, run against the same signals and compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from assistant.compiler.arms import Arms
from assistant.compiler.loading import language_of
from assistant.compiler.motion_sides import (
    Made,
    in_the_cell,
    names_of_wires,
    on_stand_ins,
    outputs_of,
    sides,
)
from assistant.program.diagnostics import Diagnostic, error, has_errors, info, warning

if TYPE_CHECKING:
    from assistant.virtual.branches import Branch
    from assistant.virtual.events import Run
    from assistant.virtual.proving.search import Found

MOVES_OTHERWISE = error(
    "CO110",
    "run, `{written}` does something else, with {inputs}: {what}",
    "nothing was written; report this with the program",
)
NOT_RUN = error(
    "CO111",
    "there is no proof by motion: {reason}",
    "nothing was written; leave --prove out, and try what was written with care",
)
NO_BRANCH = info(
    "CO112",
    "no run took this branch: {said}",
    "say with --signals what leads there, or look at it yourself",
)
STOPS_ITSELF = info(
    "CO113",
    "{count} of {runs} runs end with an error of the program, the first with {inputs}: {what}",
    "see whether a real cell has such inputs",
)
STALLED = warning(
    "CO114",
    "the script leaves `{name}` waiting here: what follows was not compared",
    "say in the script what ends the wait, if something does",
)
UNJUDGED = warning(
    "CO116",
    "with {inputs} nobody knows what `{name}` does ({reason}): these inputs are not compared",
    "see whether a real cell has such inputs, and try them on the controller",
)
STAND_IN = info(
    "CO115",
    "both were run on the {title}, as nobody has named an arm and they read where it stands",
    "name the arm that runs the program with --robot",
)


@dataclass(frozen=True, slots=True)
class Proving:
    """How a proof by motion is sought. script: file of what becomes of the signals, None for a
    search. seed: of what it draws. runs, seconds: after which it is over.
    """

    script: str | FilePath | None = None
    seed: int = 0
    runs: int = 200
    seconds: float = 10.0


@dataclass(frozen=True, slots=True)
class MotionProof:
    """What was compared, and the findings; `found` is None where nothing could be run."""

    found: Found | None
    findings: tuple[Diagnostic, ...] = ()
    names: tuple[str, str] = ("", "")

    @property
    def holds(self) -> bool:
        return self.found is not None and not has_errors(self.findings)

    def line(self) -> str:
        """The result in one line for people."""
        if self.found is None or not self.holds:
            return "not proven"
        found = self.found
        taken = [f"{t - len(n)} of {t} in {name}" for t, n, name in self._branches(found)]
        counts = [_counted(found.visits, "visit"), _counted(found.changes, "signal change")]
        more = (found.waits, "wait for inputs"), (found.values, "shared value")
        counts += [_counted(count, what) for count, what in more if count]
        left = f"; not compared: {', '.join(sorted(found.left))}" if found.left else ""
        return (
            f"proven: {_counted(found.runs, 'run')}, {', '.join(counts[:-1])} and {counts[-1]} "
            f"alike, largest distance {found.apart:.4f} mm, {found.turned:.4f} degrees; "
            f"branches taken: {', '.join(taken)}{left}"
        )

    def _branches(self, found: Found) -> Iterator[tuple[int, Sequence[Branch], str]]:
        yield from zip(found.total, found.never, self.names, strict=True)

    def record(self) -> dict[str, Any]:
        """The same for programs."""
        found = self.found
        if found is None:
            return {"holds": False}
        return {
            "holds": self.holds,
            "runs": found.runs,
            "visits": found.visits,
            "signal_changes": found.changes,
            "waits": found.waits,
            "shared_values": found.values,
            "not_compared": sorted(found.left),
            "position_mm": found.apart,
            "angle_deg": found.turned,
            "branches": [
                {"program": name, "taken": total - len(never), "of": total}
                for total, never, name in self._branches(found)
            ],
        }


def _counted(count: int, word: str) -> str:
    first, space, rest = word.partition(" for ")
    return f"{count:,} {first}{'' if count == 1 else 's'}{space}{rest}"


def prove_motion(made: Made, arms: Arms, proving: Proving, entry: str | None = None) -> MotionProof:
    """Runs what was written and its source against the same signals.

    entry: the procedure that the source begins with, None for its own. Raises Unreadable or
    Refused for a script that cannot be used.
    """
    from assistant.compiler.script_file import read_script
    from assistant.virtual.proving.search import Budget, Found, compared
    from assistant.virtual.proving.sides import can_run
    from assistant.virtual.rounding import Rounding

    origin, target = made.source.origin, language_of(made.language)
    for language in (target, *([] if origin is None else [language_of(origin.language)])):
        if not can_run(language.family):
            return _not_run(f"programs in {language.name} cannot be run")
    if not made.source.procedures:  # data that other programs use: nothing that could be run
        return MotionProof(Found(), (), (made.source.name, made.program.name))
    if entry is None and made.source.entry is None:
        return _not_run("nothing of it was run, as no procedure is the one that it begins with")
    trees, left = in_the_cell(made)
    if left:
        names_left = ", ".join(f"`{name}`" for name in left)
        return _not_run(f"the source does not declare {names_left} by a value that can be changed")
    written = [target.parse(target.decode(data, name)) for name, data in made.files.items()]
    first, second = sides(made, trees, written, arms, entry)
    precision = target.precision
    rounding = Rounding(precision.position, precision.angle, precision.position)
    rounding = rounding.of(second.constants())
    outputs = outputs_of(made, (first.family, second.family))
    names = made.source.name if origin is None else _path(trees[0]), _path(written[0])
    script = None if proving.script is None else read_script(proving.script)
    budget = Budget(proving.seed, proving.runs, proving.seconds)
    found = compared(first, second, outputs, rounding, budget, script)
    told: list[Diagnostic] = []
    if found.unknown is not None and first.robot is None and second.robot is None:
        for arm, one, two in on_stand_ins(first, second):
            again = compared(one, two, outputs, rounding, budget, script)
            if again.unknown is None and again.failing < again.runs:
                found = again
                told = [STAND_IN(title=arm.title)]
                break
    told += _findings(found, names, names_of_wires(made))
    return MotionProof(found, tuple(told), names)


def _not_run(reason: str) -> MotionProof:
    return MotionProof(None, (NOT_RUN(reason=reason),))


def _path(tree: Any) -> str:
    return PurePath((tree.source and tree.source.path) or "standard input").name


def _findings(
    found: Found, names: tuple[str, str], wires: Mapping[str, str]
) -> Iterator[Diagnostic]:
    """names: of both programs. wires: as the first one calls them."""
    stop = found.unknown
    if stop is not None:
        reason = f"`{names[stop.side]}` cannot be run here ({_message(stop.run)})"
        yield NOT_RUN(reason=reason, **_at(stop.run.place))
    elif found.unlike is not None:
        first, second = found.unlike.first, found.unlike.second
        what = str(found.unlike)
        if second is not None and second.place is not None:
            what += f" ({second.place[0] or names[1]}:{second.place[1]})"
        place = first.place if first is not None else None
        inputs = found.scenario.said(wires) if found.scenario else ""
        yield MOVES_OTHERWISE(written=names[1], inputs=inputs, what=what, **_at(place))
    elif found.failing == found.runs and found.failed is not None:
        reason = f"`{names[0]}` ends with an error of its own ({_message(found.failed.run)})"
        yield NOT_RUN(reason=reason, **_at(found.failed.run.place))
    elif found.idling == found.runs and found.idle is not None:
        reason = f"`{names[0]}` only waits, and nothing is compared ({_message(found.idle.run)})"
        yield NOT_RUN(reason=reason, **_at(found.idle.run.place))
    elif found.failed is not None:
        run = found.failed.run
        yield STOPS_ITSELF(
            count=found.failing,
            runs=found.runs,
            inputs=found.failed.scenario.said(wires),
            what=_message(run),
            **_at(run.place),
        )
    if found.unjudged is not None:
        stop = found.unjudged
        inputs, reason = stop.scenario.said(wires), _message(stop.run)
        unjudged = UNJUDGED(name=names[stop.side], inputs=inputs, reason=reason)
        yield replace(unjudged, **_at(stop.run.place))
    if found.stalled is not None:
        yield STALLED(name=names[0], **_at(found.stalled.run.place))
    for branches, name in zip(found.never, names, strict=True):
        for one in branches:
            yield NO_BRANCH(said=one.said, **_at((one.file or name, one.line)))


def _message(run: Run) -> str:
    """What it says, without the place that the finding has."""
    place = "" if run.place is None else f"{run.place[0]}:{run.place[1]}: ".lstrip(":")
    return run.message.removeprefix(place) or run.ended


def _at(place: tuple[str, int] | None) -> dict[str, Any]:
    return {} if place is None else {"path": place[0] or None, "line": place[1] or None}
