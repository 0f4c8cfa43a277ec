"""Displacements, work objects on mechanical units and arm kinematics, as plain frames.

`PDispSet shift;` becomes `displaced:=shift;`, a pose that every work object of a move is multiplied
by; moves in the base get a work object for that. Positions are read in the same ones (RAPID
reference manual: PDispSet, PDispOn, PDispAdd, CRobT). `CalcRobT` of the joints `j` with the tool
`grip` in `w` becomes `target_of_joints(j,grip.tframe,w.uframe,w.oframe)` of the library, which asks
for `CalcRobT(j,tool0)`: other languages compute without a tool. Other languages have no frame that
moves with an external axis. A cell states where the unit `STN1` is as the frame `STN1_stands`,
which takes the place of `[FALSE,FALSE,"STN1",user,object]`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.data_names import FreshNames, predefined_value
from assistant.languages.rapid.lift.flatten.library import ARM_FUNCTIONS, function_call
from assistant.languages.rapid.lift.flatten.tree_rewriting import rewritten
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import carrying_unit, still_frame_name, units_can_stand
from assistant.languages.rapid.tree.walk import called, inner_names, nodes, option, positional
from assistant.program.geometry import FLANGE
from assistant.program.rewriting import rewrite

_SETTING: Final = frozenset(("pdispset", "pdispadd", "pdispon"))
_ENDING: Final = "pdispoff"
_FRAME: Final = "wobj"
_BASE: Final = "wobj0"
_UNDISPLACED_CALLS: Final = frozenset(("calcrobt", "calcjointt", "eoffson", "pdispon"))
"""Calls with a work object that neither move nor read a position."""
_READS_IN_ACTIVE: Final = frozenset(("crobt", "cpos"))
"""Without a work object they read in that of the move before."""

Call = s.ProcedureCall | s.FunctionCall


def with_displacements(
    modules: Sequence[s.Module], fresh: FreshNames
) -> tuple[Sequence[s.Module], str]:
    """Return the modules without displacement instructions, and the name of the displacement.

    Return them unchanged, with an empty name, if they have no displacement or if a call does not
    give its work object by name.
    """
    every = list(nodes(tuple(modules)))
    own = {one.name.lower() for one in every if isinstance(one, s.Routine)}
    words = {key for one in every if isinstance(one, s.ProcedureCall) and (key := _call_word(one))}
    # Routines of the program with such names are not RAPID's.
    if not (words - own) & _SETTING or own & {*_SETTING, _ENDING}:
        return modules, ""
    calls = [one for one in every if isinstance(one, Call) and _call_word(one) not in own]
    routines = [one for one in every if isinstance(one, s.Routine)]
    hidden = {name.lower() for name in inner_names(routines)}
    # A frame that is a parameter or local data cannot be split into displaced parts.
    if not all(_has_module_frame(one, hidden) for one in calls):
        return modules, ""
    said = _DisplacementRewriting(fresh, own)
    first, *others = (rewritten(rewrite(one, said.mounted, ()), said.set) for one in modules)
    return (replace(first, items=(*said.data(), *first.items)), *others), said.name


def _call_word(call: Call) -> str:
    return call.name.lower() if isinstance(call.name, str) else ""


def _takes_frame(call: Call) -> bool:
    """True if a routine of every controller moves or reads positions in a work object."""
    word = _call_word(call)
    known = signature(word)
    slots = () if known is None else known.slots
    frames = (q.name.lower() == _FRAME for slot in slots for q in slot.alternatives)
    return word not in _UNDISPLACED_CALLS and any(frames)


def _has_module_frame(call: Call, hidden: set[str]) -> bool:
    """True if the call takes no work object, or one with a name of a module."""
    if not _takes_frame(call) and _call_word(call) != "pdispon":
        return True
    for one in call.arguments:
        if isinstance(one, s.Conditional) and one.name.lower() == _FRAME:
            return False
        if isinstance(one, s.Option) and one.name.lower() == _FRAME:
            value = one.value
            return isinstance(value, s.NameRef) and value.name.lower() not in hidden
    return True


class _DisplacementRewriting:
    def __init__(self, fresh: FreshNames, own: set[str]) -> None:
        self.own = own
        self.name, self.base = fresh("displaced"), fresh("displaced_base")
        self.there, self.meant = fresh("executed"), fresh("programmed")
        self.poses = fresh("executed_at"), fresh("programmed_at")

    def data(self) -> Iterator[s.Data]:
        yield s.Data("", "VAR", "pose", self.name, (), _zero_pose())
        yield s.Data("", "PERS", "wobjdata", self.base, (), predefined_value(_BASE))
        for name in (self.there, self.meant):
            yield s.Data("", "VAR", "robtarget", name)
        for name in self.poses:
            yield s.Data("", "VAR", "pose", name)

    def mounted(self, node: Any) -> Any:
        """A move or reading in a work object that is displaced."""
        match node:
            case s.ProcedureCall() | s.FunctionCall() if _call_word(
                node
            ) not in self.own and _takes_frame(node):
                return self._mounted(node)
            case s.MoveRunNode(run):
                rows = (
                    replace(one, frame=self.base) if one.frame.lower() in ("", _BASE) else one
                    for one in run.motions.table
                )
                motions = replace(run.motions, table=tuple(rows))
                return replace(node, run=replace(run, motions=motions))
        return node

    def _mounted(self, call: Call) -> Call:
        frame = option(call, _FRAME)
        if frame is None:
            # It reads in the work object of the move before, which is displaced already.
            if _call_word(call) in _READS_IN_ACTIVE:
                return call
            return replace(call, arguments=(*call.arguments, self._frame()))
        if isinstance(frame.value, s.NameRef) and frame.value.name.lower() == _BASE:
            rest = (self._frame() if one is frame else one for one in call.arguments)
            return replace(call, arguments=tuple(rest))
        return call

    def _frame(self) -> s.Option:
        return s.Option("WObj", s.NameRef(self.base))

    def set(self, node: s.StatementNode) -> Iterator[s.StatementNode]:
        """Yield the statements that replace an instruction which sets or ends a displacement."""
        match node:
            case s.ProcedureCall(str(name), (s.Positional(shift),)) if name.lower() == "pdispset":
                yield self._given(node, shift)
            case s.ProcedureCall(str(name), (s.Positional(shift),)) if name.lower() == "pdispadd":
                yield self._given(node, function_call("PoseMult", s.NameRef(self.name), shift))
            case s.ProcedureCall(str(name)) if name.lower() == _ENDING:
                yield self._given(node, _zero_pose())
            case s.ProcedureCall(str(name)) if name.lower() == "pdispon":
                yield from self._on(node)
            case _:
                yield node

    def _given(self, node: s.StatementNode, value: s.Expression) -> s.Assignment:
        return s.Assignment(s.NameRef(self.name), value, span=node.span)

    def _on(self, node: s.ProcedureCall) -> Iterator[s.StatementNode]:
        r"""From a programmed place to the one of \ExeP, or to where the robot stands."""
        given, executed = positional(node), option(node, "exep")
        if len(given) != 2:
            yield node
            return
        span, there, meant = node.span, s.NameRef(self.there), s.NameRef(self.meant)
        yield s.Assignment(meant, given[0], span=span)
        if executed is not None and executed.value is not None:
            yield s.Assignment(there, executed.value, span=span)
        else:
            frame = option(node, _FRAME) or s.Option("WObj", s.NameRef(_BASE))
            here = s.FunctionCall("CRobT", (s.Option("Tool", given[1]), frame))
            # The position has to be read without the displacement that is about to be set.
            yield self._given(node, _zero_pose())
            yield s.Assignment(there, self._mounted(here), span=span)  # type: ignore[arg-type]
        if option(node, "rot") is not None:
            at, planned = (s.NameRef(name) for name in self.poses)
            for pose, target in ((at, there), (planned, meant)):
                for part in ("trans", "rot"):
                    place, value = s.Component(pose, part), s.Component(target, part)
                    yield s.Assignment(place, value, span=span)
            # The pose that takes the programmed place to the executed one.
            yield self._given(
                node, function_call("PoseMult", at, function_call("PoseInv", planned))
            )
            return
        yield self._given(node, _zero_pose())
        for axis in "xyz":
            parts = (s.Component(s.Component(one, "trans"), axis) for one in (there, meant))
            moved = s.Component(s.Component(s.NameRef(self.name), "trans"), axis)
            yield s.Assignment(moved, s.Infix("-", *parts), span=span)


def _zero_pose() -> s.AggregateNode:
    """The pose that displaces and turns nothing."""
    values = ((0, 0, 0), (1, 0, 0, 0))
    parts = (tuple(s.NumberLiteral(str(number)) for number in part) for part in values)
    return s.AggregateNode(tuple(map(s.AggregateNode, parts)))


_BASE_FRAME: Final = "wobj0"
_NAMED_VALUES: Final = (s.NameRef, s.Component, s.Element)


def with_arm_kinematics(modules: Sequence[s.Module], displaced: str) -> Sequence[s.Module]:
    """The modules with such calls. displaced: the displacement of all targets, or empty."""
    every = list(nodes(tuple(modules)))
    own = {one.name.lower() for one in every if isinstance(one, s.Routine)}
    wanted = ARM_FUNCTIONS.keys() - own
    if not any(isinstance(one, s.FunctionCall) and one.name.lower() in wanted for one in every):
        return modules

    def change(node: Any) -> Any:
        if isinstance(node, s.FunctionCall) and node.name.lower() in wanted:
            return _kinematics_call(node, displaced) or node
        return node

    def item(one: s.Item) -> s.Item:
        # The library's own functions contain the plain call that the others become.
        asks = isinstance(one, s.Routine) and one.name in ARM_FUNCTIONS.values()
        return one if asks else rewrite(one, change, ())

    made = [replace(module, items=tuple(map(item, module.items))) for module in modules]
    return made


def _kinematics_call(node: s.FunctionCall, displaced: str) -> s.Expression | None:
    """Return a kinematics call for the flange in the base; None if the call already has that form
    or has an unsupported option.
    """
    call = called(node)
    options = {} if call is None else {name.lower(): one for name, one in call.options.items()}
    if call is None or options.keys() - {"wobj"} or len(call.given) != 2:
        return None
    value, tool = call.given
    frame = options.get("wobj")
    if not isinstance(tool, _NAMED_VALUES) or value is None:
        return None
    bare = isinstance(tool, s.NameRef) and tool.name.lower() == FLANGE
    if isinstance(frame, s.NameRef) and frame.name.lower() == _BASE_FRAME:
        frame = None
    if bare and frame is None and not displaced:
        return function_call(node.name, value, tool) if options else None
    user: s.Expression = _zero_pose()
    object: s.Expression = _zero_pose()
    match frame:
        case s.NameRef() | s.Component() | s.Element():
            user, object = s.Component(frame, "uframe"), s.Component(frame, "oframe")
        case s.Node():
            return None
    if displaced:
        object = function_call("PoseMult", object, s.NameRef(displaced))
    tip: s.Expression = _zero_pose() if bare else s.Component(tool, "tframe")
    return function_call(ARM_FUNCTIONS[node.name.lower()], value, tip, user, object)


_Remarks = tuple[Diagnostic, ...]


def with_fixed_units(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules with such work objects, and the findings of each."""
    nothing: list[list[Diagnostic]] = [[] for _ in modules]
    places: dict[str, s.AggregateNode] = {}
    for item in (item for module in modules for item in module.items):
        if isinstance(item, s.Data) and isinstance(item.value, s.AggregateNode):
            places[item.name.lower()] = item.value
    units = {unit for module in modules for unit in map(carrying_unit, nodes(module)) if unit}
    known = {unit: places.get(still_frame_name(unit).lower()) for unit in units}
    if None in known.values() or not units or not units_can_stand(modules):
        return modules, nothing

    def stood(node: Any) -> Any:
        place = known.get(carrying_unit(node))
        if place is None:
            return node
        _, _, _, _, object = node.items
        fixed = (s.BoolLiteral(False), s.BoolLiteral(True), s.StringLiteral(""))
        return replace(node, items=(*fixed, _user_frame(place), object))

    made = [rewrite(module, stood, ()) for module in modules]
    return made, [_unit_findings(module) for module in modules]


def _user_frame(place: s.AggregateNode) -> s.Expression:
    """The user frame of what the cell states, which has no object frame."""
    return place.items[3]


def _unit_findings(module: s.Module) -> list[Diagnostic]:
    """A finding for each statement and declaration that says such a work object."""
    return [
        rules.STANDS(unit=unit, frame=still_frame_name(unit), span=node.span)
        for node in nodes(module)
        if isinstance(node, s.Data | s.Assignment) and node.span is not None
        for unit in dict.fromkeys(filter(None, map(carrying_unit, nodes(node.value))))
    ]
