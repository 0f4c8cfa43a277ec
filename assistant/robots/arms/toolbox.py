"""Convert robots from and to roboticstoolbox, which uses metres and radians.

A DHRobot, or a Robot (ERobot) of elementary transforms, becomes a robot in mm and degrees. The
package is an extra, which is imported only when it is used.
"""

from __future__ import annotations

import re
import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, finite_row
from assistant.base.diagnostics import Refused, error, info
from assistant.base.installation import missing_extra
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import METRE, Joint
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.spherical_wrist import Placed, recognise_six_axis
from assistant.robots.robot import Robot, programming_languages, usual_radii

if TYPE_CHECKING:
    from roboticstoolbox import DHRobot
    from roboticstoolbox import Robot as ToolboxRobot


_NEEDS_TOOLBOX: Final = missing_extra(
    "RB003",
    "{purpose} needs roboticstoolbox, which is not installed",
    "toolbox",
)
_COUPLED: Final = error(
    "RB009",
    "a robot of roboticstoolbox has no joint that turns with another, as J3 of {robot} does",
    "take the robot without `coupling`, and add its share of J2 to J3",
)
_TOOLBOX_METRE: Final = 1000.0
"""mm."""


def toolbox_library(purpose: str) -> Any:
    """The module `roboticstoolbox`; raises Refused, naming the extra, if it is missing."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import roboticstoolbox
    except ImportError:
        raise Refused(_NEEDS_TOOLBOX(purpose=purpose), exit_status=2) from None
    return roboticstoolbox


def to_rtb(robot: Robot) -> DHRobot | ToolboxRobot:
    """See `Robot.to_rtb`."""
    if robot.coupling:
        raise Refused(_COUPLED(robot=robot.name))
    toolbox = toolbox_library("a robot of roboticstoolbox")
    zero = np.where(robot.sliding, robot.zero / _TOOLBOX_METRE, np.radians(robot.zero))
    limits = robot.limits * np.where(robot.sliding, 1.0 / _TOOLBOX_METRE, np.radians(1.0))[:, None]
    links = robot.arm.links()
    if not links:
        arm = robot.arm.chain if isinstance(robot.arm, Placed) else robot.arm
        assert isinstance(arm, Serial)
        name = {"name": robot.title, "manufacturer": robot.maker}
        return toolbox.Robot(arm.chain.elementary(zero, limits), **name)
    rows = []
    for link, at, qlim in zip(links, zero, limits, strict=True):
        a, d = link.a / _TOOLBOX_METRE, link.d / _TOOLBOX_METRE
        if link.sliding:
            row = toolbox.PrismaticDH(
                theta=link.theta, a=a, alpha=link.alpha, offset=d + at, qlim=qlim
            )
        else:
            row = toolbox.RevoluteDH(d=d, a=a, alpha=link.alpha, offset=link.theta + at, qlim=qlim)
        rows.append(row)
    return toolbox.DHRobot(rows, name=robot.title, manufacturer=robot.maker)


_NO_CHAIN: Final = error(
    "RB010",
    "`{name}` of roboticstoolbox cannot be taken over: {reason}",
    "give a DHRobot or a Robot with one chain of joints, each with limits, and a speed for each",
)
_ASSUMED: Final = info(
    "RB011",
    "`{name}` of roboticstoolbox does not say everything: maker's counting, languages and payload "
    "are assumed{rest}",
    "write a robot file with what you know better",
)
_NOT_IN_NAMES: Final = re.compile(r"[^A-Za-z0-9_.-]+")
AXES: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_FLANGES_AGREE: Final = 1e-9
"""m, and of a cosine, by which forward kinematics of both may differ."""
_MOST_AXES: Final = 32


def from_rtb(arm: DHRobot | ToolboxRobot, speeds: ArrayLike) -> Robot:
    """A robot of roboticstoolbox as one of ours, in mm and degrees, its base and tool counted in.

    speeds: (a,) of the axes, deg/s, of one that slides mm/s: roboticstoolbox has none. Six axes
    with a spherical wrist get the closed form, other chains are solved numerically. Raises Refused
    for what is no chain of joints with limits, and for one that ours does not agree with.
    """
    name = _robot_name(getattr(arm, "name", ""))

    def refused(reason: str) -> Refused:
        return Refused(_NO_CHAIN(name=name, reason=reason), exit_status=2)

    try:
        ets, qlim = arm.ets(), np.asarray(arm.qlim, dtype=np.float64)
        parts = list(ets)
    except (AttributeError, TypeError, ValueError) as problem:
        raise refused(str(problem) or "it has no single chain") from None
    count = sum(1 for part in parts if part.isjoint)
    if not 1 <= count <= _MOST_AXES or qlim.shape != (2, count) or not np.isfinite(qlim).all():
        raise refused(f"it has {count} joints, with limits of shape {qlim.shape}")
    fast = finite_row(speeds, "speeds")
    if fast.shape != (count,) or not (fast > 0.0).all() or not np.isfinite(fast).all():
        raise refused(f"{count} speeds above 0 are wanted")
    chain = _serial(parts, qlim, *_ends(arm, ets, qlim))
    known = recognise_six_axis(chain) or chain
    made = _robot(arm, name, known, qlim, fast)
    _refuse_unlike(arm, made, qlim, refused)
    return made


def _ends(arm: Any, ets: Any, qlim: Floats) -> tuple[Floats, Floats]:
    """Base and tool as matrices, where the transforms do not have them: those of a DHRobot do."""
    middle = qlim.mean(axis=0)
    if np.allclose(arm.fkine(middle).A, ets.fkine(middle).A, rtol=0.0, atol=_FLANGES_AGREE):
        return np.eye(4), np.eye(4)
    base, tool = (np.asarray(one.A, dtype=np.float64) for one in (arm.base, arm.tool))
    return base, tool


def _serial(parts: list[Any], qlim: Floats, base: Floats, tool: Floats) -> Serial:
    joints: list[Joint] = []
    before = _pose(base)
    for part in parts:
        if not part.isjoint:
            before = before @ _pose(np.asarray(part.A(), dtype=np.float64))
            continue
        kind = part.kind if hasattr(part, "kind") else part.axis  # as it was until 1.4
        sliding = kind[0] == "t"
        low, high = qlim[:, len(joints)] * (METRE if sliding else 1.0)
        x, y, z = AXES[kind[-1].lower()]
        way = -1.0 if part.isflip else 1.0
        joints.append(Joint(before, (way * x, way * y, way * z), sliding, float(low), float(high)))
        before = IDENTITY
    return Serial(tuple(joints), before @ _pose(tool))


def _robot(arm: Any, name: str, known: Any, qlim: Floats, speeds: Floats) -> Robot:
    units = np.where(known.sliding, METRE, np.degrees(1.0))
    limits = qlim.T * units[:, None]
    rest = "; it has no closed form and is solved numerically" if known.kind == Serial.kind else ""
    count = len(known.axes)
    return Robot(
        name=name,
        title=str(arm.name) or name,
        maker=str(getattr(arm, "manufacturer", "")) or "unknown",
        controller="unknown",
        languages=tuple(programming_languages()),
        arm=known,
        zero=np.zeros(count),
        limits=limits,
        speeds=speeds,
        home=np.clip(np.zeros(count), *limits.T),
        tcp_speed=None,
        payload=None,
        reach=max(known.reach, 1.0),
        counts="quadrants",
        source="roboticstoolbox",
        unconfirmed=("maker", "controller", "languages", "configuration", "home"),
        radii=usual_radii(count, known.reach),
        findings=(_ASSUMED(name=name, rest=rest),),
    )


def _refuse_unlike(arm: Any, made: Robot, qlim: Floats, refused: Any) -> None:
    """Both are asked where their flanges are, for a few joints."""
    low, high = qlim
    values = low + np.linspace(0.1, 0.9, 5)[:, None] * (high - low)
    theirs = np.stack([np.asarray(arm.fkine(row).A, dtype=np.float64) for row in values])
    p, q = made.fk(values * np.where(made.sliding, METRE, np.degrees(1.0)))
    off = np.abs(theirs[:, :3, 3] - p / METRE).max()
    turned = np.abs(theirs[:, :3, :3] - rotations.to_matrix(q)).max()
    if not max(off, turned) < _FLANGES_AGREE:
        raise refused("its forward kinematics is not that of its chain")


def _pose(matrix: Floats) -> Pose:
    return Pose.of(matrix[:3, 3] * METRE, rotations.from_matrix(matrix[:3, :3]))


def _robot_name(given: object) -> str:
    """Return a valid robot name, see `robot_file`."""
    return _NOT_IN_NAMES.sub("-", " ".join(str(given).split())).strip("-_.").lower()[:64] or "robot"
