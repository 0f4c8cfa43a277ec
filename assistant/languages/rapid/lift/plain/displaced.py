r"""Displacements of all targets, as work objects that move along.

`PDispSet shift;` becomes `displaced:=shift;`, a pose that every work object of a move is multiplied
by (`mounted.py`); moves in the base get a work object of their own for that. Positions that are
read are told in the same ones (RAPID reference manual: PDispSet, PDispOn, PDispAdd, CRobT).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.exchanging import rewritten
from assistant.languages.rapid.lift.plain.library import function_call
from assistant.languages.rapid.lift.plain.scopes import FreshNames
from assistant.languages.rapid.lift.plain.standard import predefined_value
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import option, positional
from assistant.languages.rapid.tree.walk import inner_names, nodes
from assistant.program.rewriting import rewrite

_SETTING: Final = frozenset(("pdispset", "pdispadd", "pdispon"))
_ENDING: Final = "pdispoff"
_FRAME: Final = "wobj"
_BASE: Final = "wobj0"
_UNDISPLACED_CALLS: Final = frozenset(("calcrobt", "calcjointt", "eoffson", "pdispon"))
"""Of what takes a work object: what is no motion and no reading."""
_READS_IN_ACTIVE: Final = frozenset(("crobt", "cpos"))
"""Without a work object they read in that of the move before."""

Call = s.ProcedureCall | s.FunctionCall


def with_displacements(
    modules: Sequence[s.Module], fresh: FreshNames
) -> tuple[Sequence[s.Module], str]:
    """The modules without such instructions, and the name of the displacement.

    As they are, and no name, where there is none, or a work object is not told by its name.
    """
    every = list(nodes(tuple(modules)))
    own = {one.name.lower() for one in every if isinstance(one, s.Routine)}
    words = {key for one in every if isinstance(one, s.ProcedureCall) and (key := _call_word(one))}
    if not (words - own) & _SETTING or own & {*_SETTING, _ENDING}:
        return modules, ""
    calls = [one for one in every if isinstance(one, Call) and _call_word(one) not in own]
    routines = [one for one in every if isinstance(one, s.Routine)]
    hidden = {name.lower() for name in inner_names(routines)}
    if not all(_has_module_frame(one, hidden) for one in calls):
        return modules, ""
    said = _DisplacementRewriting(fresh, own)
    first, *others = (rewritten(rewrite(one, said.mounted, ()), said.set) for one in modules)
    return (replace(first, items=(*said.data(), *first.items)), *others), said.name


def _call_word(call: Call) -> str:
    return call.name.lower() if isinstance(call.name, str) else ""


def _takes_frame(call: Call) -> bool:
    """Whether a routine that every controller has moves or reads in a work object."""
    word = _call_word(call)
    known = signature(word)
    slots = () if known is None else known.slots
    frames = (q.name.lower() == _FRAME for slot in slots for q in slot.alternatives)
    return word not in _UNDISPLACED_CALLS and any(frames)


def _has_module_frame(call: Call, hidden: set[str]) -> bool:
    """Whether the work object of a call has a name of a module, if it takes one."""
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
        yield s.Data("", "VAR", "pose", self.name, (), zero_pose())
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
        """What stands for an instruction that sets or ends a displacement."""
        match node:
            case s.ProcedureCall(str(name), (s.Positional(shift),)) if name.lower() == "pdispset":
                yield self._given(node, shift)
            case s.ProcedureCall(str(name), (s.Positional(shift),)) if name.lower() == "pdispadd":
                yield self._given(node, function_call("PoseMult", s.NameRef(self.name), shift))
            case s.ProcedureCall(str(name)) if name.lower() == _ENDING:
                yield self._given(node, zero_pose())
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
            yield self._given(node, zero_pose())
            yield s.Assignment(there, self._mounted(here), span=span)  # type: ignore[arg-type]
        if option(node, "rot") is not None:
            at, planned = (s.NameRef(name) for name in self.poses)
            for pose, target in ((at, there), (planned, meant)):
                for part in ("trans", "rot"):
                    place, value = s.Component(pose, part), s.Component(target, part)
                    yield s.Assignment(place, value, span=span)
            yield self._given(
                node, function_call("PoseMult", at, function_call("PoseInv", planned))
            )
            return
        yield self._given(node, zero_pose())
        for axis in "xyz":
            parts = (s.Component(s.Component(one, "trans"), axis) for one in (there, meant))
            moved = s.Component(s.Component(s.NameRef(self.name), "trans"), axis)
            yield s.Assignment(moved, s.Infix("-", *parts), span=span)


def zero_pose() -> s.AggregateNode:
    """The pose that displaces and turns nothing."""
    values = ((0, 0, 0), (1, 0, 0, 0))
    parts = (tuple(s.NumberLiteral(str(number)) for number in part) for part in values)
    return s.AggregateNode(tuple(map(s.AggregateNode, parts)))
