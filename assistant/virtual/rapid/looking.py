"""Routines that run and their data, for who looks at a program that is held."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from assistant.virtual.kernel.looking import Level, Shown
from assistant.virtual.rapid.machine import Machine, place_of
from assistant.virtual.rapid.scopes import Cell, Frame, Meaning, Place
from assistant.virtual.rapid.values import (
    Array,
    Clock,
    Handle,
    Record,
    Shape,
    Trigger,
    Value,
    text_of,
)


def call_levels(machine: Machine) -> list[Level]:
    """The routines that run, the innermost first."""
    at, found = machine.at, []
    for frame in reversed(machine.frames):
        if frame.routine is not None:
            found.append(Level(frame.routine.name, place_of(at), _data_groups(machine, frame)))
        at = frame.called_at
    return found


def _data_groups(machine: Machine, frame: Frame) -> Mapping[str, Callable[[], Sequence[Shown]]]:
    return {
        "Routine": lambda: list(_shown_data(frame.names)),
        "Module": lambda: list(_shown_data(frame.unit.names)),
        "Task": lambda: list(_shown_data(machine.named)),
    }


def _shown_data(names: Mapping[str, Meaning]) -> Iterator[Shown]:
    for name, meaning in names.items():
        match meaning:
            case Cell(shape=shape, value=value):
                yield _shown_value(name, value, shape)
            case Place(holder=holder, shape=shape):
                known = holder.value is not None if isinstance(holder, Cell) else True
                yield _shown_value(name, meaning.get() if known else None, shape)


def _shown_value(name: str, value: Value | None, shape: Shape) -> Shown:
    kind = shape.type + "".join(f"{{{size}}}" for size in shape.sizes)
    match value:
        case None:
            return Shown(name, "", kind)
        case Record(parts=parts):
            inside = [_shown_value(key, part, Shape("")) for key, part in parts.items()]
        case Array(items):
            inside = [
                _shown_value(f"{{{i}}}", item, shape.element) for i, item in enumerate(items, 1)
            ]
        case Clock() | Trigger() | Handle():
            return Shown(name, f"<{kind}>", kind)
        case _:
            return Shown(name, text_of(value), kind)
    return Shown(name, _value_text(value), kind, lambda: inside)


def _value_text(value: Value) -> str:
    """As ValToStr writes it; of what that cannot write, that it is one."""
    try:
        return text_of(value)
    except ValueError:
        return "<no value>"
