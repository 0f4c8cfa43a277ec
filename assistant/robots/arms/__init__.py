"""Kinds of arms: each with its kinematics, its branches and what is said of them."""

from __future__ import annotations

from assistant.robots.arms.arm import Arm, Link
from assistant.robots.arms.five_axis import FiveAxis
from assistant.robots.arms.lengths import Lengths
from assistant.robots.arms.scara import Scara
from assistant.robots.arms.six_axis import SixAxis

__all__ = ["Arm", "FiveAxis", "Lengths", "Link", "Scara", "SixAxis"]
