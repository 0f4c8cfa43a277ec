"""Two programs that are run for a proof by motion: their arms, and their signals as wires."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from assistant.compiler.arms import Arms, known_robot, taught_on
from assistant.compiler.loading import language_of
from assistant.program.analysis.uses import base
from assistant.program.calls import Call
from assistant.program.contents import everywhere
from assistant.program.expressions import Apply
from assistant.program.passes.cycles import repeats
from assistant.program.program import Program, Signal, Variable
from assistant.program.wanted import STANDS

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.comparing import Bits
    from assistant.virtual.proving.sides import Side
    from assistant.virtual.proving.wires import Wiring

HAND_NUMBERS: Final = 9000
"""Numbers of no signal, for the hands that a language has words for."""
HANDS: Final = 8
HEADED: Final = re.compile(r"(?m)^.*\bvariable: (\w+) = (\w+) \w+ persistent\b")
"""A line above a program that tells what its source calls a variable."""


@dataclass(frozen=True, slots=True)
class Made:
    """What was written: a program as its language says it, its files, and what it was made of."""

    source: Program
    program: Program
    language: str
    files: Mapping[str, bytes]

    @property
    def signals(self) -> dict[str, Signal]:
        """Of both programs by their names, with numbers where either has them."""
        found: dict[str, tuple[str, Signal]] = {}
        for program in (self.source, self.program):
            for name, signal in program.signals.items():
                known = found.get(name.lower())
                if known is None or known[1].number is None:
                    found[name.lower()] = name, signal
        return dict(found.values())


def sides(
    made: Made, trees: Sequence[Any], written: Sequence[Any], arms: Arms, entry: str | None
) -> tuple[Side, Side]:
    """The source and what was written, parsed, before the same motion and with the same signals."""
    from assistant.virtual.proving.sides import PLAIN_JOINTS, PLAIN_START, PSEUDO, Side
    from assistant.virtual.running import home

    source = made.source
    spoken = None if source.origin is None else source.origin.language
    here, there = taught_on(source, arms), arms.robot or known_robot(source.robot)
    start = home(here) or home(there) or PLAIN_START
    joints = None if here or there else PLAIN_JOINTS
    signals = {name.lower(): signal for name, signal in made.signals.items()}

    again = repeats(made.program) and not repeats(source)
    shared = _shared_data(made, trees, written)

    def side(language: str | None, files: Sequence[Any], robot: Robot | None, begin: str) -> Side:
        family = PSEUDO if language is None else language_of(language).family
        return Side(
            family=family,
            trees=tuple(files),
            robot=robot,
            start=start,
            joints=joints,
            entry=begin,
            wiring=_wiring(signals, family),
            outputs=_other_names(signals, family),
            repeats=again and language == spoken,
            shared=shared[0] if files is trees else shared[1],
        )

    first = side(spoken, trees, here if spoken else here or there, entry or "main")
    first = replace(first, lenient=True)
    return first, side(made.language, written, there, "main")


def _shared_data(
    made: Made, trees: Sequence[Any], written: Sequence[Any]
) -> tuple[dict[str, str], dict[str, str]]:
    """Names of the source for data that outlives a run, by the names in either text.

    Without those that routines have by reference: one language changes them there, another one
    behind the call.
    """
    kept = made.source.variables, made.program.variables
    names = [
        {name.lower() for name, one in known.items() if one.storage == "persistent" and _plain(one)}
        for known in kept
    ]
    texts = [_text(files) for files in (trees, written)]
    own = [{name.lower(): own.lower() for own, name in HEADED.findall(text)} for text in texts]
    found: tuple[dict[str, str], dict[str, str]] = {}, {}
    for name in sorted((names[0] & names[1]) - _by_reference(made.source)):
        spoken = [known.get(name, name) for known in own]
        if all(re.search(rf"(?i)\b{s}\b", t) for s, t in zip(spoken, texts, strict=True)):
            for side, called in zip(found, spoken, strict=True):
                side[called] = name
    return found


def _by_reference(program: Program) -> set[str]:
    """Names in lower case that calls give for `inout` parameters."""
    modes = {q.name.lower(): [one.mode for one in q.parameters] for q in program.procedures}
    calls = [(node.procedure, node.arguments) for node in everywhere(program, Call)]
    calls += [(node.function, node.arguments) for node in everywhere(program, Apply)]
    return {
        base(given)
        for called, arguments in calls
        for mode, given in zip(modes.get(called.lower(), ()), arguments, strict=False)
        if mode == "inout" and given is not None and base(given)
    }


def _plain(variable: Variable) -> bool:
    """Return whether a variable holds one number, truth or text."""
    return not variable.size and variable.type in ("number", "integer", "truth", "text")


def _text(files: Sequence[Any]) -> str:
    sources = (getattr(tree, "source", None) for tree in files)
    return "\n".join(source.text for source in sources if source is not None)


def on_stand_ins(first: Side, second: Side) -> Iterator[tuple[Robot, Side, Side]]:
    """Both programs on arms that nobody has named: where only an arm tells what they read of it.

    A small, a middling and a large one of the catalogue, as a program may be for any of them.
    """
    from assistant import robots
    from assistant.virtual.running import home

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


def in_the_cell(made: Made) -> tuple[list[Any], list[str]]:
    """The trees of the source, and names of what stands elsewhere that cannot be put into them.

    Tools and frames that a process file states anew are in the source as it was lifted, not in the
    text that is run.
    """
    from assistant.virtual.proving.equipping import Cell, equipped

    origin, program = made.source.origin, made.source
    if origin is None:  # it is run as it stands
        return [program], []
    tools = {n: t.tip for n, t in program.tools.items() if origin.lifted.tools.get(n) != t}
    frames = {n: f for n, f in program.frames.items() if origin.lifted.frames.get(n) != f}
    cell = Cell(
        {name.lower(): tip for name, tip in tools.items()},
        {name.lower(): frame for name, frame in frames.items()},
        {n.lower(): f.pose for n, f in program.frames.items() if n.endswith(STANDS)},
    )
    if not cell:
        return list(origin.trees), []
    language = language_of(origin.language)
    trees, found = [], set[str]()
    for tree in origin.trees:
        text, there = equipped(language.family, tree, cell)
        trees.append(language.parse(text))
        found |= there
    return trees, [name for name in (*tools, *frames) if name.lower() not in found]


def names_of_wires(made: Made) -> dict[str, str]:
    """What people call the wires of inputs, where that is one each."""
    found = {}
    for name, signal in made.signals.items():
        if signal.direction == "input" and signal.number is not None and signal.bits == 1:
            found[str(_register(signal) if signal.kind == "analog" else signal.number)] = name
    return found


def _wiring(signals: Mapping[str, Signal], family: str) -> Wiring:
    """What a program of a family calls the inputs: by their numbers where it counts them."""
    from assistant.virtual.proving.sides import counts_signals
    from assistant.virtual.proving.wires import Wiring

    named: dict[str, tuple[str, ...]] = {}
    wide: set[str] = set()
    for name, signal in signals.items():
        if signal.direction != "input":
            continue
        wires = tuple(map(str, _numbers(signal))) or (_register(signal) or name,)
        named[name] = wires
        if counts_signals(family):
            named |= {wire: (wire,) for wire in wires}
        if len(wires) == 1 and signal.kind != "digital":
            wide |= {name, *wires}
    return Wiring(named, frozenset(wide))


def _numbers(signal: Signal) -> range:
    """Of its bits; none of an analog one."""
    first = signal.number
    if first is None or signal.kind == "analog":
        return range(0)
    return range(first, first + signal.bits)


def _register(signal: Signal) -> str | None:
    """What programs that count signals have for an analog one."""
    from assistant.virtual.melfa.world import register

    return None if signal.number is None else register(signal.number)


def outputs_of(made: Made, families: Sequence[str]) -> Bits:
    """Numbers of what one program names and the other one counts."""
    if len(set(families)) == 1:
        return {}
    hands = {
        name: (HAND_NUMBERS + hand,)
        for hand in range(1, HANDS + 1)
        for name in (f"hand{hand}", f"hand{hand}_open")
    }
    given = {
        name.lower(): tuple(_numbers(signal)) or str(_register(signal))
        for name, signal in made.signals.items()
        if signal.direction == "output" and signal.number is not None
    }
    return {**hands, **given}


def _other_names(signals: Mapping[str, Signal], family: str) -> dict[str, str]:
    """What a program calls outputs of one bit, by their names or else by their numbers."""
    from assistant.virtual.proving.sides import counts_signals

    found: dict[str, str] = {}
    for name, signal in signals.items():
        numbers = _numbers(signal)
        if signal.direction == "output" and len(numbers) == 1:
            pair = (name, str(numbers[0]))
            found |= {pair[0]: pair[1]} if counts_signals(family) else {pair[1]: pair[0]}
    return found
