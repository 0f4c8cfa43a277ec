"""Motion proof: two programs, run in interpreters against the same signals and compared.

`ProgramPair` holds two programs that are to do the same, in two languages or in one. `_proof_sides`
gives both the same arm and the same wires: signals that have other names or numbers in each.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, has_errors, info, warning
from assistant.compiler.arms import Arms, known_robot, teaching_arm
from assistant.compiler.loader import language_of
from assistant.program.analysis.io_use import used_signal_names
from assistant.program.analysis.uses import base_variable
from assistant.program.expressions import Apply
from assistant.program.passes.variables import repeats_cycle
from assistant.program.program import Program, Signal, Variable
from assistant.program.statement_index import records_in_procedures
from assistant.program.statements import Call
from assistant.program.undeclared_names import BASE_FRAME_SUFFIX

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.robots import Robot
    from assistant.virtual.events import Branch, Moved, Run
    from assistant.virtual.proving.compared_programs import Side
    from assistant.virtual.proving.comparison import Bits, Rounding
    from assistant.virtual.proving.driver import Wiring
    from assistant.virtual.proving.search import Found, Visit


_HAND_NUMBERS: Final = 9000
"""Numbers of no signal, for the hands that a language has words for."""
_HANDS: Final = 8
_FIRST_FREE_NUMBER: Final = 30_000
"""The first number of signals that have no number in either program."""
_VARIABLE_HEADING: Final = re.compile(r"(?m)^.*\bvariable: (\w+) = (\w+) \w+ persistent\b")
"""A line above a program that tells what its source calls a variable."""


@dataclass(frozen=True, slots=True)
class ProgramPair:
    """Two programs that are to do the same, in two languages or in one.

    language, trees: of the second, None and the program itself where it is run as it stands. names:
    of its signals and data by those that the first one has for them, in lower case; what has the
    same name or number in both need not be there.
    """

    first: Program
    second: Program
    language: str | None
    trees: Sequence[Any]
    names: Mapping[str, str] = field(default_factory=dict)

    @property
    def signals(self) -> dict[str, Signal]:
        """Return the signals of both programs by their names, with numbers if either has them."""
        found: dict[str, tuple[str, Signal]] = {}
        for program in (self.first, self.second):
            for name, signal in program.signals.items():
                known = found.get(name.lower())
                if known is None or known[1].number is None:
                    found[name.lower()] = name, signal
        for free, (own, other) in enumerate(self.names.items(), _FIRST_FREE_NUMBER):
            pair = found.get(own), found.get(other)
            some = pair[0] or pair[1]
            if some is None:  # data
                continue
            # Both signals of a pair get one number: the stated one, else that of either program,
            # else a free one.
            stated = int(other) if other.isdecimal() else None
            numbers = [known[1].number for known in pair if known is not None]
            number = next((n for n in (stated, *numbers) if n is not None), free)
            for name, known in zip((own, other), pair, strict=True):
                title, signal = known or (name, some[1])
                found[name] = title, replace(signal, number=number)
        return dict(found.values())

    def others_name(self, name: str) -> str:
        """Return the second program's name for a name of the first one."""
        return self.names.get(name.lower(), name)


def written_pair(
    source: Program, program: Program, language: str, files: Mapping[str, bytes]
) -> ProgramPair:
    """Return a source with the program compiled from it, as parsed from its files."""
    spoken = language_of(language)
    trees = [spoken.parse(spoken.decode(data, name)) for name, data in files.items()]
    return ProgramPair(source, program, language, trees)


def _proof_sides(
    pair: ProgramPair, trees: Sequence[Any], arms: Arms, entry: str | None
) -> tuple[Side, Side]:
    """Both programs before the same motion and with the same signals. trees: of the first."""
    from assistant.virtual.program_run import home
    from assistant.virtual.proving.compared_programs import PLAIN_JOINTS, PLAIN_START, PSEUDO, Side

    first = pair.first
    spoken = None if first.origin is None else first.origin.language
    here = teaching_arm(first, arms)
    there = arms.robot or known_robot(pair.second.robot or first.robot)
    start = home(here) or home(there) or PLAIN_START
    joints = None if here or there else PLAIN_JOINTS
    signals = {name.lower(): signal for name, signal in pair.signals.items()}
    again = repeats_cycle(first), repeats_cycle(pair.second)
    shared = _shared_data(pair, trees)
    arm = here if spoken else here or there

    def side(place: int, language: str | None, files: Sequence[Any]) -> Side:
        family = PSEUDO if language is None else language_of(language).family
        return Side(
            family=family,
            trees=tuple(files),
            robot=(arm, there)[place],
            start=start,
            joints=joints,
            entry=(entry or first.entry or "main", pair.second.entry or "main")[place],
            wiring=_wiring(signals, family),
            outputs=_other_names(signals, family),
            repeats=again[1 - place] and not again[place],
            shared=shared[place],
            lenient=place == 0,
        )

    return side(0, spoken, trees), side(1, pair.language, pair.trees)


def _shared_data(pair: ProgramPair, trees: Sequence[Any]) -> tuple[dict[str, str], dict[str, str]]:
    """Names of the first program for data that outlives a run, by the names in either text.

    Without those that routines have by reference: one language changes them there, another one
    behind the call.
    """
    first, second = (
        {name.lower() for name, one in program.variables.items() if _outlives_run(one)}
        for program in (pair.first, pair.second)
    )
    stated = {n for n in pair.names if n in _plain_variables(pair.first)}
    texts = [_joined_text(files) for files in (trees, pair.trees)]
    own = [
        {name.lower(): own.lower() for own, name in _VARIABLE_HEADING.findall(text)}
        for text in texts
    ]
    found: tuple[dict[str, str], dict[str, str]] = {}, {}
    for name in sorted(((first & second) | stated) - _by_reference(pair.first)):
        names = name, pair.others_name(name)
        spoken = [known.get(one, one) for known, one in zip(own, names, strict=True)]
        # Data that one of the texts does not name cannot be compared.
        if all(re.search(rf"(?i)\b{s}\b", t) for s, t in zip(spoken, texts, strict=True)):
            for side, called in zip(found, spoken, strict=True):
                side[called] = name
    return found


def _by_reference(program: Program) -> set[str]:
    """Names in lower case that calls give for `inout` parameters."""
    modes = {q.name.lower(): [one.mode for one in q.parameters] for q in program.procedures}
    calls = [(node.procedure, node.arguments) for node in records_in_procedures(program, Call)]
    calls += [(node.function, node.arguments) for node in records_in_procedures(program, Apply)]
    return {
        base_variable(given)
        for called, arguments in calls
        for mode, given in zip(modes.get(called.lower(), ()), arguments, strict=False)
        if mode == "inout" and given is not None and base_variable(given)
    }


def _plain_variables(program: Program) -> set[str]:
    return {name.lower() for name, one in program.variables.items() if _is_plain(one)}


def _outlives_run(variable: Variable) -> bool:
    return variable.storage == "persistent" and _is_plain(variable)


def _is_plain(variable: Variable) -> bool:
    """Return whether a variable holds one number, truth or text."""
    return not variable.size and variable.type in ("number", "integer", "truth", "text")


def _joined_text(files: Sequence[Any]) -> str:
    sources = (getattr(tree, "source", None) for tree in files)
    return "\n".join(source.text for source in sources if source is not None)


def _stand_in_sides(first: Side, second: Side) -> Iterator[tuple[Robot, Side, Side]]:
    """Yield both programs on stand-in arms, if their positions depend on an arm and none is named.

    A small, a medium and a large one of the catalogue, as a program may be for any of them.
    """
    from assistant import robots
    from assistant.virtual.program_run import home

    known = sorted(map(robots.get, robots.names()), key=lambda robot: robot.reach)
    usual = [r for r in known if len(r.axes) == 6 and r.counts == "quadrants"]
    for place in (len(usual) // 2, 0, len(usual) - 1):
        arm = usual[place]
        start = home(arm) or first.start
        joints = tuple(map(float, arm.home))
        yield (
            arm,
            replace(first, robot=arm, start=start, joints=joints),
            replace(second, robot=arm, start=start, joints=joints),
        )


def trees_in_cell(program: Program) -> tuple[list[Any], list[str]]:
    """The trees of a program, and names of what stands elsewhere that cannot be put into them.

    Tools and frames that a process file states anew are in the program as it was lifted, not in the
    text that is run.
    """
    from assistant.virtual.proving.compared_programs import Cell, with_equipment

    origin = program.origin
    if origin is None:  # it is run as it stands
        return [program], []
    tools = {n: t.tip for n, t in program.tools.items() if origin.lifted.tools.get(n) != t}
    frames = {n: f for n, f in program.frames.items() if origin.lifted.frames.get(n) != f}
    cell = Cell(
        {name.lower(): tip for name, tip in tools.items()},
        {name.lower(): frame for name, frame in frames.items()},
        {n.lower(): f.pose for n, f in program.frames.items() if n.endswith(BASE_FRAME_SUFFIX)},
    )
    if not cell:
        return list(origin.trees), []
    language = language_of(origin.language)
    trees, found = [], set[str]()
    for tree in origin.trees:
        text, there = with_equipment(language.family, tree, cell)
        trees.append(language.parse(text))
        found |= there
    return trees, [name for name in (*tools, *frames) if name.lower() not in found]


def wire_names(pair: ProgramPair) -> dict[str, str]:
    """Return the names of inputs with a single wire, as the first program names them."""
    found: dict[str, str] = {}
    for name, signal in pair.signals.items():
        if signal.direction == "input" and signal.number is not None and signal.bits == 1:
            wire = str(_analog_register(signal) if signal.kind == "analog" else signal.number)
            found.setdefault(wire, name)
    return found


def _wiring(signals: Mapping[str, Signal], family: str) -> Wiring:
    """Return a family's names of the inputs: their numbers if it counts them."""
    from assistant.virtual.proving.compared_programs import counts_signals
    from assistant.virtual.proving.driver import Wiring

    named: dict[str, tuple[str, ...]] = {}
    wide: set[str] = set()
    for name, signal in signals.items():
        if signal.direction != "input":
            continue
        wires = tuple(map(str, _bit_numbers(signal))) or (_analog_register(signal) or name,)
        named[name] = wires
        if counts_signals(family):
            named |= {wire: (wire,) for wire in wires}
        if len(wires) == 1 and signal.kind != "digital":
            wide |= {name, *wires}
    return Wiring(named, frozenset(wide))


def _bit_numbers(signal: Signal) -> range:
    """Return the numbers of the signal's bits; an analog signal has none."""
    first = signal.number
    if first is None or signal.kind == "analog":
        return range(0)
    return range(first, first + signal.bits)


def _analog_register(signal: Signal) -> str | None:
    """Return the register of an analog signal in programs that count signals."""
    from assistant.virtual.melfa.world import register

    return None if signal.number is None else register(signal.number)


def _output_numbers(pair: ProgramPair, families: Sequence[str]) -> Bits:
    """Numbers of outputs, which two programs may call otherwise, by the names in either.

    families: of their languages.
    """
    from assistant.virtual.proving.compared_programs import counts_signals

    if all(map(counts_signals, families)) and not pair.names:
        return {}
    # A program that counts signals has words for hands: what it sets as an output is no hand.
    sides = zip((pair.first, pair.second), families, strict=True)
    outputs = set().union(*(used_signal_names(one) for one, of in sides if counts_signals(of)))
    hands = {
        name: (_HAND_NUMBERS + hand,)
        for hand in range(1, _HANDS + 1)
        for name in (f"hand{hand}", f"hand{hand}_open")
        if f"hand{hand}_open" not in outputs
    }
    given = {
        name.lower(): tuple(_bit_numbers(signal)) or str(_analog_register(signal))
        for name, signal in pair.signals.items()
        if signal.direction == "output" and signal.number is not None
    }
    # A number that a cell file states for the output of a hand is one in the other language alone.
    return {**given, **hands}


def _other_names(signals: Mapping[str, Signal], family: str) -> dict[str, str]:
    """Return a program's outputs of one bit, by their names or else by their numbers."""
    from assistant.virtual.proving.compared_programs import counts_signals

    found: dict[str, str] = {}
    for name, signal in signals.items():
        numbers = _bit_numbers(signal)
        if signal.direction == "output" and len(numbers) == 1:
            pair = (name, str(numbers[0]))
            found |= {pair[0]: pair[1]} if counts_signals(family) else {pair[1]: pair[0]}
    return found


_MOVES_OTHERWISE = error(
    "CO110",
    "run, `{written}` does something else, with {inputs}: {what}",
    "nothing was written; {cure}",
)
_REPORT_CURE: Final = "report this with the program"
_NOT_RUN = error(
    "CO111",
    "there is no proof by motion: {reason}",
    "nothing was written; leave --prove out, and try what was written with care",
)
_BRANCH_NOT_TAKEN = info(
    "CO112",
    "no run took this branch: {said}",
    "say with --signals what leads there, or look at it yourself",
)
_STOPS_ITSELF = info(
    "CO113",
    "{count} of {runs} runs end with an error of the program, the first with {inputs}: {what}",
    "see whether a real cell has such inputs",
)
_STALLED = warning(
    "CO114",
    "nothing {where} ends this wait of `{name}`: what follows was not compared",
    "say in a script, by --signals, what ends the wait, if something does",
)
_RUN_UNJUDGED = warning(
    "CO116",
    "with {inputs} nobody knows what `{name}` does ({reason}): these inputs are not compared",
    "see whether a real cell has such inputs, and try them on the controller",
)
_NOT_REACHED = error(
    "CO128",
    "run with {inputs}, the program visits {where}, which {arm} cannot take: {why}{more}",
    "move the work piece or the robot, or take another arm; if the real cell never has such "
    "inputs, write those that it has to a script and name it with --signals",
)
_VISIT_FAULTS: Final = {
    "reach": "it is out of reach",
    "joints": "joint {axis} is past its limit there",
    "configuration": "its arm configuration does not lead there",
    "nowhere": "where the motion leads is not known",
}
_BORDER: Final = 0.05
"""Millimetres, and degrees of an axis, by which a place may lie beyond what the arm takes: the
rounding of its text explains that, and the checks of targets judge it more exactly."""
_SCRIPT_BY_TIME = warning(
    "CO124",
    "the script changes `{name}` at {at:g} s, which two programs of different speed reach at "
    "different statements",
    "change it at an output or at a visit instead",
)
_RUN_ON_STAND_IN = info(
    "CO115",
    "both were run on the {title}, as nobody has named an arm and they read where it stands",
    "name the arm that runs the program with --robot",
)


@dataclass(frozen=True, slots=True)
class Proving:
    """Settings of a motion proof. script: file of signal changes, None for a search. seed: of its
    random choices. runs, seconds: limits of the search.
    """

    script: str | FilePath | None = None
    seed: int = 0
    runs: int = 200
    seconds: float = 10.0


@dataclass(frozen=True, slots=True)
class MotionProof:
    """Result of the comparison, and its findings. found: None if nothing could be run."""

    found: Found | None
    findings: tuple[Diagnostic, ...] = ()
    names: tuple[str, str] = ("", "")

    @property
    def holds(self) -> bool:
        return self.found is not None and not has_errors(self.findings)

    @property
    def empty(self) -> bool:
        """True if no run did anything that could be compared."""
        found = self.found
        return found is None or not (found.visits or found.changes or found.waits or found.values)

    def line(self, word: str = "proven") -> str:
        """The result in one line for people: what was run and compared, then the word for it."""
        found = self.found
        if found is None or not self.holds:
            return f"not {word}"
        return f"{self.compared()}: {'nothing to compare' if self.empty else word}{self.left_out()}"

    def reach(self) -> str:
        """Return how much of the first program was run, in words: a proof tells of that alone."""
        found = self.found
        if found is None or not self.holds:
            return "not proven by motion"
        if self.empty:
            return "nothing to compare by motion"
        total, taken = found.total[0], found.total[0] - len(found.never[0])
        text = "proven by motion"
        if taken < total:
            share = min(round(100 * taken / total), _MOST_OF_PART)
            text = f"{text} along {taken:,} of {total:,} branches alone, {share} %"
        elif total:
            text = f"{text} along {total:,} of {total:,} branches"
        places = [stop.run.place for stop in found.stalled]
        for file, line in [one for one in places if one is not None][:1]:
            more = f" and {len(places) - 1:,} more" if len(places) > 1 else ""
            text += (
                f", and not past the wait at {FilePath(file or self.names[0]).name}:{line}{more}"
            )
        return text

    def compared(self) -> str:
        """Return a summary of the runs and comparisons."""
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
        """Return the actions of both programs that were not compared."""
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


_MOST_OF_PART: Final = 99
"""Highest share of branches, in percent, that the first line states unless all were taken."""


def _count_text(count: int, word: str, several: str = "s") -> str:
    return f"{count:,} {word}{'' if count == 1 else several}"


@dataclass(frozen=True, slots=True)
class ComparisonTerms:
    """Terms for comparing two programs. differs, not_run: the rules that report it.

    differences: number that ends the search. typed: both were typed by people, so that the decimals
    of either count, and two of them at most. warnings: codes of the translation's warnings.
    """

    differs: Rule = _MOVES_OTHERWISE
    not_run: Rule = _NOT_RUN
    differences: int = 1
    typed: bool = False
    warnings: tuple[str, ...] = ()

    @property
    def cure(self) -> str:
        """What to do about a difference."""
        if not self.warnings:
            return _REPORT_CURE
        codes = ", ".join(self.warnings)
        return f"see whether a warning explains it ({codes}); if not, {_REPORT_CURE}"


_TRANSLATION_TERMS: Final = ComparisonTerms()
"""A program and what was made of it, whose decimals are its own."""
_TYPED_POSITION: Final = 0.00501
"""mm, half of the second decimal."""
_TYPED_ANGLE: Final = 0.0151
"""Degrees: three angles that are off by half of their second decimal."""


def prove_motion(
    pair: ProgramPair,
    arms: Arms,
    proving: Proving,
    entry: str | None = None,
    terms: ComparisonTerms = _TRANSLATION_TERMS,
) -> MotionProof:
    """Runs two programs against the same signals.

    entry: the procedure that the first begins with, None for its own. Raises Unreadable or Refused
    for a script that cannot be used.
    """
    from assistant.compiler.simulated_run import read_script, unknown_visits
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
    first, second = _proof_sides(pair, trees, arms, entry)
    rounding = _rounding_of((first, second), languages, terms)
    outputs = _output_numbers(pair, (first.family, second.family))
    names = _file_name_of(trees[0]) or names[0], _file_name_of(pair.trees[0]) or names[1]
    script = None if proving.script is None else read_script(proving.script)
    changes = () if script is None else script.changes
    budget = Budget(proving.seed, proving.runs, proving.seconds, terms.differences)
    found = compared(first, second, outputs, rounding, budget, script)
    timed = next((one for one in changes if one.when is None and one.at), None)
    findings = [] if timed is None else [_SCRIPT_BY_TIME(name=timed.name, at=timed.at)]
    findings += [] if script is None else unknown_visits(script, first.sources())
    if found.unknown is not None and first.robot is None and second.robot is None:
        for arm, one, two in _stand_in_sides(first, second):
            again = compared(one, two, outputs, rounding, budget, script)
            # A stand-in arm on which every run fails proves nothing.
            if again.unknown is None and again.failing < again.runs:
                found = again
                findings.append(_RUN_ON_STAND_IN(title=arm.title))
                break
    findings += _proof_findings(found, names, wire_names(pair), terms)
    return MotionProof(found, tuple(findings), names)


def unreached_visits(motion: MotionProof, arm: Robot, wires: Mapping[str, str]) -> list[Diagnostic]:
    """Report the places of a program's runs that its arm cannot take, once for each statement.

    Targets that only running tells are checked nowhere else. wires: see `wire_names`.
    """
    from assistant.virtual.kernel.flight import refusal_of

    visits = () if motion.found is None else motion.found.visited.values()
    faulty: dict[Any, list[tuple[Visit, str]]] = {}
    for visit in visits:
        refusal = refusal_of(visit.moved, arm)
        if refusal is not None and not _is_at_border(visit.moved, arm):
            why = _VISIT_FAULTS[refusal.reason].format(axis=refusal.axis)
            faulty.setdefault(visit.place, []).append((visit, why))
    found = []
    for place, alike in faulty.items():
        (visit, why), others = alike[0], len(alike) - 1
        more = f" (and {_count_text(others, 'place')} more from there)" if others else ""
        inputs, where = visit.scenario.said(wires), _destination(visit.moved)
        finding = _NOT_REACHED(inputs=inputs, where=where, arm=arm.title, why=why, more=more)
        found.append(replace(finding, **_place_fields(place)))
    return found


def _is_at_border(moved: Moved, arm: Robot) -> bool:
    """True if an arm takes a place but for rounding; joints and configurations are not rounded."""
    poses = [pose for pose in (moved.via, moved.flange) if pose is not None]
    if moved.joints is not None or not poses:
        return False
    joints, miss = arm.solve(
        np.array([pose.position for pose in poses]), np.array([pose.quaternion for pose in poses])
    )
    if moved.how.configuration is not None and arm.arm.named:
        branch = int(arm.branch_of(np.array([moved.how.configuration]))[0])
        joints, miss = joints[:, branch : branch + 1], miss[branch : branch + 1]
    low, high = (limit[:, None, None] for limit in arm.limits.T)
    beyond = np.maximum(low - joints, joints - high).max(axis=0)
    return bool(((miss < _BORDER) & (beyond < _BORDER)).any(axis=0).all())


def _destination(moved: Moved) -> str:
    """Return where a motion leads, for people: the tip in the robot's base, or the joints."""
    if moved.joints is not None:
        return f"the joints ({', '.join(f'{value:.2f}' for value in moved.joints)}) degrees"
    if moved.flange is None:
        return "a place that is not known"
    x, y, z = (moved.flange @ moved.tool).position
    return f"X {x:.1f}, Y {y:.1f}, Z {z:.1f} mm in its base"


def _rounding_of(
    sides: Sequence[Side], languages: Sequence[Language[Any]], terms: ComparisonTerms
) -> Rounding:
    """Return the rounding of the positions in the texts; only of the second one, if it was made
    from the first.
    """
    from assistant.virtual.proving.comparison import Rounding

    counted = languages if terms.typed else languages[-1:]
    positions = [language.precision.position for language in counted]
    angles = [language.precision.angle for language in counted]
    # Typed programs are rounded by hand: at most two decimals count.
    if terms.typed:
        positions, angles = [*positions, _TYPED_POSITION], [*angles, _TYPED_ANGLE]
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
        unjudged = _RUN_UNJUDGED(name=names[stop.side], inputs=inputs, reason=reason)
        yield replace(unjudged, **_place_fields(stop.run.place))
    where = "that was tried" if found.stalling else "in the script"
    # `_ending_findings` reports a program that only waits.
    for stop in [] if _only_waits(found) else found.stalled:
        yield _STALLED(name=names[0], where=where, **_place_fields(stop.run.place))
    for branches, name in zip(found.never, names, strict=True):
        for branch in branches:
            yield _BRANCH_NOT_TAKEN(
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
        yield _STOPS_ITSELF(
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
    """Return the message of a run, without the position that the finding already has."""
    place = "" if run.place is None else f"{run.place[0]}:{run.place[1]}: ".lstrip(":")
    return run.message.removeprefix(place) or run.ended


def _place_fields(place: tuple[str, int] | None) -> dict[str, Any]:
    return {} if place is None else {"path": place[0] or None, "line": place[1] or None}
