"""Two programs that are run for a proof by motion: their arms, and their signals as wires."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

from assistant.compiler.arms import Arms, known_robot, teaching_arm
from assistant.compiler.loading import language_of
from assistant.program.analysis.uses import base_variable
from assistant.program.expressions import Apply
from assistant.program.passes.variables import repeats_cycle
from assistant.program.program import Program, Signal, Variable
from assistant.program.statement_index import records_in_procedures
from assistant.program.statements import Call
from assistant.program.undeclared_names import BASE_FRAME_SUFFIX

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.proving.compared_programs import Side
    from assistant.virtual.proving.comparison import Bits
    from assistant.virtual.proving.driver import Wiring

HAND_NUMBERS: Final = 9000
"""Numbers of no signal, for the hands that a language has words for."""
HANDS: Final = 8
FIRST_FREE_NUMBER: Final = 30_000
"""The first number of signals that have no number in either program."""
VARIABLE_HEADING: Final = re.compile(r"(?m)^.*\bvariable: (\w+) = (\w+) \w+ persistent\b")
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
        """Of both programs by their names, with numbers where either has them."""
        found: dict[str, tuple[str, Signal]] = {}
        for program in (self.first, self.second):
            for name, signal in program.signals.items():
                known = found.get(name.lower())
                if known is None or known[1].number is None:
                    found[name.lower()] = name, signal
        for free, (own, other) in enumerate(self.names.items(), FIRST_FREE_NUMBER):
            pair = found.get(own), found.get(other)
            some = pair[0] or pair[1]
            if some is None:  # data
                continue
            stated = int(other) if other.isdecimal() else None
            numbers = [known[1].number for known in pair if known is not None]
            number = next((n for n in (stated, *numbers) if n is not None), free)
            for name, known in zip((own, other), pair, strict=True):
                title, signal = known or (name, some[1])
                found[name] = title, replace(signal, number=number)
        return dict(found.values())

    def others_name(self, name: str) -> str:
        """What the second program calls what has a name in the first one."""
        return self.names.get(name.lower(), name)


def written_pair(
    source: Program, program: Program, language: str, files: Mapping[str, bytes]
) -> ProgramPair:
    """A source, and the program that was made of it as its files say it."""
    spoken = language_of(language)
    trees = [spoken.parse(spoken.decode(data, name)) for name, data in files.items()]
    return ProgramPair(source, program, language, trees)


def proof_sides(
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
        {name.lower(): own.lower() for own, name in VARIABLE_HEADING.findall(text)}
        for text in texts
    ]
    found: tuple[dict[str, str], dict[str, str]] = {}, {}
    for name in sorted(((first & second) | stated) - _by_reference(pair.first)):
        names = name, pair.others_name(name)
        spoken = [known.get(one, one) for known, one in zip(own, names, strict=True)]
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


def stand_in_sides(first: Side, second: Side) -> Iterator[tuple[Robot, Side, Side]]:
    """Both programs on arms that nobody has named: where only an arm tells what they read of it.

    A small, a middling and a large one of the catalogue, as a program may be for any of them.
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
    """What people call the wires of inputs, where that is one each: as the first program does."""
    found: dict[str, str] = {}
    for name, signal in pair.signals.items():
        if signal.direction == "input" and signal.number is not None and signal.bits == 1:
            wire = str(_analog_register(signal) if signal.kind == "analog" else signal.number)
            found.setdefault(wire, name)
    return found


def _wiring(signals: Mapping[str, Signal], family: str) -> Wiring:
    """What a program of a family calls the inputs: by their numbers where it counts them."""
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
    """Of its bits; none of an analog one."""
    first = signal.number
    if first is None or signal.kind == "analog":
        return range(0)
    return range(first, first + signal.bits)


def _analog_register(signal: Signal) -> str | None:
    """What programs that count signals have for an analog one."""
    from assistant.virtual.melfa.world import register

    return None if signal.number is None else register(signal.number)


def output_numbers(pair: ProgramPair, families: Sequence[str]) -> Bits:
    """Numbers of outputs, which two programs may call otherwise, by the names in either.

    families: of their languages.
    """
    from assistant.virtual.proving.compared_programs import counts_signals

    if all(map(counts_signals, families)) and not pair.names:
        return {}
    hands = {
        name: (HAND_NUMBERS + hand,)
        for hand in range(1, HANDS + 1)
        for name in (f"hand{hand}", f"hand{hand}_open")
    }
    given = {
        name.lower(): tuple(_bit_numbers(signal)) or str(_analog_register(signal))
        for name, signal in pair.signals.items()
        if signal.direction == "output" and signal.number is not None
    }
    return {**hands, **given}


def _other_names(signals: Mapping[str, Signal], family: str) -> dict[str, str]:
    """What a program calls outputs of one bit, by their names or else by their numbers."""
    from assistant.virtual.proving.compared_programs import counts_signals

    found: dict[str, str] = {}
    for name, signal in signals.items():
        numbers = _bit_numbers(signal)
        if signal.direction == "output" and len(numbers) == 1:
            pair = (name, str(numbers[0]))
            found |= {pair[0]: pair[1]} if counts_signals(family) else {pair[1]: pair[0]}
    return found
