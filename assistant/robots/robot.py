"""Robots: the arm, its limits, and the flange poses of its joints.

Joints are the maker's own, degrees or mm of an axis that slides; `Robot.zero` leads to the chain
values of `arms`. `Outlines` hold the shapes and mesh file names that a robot file states for its
links; no mesh is opened here. Traits of controllers, by programming language, are data in
`programming.toml`, which explains each key.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cache, cached_property
from importlib.resources import files
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.arrays import (
    Floats,
    Ints,
    Rows,
    Truths,
    all_of,
    finite_rows,
    norms,
    require_same_length,
    rows_of,
    whole_rows,
)
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.lazy import drawing_of, pictured
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.program.motion import UNSTATED
from assistant.program.program import Program
from assistant.program.se3 import METRE, AnyPose, AnyPoses, Unit, columns_of, pose_of
from assistant.robots.arms.arm import BOUNDARY, CLOSING, Arm
from assistant.robots.arms.closed_form import FiveAxis, Lengths, SixAxis
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.spherical_wrist import Placed
from assistant.robots.configurations import BACK, QUADRANTS, TURNING_AXES
from assistant.robots.motion.rounding_tolerance import (
    RoundedPoses,
    joints_within_rounding,
    roundings,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from roboticstoolbox import DHRobot
    from roboticstoolbox import Robot as ToolboxRobot


JointUnit = Literal["rad", "deg"]
"""Radians, and m of an axis that slides; or degrees, and mm."""
_LENGTHS: Final[Mapping[JointUnit, Unit]] = {"rad": "m", "deg": "mm"}
"""Unit of the lengths that go with joints in radians, as in roboticstoolbox, and in degrees."""
_NO_JOINT_UNIT: Final = error(
    "RB012",
    "{reason}",
    'write unit="deg" (mm of an axis that slides) or unit="rad" (m)',
)
_NO_ROBOT: Final = error(
    "RB013",
    "{given} is not a Robot",
    "give what assistant.robots.get({name}) returns, or assistant.robots.load of a robot file",
)
_NO_PROGRAM: Final = error(
    "RB014",
    "{given} is not a Program",
    "give what assistant.from_poses or from_joints returns, or the program of assistant.load",
)
Kind = Literal["box", "sphere", "cylinder", "capsule", "mesh"]


@dataclass(frozen=True, slots=True)
class Outline:
    """A shape of a link.

    carrier: `base`, `J1` … or `flange`; pose: in its frame, see `Robot.link_frames`. sizes: mm; of
    a box its edges, of a sphere its radius, of a cylinder and a capsule radius and length (of the
    capsule between its half spheres). file: of a mesh in metres, as the robot's file names it, and
    scale, by which its coordinates are multiplied.
    """

    link: str
    carrier: str
    pose: Pose
    kind: Kind
    sizes: tuple[float, ...] = ()
    file: str = ""
    scale: Vector = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Outlines:
    """Shapes of the links of a robot.

    folder: base of the relative names of files. wrong: findings for invalid shapes. still: joints
    that move, but are not axes of the arm, so that the links on them are placed with these joints
    at 0.
    """

    shapes: tuple[Outline, ...]
    folder: str
    wrong: tuple[Diagnostic, ...] = ()
    still: tuple[str, ...] = ()


LIMIT_TOLERANCE: Final = 1e-6
"""degrees or mm by which a joint may pass its limit: rounding, no motion."""
_QUADRANT_TOLERANCE: Final = 1.0
"""degrees by which a joint may leave the quadrant that a target states: taught positions
are rounded, and near a singularity a rounded position turns the wrist by that much."""
CHUNK: Final = 16384
"""Rows that are computed at once: the columns stay in the processor's cache."""


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot of the catalogue, or one of the user's.

    Joints are degrees, of an axis that slides (J3 of a SCARA) mm.

    arm: its kind with its lengths. zero: (a,) of the arm's chain where the maker's joint is 0.
    limits: (a, 2). speeds: (a,) a second. home: (a,). tcp_speed: mm/s at most,
    None if not known. payload: kg, None if not known.
    accelerations: (a,) a second squared, None if no source states them. repeatability: mm, or None.
    time_to_speed: seconds that an axis takes to its full speed with up to `light` kg, or None.
    reach: mm from axis 1 to the wrist centre of the stretched arm.
    counts: form in which a target's configuration states axes 1, 4 and 6: `quadrants` (ABB) or
    only whole `turns` (Mitsubishi).
    coupling: degrees that axis 3 of the chain turns with one degree of J2; -1 where a parallel
    rod keeps the forearm level, so that the maker counts J3 from the floor and not from the
    upper arm.
    radii: (a + 1,) mm of the capsules for base and links, from the lengths of the arm.
    outlines: shapes of its links from its file, None if the file has none.
    unconfirmed: fields whose figures no available source confirms.
    findings: assumptions for values that are missing in the file that it was read from.
    """

    name: str
    title: str
    maker: str
    controller: str
    languages: tuple[str, ...]
    arm: Arm
    zero: Floats
    limits: Floats
    speeds: Floats
    home: Floats
    tcp_speed: float | None
    payload: float | None
    reach: float
    counts: Literal["quadrants", "turns"]
    source: str
    unconfirmed: tuple[str, ...] = ()
    accelerations: Floats | None = None
    repeatability: float | None = None
    time_to_speed: float | None = None
    light: float = 0.0
    coupling: float = 0.0
    radii: Floats = field(default_factory=lambda: np.zeros(0))
    findings: tuple[Diagnostic, ...] = ()
    outlines: Outlines | None = None

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.title}, {len(self.axes)} axes>"

    def _repr_html_(self) -> str:
        return pictured(self)

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the a joints, ("J1", …); a five-axis arm has no "J4"."""
        return self.arm.axes

    @cached_property
    def places(self) -> tuple[int, ...]:
        """(a,) places of the axes among J1, J2, … from 0: (0, 1, 2, 4, 5) without a "J4"."""
        return tuple(int(name[1:]) - 1 for name in self.axes)

    def own_joints(self, joints: Sequence[float]) -> tuple[float, ...]:
        """Return the joints of the robot's axes, out of six of which the others are unset (0 or
        NaN).
        """
        others = [v for i, v in enumerate(joints) if i not in self.places]
        if len(joints) != 6 or len(self.axes) > 6 or any(v > 0.0 or v < 0.0 for v in others):
            return tuple(joints)
        return tuple(joints[i] for i in self.places)

    @property
    def lengths(self) -> Lengths:
        """Link lengths of a vertical arm; raises TypeError for an arm of another kind."""
        if not isinstance(self.arm, SixAxis | FiveAxis | Placed):
            raise TypeError(f"{self.title} has no link lengths of a vertical arm")
        return self.arm.lengths

    @property
    def five_axis(self) -> bool:
        """True if the arm has no axis 4, so that its tool stays in one vertical plane."""
        return isinstance(self.arm, FiveAxis)

    @property
    def branches(self) -> int:
        """Number of arm branches that `ik` returns."""
        return self.arm.branches

    @cached_property
    def sliding(self) -> Truths:
        """(a,) which axes slide: their joints are mm, and have no turns."""
        return self.arm.sliding

    @cached_property
    def units(self) -> tuple[str, ...]:
        """Units (a,) of the joints, as words for a message."""
        return tuple("mm" if slides else "degrees" for slides in self.sliding)

    def fk(self, joints: ArrayLike, *, unit: JointUnit = "deg") -> tuple[Floats, Floats]:
        """(n, a) joints → flange in the base: positions (n, 3) mm, quaternions (n, 4).

        unit: "deg" for degrees, and mm of an axis that slides; "rad" for radians and m. Raises
        Refused for another shape and for numbers that are not finite.
        """
        rows = finite_rows(joints, len(self.axes), "joints")
        return self.flange_poses(rows if unit == "deg" else rows * self._axis_scale(unit))

    def flange_poses(self, joints: ArrayLike) -> tuple[Floats, Floats]:
        """Same as `fk` in degrees, without a check of the numbers: rows of NaN stay NaN."""
        return self.arm.fk(self.chained(joints))

    def ik(
        self,
        poses: AnyPoses,
        quaternions: ArrayLike | None = None,
        *,
        unit: Unit | None = None,
    ) -> tuple[Floats, Truths]:
        """Flange poses → joints (n, b, a) of every arm branch, valid (n, b).

        poses: of any form of `assistant.pose.columns`, or positions (n, 3) with quaternions (n, 4).
        unit: of their positions, needed for SE3, matrices and rows of seven; else mm.

        Valid: forward kinematics comes back to the pose, and every joint is inside its limits. An
        axis that turns further than once is given nearest to the middle of its range; `joints_of`
        finds the other turns. Joints of an invalid branch are NaN if it cannot be reached, else the
        angles that pass the limits.
        """
        if unit is None and quaternions is not None:
            p, q = _poses(poses, quaternions)
        else:
            given = poses if quaternions is None else (poses, quaternions)
            p, q = columns_of(given, unit=unit)
        joints = np.empty((len(p), self.branches, len(self.axes)))
        for start in range(0, len(p), CHUNK):
            rows = slice(start, start + CHUNK)
            found, _ = self.solve(p[rows], q[rows])
            for branch in range(self.branches):
                one = np.ascontiguousarray(found[:, branch].T)
                one[~self.closes(one, p[rows], q[rows])] = np.nan
                joints[rows, branch] = one
        return joints, self.inside(joints)

    def jacobian(
        self, joints: ArrayLike, *, unit: JointUnit | None = None, tool: AnyPose = IDENTITY
    ) -> Floats:
        """Return (n, 6, a) for (n, a) joints: how the tool tip moves and turns with each axis.

        Rows: x, y, z of the tip in the base, and its turn about x, y, z. unit: "deg" for joints in
        degrees, and mm and degrees for each degree of them (mm of an axis that slides); "rad" for
        radians and metres throughout, as `jacob0` of roboticstoolbox. tool: the tip in the flange.
        Raises Refused, also without a unit.
        """
        unit = _known_unit(unit)
        scale = self._axis_scale(unit)
        tip = np.array(pose_of(tool, unit=_LENGTHS[unit], what="tool").position)
        with np.errstate(over="ignore"):  # what is not finite then is refused
            rows = rows_of(joints, len(self.axes), "joints") * scale
        values = self.chained(finite_rows(rows, len(self.axes), "joints"))
        out = self.arm.whole_chain.jacobian(values, tip)
        if self.coupling:  # J2 turns what J3 turns as well
            out[:, :, 1] += self.coupling * out[:, :, 2]
        if unit == "deg":
            out[:, :3, ~self.sliding] *= np.radians(1.0)
            return out
        out[:, :3] /= METRE["m"]
        out[:, :, self.sliding] *= METRE["m"]
        return out

    def manipulability(
        self, joints: ArrayLike, *, unit: JointUnit | None = None, tool: AnyPose = IDENTITY
    ) -> Floats:
        """Return Yoshikawa's measure (n,) of joints (n, a): 0 in a singularity.

        The product of the singular values of the Jacobian in metres and radians, which for six axes
        is `manipulability` of roboticstoolbox. unit: of the joints, as of `jacobian`, which has the
        other arguments too. Raises Refused.
        """
        matrix = self.jacobian(joints, unit=unit, tool=tool)
        if unit == "deg":
            matrix[:, :3] /= METRE["m"]
            matrix[:, 3:] = np.radians(matrix[:, 3:])
            matrix[:] *= self._axis_scale("rad")
        return np.asarray(np.linalg.svd(matrix, compute_uv=False).prod(axis=1))

    def plot(self, joints: ArrayLike | None = None) -> Figure:
        """Return a figure of matplotlib with the links of the arm at joints (n, a), degrees or mm.

        joints: several stand side by side, the last one in full colour; None for home. Show it in a
        notebook, or keep it by its `savefig`. Raises Refused, without the extra
        `plot` too.
        """
        given = self.home if joints is None else joints
        rows = finite_rows(given, len(self.axes), "joints")
        drawn: Figure = drawing_of("Robot.plot")(self, rows)
        return drawn

    def _axis_scale(self, unit: JointUnit) -> Floats:
        """(a,) factors from joints in a unit to degrees and mm; raises Refused."""
        if _known_unit(unit) == "deg":
            return np.ones(len(self.axes))
        return np.where(self.sliding, METRE["m"], np.degrees(1.0))

    def solve(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...] | None = None
    ) -> tuple[Floats, Floats]:
        """Flange poses → joints (a, b, n), unproven, and excess (b, n) mm of the reach.

        branches: of `branch_of`, which to compute; None for all. Each axis is nearest to
        the middle of its range.
        """
        wanted = tuple(range(self.branches)) if branches is None else branches
        joints, excess = self.arm.ik(positions, quaternions, wanted)
        if self._slides:
            joints[~self.sliding] = np.degrees(joints[~self.sliding])
        else:
            np.degrees(joints, out=joints)
        joints -= self.zero[:, None, None]
        self._to_middle(joints)
        if self.coupling:
            joints[2] -= self.coupling * joints[1]
            self._to_middle(joints)
        return joints, excess

    def follow(
        self, joints: Floats, positions: Floats, quaternions: Floats
    ) -> tuple[Floats, Floats]:
        """Joints (m, a) of an arm without named branches, taken along flange poses (m, s, …).

        With the joints (m, s, a) the excess (m, s), as of `solve`.
        """
        assert isinstance(self.arm, Serial)
        found, excess = self.arm.follow(self.chained(joints), positions, quaternions)
        found[..., ~self.sliding] = np.degrees(found[..., ~self.sliding])
        return found - self.zero, excess

    def closes(self, joints: Floats, positions: Floats, quaternions: Floats) -> Truths:
        """(n,) whether forward kinematics of joints (n, a) gives the poses."""
        p, q = self.flange_poses(joints)
        near = norms(p - positions) < CLOSING
        same = np.abs(np.einsum("ij,ij->i", q, quaternions))
        # 1 - cos(half the angle), whose rounding is far below either tolerance.
        return np.asarray(
            near & (1.0 - same < 1.0 - np.cos(np.radians(self.arm.angle) / 2.0) + 1e-14)
        )

    def inside(self, joints: ArrayLike) -> Truths:
        """(..., a) deg → (...,) whether every joint is inside its limits; NaN is not."""
        j = joints
        if type(j) is not np.ndarray or j.dtype != np.float64 or j.shape[-1:] != self.home.shape:
            rows, shape = self._joints(joints), np.shape(joints)
            j = rows.reshape(*(shape if shape == (0,) else shape[:-1]), len(self.axes))
        low, high = self.limits.T
        return np.asarray(
            ((j >= low - LIMIT_TOLERANCE) & (j <= high + LIMIT_TOLERANCE)).all(axis=-1)
        )

    def configuration(self, joints: ArrayLike) -> NDArray[np.int8]:
        """(n, a) joints → (n, 6) neutral configuration columns (see `Path`)."""
        j = self._joints(joints)
        columns = np.zeros((len(j), 6), dtype=np.int8)
        columns[:, : QUADRANTS.start] = self.arm.shape(self.chained(j))
        for column, axis in self.turning():
            columns[:, column] = np.floor((j[:, axis] + BOUNDARY) / 90.0)
            if self.counts == "turns":
                # Turn 0 goes up to 180 and includes it, so 180 is still in quadrant 1.
                half = np.abs(j[:, axis] % 360.0 - 180.0) < BOUNDARY
                columns[half, column] = np.round(j[half, axis] / 90.0) - 1
        return columns

    def joints_of(
        self, positions: ArrayLike, quaternions: ArrayLike, configurations: ArrayLike
    ) -> Floats:
        """Flange poses (n, 3), (n, 4) and configurations (n, 6) → joints (n, a) deg.

        A row is NaN where the pose is out of reach, a joint outside its limits, or the
        quadrants (for `turns`, the turns) are not those that the branch has there, and the
        rounding of the pose does not explain it (see `rounding_tolerance`). An unstated
        configuration gives the branch nearest to home.
        """
        p, q = _poses(positions, quaternions)
        c = whole_rows(configurations, 6, "configurations")
        if len(c) != len(p):
            c = np.tile(c, (len(p), 1)) if len(c) == 1 else c
            require_same_length(p, c, "poses", "configurations")
        joints = np.empty((len(p), len(self.axes)))
        for start in range(0, len(p), CHUNK):
            rows = slice(start, start + CHUNK)
            joints[rows] = self._joints_of(p[rows], q[rows], c[rows])
        return joints

    def branch_of(self, configurations: NDArray[np.integer]) -> Rows:
        """(n, 6) configurations → (n,) index of the branch among those of `ik`."""
        return self.arm.branch(configurations[:, : QUADRANTS.start].astype(np.intp))

    def turned(self, joints: Floats, configurations: NDArray[np.integer]) -> tuple[Floats, Truths]:
        """Joints (n, a) deg, their axes 1, 4 and 6 turned to what configurations (n, 6) say.

        With it (n, 3): whether each lies in the stated quadrant (or turn) or beside it by the
        rounding of a target. Where the turn that lies best is outside the limits, that is the
        one at the other end of the quadrant (or turn).
        """
        out = joints.copy()
        fits = np.ones((len(joints), 3), dtype=bool)
        for column, axis, least, most in self._stated(configurations):
            low, high = self.limits[axis]
            centre, half = (least + most) / 2.0, (most - least) / 2.0
            turned = out[:, axis] + 360.0 * np.round((centre - out[:, axis]) / 360.0)
            beyond = np.where(turned > high + LIMIT_TOLERANCE, -360.0, 0.0)
            beyond[turned < low - LIMIT_TOLERANCE] = 360.0
            other = turned + beyond
            near = np.abs(other - centre) - half <= _QUADRANT_TOLERANCE
            inside = (other >= low - LIMIT_TOLERANCE) & (other <= high + LIMIT_TOLERANCE)
            out[:, axis] = np.where(near & inside, other, turned)
            off = np.abs(out[:, axis] - centre) - half
            fits[:, column - QUADRANTS.start] = off <= _QUADRANT_TOLERANCE
        return out, fits

    def ranges(self, configurations: NDArray[np.integer]) -> tuple[Floats, Floats]:
        """Return the lower and upper limits, (n, a) each, of axes 1, 4 and 6 within the
        configurations (n, 6).

        If limits and configuration exclude each other, the lower limit is greater than the upper
        one.
        """
        low, high = (np.tile(limit, (len(configurations), 1)) for limit in self.limits.T)
        for _, axis, least, most in self._stated(configurations):
            low[:, axis] = np.maximum(low[:, axis], least)
            high[:, axis] = np.minimum(high[:, axis], most)
        return low, high

    def _stated(
        self, configurations: NDArray[np.integer]
    ) -> Iterator[tuple[int, int, Floats, Floats]]:
        """Columns of configurations (n, 6) with their axes, and between which degrees (n,) each
        a joint is in the stated quadrant (or turn).
        """
        for column, axis in self.turning():
            q = configurations[:, column].astype(np.float64)
            if self.counts == "quadrants":
                yield column, axis, 90.0 * q, 90.0 * q + 90.0
            else:
                # Both ends of turn 0 are the same angle: 180 belongs to it, -180 does not.
                centre = 360.0 * np.floor((q + 2.0) / 4.0) + BOUNDARY
                yield column, axis, centre - 180.0, centre + 180.0

    def turning(self) -> tuple[tuple[int, int], ...]:
        """(configuration column, joint index) of the axes whose turns a configuration names."""
        return tuple(
            (QUADRANTS.start + i, self.axes.index(f"J{axis}"))
            for i, axis in enumerate(TURNING_AXES)
            if f"J{axis}" in self.axes
        )

    def winding(self) -> tuple[int, ...]:
        """The axes that may turn further than once: of a named arm those of `turning`."""
        if self.arm.named:
            return tuple(axis for _, axis in self.turning())
        return tuple(int(axis) for axis in np.flatnonzero(~self.sliding))

    def chain(self, joints: ArrayLike) -> Floats:
        """Return the (n, k, 3) mm ends of the links from the base to the flange for (n, a) joints.

        For a vertical arm these are base, axis 2, axis 3, forearm, wrist centre, flange.
        """
        return self.arm.points(self.chained(finite_rows(joints, len(self.axes), "joints")))

    def link_frames(self, joints: ArrayLike) -> tuple[Floats, Floats]:
        """(n, a) joints → the frames of the links behind the axes and of the flange, in the base.

        Their origins (n, a + 1, 3) mm and rotations (n, a + 1, 3, 3). A link's frame lies on its
        axis, where the chain of the arm has it.
        """
        rows = finite_rows(joints, len(self.axes), "joints")
        found = self.arm.whole_chain.along(self.chained(rows))
        return found.origins, found.frames

    def chained(self, joints: ArrayLike) -> Floats:
        """(n, a) joints → values of the arm's chain: radians, mm for an axis that slides."""
        values = self._joints(joints) + self.zero
        if self.coupling:
            values[:, 2] += self.coupling * (values[:, 1] - self.zero[1])
        if not self._slides:
            return np.radians(values)
        values[:, ~self.sliding] = np.radians(values[:, ~self.sliding])
        return values

    def wound(self, joints: Floats) -> Floats:
        """Differences (..., a) of joints, the whole turns of each axis taken out."""
        out = np.asarray(joints - 360.0 * np.round(joints / 360.0))
        if self._slides:
            out[..., self.sliding] = joints[..., self.sliding]
        return out

    def check(self, program: Program) -> tuple[Diagnostic, ...]:
        """Return findings for the parts of a program out of this robot's reach or limits."""
        from assistant.robots.program_solution import configure

        _, findings = configure(program, self)
        return findings

    def to_rtb(self) -> DHRobot | ToolboxRobot:
        """The same robot for roboticstoolbox: metres and radians, joints and limits the maker's.

        A DHRobot; of an arm from a URDF or from links a Robot of elementary transforms.
        Needs the extra `toolbox`; raises Refused without it.
        """
        from assistant.robots.arms.toolbox import to_rtb

        return to_rtb(self)

    def _to_middle(self, joints: Floats) -> None:
        """Turns joints (a, …), in place, by whole turns to the nearest of the middle of limits."""
        turns = joints - self.limits.mean(axis=1)[:, None, None]
        turns *= 1.0 / 360.0
        np.rint(turns, out=turns)
        turns *= 360.0
        if self._slides:
            turns[self.sliding] = 0.0
        joints -= turns

    @cached_property
    def _slides(self) -> bool:
        return bool(self.sliding.any())

    def _joints(self, joints: ArrayLike) -> Floats:
        return rows_of(joints, len(self.axes), "joints")

    def _joints_of(self, p: Floats, q: Floats, c: Ints) -> Floats:
        found, _ = self.solve(p, q)
        rows = np.arange(len(p))
        stated = c[:, BACK] != UNSTATED
        branch = np.where(stated, self.branch_of(c), 0)
        if not stated.all():
            open_ = np.moveaxis(found[:, :, ~stated], 0, -1)
            away = np.abs(open_ - self.home).max(axis=-1)
            branch[~stated] = np.where(self.inside(open_), away, np.inf).argmin(axis=0)
        plain = found[:, branch, rows].T
        turned, fits = self.turned(plain, c)
        joints = np.where(stated[:, None], turned, plain)
        good = self.closes(joints, p, q) & self.inside(joints) & (fits.all(axis=1) | ~stated)
        left = np.flatnonzero(~good & all_of(np.isfinite(p)) & all_of(np.isfinite(q)))
        if len(left) and self.arm.named:
            low, high = self.ranges(c[left])
            low[~stated[left]], high[~stated[left]] = self.limits.T
            rounding = roundings(self, p[left], q[left])
            wanted = RoundedPoses(p[left], q[left], np.zeros((len(left), 3)), rounding)
            given = wanted, branch[left], joints[left], (low, high)
            joints[left], good[left] = joints_within_rounding(self, *given)
        joints[~good] = np.nan
        return joints


def _known_unit(unit: object) -> JointUnit:
    """Return a unit of joints; raise Refused for another one and for None."""
    if isinstance(unit, str) and unit in _LENGTHS:
        return "deg" if unit == "deg" else "rad"
    reason = f"the unit {str(unit)[:40]!r} of joints is not known"
    reason = "nothing says whether the joints are degrees or radians" if unit is None else reason
    raise Refused(_NO_JOINT_UNIT(reason=reason))


def require_robot(robot: object) -> None:
    """Raise Refused for anything but a Robot, such as its name."""
    if not isinstance(robot, Robot):
        name = f'"{robot[:40]}"' if isinstance(robot, str) else "NAME"
        raise Refused(_NO_ROBOT(given=f"`{str(robot)[:40]}`", name=name))


def require_program(program: object) -> None:
    """Raise Refused for anything but a Program, such as its file."""
    if not isinstance(program, Program):
        raise Refused(_NO_PROGRAM(given=f"`{str(program)[:40]}`"))


def usual_radii(axes: int, reach: float) -> Floats:
    """Return (a + 1,) mm of capsules around the base and the links of an arm without measured
    radii.

    Linear in the reach and thicker than the arms of the catalogue look; no drawing was measured.
    """
    share = np.interp(np.linspace(0.0, 1.0, axes + 1), np.linspace(0.0, 1.0, 7), _RADIUS_SHARES)
    more = np.interp(np.linspace(0.0, 1.0, axes + 1), np.linspace(0.0, 1.0, 7), _RADIUS_MARGINS)
    return np.asarray(np.ceil(share * reach + more))


_RADIUS_SHARES: Final = (0.16, 0.15, 0.09, 0.085, 0.075, 0.05, 0.03)
"""Radii as shares of the reach, from base to last link of an arm of six axes."""
_RADIUS_MARGINS: Final = (15.0, 15.0, 18.0, 15.0, 12.0, 14.0, 12.0)
"""mm."""

IN_LINE: Final = 0.05
"""degrees of axis 5 below which the separate angles of axes 4 and 6 have no meaning."""


def _poses(positions: ArrayLike, quaternions: ArrayLike) -> tuple[Floats, Floats]:
    p, q = rows_of(positions, 3, "positions"), rows_of(quaternions, 4, "quaternions")
    require_same_length(p, q, "positions", "quaternions")
    with np.errstate(invalid="ignore", divide="ignore"):
        return p, q / norms(q)[:, None]


Trait = Literal["stops-without-mass", "turning-speed", "names-turns"]
"""A key of `programming.toml`, which says what it means."""


@cache
def _controller_traits() -> Mapping[str, Mapping[Trait, bool]]:
    """Language → its traits."""
    text = files("assistant.robots").joinpath("programming.toml").read_text("utf-8")
    return tomllib.loads(text)


def programming_languages() -> tuple[str, ...]:
    """Every language that a robot may be programmed in."""
    return tuple(_controller_traits())


def has_trait(robot: Robot, trait: Trait) -> bool:
    """True if a controller of the robot has a trait, in any of the robot's languages."""
    return any(
        _controller_traits()[name][trait]
        for name in robot.languages
        if name in _controller_traits()
    )
