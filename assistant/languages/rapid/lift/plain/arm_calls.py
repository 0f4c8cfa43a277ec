r"""Joints of a target and targets of joints, by where the flange is in the robot's base.

`CalcRobT(j,grip\WObj:=w)` becomes `target_of_joints(j,grip.tframe,w.uframe,w.oframe)` of the
library, which asks for `CalcRobT(j,tool0)`: other languages count without a tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.displaced import zero_pose
from assistant.languages.rapid.lift.plain.library import ARM_FUNCTIONS, function_call
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.geometry import FLANGE
from assistant.program.rewriting import rewrite

BASE_FRAME: Final = "wobj0"
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
        asks = isinstance(one, s.Routine) and one.name in ARM_FUNCTIONS.values()
        return one if asks else rewrite(one, change, ())

    made = [replace(module, items=tuple(map(item, module.items))) for module in modules]
    return made


def _kinematics_call(node: s.FunctionCall, displaced: str) -> s.Expression | None:
    """None where the flange is asked for in the base, or by what an option says."""
    call = called(node)
    options = {} if call is None else {name.lower(): one for name, one in call.options.items()}
    if call is None or options.keys() - {"wobj"} or len(call.given) != 2:
        return None
    value, tool = call.given
    frame = options.get("wobj")
    if not isinstance(tool, _NAMED_VALUES) or value is None:
        return None
    bare = isinstance(tool, s.NameRef) and tool.name.lower() == FLANGE
    if isinstance(frame, s.NameRef) and frame.name.lower() == BASE_FRAME:
        frame = None
    if bare and frame is None and not displaced:
        return function_call(node.name, value, tool) if options else None
    user: s.Expression = zero_pose()
    object: s.Expression = zero_pose()
    match frame:
        case s.NameRef() | s.Component() | s.Element():
            user, object = s.Component(frame, "uframe"), s.Component(frame, "oframe")
        case s.Node():
            return None
    if displaced:
        object = function_call("PoseMult", object, s.NameRef(displaced))
    tip: s.Expression = zero_pose() if bare else s.Component(tool, "tframe")
    return function_call(ARM_FUNCTIONS[node.name.lower()], value, tip, user, object)
