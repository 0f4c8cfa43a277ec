"""The catalogue: one TOML file a robot, in the folder of this module's name."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path as FilePath

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.source_text import read_bytes
from assistant.robots.robot import Robot
from assistant.robots.robot_file import read

__all__ = ["get", "load", "names", "read"]


def names() -> tuple[str, ...]:
    """The robots of the catalogue, in order of the alphabet."""
    return tuple(sorted(f.name[: -len(".toml")] for f in _folder().iterdir() if _is_robot(f)))


def get(name: str) -> Robot:
    """The robot of that name; raises KeyError, with the names there are, if there is none."""
    known = {n.lower(): n for n in names()}
    if name.lower() not in known:
        raise KeyError(f"no robot {name!r}; there are {', '.join(known.values())}")
    return _of_catalogue(known[name.lower()])


@cache
def _of_catalogue(name: str) -> Robot:
    file = _folder() / f"{name}.toml"
    return read(file.read_bytes(), file.name)


def load(path: str | FilePath) -> Robot:
    """A robot from a file of the user's own; raises Unreadable or Refused."""
    return read(read_bytes(path, most=SETTINGS_FILE), str(path))


def _folder() -> Traversable:
    return files(__package__).joinpath("catalogue")


def _is_robot(file: Traversable) -> bool:
    return file.name.endswith(".toml")
