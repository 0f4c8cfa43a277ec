"""Proof by motion: two programs, run against the same signals and compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Rule, error, has_errors, info, warning
from assistant.compiler.arms import Arms
from assistant.compiler.loading import language_of
from assistant.compiler.motion_sides import (
    ProgramPair,
    output_numbers,
    proof_sides,
    stand_in_sides,
    trees_in_cell,
    wire_names,
)
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.virtual.events import Branch, Run
    from assistant.virtual.proving.compared_programs import Side
    from assistant.virtual.proving.comparison import Rounding
    from assistant.virtual.proving.search import Found

MOVES_OTHERWISE = error(
    "CO110",
    "run, `{written}` does something else, with {inputs}: {what}",
    "nothing was written; {cure}",
)
REPORT_CURE: Final = "report this with the program"
NOT_RUN = error(
    "CO111",
    "there is no proof by motion: {reason}",
    "nothing was written; leave --prove out, and try what was written with care",
)
BRANCH_NOT_TAKEN = info(
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
    "nothing {where} ends this wait of `{name}`: what follows was not compared",
    "say in a script, by --signals, what ends the wait, if something does",
)
RUN_UNJUDGED = warning(
    "CO116",
    "with {inputs} nobody knows what `{name}` does ({reason}): these inputs are not compared",
    "see whether a real cell has such inputs, and try them on the controller",
)
SCRIPT_BY_TIME = warning(
    "CO124",
    "the script changes `{name}` at {at:g} s, which two programs of different speed reach at "
    "different statements",
    "change it at an output or at a visit instead",
)
RUN_ON_STAND_IN = info(
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

    @property
    def empty(self) -> bool:
        """Whether no run did anything that could be compared."""
        found = self.found
        return found is None or not (found.visits or found.changes or found.waits or found.values)

    def line(self, word: str = "proven") -> str:
        """The result in one line for people: what was run and compared, then the word for it."""
        found = self.found
        if found is None or not self.holds:
            return f"not {word}"
        return f"{self.compared()}: {'nothing to compare' if self.empty else word}{self.left_out()}"

    def compared(self) -> str:
        """What was run and compared."""
        found = self.found
        assert found is not None
        taken = [f"{t - len(n)} of {t} in {name}" for t, n, name in self._branches(found)]
        counts = [_count_text(found.visits, "visit"), _count_text(found.changes, "signal change")]
        more = (found.waits, "wait", "s for inputs"), (found.values, "shared value", "s")
        counts += [_count_text(count, *what) for count, *what in more if count]
        cut = f" ({found.cut:,} cut off)" if found.cut else ""
        return (
            f"branches taken: {', '.join(taken)}; {_count_text(found.runs, 'run')}{cut}, "
            f"{', '.join(counts[:-1])} and {counts[-1]}, "
            f"largest distance {found.apart:.4f} mm, {found.turned:.4f} degrees"
        )

    def left_out(self) -> str:
        """What both programs do that was not compared."""
        left = sorted(self.found.left) if self.found is not None else []
        return f"; not compared: {', '.join(left)}" if left else ""

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
            "cut_off": found.cut,
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


def _count_text(count: int, word: str, several: str = "s") -> str:
    return f"{count:,} {word}{'' if count == 1 else several}"


@dataclass(frozen=True, slots=True)
class ComparisonTerms:
    """How two programs are compared. differs, not_run: the rules that tell of it.

    differences: after which the search is over. typed: both were typed by people, so that the
    decimals of either count, and two of them at most. warnings: codes of those of the translation.
    """

    differs: Rule = MOVES_OTHERWISE
    not_run: Rule = NOT_RUN
    differences: int = 1
    typed: bool = False
    warnings: tuple[str, ...] = ()

    @property
    def cure(self) -> str:
        """What to do about a difference."""
        if not self.warnings:
            return REPORT_CURE
        codes = ", ".join(self.warnings)
        return f"see whether a warning explains it ({codes}); if not, {REPORT_CURE}"


TRANSLATION_TERMS: Final = ComparisonTerms()
"""A program and what was made of it, whose decimals are its own."""
TYPED_POSITION: Final = 0.00501
"""mm, half of the second decimal."""
TYPED_ANGLE: Final = 0.0151
"""Degrees: three angles that are off by half of their second decimal."""


def prove_motion(
    pair: ProgramPair,
    arms: Arms,
    proving: Proving,
    entry: str | None = None,
    terms: ComparisonTerms = TRANSLATION_TERMS,
) -> MotionProof:
    """Runs two programs against the same signals.

    entry: the procedure that the first begins with, None for its own. Raises Unreadable or Refused
    for a script that cannot be used.
    """
    from assistant.compiler.script_file import read_script, unknown_visits
    from assistant.virtual.proving.compared_programs import can_run
    from assistant.virtual.proving.search import Budget, Found, compared

    source = pair.first
    names = pair.first.name, pair.second.name
    spoken = [None if source.origin is None else source.origin.language, pair.language]
    languages = [language_of(name) for name in spoken if name is not None]
    for language in languages:
        if not can_run(language.family):
            return _not_run_proof(terms, f"programs in {language.name} cannot be run")
    if not source.procedures:  # data that other programs use: nothing that could be run
        return MotionProof(Found(), (), names)
    if entry is None and source.entry is None:
        reason = "nothing of it was run, as no procedure is the one that it begins with"
        return _not_run_proof(terms, reason)
    trees, left = trees_in_cell(source)
    if left:
        names_left = ", ".join(f"`{name}`" for name in left)
        reason = f"the source does not declare {names_left} by a value that can be changed"
        return _not_run_proof(terms, reason)
    first, second = proof_sides(pair, trees, arms, entry)
    rounding = _rounding_of((first, second), languages, terms)
    outputs = output_numbers(pair, (first.family, second.family))
    names = _file_name_of(trees[0]) or names[0], _file_name_of(pair.trees[0]) or names[1]
    script = None if proving.script is None else read_script(proving.script)
    changes = () if script is None else script.changes
    budget = Budget(proving.seed, proving.runs, proving.seconds, terms.differences)
    found = compared(first, second, outputs, rounding, budget, script)
    timed = next((one for one in changes if one.when is None and one.at), None)
    findings = [] if timed is None else [SCRIPT_BY_TIME(name=timed.name, at=timed.at)]
    findings += [] if script is None else unknown_visits(script, first.sources())
    if found.unknown is not None and first.robot is None and second.robot is None:
        for arm, one, two in stand_in_sides(first, second):
            again = compared(one, two, outputs, rounding, budget, script)
            if again.unknown is None and again.failing < again.runs:
                found = again
                findings.append(RUN_ON_STAND_IN(title=arm.title))
                break
    findings += _proof_findings(found, names, wire_names(pair), terms)
    return MotionProof(found, tuple(findings), names)


def _rounding_of(
    sides: Sequence[Side], languages: Sequence[Language[Any]], terms: ComparisonTerms
) -> Rounding:
    """What the texts leave open of the places in them; only the second one, if it was made of the
    first.
    """
    from assistant.virtual.proving.comparison import Rounding

    counted = languages if terms.typed else languages[-1:]
    positions = [language.precision.position for language in counted]
    angles = [language.precision.angle for language in counted]
    if terms.typed:
        positions, angles = [*positions, TYPED_POSITION], [*angles, TYPED_ANGLE]
    rounding = Rounding(max(positions), max(angles), max(positions))
    for side in sides if terms.typed else sides[1:]:
        rounding = rounding.of(side.constants())
    return rounding


def _not_run_proof(terms: ComparisonTerms, reason: str) -> MotionProof:
    return MotionProof(None, (terms.not_run(reason=reason),))


def _file_name_of(tree: Any) -> str | None:
    """The name of a file; None of a program that is run as it stands."""
    if isinstance(tree, Program):
        return None
    return PurePath((tree.source and tree.source.path) or "standard input").name


def _proof_findings(
    found: Found, names: tuple[str, str], wires: Mapping[str, str], terms: ComparisonTerms
) -> Iterator[Diagnostic]:
    """names: of both programs. wires: as the first one calls them."""
    for one in found.differences:
        unlike, scenario = one.unlike, one.scenario
        what = str(unlike)
        place, other = unlike.places
        if other is not None:
            what += f" ({other[0] or names[1]}:{other[1]})"
        inputs = scenario.said(wires)
        rule = terms.differs
        yield rule(
            source=names[0],
            written=names[1],
            inputs=inputs,
            what=what,
            cure=terms.cure,
            **_place_fields(place),
        )
    stop = found.unknown
    if stop is not None:
        reason = f"`{names[stop.side]}` cannot be run here ({_message(stop.run)})"
        yield terms.not_run(reason=reason, **_place_fields(stop.run.place))
    elif found.unfinished is not None and not found.differences:
        until = _count_text(found.visits, "visit")
        reason = (
            f"`{names[0]}` takes too long ({_message(found.unfinished.run)}), and only {until} "
        )
        yield terms.not_run(reason=f"{reason}were compared by then")
    elif not found.differences:
        yield from _ending_findings(found, names, wires, terms)
    if found.unjudged is not None:
        stop = found.unjudged
        inputs, reason = stop.scenario.said(wires), _message(stop.run)
        unjudged = RUN_UNJUDGED(name=names[stop.side], inputs=inputs, reason=reason)
        yield replace(unjudged, **_place_fields(stop.run.place))
    where = "that was tried" if found.stalling else "in the script"
    for stop in [] if _only_waits(found) else found.stalled:
        yield STALLED(name=names[0], where=where, **_place_fields(stop.run.place))
    for branches, name in zip(found.never, names, strict=True):
        for branch in branches:
            yield BRANCH_NOT_TAKEN(
                said=branch.said, **_place_fields((branch.file or name, branch.line))
            )


def _ending_findings(
    found: Found, names: tuple[str, str], wires: Mapping[str, str], terms: ComparisonTerms
) -> Iterator[Diagnostic]:
    """Findings on runs of the first program that end with an error or wait for ever."""
    if found.failing == found.runs and found.failed is not None:
        reason = f"`{names[0]}` ends with an error of its own ({_message(found.failed.run)})"
        yield terms.not_run(reason=reason, **_place_fields(found.failed.run.place))
    elif found.idling == found.runs and found.idle is not None:
        reason = f"`{names[0]}` only waits, and nothing is compared ({_message(found.idle.run)})"
        yield terms.not_run(reason=reason, **_place_fields(found.idle.run.place))
    elif _only_waits(found):
        reason = f"nothing that was tried ends this wait of `{names[0]}`, and no run came further"
        yield terms.not_run(reason=reason, **_place_fields(found.stalled[0].run.place))
    elif found.failed is not None:
        run = found.failed.run
        yield STOPS_ITSELF(
            count=found.failing,
            runs=found.runs,
            inputs=found.failed.scenario.said(wires),
            what=_message(run),
            **_place_fields(run.place),
        )


def _only_waits(found: Found) -> bool:
    """True if every run that ends without an error ends at a wait that no run passed."""
    others = found.failing + found.idling
    return found.stalling > 0 and found.stalling + others == found.runs


def _message(run: Run) -> str:
    """What it says, without the place that the finding has."""
    place = "" if run.place is None else f"{run.place[0]}:{run.place[1]}: ".lstrip(":")
    return run.message.removeprefix(place) or run.ended


def _place_fields(place: tuple[str, int] | None) -> dict[str, Any]:
    return {} if place is None else {"path": place[0] or None, "line": place[1] or None}
