"""What can be seen of a program that is held: its calls inside of one another and their data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from assistant.virtual.events import Place


@dataclass(frozen=True, slots=True)
class Shown:
    """A piece of data. value: as the language writes it. parts: its components or elements."""

    name: str
    value: str
    type: str = ""
    parts: Callable[[], Sequence[Shown]] | None = None


@dataclass(frozen=True, slots=True)
class Level:
    """A call that runs. groups: data by where it is known, worked out when it is asked for."""

    name: str
    place: Place | None
    groups: Mapping[str, Callable[[], Sequence[Shown]]]
