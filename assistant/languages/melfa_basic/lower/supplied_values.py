"""Values of a cell written into programs: position lines, settings, routines and functions.

Position lists get the lines that an export of the controller would have. Commands of the maker's
own become calls of the cell's routines, and functions that a program calls but no file has are
added as the cell has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.source_text import SourceText, ended_lines
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import (
    LAST_SET_PARAMETERS,
    NEUTRAL_SETTINGS,
    parameter_position,
)
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree import walk
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.walk import nodes, program_name
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import configuration_row
from assistant.program.program import Program
from assistant.program.rewriting import rewrite
from assistant.program.undeclared_names import ROUTINES, Supplied, SuppliedValue, Wanted

_RESULT_TYPES: Final = {"num": ("M", "0"), "string": ("C", '""'), "": ("V", "")}
"""By the type of what a function gives: its letter, and what it gives until it is written."""
_FUNCTION_END: Final = s.Command("FEnd")
_TYPE_LETTERS: Final = {"num": "M", "string": "C", "position": "P", "joints": "J"}


def _with_supplied_functions(
    tree: s.File,
    wanted: Sequence[tuple[Wanted, SuppliedValue | None]],
    trees: Sequence[s.File],
    dialect: str,
) -> s.File:
    """The tree with functions below its code: those of the cell's files, stops, or empty ones."""
    made: list[s.Item] = []
    for one, value in wanted:
        found = () if value in ROUTINES else _function_of_files(one.name, trees)
        made += found or parse(SourceText(_function_text(one, value)), dialect).items
    code = [at for at, item in enumerate(tree.items) if isinstance(item, s.Entry)]
    ends = [at for at in code if getattr(tree.items[at], "statement", None) == _FUNCTION_END]
    # Functions go below the last one, or else below the code.
    below = (ends or code or [-1])[-1] + 1
    bare = (replace(item, number=None, span=None) for item in made if isinstance(item, s.Line))
    return replace(tree, items=(*tree.items[:below], *bare, *tree.items[below:]))


def _function_text(wanted: Wanted, value: SuppliedValue | None) -> str:
    letter, nothing = _RESULT_TYPES.get(wanted.type, ("M", "0"))
    given = ",".join(
        f"ByVal {_TYPE_LETTERS.get(one.type, 'M')}G{number}"
        for number, one in enumerate(wanted.arguments, 1)
    )
    lines = [f"Function {letter} {wanted.name}({given})"]
    lines += [] if value == "empty" else ["Hlt"]
    lines += [f"{wanted.name}={nothing}"] if nothing else []
    return "\n".join((*lines, "FEnd")) + "\n"


def _function_of_files(name: str, trees: Sequence[s.File]) -> tuple[s.Item, ...]:
    """The lines of a function that a file has."""
    for tree in trees:
        lines = tuple(_function_lines(name.upper(), tree))
        if lines:
            return lines
    return ()


def _function_lines(key: str, tree: s.File) -> Iterator[s.Line]:
    inside = False
    for item in tree.code:
        if not isinstance(item, s.Line):
            continue
        if isinstance(item.statement, s.Function):
            inside = item.statement.name.upper() == key
        if inside:
            yield item
        if item.statement == _FUNCTION_END:
            inside = False


_NO_FLAGS: Final = (0, 0)
_NO_MOUNTS: Final = (Tool(), Frame())


def with_supplied(
    trees: Sequence[s.File], given: Supplied, dialect: str, folder: str
) -> list[s.File]:
    """Return the trees, each with a line for every name that its program requires, and the cell's
    routines.

    folder: given as the location of the routines.
    """
    made = []
    asked = [(one, value) for one, value in given if one.kind == "routine"]
    commands = _supplied_routines(trees)
    routines = {one.name: (one, value) for one, value in asked if one.name in commands}
    others = [(one, value) for one, value in asked if one.name not in commands]
    for at, tree in enumerate(trees):
        before = f"{program_name(tree)}_".lower() if at else ""
        lines = dict[str, str]()
        for wanted, value in given:
            shared = wanted.kind in ("tool", "frame")
            external = wanted.name[1:2] == "_"
            own = external or wanted.name.lower().startswith(before)
            own = own and _is_wanted_by(wanted, tree)
            if value is None or wanted.kind == "routine" or not (shared or own):
                continue
            # The parameter keeps no tool or base at all, so no position has to hold it.
            if wanted.name in LAST_SET_PARAMETERS.values() and value in _NO_MOUNTS:
                continue
            name = wanted.name if external else wanted.name[len(before) :]
            name = parameter_position(wanted.name) if shared else name
            name = walk.supplied_data_name(name) if walk.is_force_state(name.upper()) else name
            lines[name.upper()] = _position_line(name, value)
        there = _with_lines(tree, lines, dialect) if lines else _read_again(tree)
        there = _with_first_settings(there, tree, given) if at == 0 else there
        there = _with_routine_calls(there, routines) if routines else there
        functions = [pair for pair in others if _is_wanted_by(pair[0], tree)]
        made.append(
            _with_supplied_functions(there, functions, trees, dialect) if functions else there
        )
    made += [_routine_tree(one, value, dialect, folder) for one, value in routines.values()]
    return made


def _with_first_settings(tree: s.File, before: s.File, given: Supplied) -> s.File:
    """The tree whose first statement sets the tool and the base that parameters keep.

    before: the same without the lines that it has got.
    """
    values = {one.name: value for one, value in given}
    lines = [  # those that were set before have no place in a text either
        *(item for item in before.items if isinstance(item, s.Line) and item.span is None),
    ]
    lines += [
        s.Line(statement=s.Command(word, (s.Variable(at),)))
        for word, name in LAST_SET_PARAMETERS.items()
        if name in values
        for at in (
            NEUTRAL_SETTINGS[word] if values[name] in _NO_MOUNTS else parameter_position(name),
        )
    ]
    # Declarations stay in front of what acts.
    first = next((n for n, item in enumerate(tree.items) if _is_acting(item)), None)
    if not lines or first is None:
        return tree
    return replace(tree, items=(*tree.items[:first], *lines, *tree.items[first:]))


def without_kept(program: Program, lift: Callable[[Sequence[s.File], Any], Program]) -> Program:
    """A program without the tool and the base that parameters keep: a sister dialect keeps them."""
    origin = program.origin
    if origin is None or not any(_read_again(tree) is not tree for tree in origin.trees):
        return program
    trees = [_without_lines(tree) for tree in origin.trees]
    lifted = lift(trees, origin.robot)
    tables: dict[str, Any] = {
        table: {n: x for n, x in getattr(program, table).items() if n in getattr(lifted, table)}
        for table in ("tools", "frames")
    }
    return replace(lifted, signals=program.signals, entry=program.entry, **tables)


def _without_lines(tree: s.File) -> s.File:
    """A tree as its file has it, without the values of what parameters keep."""
    if _read_again(tree) is tree or tree.source is None:
        return tree
    names = tuple(f"{parameter_position(name)}=" for name in LAST_SET_PARAMETERS.values())
    lines = ended_lines(tree.source.text)
    text = "".join(line for line in lines if not line.startswith(names))
    return parse(replace(tree.source, text=text), tree.dialect)


def _read_again(tree: s.File) -> s.File:
    items = tuple(x for x in tree.items if not isinstance(x, s.Line) or x.span is not None)
    # Lines that were added have no place in the text.
    return tree if len(items) == len(tree.items) else replace(tree, items=items)


def _is_acting(item: s.Item) -> bool:
    """True if a line may have an effect, so that it ends the leading declarations."""
    if not isinstance(item, s.Line):
        return not isinstance(item, s.Data | PositionRows | s.Blank)
    return item.label is not None or not isinstance(item.statement, _DECLARING_STATEMENTS)


_DECLARING_STATEMENTS: Final = (
    type(None), s.Function, s.FPrm, s.Dim, s.DefNames, s.DefIo, s.DefFunction, s.DefOther,
    s.DefAct, s.Include, s.Const, s.Static,
)  # fmt: skip


def _supplied_routines(trees: Sequence[s.File]) -> set[str]:
    """Names of the routines that stand for commands of the maker's own."""
    found = set[str]()
    for tree in trees:
        for item in tree.items:
            for node in nodes(item.statement if isinstance(item, s.Line) else None):
                if isinstance(node, s.Command) and (made := walk.supplied_routine(node)):
                    found.add(made[0])
    return found


def _with_routine_calls(tree: s.File, routines: Mapping[str, object]) -> s.File:
    """Return the tree with calls of the cell's routines in place of vendor commands.

    Its text does not change, so that findings and reports show the original lines.
    """
    turned = {
        node.target.key
        for item in tree.items
        for node in nodes(item.statement if isinstance(item, s.Line) else None)
        # Such a state cannot go through an orientation, which changes its angles.
        if isinstance(node, s.Assign) and _is_no_turn(node.value)
    }

    def said(node: Any) -> Any:
        match node:
            case s.Command():
                routine = walk.supplied_routine(node)
                if routine is not None and routine[0] in routines:
                    return s.CallP(s.String(routine[0].upper()), routine[1])
            case s.Variable() if walk.is_force_state(node.key) and node.key not in turned:
                return replace(node, name=walk.supplied_data_name(node.name))
        return node

    return replace(tree, items=tuple(rewrite(item, said) for item in tree.items))


_STEEPEST_ANGLE: Final = 90.0
"""Degrees below which three angles are read back from an orientation as they were."""


def _is_no_turn(value: s.Expression) -> bool:
    """True if the last three numbers of a constant are not the unique angles of one orientation."""
    match value:
        case s.Constant(values=values):
            return any(abs(v or 0) >= _STEEPEST_ANGLE for v in values[3:6])
    return False


def _routine_tree(wanted: Wanted, value: SuppliedValue | None, dialect: str, folder: str) -> s.File:
    """A program that stops where others come to it, or that does nothing."""
    names = ",".join(f"M{number}" for number, _ in enumerate(wanted.arguments, 1))
    lines = [f"FPrm {names}"] if names else []
    lines += ["End"] if value == "empty" else ["Hlt", "End"]
    text = "\n".join(lines) + "\n"
    return parse(SourceText(text, f"{folder}/{wanted.name.upper()}.prg", newline="\n"), dialect)


def _is_wanted_by(wanted: Wanted, tree: s.File) -> bool:
    program = program_name(tree) or "program"
    return any(use.rpartition(":")[0] == program for use in wanted.uses)


def _position_line(name: str, value: SuppliedValue) -> str:
    match value:
        case Tool():
            return f"{name}={_pose_text(value.tip, _NO_FLAGS)}"
        case Frame():
            return f"{name}={_pose_text(value.pose, _NO_FLAGS)}"
        case Target():
            configuration = np.array([configuration_row(value.configuration)])
            first, second = poses.flags_of(configuration, None)[0].tolist()
            return f"{name}={_pose_text(value.pose, (first, second))}"
        case JointTarget():
            return f"{name}=({','.join(map(_number_text, value.joints))})"
        case str():
            return f'{name}="{value}"'
        case float() | int():
            return f"{name}={_number_text(float(value))}"
    raise AssertionError(value)


def _pose_text(pose: Pose, flags: tuple[int, int]) -> str:
    return f"({','.join(map(_number_text, poses.plain_values(pose)[:6]))})({flags[0]},{flags[1]})"


def _number_text(value: float) -> str:
    return printer.number(s.Number(round(value, 9)))


def _with_lines(tree: s.File, lines: Mapping[str, str], dialect: str) -> s.File:
    """A line without a value gives its place to the one that has it; others stand at the end."""
    source = tree.source or SourceText("")
    text, left = source.text, dict(lines)
    # From the last line to the first, so that the offsets of those in front stay right.
    for item in reversed(tree.items):
        if isinstance(item, s.Data) and item.span is not None and item.variable.key in left:
            if item.variable.arguments is None:
                old = text[item.span.start : item.span.end]
                end = old[len(old.rstrip("\r\n")) :]
                new = left.pop(item.variable.key)
                text = text[: item.span.start] + new + end + text[item.span.end :]
    if left:
        # The last character ends files of old systems.
        text = text.rstrip("\r\n\x1a") + "\n" + "\n".join(left.values()) + "\n"
    return parse(replace(source, text=text), dialect)
