"""Instructions that RAPID alone has, as neutral statements with the same effect.

One table of instructions calls the subject of each: process moves, outputs, waits, tasks. An
instruction without an equivalent stays as its text. Options without an equivalent are left out,
with a finding each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.late_binding import choice_of_calls
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_only import process_moves
from assistant.languages.rapid.lift.vendor_only.omissions import OMITTED_OPTIONS
from assistant.languages.rapid.lift.vendor_only.signal_statements import (
    delayed_output,
    inverse_pulse,
    inverted_output,
)
from assistant.languages.rapid.lift.vendor_only.waits import (
    flagged_wait,
    sync_counter,
    synchronised_lists,
    task_sync,
)
from assistant.languages.rapid.lift.vendor_statements import (
    instruction_of,
    lifted_call,
    without_options,
    word_of,
)
from assistant.languages.rapid.tables.signals import BRUSH_INSTRUCTION, PROCESS_MOVES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.passes.motions import declared_value
from assistant.program.program import Program


@dataclass(frozen=True, slots=True)
class VendorLowering:
    """Context for lowering the instructions of a program.

    switched: lower-case names of outputs that something besides pulses may switch on. displaced:
    True if anything displaces external axes. welds: mm/s of welds, and lists: number of tasks in
    each list, by lower-case name. delays: see `delays_into_moves`. spots, beads:
    program numbers of spot welds and of beads. All three are collected at the first request.
    points: meeting points of tasks, filled during lowering.
    """

    program: Program
    findings: Findings
    meaning: NameResolver
    switched: frozenset[str]
    displaced: bool
    welds: Mapping[str, float]
    lists: Mapping[str, e.Expression]
    delays: Callable[[], frozenset[int]]
    spots: Callable[[], Mapping[str, float]]
    beads: Callable[[], Mapping[str, int]]
    points: list[str] = field(default_factory=list)

    def lost(self, what: str, loss: str, cure: str) -> None:
        self.findings.append(rules.LEFT_OUT(what=what, loss=loss, cure=cure))

    def number(self, node: s.Expression | None) -> float | None:
        """The number that an expression is; None for what is worked out."""
        value = None if node is None else self.meaning.known(self.meaning.expression(node))
        return e.plain_number(value) if value is not None else None


_Replacement = Iterator[p.Statement]
_InstructionLowering = Callable[[VendorLowering, Called[s.Expression], p.Opaque], _Replacement]


def lowered_instruction(telling: VendorLowering, node: p.Opaque) -> Sequence[p.Statement]:
    """Lower an instruction for another language: the statement itself if it has no equivalent."""
    call = instruction_of(node)
    # Calls by a text are choices, with nothing to look up in the tables.
    if call is None or word_of(call) == "callbyvar":
        said = [*choice_of_calls(node, telling.program, telling.meaning)]
        return [replace(one, span=node.span) for one in said] or (node,)
    losses = {
        one.name.lower(): OMITTED_OPTIONS[word_of(call)][one.name.lower()]
        for one in call.arguments
        if isinstance(one, s.Option) and one.name.lower() in OMITTED_OPTIONS.get(word_of(call), {})
    }
    # With displaced external axes the option has an effect.
    if telling.displaced:
        losses.pop("noeoffs", None)
    plain = without_options(call, losses)
    known, tell = called(plain), _LOWERINGS.get(word_of(call))
    with telling.findings.at(node.span):
        # A plain statement may be all that is left without the lost options.
        said = [*lifted_call(plain, node, telling.meaning)] if losses else []
        if not said and tell is not None and known is not None:
            said = [replace(one, span=node.span) for one in tell(telling, known, node)]
        # Losses are reported only if the statement is translated.
        for option, (loss, cure) in losses.items() if said else ():
            if loss:
                telling.lost(f"\\{_option_name(call, option)}", loss, cure)
    return said or (node,)


def _option_name(call: s.ProcedureCall, option: str) -> str:
    names = (one.name for one in call.arguments if isinstance(one, s.Option))
    return next(name for name in names if name.lower() == option)


# ------------------------------------------------------------------------------------ moves


def _move_with_stated_motion(
    telling: VendorLowering, call: Called[s.Expression], _: p.Opaque
) -> _Replacement:
    r"""A move whose speed or corner is stated by `\V` and `\Z` instead of by its data."""
    options = dict(call.options)
    speed, size = telling.number(options.pop("v", None)), telling.number(options.pop("z", None))
    stated = len(call.options) - len(options)
    move = lift_call(replace(call, options=options), telling.meaning) if stated else None
    if not isinstance(move, p.MoveStatement) or stated != sum(
        one is not None for one in (speed, size)
    ):
        return
    motion = move.motion
    if speed is not None:
        known = declared_value(motion.speed, telling.program.speeds)
        # The other parts of a computed speed are not known.
        if not isinstance(known, Speed) or speed <= 0:
            return
        motion = replace(motion, speed=replace(known, tcp=speed))
    if size is not None:
        blend = declared_value(motion.blend, telling.program.blends)
        # A stop point has no size to replace.
        if not isinstance(blend, Blend) or blend.fine or size <= 0:
            return
        motion = replace(motion, blend=Blend(size))
    yield replace(move, motion=motion)


_PLAIN_MOVES: Final = {"movej": "MoveJ", "movel": "MoveL", "movec": "MoveC"}
_CORNER_LOSS: Final = (
    "it is done in the middle of the corner: here where the corner begins",
    "see that this is not too early, or end the move with `fine`",
)


def _move_setting_output(word: str) -> _InstructionLowering:
    """A move that sets an output at its end: as a move and what sets the output."""

    def does(telling: VendorLowering, call: Called[s.Expression], node: p.Opaque) -> _Replacement:
        *given, signal, value = call.given
        setting = lift_call(Called(word, (signal, value)), telling.meaning)
        yield from _move_then(telling, replace(call, given=given), node, setting)

    return does


def _move_setting_group(
    telling: VendorLowering, call: Called[s.Expression], node: p.Opaque
) -> _Replacement:
    *given, signal = call.given
    options = dict(call.options)
    setting = lift_call(Called("SetGO", (signal, options.pop("value", None))), telling.meaning)
    yield from _move_then(telling, replace(call, given=given, options=options), node, setting)


def _move_calling(
    telling: VendorLowering, call: Called[s.Expression], node: p.Opaque
) -> _Replacement:
    """A move that calls a procedure at its end."""
    *given, name = call.given
    known = telling.program.procedure(name.value) if isinstance(name, s.StringLiteral) else None
    setting = None if known is None or known.parameters else p.Call(known.name)
    yield from _move_then(telling, replace(call, given=given), node, setting)


def _move_then(
    telling: VendorLowering, call: Called[s.Expression], node: p.Opaque, then: p.Statement | None
) -> _Replacement:
    """A plain move, and what is done at its end."""
    # The first five letters are the plain move.
    move = lift_call(replace(call, word=_PLAIN_MOVES[call.word.lower()[:5]]), telling.meaning)
    if then is None or not isinstance(move, p.MoveStatement):
        return
    _report_corner(telling, move, node)
    yield move
    yield then


# --------------------------------------------------------------------------------- settings


def _acceleration(telling: VendorLowering, call: Called[s.Expression], _: p.Opaque) -> _Replacement:
    """`AccSet`: the acceleration; how fast it grows is each controller's own."""
    match call.given:
        case (most, ramp) if most is not None and ramp is not None and not call.options:
            percent = telling.meaning.expression(most)
            if telling.number(ramp) != _FULL_PERCENT:
                loss = "accelerations grow as fast as the controller has it"
                telling.lost("the ramp of AccSet", loss, "see that the part takes that")
            yield p.SetAcceleration(percent, percent)


_FULL_PERCENT: Final = 100.0


def _velocity(telling: VendorLowering, call: Called[s.Expression], _: p.Opaque) -> _Replacement:
    """`VelSet`: the share of programmed speeds; `limits` sees to the most that there may be."""
    match call.given:
        case (share, most) if share is not None and most is not None and not call.options:
            yield p.SetOverride(telling.meaning.expression(share))


def _process_move(
    telling: VendorLowering, call: Called[s.Expression], node: p.Opaque
) -> _Replacement:
    """Lower a move with a process; report data of the equipment, besides signals, as omitted."""
    kind = (
        "brush" if call.word.lower() == BRUSH_INSTRUCTION else PROCESS_MOVES[call.word.lower()].kind
    )
    said = [*_PROCESS_LOWERINGS[kind](telling, call)]
    if said:
        telling.lost(f"the data of {node.text.split()[0]}", *_EQUIPMENT_LOSSES[kind])
    first = said[0] if said[1:] else None
    if kind == "bead" and isinstance(first, p.MoveStatement):
        _report_corner(telling, first, node)
    yield from said


def _report_corner(telling: VendorLowering, move: p.MoveStatement, node: p.Opaque) -> None:
    """Tells where something is done behind a move that does not stop."""
    blend = declared_value(move.motion.blend, telling.program.blends)
    if not (isinstance(blend, Blend) and blend.fine):
        telling.lost(f"the place of {node.text.split()[0]}", *_CORNER_LOSS)


_PROCESS_LOWERINGS: Final[
    Mapping[str, Callable[[VendorLowering, Called[s.Expression]], _Replacement]]
] = {
    "arc": lambda telling, call: process_moves.weld_move(call, telling.meaning, telling.welds),
    "spot": lambda telling, call: process_moves.spot_move(call, telling.meaning, telling.spots()),
    "bead": lambda telling, call: process_moves.bead_move(call, telling.meaning, telling.beads()),
    "paint": lambda telling, call: process_moves.paint_move(call, telling.meaning),
    "brush": lambda telling, call: process_moves.brush_change(call, telling.meaning),
}
_EQUIPMENT_LOSSES: Final[Mapping[str, tuple[str, str]]] = {
    "arc": (
        "the output `arc_on` lights the arc and puts it out, and its moves have the speed of the "
        "weld; what the power source is told, weaving and tracking are not said",
        "set the power source up for the weld, and give the output its number",
    ),
    "spot": (
        "the gun is told the number of the weld and to start, and the program goes on when it is "
        "ready; force, thickness and when the gun begins to close are not said",
        "set gun and timer up by that number, so that ready also means that the gun is open",
    ),
    "bead": (
        "the dispenser is told the number of the bead, and when to begin and to end; its flow is "
        "not said",
        "set the dispenser up for the numbers: beads count in the order of their declarations",
    ),
    **dict.fromkeys(
        ("paint", "brush"),
        (
            "the brush is told by its number; what belongs to it is not said",
            "set the brushes up in the equipment by these numbers",
        ),
    ),
}
"""By kind of process what its equipment is not told, and what to do about it."""


def _meet_tasks(telling: VendorLowering, call: Called[s.Expression], _: p.Opaque) -> _Replacement:
    said = [*task_sync(call, telling.lists)]
    match call.given:
        case (s.NameRef(point), _) if said:
            telling.points.append(point)
            telling.findings.append(rules.MEETING(point=point, name=sync_counter(point)[0]))
    yield from said


def _synchronised_moves(
    telling: VendorLowering, call: Called[s.Expression], node: p.Opaque
) -> _Replacement:
    """Lower `SyncMoveOn` and `SyncMoveOff`: tasks meet there; between them each arm moves
    independently.
    """
    given = call.given
    # SyncMoveOff names no list of tasks: only one can be meant.
    if len(given) == 1 and len(lists := synchronised_lists(telling.program)) == 1:
        given = (*given, s.NameRef(*lists))
    said = [*_meet_tasks(telling, replace(call, given=given), node)]
    if said:
        telling.lost(node.text.split()[0], *OMITTED_OPTIONS["movel"]["id"])
    yield from said


def _test_and_set(telling: VendorLowering, call: Called[s.Expression], _: p.Opaque) -> _Replacement:
    """`WaitTestAndSet`: waits until a truth is false and sets it."""
    match call.given:
        case (s.NameRef() as node,) if not call.options:
            taken = telling.meaning.expression(node)
            telling.lost("the one step of WaitTestAndSet", *TEST_AND_SET_LOSS)
            yield p.WaitUntil(e.Unary("not", taken))
            yield p.Assign(taken, e.Truth(True))


TEST_AND_SET_LOSS: Final = (
    "another program may take it between the test and the next line",
    "let one program alone wait for it, or give each a variable of its own",
)
_LOWERINGS: Final[Mapping[str, _InstructionLowering]] = {
    "waittestandset": _test_and_set,
    **dict.fromkeys((*PROCESS_MOVES, BRUSH_INSTRUCTION), _process_move),
    "waitsynctask": _meet_tasks,
    **dict.fromkeys(("syncmoveon", "syncmoveoff"), _synchronised_moves),
    **dict.fromkeys(("movej", "movel", "movec"), _move_with_stated_motion),
    **dict.fromkeys(("movejdo", "moveldo", "movecdo"), _move_setting_output("SetDO")),
    **dict.fromkeys(("movejao", "movelao", "movecao"), _move_setting_output("SetAO")),
    **dict.fromkeys(("movejgo", "movelgo", "movecgo"), _move_setting_group),
    **dict.fromkeys(("movejsync", "movelsync", "movecsync"), _move_calling),
    "accset": _acceleration,
    "velset": _velocity,
    "pulsedo": lambda telling, call, _: inverse_pulse(
        call, telling.meaning, telling.switched, telling.findings
    ),
    "invertdo": lambda telling, call, _: inverted_output(call, telling.meaning),
    "setdo": lambda telling, call, node: delayed_output(
        call, telling.meaning, telling.findings, moves=id(node) in telling.delays()
    ),
    **dict.fromkeys(
        ("waituntil", "waitdi", "waitdo", "waitgi", "waitgo"),
        lambda telling, call, _: flagged_wait(call, telling.meaning, telling.program),
    ),
}
"""By instruction in lower case, what says the same (RAPID reference manual, instructions)."""
