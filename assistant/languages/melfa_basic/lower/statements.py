"""Writers of statements: how each statement of the pseudo-program becomes lines of MELFA-BASIC.

A move is written with the settings that it needs and that do not hold already; a path as rows of
moves. Outputs that a move sets on its way, and what breaks it off, are appended by `Wth` and
`WthIf`. `Def Act 1,M_In(3)=1 GoSub *AC1` leads to lines after the end of the program, which call a
procedure and continue where the program was by `Return 0`. An interrupt of a lower number may come
while one is answered; as none shall, several are shut meanwhile.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Declared
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert.dialect_words import reworded
from assistant.languages.melfa_basic.lower.expressions import (
    Unsayable,
    channel_number,
    signed_number,
)
from assistant.languages.melfa_basic.lower.writer import Writer, marked
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables import poses, variables
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, EMITTED_LINE, Dialect
from assistant.languages.melfa_basic.tables.equivalents import STATEMENT_ROWS, TRIGGER_MEASURES
from assistant.languages.melfa_basic.tables.variables import (
    ALL_INTERRUPTS,
    ARC_START,
    FILE_MODE_WORDS,
    INTERRUPT_NUMBERS,
    MOST_TIMERS,
    line_name,
)
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.text.header import path_note
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MOV, MVR, MVS, MoveRows
from assistant.languages.melfa_basic.tree.control_flow import is_plain_wait, waiting_loop
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines
from assistant.languages.melfa_basic.tree.walk import literal, nodes, timer_variable
from assistant.languages.patterns import Write, Writing
from assistant.languages.runs.paths import setting_codes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called
from assistant.program.geometry import BASE
from assistant.program.motion import Blend, Kind, Path, Speed
from assistant.program.passes.trigger_positions import ZERO, is_at_start, is_steady
from assistant.program.program import Procedure, walk
from assistant.program.rewriting import Body, records

_TIMEOUT_ERROR: Final = 9100
"""The error that a wait ends with when its time is over: the program stops, as RAPID's does."""
_MOST_HANDS: Final = 8


def write_row(w: Writer, node: p.Statement) -> None:
    """A statement that is a row of `tables.statements`."""
    writers: dict[str, Write[s.Expression]] = {
        "value": lambda value, _: w.expressions.of(value),
        "hand": lambda number, _: hand_number(number),
    }
    writing: Writing[s.Expression] = Writing(writers)
    called = STATEMENT_ROWS.write(node, writing)
    if called is None:
        raise Unsayable(f"such a {type(node).__name__}", "say it otherwise")
    w.add(s.Command(called.word, tuple(called.given)))


def hand_number(number: int) -> s.Number:
    if not 1 <= number <= _MOST_HANDS:
        raise Unsayable(f"hand {number}", f"use hands 1 to {_MOST_HANDS}")
    return s.Number(number)


def write_signal_wait(w: Writer, node: p.WaitSignal) -> None:
    condition = s.Binary("=", w.expressions.name(node.signal), w.expressions.of(node.value))
    _write_wait_for(w, condition, node.timeout)


def write_wait(w: Writer, node: p.WaitUntil) -> None:
    _write_wait_for(w, w.expressions.of(node.condition), node.timeout)


def _write_wait_for(w: Writer, condition: s.Expression, timeout: e.Expression | None) -> None:
    if timeout is not None:
        _write_limited_wait(w, condition, timeout)
        return
    if w.dialect.wide_wait or is_plain_wait(condition):
        w.add(s.Command("Wait", (condition,)))
    else:
        w.items += waiting_loop(w.made_label("W"), condition, s.Line())


def _write_limited_wait(w: Writer, condition: s.Expression, timeout: e.Expression) -> None:
    """A wait that ends with an error when its time is over."""
    if not w.names.wait_timer:
        raise Unsayable(f"a time limit beside {MOST_TIMERS} timers", "use fewer timers")
    passed = timer_variable(w.expressions.word(variables.TIMER_WORD), w.names.wait_timer)
    limit = _milliseconds(w, timeout)
    # Below the label: done if the condition holds, again while time is left, else the error.
    label = w.made_label("W")
    w.add(s.Assign(passed, s.Number(0)))
    w.items.append(s.Line(label=label))
    w.add(s.If(condition, s.Target(label + "Z")))
    w.add(s.If(s.Binary("<", passed, limit), s.Target(label)))
    w.add(s.Command("Error", (s.Number(_TIMEOUT_ERROR),)))
    w.items.append(s.Line(label=label + "Z"))


def _milliseconds(w: Writer, seconds: e.Expression) -> s.Expression:
    number = e.plain_number(seconds)
    if number is not None and number < 0:
        raise Unsayable(f"a time limit of {number:g} seconds", "give a positive one")
    if number is not None:
        # The product of 0.0029 and 1000 has binary noise, which the text must not show.
        return signed_number(round(number * variables.MILLISECONDS, 6))
    return s.Binary("*", w.expressions.of(seconds), s.Number(variables.MILLISECONDS))


def write_timer_start(w: Writer, node: p.StartTimer) -> None:
    w.add(s.Assign(w.expressions.timer(node.timer), s.Number(0)))


def write_signal(w: Writer, node: p.SetSignal) -> None:
    pulse = None if node.pulse is None else w.expressions.of(node.pulse)
    w.add(output_assignment(w, node, pulse))


def output_assignment(
    w: Writer, one: p.SetSignal | p.Trigger, pulse: s.Expression | None = None
) -> s.Assign:
    """Return the assignment that gives an output its value."""
    target, value = w.expressions.output(one.signal, w.expressions.of(one.value))
    if pulse is not None and any(x == target for x in nodes(value)):
        raise Unsayable(
            f"a pulse of `{one.signal}`, a group beside other bits of its byte",
            "set it, wait and set it back",
        )
    return s.Assign(target, value, pulse)


def write_open(w: Writer, node: p.Attach) -> None:
    match node.kind, node.place:
        case "line", (e.Number(line),):
            w.add(s.Open(s.String(line_name(int(line))), "", _file_number(w, node.channel)))
        case "file", (place,) if node.mode in FILE_MODE_WORDS:
            name = w.expressions.of(place)
            w.add(s.Open(name, FILE_MODE_WORDS[node.mode], _file_number(w, node.channel)))
        case _:
            raise Unsayable(f"such a channel as `{node.channel}`", "open a line or a file")


def write_close(w: Writer, node: p.Detach) -> None:
    w.add(s.Close((_file_number(w, node.channel),)))


def write_print(w: Writer, node: p.Send) -> None:
    """Write a `Print` with a comma before the first part and semicolons before the others, which
    add nothing.
    """
    marks = (",", *(";" for _ in node.parts))
    values: list[s.Expression | None] = [w.expressions.of(part) for part in node.parts]
    if node.kind == "piece":
        # A trailing semicolon keeps `Print` from ending the line.
        if not values:
            return
        values.append(None)
    w.add(s.Print(_file_number(w, node.channel), tuple(zip(marks, values, strict=False))))


def write_input(w: Writer, target: e.Expression, channel: str) -> None:
    """An item into a variable."""
    w.add(s.Input(_file_number(w, channel), (w.expressions.place(target),)))
    w.changed_place(target)


def _file_number(w: Writer, channel: str) -> s.Number:
    return s.Number(channel_number(w.names, channel))


def write_call(w: Writer, node: p.Call) -> None:
    callee = w.program.procedure(node.procedure)
    if callee is None:
        w.report(rules.MISSING(name=node.procedure))
        return
    arguments = tuple(w.expressions.argument(a) for a in node.arguments)
    if len(arguments) != len(callee.parameters):
        raise Unsayable(
            f"{len(arguments)} arguments for the {len(callee.parameters)} of `{callee.name}`",
            "give one for each parameter",
        )
    if callee.unit != w.unit:
        if callee.unit is None or not w.is_first(callee):
            raise Unsayable(
                f"a call of `{callee.name}` inside another program",
                "let it be the first procedure of its unit",
            )
        w.add(s.CallP(s.String(w.names.units[callee.unit]), arguments))
    elif w.is_first(callee):
        raise Unsayable(f"a call of `{callee.name}` from its own program", "move its body")
    elif w.functions:
        w.add(s.Call(s.Variable(w.names.procedures[callee.name.lower()], "", arguments)))
    elif arguments:
        raise Unsayable(f"the arguments of `{callee.name}`", "use variables instead")
    else:
        w.add(s.Jump("GoSub", s.Target(w.names.procedures[callee.name.lower()])))
    # The procedure may leave other settings active than those that were written last.
    w.forget()


def write_assignment(w: Writer, node: p.Assign) -> None:
    match node.value:
        case e.Apply(function, (e.Text(channel),)) if function in e.TAKING:
            write_input(w, node.target, channel)
            return
    # `Base` takes the robot's place in the frame, which is the inverse of the frame's place.
    if (base := w.changed_frame(node.target)) is not None:
        w.add(s.Assign(base, w.expressions.of(e.inverse(node.value))))
        w.previous = None
        return
    target = w.expressions.place(node.target)
    if poses.is_angle(target.component, w.expressions.robot):
        value = w.expressions.angle(node.value)
    elif isinstance(node.target, e.Member) and node.target.field.lower() in poses.ADDITIONAL:
        value = w.expressions.additional(node.value, node.target.field)
    else:
        value = w.expressions.of(node.value)
    w.add(s.Assign(target, value))
    w.changed_tool(node.target)
    w.changed_place(node.target)


def write_return(w: Writer, node: p.Return) -> None:
    first = w.owner is not None and w.is_first(w.owner)
    if node.value is not None:
        if not w.functions or w.owner is None:
            raise Unsayable("a result of a procedure", "use a variable instead")
        w.add(s.Assign(result_of(w, w.owner), w.expressions.of(node.value)))
        # A Function that ends here returns anyway.
        if node is w.owner.body[-1]:
            return
    if w.functions and not first:
        w.add(s.Command("Exit Function"))
    else:
        w.add(s.Command("End" if first else "Return"))


def result_of(w: Writer, procedure: Procedure) -> s.Variable:
    """Return the variable for a Function's result: its own name."""
    suffix = "$" if procedure.result == "text" else ""
    return s.Variable(w.names.procedures[procedure.name.lower()], suffix)


def write_stop(w: Writer, node: p.Stop) -> None:
    if node.end:
        raise Unsayable("an end for good", "write `Hlt` in a loop")
    write_row(w, node)
    w.previous = None


# ----------------------------------------------------------------------------- branches


_SHORT_STATEMENTS: Final = (
    p.Assign,
    p.SetSignal,
    p.Goto,
    p.Call,
    p.Stop,
    p.Return,
    p.Wait,
    p.Gripper,
)
"""Statements that one line of an `If` may hold."""


def write_if(w: Writer, node: p.If) -> None:
    if w.dialect.blocks:
        _write_if_block(w, node)
    elif not _write_short_if(w, node):
        _write_if_of_jumps(w, node)


def _write_if_block(w: Writer, node: p.If) -> None:
    for i, branch in enumerate(node.branches):
        condition = w.expressions.of(branch.condition)
        w.part(s.If(condition, None) if i == 0 else s.ElseIf(condition), branch.body)
    if node.otherwise:
        w.part(s.Command("Else"), node.otherwise)
    w.part(s.Command("EndIf"))


def _write_short_if(w: Writer, node: p.If) -> bool:
    """Writes an `If` of one short statement, or one for each case; False if it is another."""
    if len(node.branches) != 1:
        return False
    (branch,) = node.branches
    then, otherwise = _short_statement(w, branch.body), _short_statement(w, node.otherwise)
    if then is None or (otherwise is None and node.otherwise):
        return False
    line = s.Line(statement=s.If(w.expressions.of(branch.condition), then, otherwise))
    # A step number of up to five digits comes before the statement; the limit counts bytes.
    if len(printer.line(line, w.dialect.upper).encode()) > EMITTED_LINE - len("32767 "):
        return False
    w.items.append(line)
    w.forget()
    return True


def _short_statement(w: Writer, body: Body) -> s.Statement | s.Target | None:
    """The one statement that a body is, None if it is another."""
    if len(body) != 1 or not isinstance(body[0], _SHORT_STATEMENTS):
        return None
    # Write the statement to see its lines, then take them out again.
    before = len(w.items)
    try:
        w.statement(body[0])
    except Unsayable:
        return None  # found once more where the body is written by itself, at its own place
    finally:
        made, w.items[before:] = w.items[before:], []
    match made:
        case [s.Line(statement=s.Jump("GoTo", target))]:
            return target
        case [s.Line(statement=statement)]:
            return statement
    return None


def _write_if_of_jumps(w: Writer, node: p.If) -> None:
    label = w.made_label("I")
    for i, branch in enumerate(node.branches, start=1):
        condition = w.expressions.of(branch.condition)
        then, following = f"{label}T{i}", f"{label}N{i}"
        w.add(s.If(condition, s.Target(then), s.Target(following)))
        w.label(then)
        w.body(branch.body)
        w.add(s.Jump("GoTo", s.Target(label + "Z")))
        w.label(following)
    w.body(node.otherwise)
    w.label(label + "Z")


def write_switch(w: Writer, node: p.Switch) -> None:
    w.add(s.Select(w.expressions.of(node.subject)))
    for case in node.cases:
        w.part(s.Case(tuple(s.CaseRange(w.expressions.of(v)) for v in case.values)), case.body)
        _write_break(w)
    if node.otherwise:
        w.part(s.Command("Default"), node.otherwise)
        _write_break(w)
    w.part(s.Command("End Select"))


def _write_break(w: Writer) -> None:
    """The word that people end a case with, where there is one."""
    if w.dialect.breaks:
        w.add(s.Command("Break"))


def write_while(w: Writer, node: p.While) -> None:
    w.part(s.Command("While", (w.expressions.of(node.condition),)), node.body)
    w.stand(node.condition)
    w.part(s.Command("WEnd"))


def write_for(w: Writer, node: p.For) -> None:
    short = w.expressions.variable(node.variable)
    if short is None:
        raise Unsayable(f"the loop variable `{node.variable}`", "give it another name")
    variable = s.Variable(short)
    first, last = w.expressions.of(node.first), w.expressions.of(node.last)
    step = None if node.step is None or node.step == p.ONE else w.expressions.of(node.step)
    begin, motion = s.For(variable, first, last, step), _steady_motion(node.body)
    if motion is None:
        w.part(begin, node.body)
        w.part(s.Next((variable,)))
        return
    # Moves under the same settings need these once, before the loop.
    _write_motion_settings(w, motion)
    w.add(begin)
    w.previous = None
    w.body(node.body)
    w.add(s.Next((variable,)))
    w.previous = None


def _steady_motion(body: Body) -> p.Motion | None:
    """The motion of moves that are all of a body, if it is the same for all and stated in
    numbers.
    """
    moves = [one for one in body if isinstance(one, p.Move)]
    if not moves or len(moves) < len(body):
        return None
    motion = moves[0].motion
    fixed = isinstance(motion.speed, Speed) and isinstance(motion.blend, Blend)
    return motion if fixed and all(one.motion == motion for one in moves) else None


# --------------------------------------------------------------------------------- jumps


def write_label(w: Writer, node: p.Label) -> None:
    w.label(_label_target(w, node.name))


def write_goto(w: Writer, node: p.Goto) -> None:
    w.add(s.Jump("GoTo", s.Target(_label_target(w, node.label))))


def _label_target(w: Writer, name: str) -> str:
    owner = w.owner.name.lower() if w.owner else ""
    short = w.names.labels.get((owner, name.lower()))
    if short is None:
        raise Unsayable(f"a jump to `{name}`, which is missing", "add the label")
    return short


_MEASURE_WORDS: Final = {measure: name for name, (measure, _) in TRIGGER_MEASURES.items()}
"""The status variable of each measure that has one."""


def appended_statement(w: Writer, move: p.MoveStatement) -> s.Append | None:
    """`Wth` or `WthIf` for what a move sets on its way or ends at, None if that is nothing."""
    triggers, blend = move.triggers, move.motion.blend
    if move.until is not None:
        if triggers:
            raise Unsayable(
                f"that `{triggers[0].signal}` is set on the way of a move that may be broken off",
                "set it before or behind the move",
            )
        return s.Append(s.Command("Skip"), w.expressions.of(move.until))
    if not triggers:
        return None
    if len(triggers) > 1:
        names = " and ".join(f"`{one.signal}`" for one in triggers)
        raise Unsayable(
            f"that {names} are set on the way of one move, which has one `Wth`",
            "divide the move, or set all but one before or behind it",
        )
    (one,) = triggers
    stops, at = isinstance(blend, Blend) and blend.fine, one.amount
    given = all(isinstance(x, e.Number) for x in (one.value, one.pulse or ZERO))
    steady = isinstance(at, e.Number) or (stops and is_steady(at, w.expressions.signals))
    for what, cure in _unsayable_trigger(one, given and steady):
        raise Unsayable(what, cure)
    pulse = None if one.pulse is None else w.expressions.of(one.pulse)
    assignment = output_assignment(w, one, pulse)
    if is_at_start(one):
        return s.Append(assignment)
    name = _MEASURE_WORDS[one.measure]
    place, operator = s.Variable(w.expressions.word(name)), TRIGGER_MEASURES[name][1]
    return s.Append(assignment, s.Binary(operator, place, w.expressions.of(one.amount)))


def _unsayable_trigger(x: p.Trigger, steady: bool) -> Iterator[tuple[str, str]]:
    """Yield properties of a trigger that `Wth` and `WthIf` cannot express, each with its cure.

    steady: the value that it sets is a number, and so is its place, or the move stops and the place
    stays as it is until then.
    """
    name = f"`{x.signal}`"
    if x.ahead is not None:
        yield f"a delay of what {name} sets on the way", "give the place where it is to be set"
    if x.measure == "time":
        yield f"that {name} is set a time before the end of a move", "give mm before the end"
    if not steady:
        cure = "write numbers, or let the move end with `fine`"
        yield f"what {name} is set to, or where, by more than numbers", cure
    if x.measure == "start" and not is_at_start(x):
        yield (
            f"that {name} is set mm behind the start of a way of unknown length",
            "give mm before the end, or let a move to a known target stand before it",
        )
    if x.measure in _MEASURE_WORDS and x.pulse is not None:
        yield f"a pulse of {name} at a place of the way", "set it there, and back elsewhere"
    if x.measure == "end" and x.amount == ZERO:
        yield (
            f"that {name} is set at the very end of a move that does not stop",
            "end the move with `fine`, or set it some mm before",
        )


def write_move(w: Writer, node: p.Move) -> None:
    target = _move_arguments(w, node.target, node.motion.frame)
    _write_motion_settings(w, node.motion)
    append = appended_statement(w, node)
    w.add(s.Motion("Mov" if node.kind == "joint" else "Mvs", target, append=append))
    _remember_place(w, target, node)


def write_joint_move(w: Writer, node: p.MoveJoints) -> None:
    target = w.expressions.target(node.target)
    _write_motion_settings(w, node.motion)
    w.add(s.Motion("Mov", (target,), append=appended_statement(w, node)))
    w.previous, w.stands = None, _stops(node.motion.blend)


def write_circular_move(w: Writer, node: p.MoveCircular) -> None:
    frame = node.motion.frame
    via, target = w.expressions.target(node.via), w.expressions.target(node.target)
    _check_arc_start(w, node.motion.tool, frame)
    _write_motion_settings(w, node.motion)
    start = _arc_start(w, node.motion.tool, frame)
    points = start, _target_in_frame(w, via, frame), _target_in_frame(w, target, frame)
    w.add(s.Motion("Mvr", points, append=appended_statement(w, node)))
    _remember_place(w, (target,), node)


def write_path(w: Writer, node: p.Follow) -> None:
    path = node.path
    if not len(path):
        raise Unsayable(f"the empty path `{path.name}`", "leave it out")
    segments = list(path_segments(path))
    _check_arcs_of_path(w, path, segments)
    first = w.number
    w.number += len(path)
    w.paths.append((first, path))
    if w.program.origin is None:
        note = path_note(first, first + len(path) - 1, path.name)
        w.items.append(s.Line(comment=marked(p.Comment(note))))
    for start, stop in segments:
        _write_segment(w, path, start, stop, first)
    w.previous, w.stands = None, _stops(path.blends[path.blend[len(path) - 1]])
    if path.kinds[-1] != Kind.VIA:
        last = len(path) - 1
        tool, frame = path.tools[path.tool[last]], path.frames[path.frame[last]]
        w.previous = s.Variable(f"P{first + last}"), tool, frame


def _write_motion_settings(w: Writer, motion: p.Motion) -> None:
    _write_settings(w, motion.speed, motion.blend, motion.tool, motion.frame)


def _write_settings(
    w: Writer,
    speed: Speed | p.ComputedSpeed | e.Name,
    blend: Blend | p.ComputedBlend | e.Name,
    tool: str,
    frame: str,
) -> None:
    """Writes what does not hold already."""
    if isinstance(speed, e.Name) or isinstance(blend, e.Name):
        raise Unsayable("a speed or blend by name", "declare its value")
    w.mount(tool, frame)
    w.move_by(speed, blend)


def _target_in_frame(w: Writer, target: s.Expression, frame: str) -> s.Expression:
    """Return a target in its frame: unchanged where `Base` is the frame, else multiplied by it."""
    if not w.names.products or frame.lower() == BASE:
        return target
    name = w.names.frames.get(frame.lower())
    if name is None:
        raise Unsayable(f"a target in `{frame}`, whose place is not known", "declare the frame")
    return s.Binary("*", s.Variable(name), target)


def _move_arguments(w: Writer, value: e.Expression, frame: str) -> tuple[s.Expression, ...]:
    """Return the arguments of a move; a distance along the tool is a separate argument."""
    match value:
        case e.Apply(function="relative", arguments=(base, x, y, z)) if (
            e.plain_number(x) == 0 and e.plain_number(y) == 0
        ):
            return _target_in_frame(w, w.expressions.target(base), frame), w.expressions.of(z)
    return (_target_in_frame(w, w.expressions.target(value), frame),)


def _remember_place(
    w: Writer, target: tuple[s.Expression, ...], node: p.Move | p.MoveCircular
) -> None:
    """Record the robot's position, if the next arc may name it."""
    w.previous, motion = None, node.motion
    w.stands = _stops(motion.blend)
    if node.until is not None:
        return
    match target:
        case (s.Binary("*", s.Variable(), inner), *_) if (
            _target_in_frame(w, inner, motion.frame) == target[0]
        ):
            target = (inner, *target[1:])
    if len(target) == 2 and (distance := literal(target[1])) is not None:
        # `Mvs P1,-50` leads to P1 moved along the tool.
        along = s.Constant((0.0, 0.0, float(distance), 0.0, 0.0, 0.0))
        target = (s.Binary("*", target[0], along),)
    if len(target) == 1 and _stays(target[0]):
        w.previous = target[0], motion.tool, motion.frame


def _stops(blend: object) -> bool:
    """True if the arm surely stands at the end of a motion with this blend."""
    return isinstance(blend, Blend) and blend.fine


def _stays(place: s.Expression) -> bool:
    """True for a variable, an element of an array, or either moved by numbers."""
    match place:
        # Names whose second character is `_` are external or of the controller, and may change
        # before an arc begins.
        case s.Variable(name=name, arguments=arguments, component=""):
            return name[1:2] != "_" and all(isinstance(x, s.Number) for x in arguments or ())
        case s.Binary("+" | "*", base, s.Constant()):
            return _stays(base)
    return False


def _arc_start(w: Writer, tool: str, frame: str) -> s.Expression:
    """The position that an arc starts at; read from the robot, which stands, if it is not known."""
    _check_arc_start(w, tool, frame)
    if w.previous is not None and w.previous[1:] == (tool, frame):
        return _target_in_frame(w, w.previous[0], frame)
    name = w.owner.name if w.owner else "main"
    w.report(rules.ARC_AT_START(name=name, about=Declared(name, "procedures", in_full=True)))
    start = s.Variable(ARC_START)
    w.add(s.Assign(start, s.Variable(w.expressions.word("P_Curr"))))
    return start


def _check_arc_start(w: Writer, tool: str, frame: str) -> None:
    """Raises Unsayable for an arc whose start is not known and may lie in a corner.

    A controller reads ahead while the arm is in a corner, so that what it reads of the position
    there is any place before the end of the motion: the arm would go back to it.
    """
    if w.stands or (w.previous is not None and w.previous[1:] == (tool, frame)):
        return
    raise _unknown_start()


def _unknown_start() -> Unsayable:
    return Unsayable(
        "an arc whose start is not known, after a motion that may end with a corner",
        "let a straight move that stops (fine) in the same tool and frame stand before the arc",
    )


def _write_segment(w: Writer, path: Path, start: int, stop: int, first: int) -> None:
    """Rows under the same settings."""
    speed, blend = path.speeds[path.speed[start]], path.blends[path.blend[start]]
    tool, frame = path.tools[path.tool[start]], path.frames[path.frame[start]]
    _write_settings(w, speed, blend, tool, frame)
    kinds = path.kinds[start:stop]
    # An arc that begins a segment needs its start, which only the row above can be.
    if kinds[0] == Kind.VIA:
        known = s.Variable(f"P{first + start - 1}")
        if start == 0 or w.previous != (known, tool, frame):
            begin = _arc_start(w, tool, frame)
            numbers = (first + start, first + start + 1)
            ends = (_target_in_frame(w, s.Variable(f"P{n}"), frame) for n in numbers)
            w.add(s.Motion("Mvr", (begin, *ends)))
            start += 2
            kinds = kinds[2:]
    if start < stop:
        rows = _move_rows(kinds, first + start)
        w.items += (
            [rows] if frame.lower() == BASE or not w.names.products else _write_rows(w, rows, frame)
        )
    w.previous = s.Variable(f"P{first + stop - 1}"), tool, frame
    w.stands = _stops(blend)


def _check_arcs_of_path(w: Writer, path: Path, segments: list[tuple[int, int]]) -> None:
    """Raises Unsayable for an arc of a path whose start is not known, before a line is written."""
    for start, _ in segments:
        if path.kinds[start] != Kind.VIA:
            continue
        tool, frame = path.tools[path.tool[start]], path.frames[path.frame[start]]
        if start == 0:
            _check_arc_start(w, tool, frame)
            continue
        last = start - 1
        before = path.tools[path.tool[last]], path.frames[path.frame[last]]
        if before != (tool, frame) and not _stops(path.blends[path.blend[last]]):
            raise _unknown_start()


def _write_rows(w: Writer, rows: MoveRows, frame: str) -> Iterator[s.Line]:
    """Moves in columns as lines, each target in its frame."""
    for line in rows_as_lines(rows):
        if isinstance(line, s.Line) and isinstance(line.statement, s.Motion):
            targets = (
                _target_in_frame(w, a, frame) for a in line.statement.arguments if a is not None
            )
            yield s.Line(statement=replace(line.statement, arguments=tuple(targets)))


def path_segments(path: Path) -> Iterator[tuple[int, int]]:
    """Ranges of rows under the same settings; an arc's two rows are never apart."""
    codes = setting_codes(path)
    differs = (codes[1:] != codes[:-1]) & (path.kinds[1:] != Kind.END)
    edges = [0, *(np.flatnonzero(differs) + 1).tolist(), len(path)]
    yield from itertools.pairwise(edges)


# By number of `Kind`; rows with a point on the way are part of the next row's move.
_ROW_KINDS: Final = np.array([MOV, MVS, -1, MVR], dtype=np.int64)


def _move_rows(kinds: Any, first: int) -> MoveRows:
    """The moves through P<first> … of rows of these kinds; an arc's two rows are one move."""
    ends = np.flatnonzero(kinds != Kind.VIA)
    code = _ROW_KINDS[kinds[ends]]
    number = first + ends.astype(np.int64)
    arc = code == MVR
    return MoveRows(
        "P",
        np.zeros(len(ends), dtype=np.int64),
        code,
        np.where(arc, number - 2, -1),
        np.where(arc, number - 1, -1),
        number,
    )


def interrupt_label(number: int) -> str:
    """Return the label of an interrupt's lines."""
    return f"AC{number}"


def write_interrupt_answers(w: Writer) -> None:
    """The lines that interrupts lead to."""
    shut = len(w.answers) > 1
    for node in w.answers:
        w.label(interrupt_label(w.names.interrupts[node.name.lower()]))
        if shut:
            # An interrupt of a lower number would come in while this one is answered.
            w.add(_act_command(ALL_INTERRUPTS, on=False))
        with w.findings.at(node.span), w.saying():
            write_call(w, node.call)
        if shut:
            w.add(_act_command(ALL_INTERRUPTS, on=True))
        if node.ends is not None:
            with w.findings.at(node.span), w.saying():
                w.add(s.If(w.expressions.of(node.ends), s.Command("End")))
        w.add(s.Command("Return", (s.Number(0),)))
    w.answers.clear()


def _write_interrupt(w: Writer, node: p.Interrupt) -> None:
    if any(isinstance(one, e.Here) for one in records(node.condition)):
        raise Unsayable(
            f"the interrupt `{node.name}`, which asks for the position of the robot",
            "ask for it in the program",
        )
    _check_interrupt(w, node)
    number = _interrupt_number(w, node.name)
    condition = w.expressions.of(node.condition)
    w.add(s.DefAct(s.Number(number), condition, "GoSub", s.Target(interrupt_label(number))))
    w.answers.append(node)


def _check_interrupt(w: Writer, node: p.Interrupt) -> None:
    """Raises Unsayable for what would change how the moves of the program are made."""
    pending, seen = [node.call.procedure.lower()], set[str]()
    while pending:
        procedure = w.program.procedure(pending.pop())
        if procedure is None or procedure.name.lower() in seen:
            continue
        seen.add(procedure.name.lower())
        pending += called(procedure)
        for one in walk(procedure.body):
            if isinstance(one, p.Moving | p.SetOverride | p.SetAcceleration):
                raise Unsayable(
                    f"the interrupt `{node.name}`, which moves the robot or sets how it moves",
                    "set an output or a variable in it, and move where the program asks for that",
                )
            # It would open the interrupts that are shut while this one is answered.
            if isinstance(one, p.SwitchInterrupts):
                raise Unsayable(
                    f"the interrupt `{node.name}`, which switches all interrupts",
                    "switch them one by one",
                )


def _write_switch(w: Writer, node: p.SwitchInterrupt) -> None:
    w.add(_act_command(_interrupt_number(w, node.name), on=node.state == "on"))


def _write_switch_all(w: Writer, node: p.SwitchInterrupts) -> None:
    w.add(_act_command(ALL_INTERRUPTS, on=node.state == "on"))


def _interrupt_number(w: Writer, name: str) -> int:
    number = w.names.interrupts.get(name.lower())
    if number is None:
        if name.lower() not in w.names.defined:
            raise Unsayable(f"the interrupt `{name}`, which nothing defines", "define it")
        raise Unsayable(f"more than {len(INTERRUPT_NUMBERS)} interrupts", "use fewer of them")
    return number


def _act_command(number: int, *, on: bool) -> s.Command:
    return s.Command("Act", (s.Binary("=", s.Number(number), s.Number(int(on))),))


_INTERRUPT_WRITERS: Final[Mapping[type, Callable[[Writer, Any], None]]] = {
    p.Interrupt: _write_interrupt,
    p.SwitchInterrupt: _write_switch,
    p.SwitchInterrupts: _write_switch_all,
}


def write_comment(w: Writer, node: p.Comment) -> None:
    w.items.append(s.Line(comment=marked(node)))


def write_message(_: Writer, node: p.Message) -> None:
    raise Unsayable(f"the message of {len(node.parts)} parts on the teach pendant", "leave it out")


def write_vendor_statement(w: Writer, node: p.Opaque) -> None:
    line = vendor_line(node, w.dialect)
    if line is None or line.statement is None:
        what, cure = f"the {node.language} statement `{node.text}`", "say it in plain statements"
        if node.reason is not None:
            what, cure = f"{what}: {node.reason.why}", node.reason.cure
        raise Unsayable(what, cure)
    w.items.append(line)
    w.forget()


def vendor_line(node: p.Opaque, dialect: Dialect) -> s.Line | None:
    """The line of a vendor statement that this dialect accepts, or has other words for."""
    origin = DIALECTS.get(node.language)
    line = None if origin is None else read_statement(node.text)
    if origin is None or line is None or line.label is not None or line.comment is not None:
        return None
    return line if origin.level <= dialect.level else reworded(line, dialect)


STATEMENTS: Final[dict[type, Callable[[Writer, Any], None]]] = {
    **dict.fromkeys(STATEMENT_ROWS.records, write_row),
    p.Move: write_move,
    p.MoveCircular: write_circular_move,
    p.MoveJoints: write_joint_move,
    p.Follow: write_path,
    p.WaitSignal: write_signal_wait,
    p.WaitUntil: write_wait,
    p.StartTimer: write_timer_start,
    p.SetSignal: write_signal,
    p.Call: write_call,
    p.Assign: write_assignment,
    p.If: write_if,
    p.While: write_while,
    p.For: write_for,
    p.Switch: write_switch,
    p.Stop: write_stop,
    p.Return: write_return,
    p.Comment: write_comment,
    p.Label: write_label,
    p.Goto: write_goto,
    p.Message: write_message,
    p.Attach: write_open,
    p.Detach: write_close,
    p.Send: write_print,
    **_INTERRUPT_WRITERS,
    p.Opaque: write_vendor_statement,
}
