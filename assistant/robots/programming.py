"""What controllers do with every program, by the languages that they are programmed in."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Literal

from assistant.robots.robot import Robot

Trait = Literal["stops-without-mass", "turning-speed"]
"""A key of `programming.toml`, which says what it means."""


@cache
def controller_traits() -> Mapping[str, Mapping[Trait, bool]]:
    """Language → its traits."""
    text = files("assistant.robots").joinpath("programming.toml").read_text("utf-8")
    return tomllib.loads(text)


def programming_languages() -> tuple[str, ...]:
    """Every language that a robot may be programmed in."""
    return tuple(controller_traits())


def has_trait(robot: Robot, trait: Trait) -> bool:
    """Whether a controller of the robot has a trait, in any of the robot's languages."""
    return any(
        controller_traits()[name][trait] for name in robot.languages if name in controller_traits()
    )
