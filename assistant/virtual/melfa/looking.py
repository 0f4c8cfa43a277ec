"""Functions and subroutines that run and their data, for who looks at a program that is held."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from assistant.virtual.events import Place
from assistant.virtual.kernel.looking import Level, Shown
from assistant.virtual.melfa.machine import Frame, Machine
from assistant.virtual.melfa.memory import Cell, Memory
from assistant.virtual.melfa.values import (
    COMPONENTS,
    FLAGS,
    JOINTS,
    Bare,
    Elements,
    Joints,
    Position,
    Value,
)
from assistant.virtual.melfa.world import World


def statement_place(world: World) -> Place | None:
    """Of the statement at hand."""
    if not world.running:
        return None
    machine = world.running[-1]
    return machine.code.place(machine.here)


def call_levels(world: World) -> list[Level]:
    """The functions and subroutines that run, of all programs, the innermost first."""
    return [level for machine in reversed(world.running) for level in _program_levels(machine)]


def _program_levels(machine: Machine) -> list[Level]:
    at, found = machine.here, []
    for frame in reversed(machine.frames):
        groups = _data_groups(machine, frame)
        for back in reversed(frame.back):
            found.append(Level("GoSub", machine.code.place(at), groups))
            at = back - 1
        found.append(Level(frame.function or "Main", machine.code.place(at), groups))
        at = frame.called_from
    return found


def _data_groups(machine: Machine, frame: Frame) -> Mapping[str, Callable[[], Sequence[Shown]]]:
    groups = {"Program": lambda: list(_shown_data(machine.main))}
    if frame.function:
        groups = {"Function": lambda: list(_shown_data(frame.memory)), **groups}
    return {**groups, "All programs": lambda: list(_shown_data(machine.world.shared))}


def _shown_data(memory: Memory) -> Iterator[Shown]:
    for name, place in memory.places.items():
        if not isinstance(place, Cell):
            yield _shown_value(name, place.cell.values.get(place.at), place.kind)
        elif place.size:
            size = ",".join(map(str, place.size))
            items = [
                _shown_value(f"({','.join(map(str, index))})", value, place.kind)
                for index, value in sorted(place.values.items())
            ]
            yield Shown(name, f"({size})", place.kind, lambda items=items: items)  # type: ignore[misc]
        else:
            yield _shown_value(name, place.values.get(()), place.kind)


def _shown_value(name: str, value: Value | None, kind: str) -> Shown:
    match value:
        case None:
            return Shown(name, "", kind)
        case Position(values, flags):
            parts = [*_shown_elements(COMPONENTS, values), *_shown_elements(FLAGS, flags)]
        case Joints(values) | Bare(values):
            parts = list(_shown_elements(JOINTS, values))
        case str():
            return Shown(name, f'"{value}"', kind)
        case _:
            return Shown(name, f"{float(value):.10g}", kind)
    text = "(" + ",".join(part.value for part in parts) + ")"
    return Shown(name, text, kind, lambda: parts)


def _shown_elements(
    names: Sequence[str], values: Elements | Sequence[int | None]
) -> Iterator[Shown]:
    for name, value in zip(names, values, strict=True):
        yield Shown(name, "" if value is None else f"{value:.10g}")
