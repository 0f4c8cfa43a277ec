"""Kinds of arms: each with its kinematics, its branches and what is said of them."""

from __future__ import annotations

from assistant.robots.arms.arm import Arm, Link
from assistant.robots.arms.chain import Joint
from assistant.robots.arms.five_axis import FiveAxis
from assistant.robots.arms.lengths import Lengths
from assistant.robots.arms.placed import Placed
from assistant.robots.arms.scara import Scara
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.six_axis import SixAxis

__all__ = ["Arm", "FiveAxis", "Joint", "Lengths", "Link", "Placed", "Scara", "Serial", "SixAxis"]
