"""Statements of MELFA-BASIC by form and by word: assignments, jumps, settings, waits, ends.

Also the blocks (If, For, While, Select), how they are left, and statements on data (ChrSrch, Clr).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.events import Said
from assistant.virtual.melfa import (
    arm_statements,
    communication,
    controller,
    expressions,
    interrupts,
    positions,
    status,
)
from assistant.virtual.melfa.arm_state import FULL, OPTIMUM
from assistant.virtual.melfa.code import LOOPS, Block, nodes
from assistant.virtual.melfa.expressions import RELATIONS, SPELLINGS, binary
from assistant.virtual.melfa.values import (
    Bare,
    Cell,
    Ended,
    Failed,
    Storage,
    Unknown,
    Value,
    holds,
    is_external,
    kind_of,
    number,
    open_point,
    out_of_range,
    position,
    text,
    whole,
    with_component,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Loop, Machine


def enter_if(m: Machine, node: s.If) -> None:
    """Goes to the first part whose condition is met."""
    block = m.code.opened[m.here]
    check_depth(block)
    if holds(expressions.value(m, node.condition)):
        m.took(0)
        return
    for way, part in enumerate(block.parts, 1):
        statement = m.code.rows[part].statement
        m.at = part + 1
        if not isinstance(statement, s.ElseIf) or holds(expressions.value(m, statement.condition)):
            m.took(way)
            return
    m.took(len(block.parts) + 1)
    m.at = block.end + 1


def check_depth(block: Block) -> None:
    """Raises Failed where blocks stand too deep in each other."""
    if block.loops > _MOST_LOOPS:
        raise Failed(3240, f"more than {_MOST_LOOPS} loops in each other")
    if block.branches > _MOST_BRANCHES:
        raise Failed(3253, f"more than {_MOST_BRANCHES} If in each other")


_MOST_LOOPS: Final = 16
_MOST_BRANCHES: Final = 8
"""CR1D 4-151 and 4-208."""


def skip_rest(m: Machine, _: Any) -> None:
    """A part that another one ends in: behind the whole block."""
    m.at = m.code.parted[m.here].end + 1


def leave_block(m: Machine, _: s.Command) -> None:
    """`Break`: continue after the innermost block and set M_BrkCq (CR1D 4-208)."""
    block = m.code.inside[m.here]
    if m.world.options.breaks == "If and Select":
        while block is not None and block.kind in LOOPS:
            block = m.code.inside[block.start]
    if block is None or block.kind == "Function":
        raise Failed(4220, "Break outside of a block")
    m.at = block.end + 1
    m.world.left = True


# -------------------------------------------------------------------------------------- loops


def begin_for(m: Machine, node: s.For) -> None:
    """Bounds are worked out once; a loop without a turn is passed (COSIROP: FOR)."""
    from assistant.virtual.melfa.machine import Loop

    check_depth(m.code.opened[m.here])
    first = expressions.plain(m, node.first, "the first value of a loop")
    last, step = _loop_bounds(m, node)
    place, index = expressions.reference(m, node.variable)
    place.set(first, index)
    m.frame.loops[m.here] = Loop(last, step)
    # A variable of whole numbers rounds what it is given, so the test reads it back.
    runs = _loop_continues(number(place.get(index)), last, step)
    m.took(0 if runs else 1)
    if not runs:
        block = m.code.opened[m.here]
        m.at = block.end + 1


def _loop_bounds(m: Machine, node: s.For) -> tuple[float, float]:
    last = expressions.plain(m, node.last, "the last value of a loop")
    step = 1 if node.step is None else expressions.plain(m, node.step, "the step of a loop")
    if step == 0:
        raise Unknown("a loop of step 0")
    return last, step


def next_turn(m: Machine, _: s.Next) -> None:
    """Count on and return to the first statement of the loop, or continue after it."""
    # `Next M1,M2`: the outer loop counts on once the inner one is over.
    for closed in m.code.closed[m.here]:
        statement = m.code.rows[closed.start].statement
        assert isinstance(statement, s.For)
        loop = m.frame.loops.get(closed.start)
        if loop is None:
            raise Failed(3230, "Next without its For")
        _follow_bounds(m, statement, loop)
        place, index = expressions.reference(m, statement.variable)
        place.set(number(place.get(index)) + loop.step, index)
        if _loop_continues(number(place.get(index)), loop.last, loop.step):
            m.at = closed.start + 1
            return


def _follow_bounds(m: Machine, node: s.For, loop: Loop) -> None:
    """Update the bounds of a loop as the option `bounds` requires; raises Unknown if it is unset
    and they change.
    """
    way = m.world.options.bounds
    # Bounds in plain numbers cannot change.
    if isinstance(node.last, s.Number) and (node.step is None or isinstance(node.step, s.Number)):
        return
    if way == "each":
        loop.last, loop.step = _loop_bounds(m, node)
    elif (
        # Evaluating the bounds once more must have no effect, which a function may have.
        way is None
        and not _calls_function(m, node)
        and _loop_bounds(m, node) != (loop.last, loop.step)
    ):
        raise open_point("a loop whose bounds change while it runs", "bounds")


def _calls_function(m: Machine, node: s.For) -> bool:
    """True if a bound calls a function of the program; it is not evaluated once more then."""
    return any(
        isinstance(part, s.Variable) and part.key in m.code.functions
        for part in nodes((node.last, node.step))
    )


def _loop_continues(value: float, last: float, step: float) -> bool:
    return value <= last if step > 0 else value >= last


def test_while(m: Machine, node: s.Command) -> None:
    check_depth(m.code.opened[m.here])
    met = holds(expressions.value(m, node.arguments[0]))
    m.took(0 if met else 1)
    if not met:
        m.at = m.code.opened[m.here].end + 1


def back_to_while(m: Machine, _: s.Command) -> None:
    (block,) = m.code.closed[m.here]
    m.at = block.start


# ------------------------------------------------------------------------------------- Select


def choose_case(m: Machine, node: s.Select) -> None:
    """The first part that fits, Default where none does; lines before the first never run."""
    block = m.code.opened[m.here]
    subject = expressions.value(m, node.subject)
    for way, part in enumerate(block.parts):
        statement = m.code.rows[part].statement
        if not isinstance(statement, s.Case) or any(
            _case_fits(m, item, subject) for item in statement.items
        ):
            m.took(way)
            m.at = part + 1
            return
    m.took(len(block.parts))
    m.at = block.end + 1


def _case_fits(m: Machine, item: s.CaseRange | s.CaseIs, subject: Value) -> bool:
    if isinstance(item, s.CaseIs):
        sign = SPELLINGS.get(item.operator, item.operator)
        return _case_compared(m, sign, subject, expressions.value(m, item.value))
    first = expressions.value(m, item.first)
    if item.last is None:
        return _case_compared(m, "=", subject, first)
    last = expressions.value(m, item.last)
    return _case_compared(m, ">=", subject, first) and _case_compared(m, "<=", subject, last)


def _case_compared(m: Machine, sign: str, left: Value, right: Value) -> bool:
    if sign not in RELATIONS:
        raise Failed(4220, f"Case Is {sign}")
    return bool(binary(m, sign, left, right))


def _search_array(
    m: Machine, array: s.Expression, sought: s.Expression, found: s.Expression
) -> None:
    """ChrSrch: the first element that is all of a text, whatever element is named; else 0."""
    if not isinstance(array, s.Variable) or not isinstance(found, s.Variable):
        raise Failed(3810, "ChrSrch takes an array of texts and a variable")
    cell = m.memory_of(array.key).place(array.key)
    if not isinstance(cell, Cell) or cell.kind != "text" or len(cell.size) != 1:
        raise Failed(4370, f"{array.name} is no array of texts of one dimension")
    wanted = text(expressions.value(m, sought), "what ChrSrch looks for")
    places = (i for i in range(1, cell.size[0] + 1) if cell.values.get((i,)) == wanted)
    expressions.store(m, found, next(places, 0))


def _clear_variables(m: Machine, kind: s.Expression) -> None:
    """Clr 2 and 3: numbers of the program, or of all programs, are 0 (COSIROP: CLR)."""
    which = expressions.integer(m, kind, "the kind of Clr")
    if which not in range(4):
        raise out_of_range(f"the kind {which} of Clr")
    if which in (0, 1):
        raise Unknown("the pattern that outputs are reset to, which stands in parameters")
    if m.code.functions:
        raise Unknown("Clr in a program of functions")
    for place in _number_variables(m, external=which == _EXTERNAL_VARIABLES):
        extents = place.size if isinstance(place, Cell) else ()
        for index in product(*(range(1, n + 1) for n in extents)):
            place.set(0, index)


_EXTERNAL_VARIABLES: Final = 3


def _number_variables(m: Machine, external: bool) -> Iterator[Storage]:
    """Numeric variables that the program uses, or that all programs share."""
    # By identity, as a program may be among those that it may call.
    machines = {id(x): x for x in (m, *m.programs.values())}.values() if external else (m,)
    for machine in machines:
        known = {*machine.code.signals, *machine.code.definitions, *machine.code.constants}
        for row in machine.code.rows:
            for node in nodes(row.statement):
                if isinstance(node, s.Variable) and node.key not in known:
                    yield from _number_variable(machine, node, external)


def _number_variable(m: Machine, node: s.Variable, external: bool) -> Iterator[Storage]:
    if expressions.is_status(node.key) or vocabulary.function(node.key) is not None:
        return
    if is_external(node.key) != external:
        return
    place = m.memory_of(node.key).place(node.key)
    if place.kind in expressions.NUMBER_KINDS and isinstance(place, Cell):
        yield place


_DATA_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "CHRSRCH": _search_array,
    "CLR": _clear_variables,
}


def run_command(m: Machine, node: s.Command) -> None:
    """Runs a command; raises Unknown for one that is not simulated."""
    word = " ".join(node.keyword.upper().split())
    if m.world.commands and _run_plugin(m, word, node.arguments):
        return
    if word in _BLOCK_WORDS:
        _BLOCK_WORDS[word](m, node)
    elif word in _COMMAND_WORDS:
        known, count = vocabulary.statement(word), len(node.arguments)
        if known and not known.least <= count <= (count if known.most is None else known.most):
            raise Failed(3120, f"{node.keyword} with {count} arguments")
        _COMMAND_WORDS[word](m, *node.arguments)
    elif word in _TUNING_WORDS:
        m.world.note(f"{node.keyword} has no effect on this run")
    elif word not in _WORDS_WITHOUT_EFFECT:
        raise Unknown(f"the statement {node.keyword}")


def _run_plugin(m: Machine, word: str, nodes: tuple[s.Expression | None, ...]) -> bool:
    """Runs the plug-in of a command, which may have its first word of arguments in its name."""
    first = nodes[0] if nodes else None
    two = f"{word} {expressions.bare(first)}".upper()
    name = two if two in m.world.commands else word
    if name not in m.world.commands:
        return False
    rest = nodes[1:] if name == two else nodes
    m.world.given(name, tuple(None if a is None else _loose_argument(m, a) for a in rest))
    return True


def _loose_argument(m: Machine, node: s.Expression) -> Value:
    """The value of an argument of a plug-in; a bare word is a text."""
    word = expressions.bare(node)
    return word if word in _LOOSE_WORDS else expressions.value(m, node)


_LOOSE_WORDS: Final = frozenset(("On", "Off", "Jnt", "Pos", "Tool"))

_WORDS_WITHOUT_EFFECT: Final = frozenset(("ENDIF", "END SELECT", "TITLE"))
"""Ends of blocks, and what is a comment."""
_TUNING_WORDS: Final = frozenset((
    "OADL", "LOADSET", "FINE", "PREC", "MVTUNE", "SPDOPT", "COLCHK", "COLLVL", "CAVCHK", "CMPG",
    "TORQ",
))  # fmt: skip
"""Settings that change no event: how the arm is driven, and what it watches."""

# ------------------------------------------------------------------------------------ motion


def _set_speed(m: Machine, node: s.Expression) -> None:
    speed = expressions.plain(m, node, "the speed")
    if speed <= 0:
        raise out_of_range(f"the speed {speed}")
    m.world.settings.speed = min(float(speed), OPTIMUM)


def _percent_of(m: Machine, node: s.Expression | None, what: str) -> float:
    value = FULL if node is None else float(expressions.plain(m, node, what))
    if not 0 < value <= FULL:
        raise out_of_range(f"{what} of {value} percent")
    return value


def _set_override(m: Machine, node: s.Expression, *others: s.Expression | None) -> None:
    for other in others:
        _percent_of(m, other, "the override of Mva")
    m.world.settings.override = _percent_of(m, node, "the override")


def _set_joint_override(m: Machine, node: s.Expression) -> None:
    m.world.settings.joint_override = _percent_of(m, node, "the joint override")


def _set_acceleration(m: Machine, *nodes: s.Expression | None) -> None:
    first, second, *_ = (*nodes, None, None)
    m.world.settings.acceleration = (
        _percent_of(m, first, "the acceleration"),
        _percent_of(m, second, "the deceleration"),
    )


def _set_corner(m: Machine, switch: s.Expression, *sizes: s.Expression | None) -> None:
    """`Cnt 1,a,b`: a corner from a before the target to b after it; the smaller one limits."""
    on = expressions.integer(m, switch, "the switch of Cnt")
    given = [float(expressions.plain(m, node, "a corner")) for node in sizes if node is not None]
    if on not in (0, 1) or any(size < 0 for size in given):
        raise out_of_range("an argument of Cnt")
    m.world.settings.corner = min(given, default=math.inf) if on else 0.0


# ----------------------------------------------------------------------------------- pallets


def define_pallet(m: Machine, arguments: tuple[s.Expression | None, ...]) -> None:
    """`Def Plt`, whose diagonal corner may be missing with its comma."""
    if len(arguments) == 7:
        arguments = (*arguments[:4], None, *arguments[4:])
    if len(arguments) != 8:
        raise Failed(3120, f"Def Plt with {len(arguments)} arguments")
    number = expressions.integer(m, arguments[0], "the pallet")
    corners = [None if a is None else expressions.value(m, a) for a in arguments[1:5]]
    first, second, direction = (
        expressions.integer(m, a, "an argument of Def Plt") for a in arguments[5:]
    )
    places = tuple(None if c is None else position(c, "a corner of the pallet") for c in corners)
    m.pallets[number] = positions.pallet_grid(
        number, places, (first, second), direction, fixed=m.world.options.pallets == "start"
    )


# ------------------------------------------------------------------------------ waits and ends


def _delay(m: Machine, node: s.Expression) -> None:
    seconds = float(expressions.plain(m, node, "the time"))
    if seconds < 0:
        raise out_of_range(f"a time of {seconds} seconds")
    # The move before may have to end at its target, without its corner.
    m.world.stand()
    m.world.task.delay(seconds)


def _wait(m: Machine, node: s.Expression) -> None:
    """Wait for a condition; one with a timer is evaluated again and again, as the timer runs on."""
    task = m.world.task
    m.world.stand()
    # Time alone may meet the condition, and the kernel has no event for that.
    if any(isinstance(part, s.Variable) and part.key == "M_TIMER" for part in nodes(node)):
        since = task.kernel.now
        while not holds(expressions.value(m, node)):
            task.looked(since, over=False)
            task.step()
        task.looked(since, over=True)
    else:
        interrupts.attend(m, node)
        try:
            task.wait(lambda: holds(expressions.value(m, node)))
        finally:
            interrupts.attend(m)


def _halt_program(m: Machine) -> None:
    m.world.stand()
    m.world.halt()


def _raise_error(m: Machine, node: s.Expression) -> None:
    number = expressions.integer(m, node, "the number of an error")
    if number not in _USER_ERRORS:
        raise out_of_range(f"the error {number}")
    if number < _FIRST_CAUTION:
        raise Failed(number, "raised by the program")
    m.world.warn(number)
    m.world.task.tell(Said(f"error {number}"))


def _reset_error(m: Machine) -> None:
    if not m.world.options.resets:
        raise Failed(None, "Reset Err in a program that does not always run (ALWENA)")
    m.world.warn(0)


_USER_ERRORS: Final = range(9000, 9300)
_FIRST_CAUTION: Final = 9200
"""From here on the program runs on."""


def _end_program(_: Machine) -> None:
    raise Ended


_COMMAND_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    **arm_statements.ARM_WORDS,
    **_DATA_WORDS,
    "SPD": _set_speed,
    "OVRD": _set_override,
    "JOVRD": _set_joint_override,
    "ACCEL": _set_acceleration,
    "CNT": _set_corner,
    "DLY": _delay,
    "WAIT": _wait,
    "HLT": _halt_program,
    "ERROR": _raise_error,
    "RESET ERR": _reset_error,
    "END": _end_program,
    "EXIT FUNCTION": lambda m: m.leave(),
    "FEND": lambda m: m.leave(),
    **controller.SLOT_WORDS,
    **interrupts.WORDS,
}

_BLOCK_WORDS: Final[Mapping[str, Callable[[Machine, Any], None]]] = {
    "ELSE": skip_rest,
    "DEFAULT": skip_rest,
    "WHILE": test_while,
    "WEND": back_to_while,
    "BREAK": leave_block,
}


def execute(m: Machine, statement: s.Statement) -> None:
    """Runs one statement; the row that comes next is set already."""
    if isinstance(statement, s.Command):
        run_command(m, statement)
        return
    run = _STATEMENT_FORMS.get(type(statement))
    if run is None:
        raise Unknown(f"the statement {type(statement).__name__}")
    run(m, statement)


def _no_effect(_m: Machine, _node: Any) -> None:
    """Definitions are taken in before the program runs."""


def _run_motion(m: Machine, node: s.Motion) -> None:
    arm_statements.move(m, node)


# ------------------------------------------------------------------------------- assignments


def _assign(m: Machine, node: s.Assign) -> None:
    target, key = node.target, node.target.key
    value = expressions.value(m, node.value)
    if m.is_result(target):
        _assign_result(m, target, value)
    elif m.world.commands and f"{key}=" in m.world.commands:
        m.world.given(f"{key}=", (*expressions.values(m, target.arguments or ()), value))
    # A function's own variable hides a name of the program or the controller.
    elif not m.is_own(key) and key in m.code.signals:
        first, width, mask = expressions.io_of(m, m.code.signals[key])
        _switch_signals(m, node, first, width, whole(value), mask)
    elif key in status.SIGNAL_WIDTHS and not m.is_own(key):
        first = _element_index(m, target)
        if not status.SIGNAL_WIDTHS[key][0]:
            raise Failed(3210, f"{target.name} is written")
        _switch_signals(m, node, first, status.SIGNAL_WIDTHS[key][1], whole(value))
    elif status.REGISTER_OUTPUTS.get(key) and not m.is_own(key):
        m.world.set_register(_element_index(m, target), value)
    elif key == "M_TIMER":
        m.world.set_timer(status.timer_number(_element_index(m, target)), float(whole(value)))
    elif key == "M_HND":
        arm_statements.order_hand(m, _element_index(m, target), float(whole(value)))
    elif key == "M_TOOL":
        arm_statements.choose_tool(m, whole(value))
    elif key == "C_COM" and not m.is_own(key):
        communication.set_target(
            m.world, _element_index(m, target), text(value, "the target of a line")
        )
    elif expressions.is_status(key) and not m.is_own(key):
        raise Unknown(f"setting the status variable {target.name}")
    elif node.delay is not None:
        raise Failed(4220, "a pulse of what is no output")
    else:
        expressions.store(m, target, value)


def _assign_result(m: Machine, target: s.Variable, value: Any) -> None:
    """The result of the Function that runs."""
    if target.component:
        m.set_result(with_component(m.result(), target.component, value, m.world.options))
    else:
        m.set_result(value)


def _element_index(m: Machine, target: s.Variable) -> int:
    if not target.arguments or len(target.arguments) != 1:
        raise Failed(4370, f"{target.name} without one number")
    return expressions.integer(m, target.arguments[0], f"the number of {target.name}")


def _switch_signals(
    m: Machine, node: s.Assign, first: int, width: int, value: int, mask: int = -1
) -> None:
    """Sets outputs; with a time it is a pulse."""
    if node.delay is None:
        m.world.switch(first, width, value, mask)
        return
    before = m.world.read(output=True, first=first, width=width)
    if width != 1:
        raise Unknown("a pulse of a group of signals")
    seconds = float(expressions.plain(m, node.delay, "the time of a pulse"))
    if seconds < 0:
        raise out_of_range("the time of a pulse")
    # The manuals do not state whether such an output is set back afterwards.
    if before == value:
        raise Unknown(
            "`Dly` behind the value that the output has: no manual says whether it is set back"
        )
    m.world.pulse(first, value, before, seconds)


# ------------------------------------------------------------------------------------ jumps


def _run_if(m: Machine, node: s.If) -> None:
    if node.then is None:
        enter_if(m, node)
        return
    met = holds(expressions.value(m, node.condition))
    m.took(0 if met else 1)
    branch = node.then if met else node.otherwise
    if isinstance(branch, s.Target):
        m.jump(branch)
    elif branch is not None:
        execute(m, branch)


def _run_jump(m: Machine, node: s.Jump) -> None:
    if node.keyword == "GoSub":
        m.gosub(node.target)
    else:
        m.jump(node.target)


def _on_jump(m: Machine, node: s.OnJump) -> None:
    which = expressions.integer(m, node.subject, "the place of a jump")
    if not 0 <= which <= _LARGEST_INDEX:
        raise out_of_range(f"the place {which} of a jump")
    passed = not 1 <= which <= len(node.targets)
    m.took(0 if passed else which)
    if passed:
        return
    target = node.targets[which - 1]
    if target is None:
        raise out_of_range(f"the empty place {which} of a jump")
    _run_jump(m, s.Jump(node.keyword, target))


_LARGEST_INDEX: Final = 32767


def _call_subroutine(m: Machine, node: s.Call) -> None:
    if node.function.key in m.world.commands:
        given = node.function.arguments or ()
        arguments = expressions.values(m, given)
        m.world.given(node.function.key, arguments)
    else:
        m.call(node.function)


def _call_program(m: Machine, node: s.CallP) -> None:
    name = text(expressions.value(m, node.program), "the name of a program")
    m.call_program(name, tuple(expressions.value(m, a) for a in node.arguments))


def _take_parameters(m: Machine, node: s.FPrm) -> None:
    if len(node.variables) != len(m.arguments):
        raise Failed(3120, f"{len(m.arguments)} arguments for {len(node.variables)}")
    for variable, value in zip(node.variables, m.arguments, strict=True):
        kind = expressions.reference(m, variable)[0].kind
        wanted = "number" if kind in expressions.NUMBER_KINDS else kind
        if not isinstance(value, Bare) and kind_of(value) != wanted:
            raise Failed(3810, f"an argument for {variable.name} of another type")
        expressions.store(m, variable, value)


# ------------------------------------------------------------------------------ definitions


def _define_constant(m: Machine, node: s.Const) -> None:
    place, index = expressions.reference(m, node.variable)
    place.set(expressions.value(m, node.value), index)


def _define_other(m: Machine, node: s.DefOther) -> None:
    if node.kind.upper() == "ARCH":
        m.world.note("Def Arch has no effect: Mva is not simulated")
        return
    if node.kind.upper() != "PLT":
        raise Unknown(f"Def {node.kind}")
    define_pallet(m, node.arguments)


def _end_function(m: Machine, _: s.Function) -> None:
    """A Function that is run into: the first one of a program is its beginning."""
    block = m.code.functions.get("MAIN")
    if block is None:
        raise Unknown("a program that runs into a Function")
    m.enter_main(block)


_STATEMENT_FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.Motion: _run_motion,
    s.Assign: _assign,
    s.If: _run_if,
    s.ElseIf: skip_rest,
    s.For: begin_for,
    s.Next: next_turn,
    s.Select: choose_case,
    s.Case: skip_rest,
    s.Jump: _run_jump,
    s.OnJump: _on_jump,
    s.CallP: _call_program,
    s.Call: _call_subroutine,
    s.FPrm: _take_parameters,
    s.DefNames: _no_effect,
    s.DefIo: _no_effect,
    s.DefFunction: _no_effect,
    s.DefOther: _define_other,
    s.Dim: _no_effect,
    s.Const: _define_constant,
    s.Static: _no_effect,
    **communication.FILE_FORMS,
    **interrupts.FORMS,
    s.Function: _end_function,
}
