"""What the steps of adapting share: the program at hand, its motions, tools and targets."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.languages.five_axes import target_in_reach
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, JointTarget, Target
from assistant.program.motion import Blend, Speed
from assistant.program.passes.legalising import Legalising
from assistant.program.passes.motions import joint_percent, meant, without_axes
from assistant.program.path import configuration_of, configuration_row
from assistant.program.subjects import Subject

if TYPE_CHECKING:
    from assistant.robots import Robot

FARTHEST: Final = 1e6
"""mm or degrees; no robot reaches there, and a controller refuses the number."""

NOMINAL_TCP: Final = 5000.0
"""mm/s that 100 percent of joint speed is taken for where no robot is named."""


class Context:
    """What the steps of adapting share."""

    def __init__(
        self,
        job: Legalising,
        dialect: Dialect,
        robot: Robot | None,
        products: bool = False,
    ) -> None:
        self.job, self.program, self.findings = job, job.program, job.findings
        self.five_axis, self.dialect, self.robot = job.can.five_axes, dialect, robot
        self.products = products
        self.unstated = 0
        self.named = 0
        self.constants: dict[str, e.Number] = {}

    def speed(self, speed: Speed | e.Name, joint_move: bool) -> Speed | e.Name:
        """The speed by value, with its percentage for joint moves only."""
        named = isinstance(speed, e.Name)
        speed = meant(speed, self.program.speeds)
        if isinstance(speed, e.Name):
            self.findings.append(rules.UNKNOWN(what="the speed", name=speed.name))
            return Speed(math.inf, joint=1.0) if joint_move else Speed(100.0)
        self.named += named
        speed, parts = without_axes(speed)
        self.findings += [rules.SPEED_PARTS(part=part) for part in parts]
        if not joint_move:
            return replace(speed, joint=None)
        if speed.joint is None:
            known = None if self.robot is None else self.robot.tcp_speed
            percent = joint_percent(speed.tcp, NOMINAL_TCP if known is None else known)
            tcp = "the most" if math.isinf(speed.tcp) else f"{speed.tcp:g}"
            self.findings.append(rules.JOINT_PERCENT(tcp=tcp, percent=percent))
            return Speed(math.inf, joint=percent)
        return Speed(math.inf, joint=min(100.0, max(1.0, speed.joint)))

    def blend(self, blend: Blend | e.Name) -> Blend | e.Name:
        named = isinstance(blend, e.Name)
        blend = meant(blend, self.program.blends)
        if isinstance(blend, e.Name):
            self.findings.append(rules.UNKNOWN(what="the blend", name=blend.name))
            return Blend()
        self.named += named
        if blend.details is not None:
            self.findings.append(rules.BLEND_PARTS())
            blend = replace(blend, details=None)
        if blend.exit is not None and (
            blend.exit == blend.radius or blend.radius is None or math.isinf(blend.radius)
        ):
            blend = replace(blend, exit=None)
        return blend

    def motion(self, motion: p.Motion, joint_move: bool) -> p.Motion:
        tool, frame = self.tool(motion.tool), self.frame(motion.frame)
        speed, blend = self.speed(motion.speed, joint_move), self.blend(motion.blend)
        return p.Motion(speed, blend, tool, frame)

    def tool(self, name: str) -> str:
        return self._named(name, self.program.tools, FLANGE, "the tool")

    def frame(self, name: str) -> str:
        return self._named(name, self.program.frames, BASE, "the frame")

    def _named(self, name: str, given: dict[str, Any], default: str, what: str) -> str:
        if name.lower() == default:
            return default
        known = next((n for n in given if n.lower() == name.lower()), None)
        if known is None:
            self.findings.append(rules.UNKNOWN(what=what, name=name))
        return known or name

    def target(self, name: str, target: Target, about: Subject | str) -> Target:
        numbers = (*target.pose.position, *target.pose.quaternion)
        if not all(math.isfinite(v) and abs(v) < FARTHEST for v in numbers):
            self.findings.append(rules.NOT_FINITE(where=f"the target `{name}`", about=about))
            return target
        if target.configuration is None:
            self.unstated += 1
        row = np.array([configuration_row(target.configuration)], dtype=np.int8)
        configuration = configuration_of(poses.rounded_configurations(row, self.robot)[0])
        if any(v == v for v in target.external[2:]):
            self.job.cannot(
                what=f"external axes beyond the second, of `{name}`",
                cure="leave them out",
                about=about,
            )
        first, second, *_ = (*target.external, math.nan, math.nan)
        if math.isnan(first) and not math.isnan(second):
            self.job.cannot(
                what=f"the second external axis of `{name}` without the first",
                cure="give the first one a value as well",
                about=about,
            )
        if self.five_axis is not None:
            target = target_in_reach(name, target, about, self.five_axis, self.findings)
        return replace(target, configuration=configuration, external=_printed(target.external))

    def joints(self, name: str, target: JointTarget, about: Subject | str) -> JointTarget:
        joints = target.joints
        if self.five_axis is not None and len(joints) == 6:
            fourth = joints[3]
            if fourth == fourth and abs(fourth) > 0.01:
                self.job.cannot(
                    what=f"axis 4 of `{name}` for an arm of five axes", cure="teach it on this arm"
                )
            joints = joints[:3] + joints[4:]
        elif self.robot is not None:
            joints = self.robot.own_joints(joints)
        if self.five_axis is None and any(v != v for v in joints):
            joints = tuple(0.0 if v != v else v for v in joints)
        wanted = 6 if self.robot is None else min(len(self.robot.axes), 6)
        used = tuple(v for v in target.external if v == v)
        if len(joints) != wanted or used != target.external[: len(used)] or len(used) > 2:
            self.job.cannot(
                what=f"the {len(joints)} joints and external axes of `{name}`",
                cure=f"give {wanted} joints and at most two external axes",
                about=about,
            )
        self.finite(f"the joint target `{name}`", (v for v in joints if v == v), about)
        return JointTarget(_printed(joints), _printed(target.external))

    def finite(self, where: str, values: Iterable[float], about: Subject | str) -> None:
        if not all(math.isfinite(v) and abs(v) < FARTHEST for v in values):
            self.findings.append(rules.NOT_FINITE(where=where, about=about))


def _printed(values: Iterable[float]) -> tuple[float, ...]:
    """Joints or external axes with the two decimals that are printed, NaN where there is none."""
    return tuple(round(v, 2) + 0.0 if math.isfinite(v) else v for v in values)
