"""Declarations to text and from it: what is above the procedures."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, Literal, cast

from lark import Token, Tree

from assistant.program.program import Parameter, Program, Signal, ValueType, Variable
from assistant.program.pseudo.expressions import (
    blend_text,
    expression_text,
    frame_text,
    joints_text,
    read_blend,
    read_expression,
    read_frame,
    read_joints,
    read_speed,
    read_target,
    read_tool,
    speed_text,
    target_text,
    tool_text,
)
from assistant.program.pseudo.words import (
    Node,
    name_text,
    raw_text,
    read_integer,
    read_name,
    read_word,
    word_text,
)

_Storage = Literal["constant", "variable", "persistent"]
_SignalKind = Literal["digital", "analog", "group"]

# ------------------------------------------------------------------------------------- to text


def header_text(program: Program) -> str:
    """Return the `program` line; the entry `main` is not written."""
    parts = [f"program {name_text(program.name)}"]
    parts += [f"for {word_text(program.robot)}"] if program.robot is not None else []
    if program.entry is None:
        parts.append("without entry")
    elif program.entry != "main":
        parts.append(f"entry {name_text(program.entry)}")
    return " ".join(parts)


def section_lines(program: Program) -> Iterator[list[str]]:
    """The declarations by kind, each kind in the order of its names."""
    for word, field, text in _SECTIONS:
        table = getattr(program, field)
        yield [f"{word} {name_text(n)} {text(table[n])}".rstrip() for n in _ordered(table)]
    yield variable_lines(program.variables)
    yield [line for d in program.declarations for line in opaque_lines(d.language, d.text)]


def variable_lines(variables: Mapping[str, Variable]) -> list[str]:
    return [variable_text(variables[name], name_text(name)) for name in _ordered(variables)]


def opaque_lines(language: str, text: str) -> list[str]:
    """One line, or a block of them for a text of several."""
    head = f"opaque {word_text(language)}"
    if "\n" not in text:
        return [f"{head} {raw_text(text)}" if text else f'{head} ""']
    return [head, *("  " + raw_text(line) for line in text.split("\n")), "end"]


def parameter_text(parameter: Parameter) -> str:
    mode = "inout " if parameter.mode == "inout" else ""
    extents = "[" + "," * (parameter.dimensions - 1) + "]" if parameter.dimensions else ""
    return f"{name_text(parameter.name)} {mode}{parameter.type}{extents}"


def signal_text(signal: Signal) -> str:
    parts: list[str] = [signal.kind, signal.direction]
    parts += [] if signal.number is None else [str(signal.number)]
    parts += [] if signal.bits == 1 else [f"bits {signal.bits}"]
    return " ".join(parts)


def variable_text(variable: Variable, name: str = "") -> str:
    local = "local " if variable.local else ""
    size = "[" + ", ".join(map(str, variable.size)) + "]" if variable.size else ""
    value = "" if variable.initial is None else f" = {expression_text(variable.initial)}"
    named = f"{name} " if name else ""
    return f"{local}{variable.storage} {named}{variable.type}{size}{value}"


def _ordered(table: Mapping[str, object]) -> list[str]:
    """p2 before p10, so that equal tables print equally and read well."""
    return sorted(table, key=lambda n: (_parts(n.lower()), n))


def _parts(name: str) -> list[tuple[int, int, str]]:
    found = re.findall(r"([0-9]{1,18})|([^0-9]+)", name)
    return [(0, int(digits), digits) if digits else (1, 0, letters) for digits, letters in found]


_SECTIONS: Final[tuple[tuple[str, str, Callable[[Any], str]], ...]] = (
    ("tool", "tools", tool_text),
    ("frame", "frames", frame_text),
    ("speed", "speeds", speed_text),
    ("blend", "blends", blend_text),
    ("signal", "signals", signal_text),
    ("target", "targets", target_text),
    ("joints", "joint_targets", joints_text),
)


# ----------------------------------------------------------------------------------- from text


def read_declaration(tree: Node) -> tuple[str, str, object] | None:
    """Table of the program, name, and value; None if the line declares no such thing."""
    found = _READERS.get(tree.data)
    if found is None:
        return None
    field, reader = found
    name, *parts = tree.children
    return field, read_name(cast(Node, name)), reader(*parts)


def read_variable(tree: Node) -> tuple[str, Variable]:
    local, storage, name, type_, size, initial = cast("list[Any]", tree.children)
    extents = () if size is None else tuple(map(read_integer, size.children))
    value = None if initial is None else read_expression(initial)
    kind, kept = cast(ValueType, str(type_)), cast(_Storage, str(storage))
    return read_name(name), Variable(kind, value, extents, kept, local is not None)


def read_header(tree: Node) -> dict[str, str | None]:
    """Name, robot and entry."""
    name, robot, entry, without = cast("list[Any]", tree.children)
    return {
        "name": read_name(name),
        "robot": None if robot is None else read_word(robot),
        "entry": None if without is not None else "main" if entry is None else read_name(entry),
    }


def read_parameters(tree: Node) -> tuple[Parameter, ...]:
    return tuple(_read_parameter(part) for part in tree.children if isinstance(part, Tree))


def _read_parameter(tree: Node) -> Parameter:
    name, mode, type_, extents = tree.children
    return Parameter(
        read_name(cast(Node, name)),
        cast(ValueType, str(type_)),
        "in" if mode is None else "inout",
        0 if extents is None else str(extents).count(",") + 1,
    )


def _read_signal(kind: Token, direction: Token, number: Token | None, bits: Token | None) -> Signal:
    return Signal(
        cast(_SignalKind, str(kind)),
        "input" if direction == "input" else "output",
        None if number is None else read_integer(number),
        1 if bits is None else read_integer(bits),
    )


_READERS: Final[dict[str, tuple[str, Callable[..., object]]]] = {
    "tool": ("tools", read_tool),
    "frame": ("frames", read_frame),
    "named_speed": ("speeds", read_speed),
    "named_blend": ("blends", read_blend),
    "signal": ("signals", _read_signal),
    "named_target": ("targets", read_target),
    "named_joints": ("joint_targets", read_joints),
}
"""Rule → table of the program, and what reads the parts after the name."""
