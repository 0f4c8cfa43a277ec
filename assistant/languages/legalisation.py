"""Legalise a program for one language: passes, positions, and orientations of five-axis arms.

`adapted` runs the passes of a language and reports what its tree still cannot express.
`PartLegaliser` converts positions, joints, tools, frames and loads into numbers that the language
can write: what it cannot write is an error, what it writes otherwise is a finding. For an arm of
five axes, orientations are replaced by the closest reachable ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Declared, Findings, Refused, Subject
from assistant.languages.language import Language
from assistant.languages.language_types import Adapted, Tree
from assistant.program.geometry import (
    BASE,
    FLANGE,
    IDENTITY,
    UNUSED_AXIS,
    Frame,
    JointTarget,
    Load,
    Pose,
    Target,
    Tool,
)
from assistant.program.motion import UNSTATED, Path, configuration_of, configuration_row
from assistant.program.passes.legalisation import (
    Capabilities,
    FiveAxes,
    Legalisation,
    Loads,
    Mounts,
    Pass,
    Positions,
    legalise,
)
from assistant.program.passes.paths import has_half_arcs, with_whole_arcs
from assistant.program.program import Program
from assistant.robots import Robot
from assistant.robots.configurations import BACK

T = TypeVar("T", bound=Tree)


def adapted(
    language: Language[T],
    program: Program,
    can: Capabilities,
    passes: Sequence[Pass],
    robot: Robot | None = None,
) -> Adapted:
    """The program after all passes; what its tree cannot be built of even then is an error.

    For a language whose programs are one unit.
    """
    findings = Findings()
    program = legalise(Legalisation(program, can, findings), passes)
    trees: dict[str | None, T] = {}
    try:
        # Building shows what the passes could not make expressible; the tree is kept for the
        # caller.
        trees[None] = language.build(program, robot)
    except Refused as refused:
        findings += refused.findings
    # Several passes may report the same fault.
    return Adapted(program, tuple(dict.fromkeys(findings)), trees)


_ORIENTATION_TOLERANCE: Final = 0.05
"""degrees by which an orientation may leave what five axes reach."""
_EQUAL_ORIENTATION: Final = 1e-6
"""degrees below which it is reached as it is."""
_VERTICAL: Final = 1e-4
"""Sine of the tool's tilt below which it counts as straight up or down."""


def _over_the_back(
    positions: Floats,
    quaternions: Floats,
    configurations: NDArray[np.int8],
) -> Truths:
    """Which poses a five-axis arm takes over its back with a tool that is not vertical (n,).

    Their A and B depend on axis 1, which no source says of this branch; straight down both
    branches show the same.
    """
    # Kinematics are loaded for five-axis arms only.
    from assistant.robots.arms import closed_form

    tilt = closed_form.to_ab(positions, quaternions)[:, 1]
    tilted = np.abs(np.sin(np.radians(tilt))) > _VERTICAL
    return np.asarray((configurations[:, BACK] == 1) & tilted)


def _target_in_reach(
    name: str, target: Target, about: Subject | str, can: FiveAxes, findings: Findings
) -> Target:
    """A target with the orientation that is reached at its position."""
    positions, quaternions = np.array([target.pose.position]), np.array([target.pose.quaternion])
    row = np.array([configuration_row(target.configuration)], dtype=np.int8)
    if _over_the_back(positions, quaternions, row)[0]:
        findings.append(can.over_the_back(name=name, about=about))
    (angle,) = miss = _orientation_error(positions, quaternions)
    if angle > _ORIENTATION_TOLERANCE:
        findings.append(can.unreachable(name=name, angle=float(angle), about=about))
    # An orientation that is reached already keeps its digits.
    if angle <= _EQUAL_ORIENTATION:
        return target
    w, x, y, z = (float(v) for v in _reached_orientations(positions, quaternions, miss)[0])
    return replace(target, pose=replace(target.pose, quaternion=(w, x, y, z)))


def _path_in_reach(path: Path, can: FiveAxes, findings: Findings) -> Path:
    """A path with the orientations that are reached at its positions."""
    behind = _over_the_back(path.positions, path.quaternions, path.configurations)
    if behind.any():
        place = f"{int(behind.sum())} targets of {path.name}"
        name = f"{path.name}_{int(behind.argmax()) + 1}"
        findings.append(can.over_the_back(name=name, place=place))
    miss = _orientation_error(path.positions, path.quaternions)
    if far := int(np.count_nonzero(miss > _ORIENTATION_TOLERANCE)):
        worst = int(np.argmax(miss))
        name, place = f"{path.name}_{worst + 1}", f"{far} targets of {path.name}"
        findings.append(can.unreachable(name=name, angle=float(miss[worst]), place=place))
    if not (miss > _EQUAL_ORIENTATION).any():
        return path
    return replace(path, quaternions=_reached_orientations(path.positions, path.quaternions, miss))


def _orientation_error(positions: Floats, quaternions: Floats) -> Floats:
    from assistant.robots.arms import closed_form

    return closed_form.plane_miss(positions, quaternions)


def _reached_orientations(positions: Floats, quaternions: Floats, miss: Floats) -> Floats:
    """The orientations, those that are missed exchanged for what is reached there."""
    from assistant.robots.arms import closed_form

    off, made = miss > _EQUAL_ORIENTATION, quaternions.copy()
    ab = closed_form.to_ab(positions[off], quaternions[off])
    made[off] = closed_form.from_ab(positions[off], ab)
    return made


_ORDINALS: Final = ("first", "second", "third", "fourth", "fifth", "sixth")
_COUNTS: Final = ("no", "one", "two", "three", "four", "five", "six")
_AXIS_4: Final = 3
"""Index of axis 4 among six joints: an arm of five axes has none."""
_NEGLIGIBLE: Final = 0.01
"""mm or degrees: a smaller value of the axis, or offset of a tool from its axis, counts as zero."""
_LEAST_NORM: Final = 0.5
"""A quaternion that is shorter is no orientation."""


class PartLegaliser:
    """Parts of a program as a language writes them. unstated: targets without an arm branch."""

    def __init__(self, job: Legalisation, can: Positions) -> None:
        self.job, self.can, self.five_axes = job, can, job.can.five_axes
        self.unstated = 0

    def targets(self, given: Mapping[str, Target]) -> dict[str, Target]:
        return {n: self.target(one, n, Declared(n, "targets")) for n, one in given.items()}

    def joint_targets(self, given: Mapping[str, JointTarget]) -> dict[str, JointTarget]:
        return {n: self.joints(one, n, Declared(n, "joint_targets")) for n, one in given.items()}

    def target(self, target: Target, name: str, about: Subject | str) -> Target:
        """With an arm branch; name: of the target in findings, or what it is."""
        pose = self.pose(target.pose, f"the target `{name}`", about)
        if pose is None:
            return target
        target = replace(target, pose=pose)
        row = np.array([configuration_row(target.configuration)], dtype=np.int8)
        (branch,) = self._branches(row, about)
        self._check_external(np.array([target.external]), name, about)
        if self.five_axes is not None:
            target = _target_in_reach(name, target, about, self.five_axes, self.job.findings)
        external = self.external(target.external)
        return replace(target, configuration=configuration_of(branch), external=external)

    def path(self, path: Path) -> Path:
        """With arm branches, and arcs that are whole."""
        wild = np.flatnonzero(self._wild(path.positions, path.quaternions))
        if len(wild):
            where, about = f"`{path.name}_{wild[0] + 1}`", Declared(path.name, "paths")
            self.job.findings.append(self.can.not_finite(what=where, about=about))
            return path
        if has_half_arcs(path):
            self.job.cannot(f"half an arc in `{path.name}`", "give each arc a via point and an end")
            return path
        self._check_external(path.external, path.name)
        path = with_whole_arcs(path)
        unstated = int(np.count_nonzero(path.configurations[:, 0] == UNSTATED))
        branches = self._branches(path.configurations, f"{unstated} targets of `{path.name}`")
        if self.five_axes is not None:
            path = _path_in_reach(path, self.five_axes, self.job.findings)
        if self.can.quaternions:
            path = replace(path, quaternions=rotations.canonical(path.quaternions))
        if not np.isnan(path.external).all():
            # Adding 0.0 turns -0.0 into 0.0, which is printed without a sign.
            external = np.round(path.external, self.can.decimals) + 0.0
            external[external >= self.can.unused] = UNUSED_AXIS
            path = replace(path, external=external)
        return replace(path, configurations=branches)

    def joints(self, target: JointTarget, name: str, about: Subject | str) -> JointTarget:
        """With the joints that the arm has; name: see `target`."""
        joints, can = target.joints, self.can
        if self.five_axes is not None and len(joints) == can.joints + 1:
            if abs(joints[_AXIS_4]) > _NEGLIGIBLE:
                what = f"axis 4 of `{name}` for an arm of five axes"
                self.job.cannot(what, "teach it on this arm")
            # Six-axis sources have axis 4 where a five-axis arm has none.
            joints = joints[:_AXIS_4] + joints[_AXIS_4 + 1 :]
        joints = can.own(joints)
        missing = max(0, can.joints - len(joints)) if can.padded else 0
        # A joint that is not stated is NaN, which differs from itself.
        if missing or any(v != v for v in joints):
            told = "a joint that is not stated", "0 degrees", "state every joint"
            self.job.changed(*told, about)
            joints = tuple(0.0 if v != v else v for v in joints) + (0.0,) * missing
        used = tuple(v for v in target.external if v == v)
        uneven = can.external is not None and (
            # Axes have to be used from the first on, without a gap.
            used != target.external[: len(used)] or len(used) > can.external
        )
        if len(joints) != can.joints or uneven:
            most = _COUNTS[len(_COUNTS) - 1 if can.external is None else can.external]
            self.job.cannot(
                what=f"the {len(joints)} joints and external axes of `{name}`",
                cure=f"give {can.joints} joints and at most {most} external axes",
                about=about,
            )
        # Written as a negation, so that NaN is refused too.
        if not all(abs(v) < can.farthest for v in joints):
            what = f"the joint target `{name}`"
            self.job.findings.append(can.not_finite(what=what, about=about))
        return JointTarget(self._rounded(joints), self.external(target.external))

    def external(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """External axes as they are printed, NaN for an unused one."""
        unused = self.can.unused
        return self._rounded(UNUSED_AXIS if v >= unused else v for v in values)

    def pose(self, pose: Pose, what: str, about: Subject | str | None = None) -> Pose | None:
        """With the one quaternion that it is written with; None if it holds what is no number."""
        if self._wild(np.array([pose.position]), np.array([pose.quaternion]))[0]:
            self.job.findings.append(self.can.not_finite(what=what, about=about))
            return None
        if not self.can.quaternions:
            return pose
        return Pose.of(np.array(pose.position), rotations.canonical(np.array(pose.quaternion)))

    def _wild(self, positions: Floats, quaternions: Floats) -> Truths:
        """True for poses (n,) with an invalid or too large number, or without an orientation."""
        numbers = np.concatenate([positions, quaternions], axis=1)
        # Comparisons with NaN are false, so an invalid number is not tame.
        tame = (np.abs(numbers) < self.can.farthest).all(axis=1)
        squared = np.einsum("ij,ij->i", quaternions, quaternions)
        return np.asarray(~(tame & (squared > _LEAST_NORM**2)))

    def _branches(self, rows: NDArray[np.int8], about: Subject | str) -> NDArray[np.int8]:
        """Arm branches as they are written. about: the targets, where some state none."""
        count = int(np.count_nonzero(rows[:, 0] == UNSTATED))
        self.unstated += count
        if count and self.can.unstated is not None:
            self.job.findings.append(self.can.unstated(about=about))
        return self.can.branches(rows)

    def _check_external(
        self, external: Floats, name: str, about: Subject | str | None = None
    ) -> None:
        """Errors where targets have more external axes than there may be, or not the same."""
        most = self.can.external
        if most is None:
            return
        used = ~np.isnan(external)
        if used[:, most:].any():
            beyond = f"external axes beyond the {_ORDINALS[most - 1]}, of `{name}`"
            self.job.cannot(beyond, "leave them out", about)
        used = used[:, :most]
        # An axis that is used while the one before it is not.
        late = (used[:, 1:] & ~used[:, :-1]).any(axis=0)
        if len(used) == 1 and late.any():
            at = int(np.flatnonzero(late)[0])
            self.job.cannot(
                f"the {_ORDINALS[at + 1]} external axis of `{name}` without the {_ORDINALS[at]}",
                f"give the {_ORDINALS[at]} one a value as well",
                about,
            )
        elif late.any() or (used.any(axis=0) != used.all(axis=0)).any():
            self.job.cannot(
                f"an external axis that only some targets of `{name}` have",
                "give every target of the path the same external axes, the first one first",
                about,
            )

    def _rounded(self, values: Iterable[float]) -> tuple[float, ...]:
        # Adding 0.0 turns -0.0 into 0.0, which is printed without a sign.
        return tuple(round(v, self.can.decimals) + 0.0 for v in values)

    # ----------------------------------------------------------------- tools and frames

    def tools(self, given: Mapping[str, Tool]) -> dict[str, Tool]:
        """With poses that can be written; of a language with loads each has one."""
        made, can = {}, self.can
        for name, tool in given.items():
            # Every controller has the bare flange.
            if name.lower() == FLANGE and tool.tip == IDENTITY:
                continue
            about = Declared(name, "tools")
            if can.loads is not None:
                tool = replace(tool, load=_accepted_load(self.job, can.loads, name, tool.load))
            if can.mounts is not None:
                tool = self._mounted(can.mounts, name, tool)
            tip = self.pose(tool.tip, f"the tool `{name}`", about)
            made[name] = tool if tip is None else replace(tool, tip=tip)
        return made

    def _mounted(self, can: Mounts, name: str, tool: Tool) -> Tool:
        """Without its load; an error where the robot does not hold it as it must."""
        about, findings = Declared(name, "tools"), self.job.findings
        if not tool.held:
            findings.append(can.held(name=name, about=about))
        if tool.load is not None:
            findings.append(can.load(name=name, about=about))
        if self.five_axes is not None:
            turned = rotations.angle_between(tool.tip.quaternion, IDENTITY.quaternion)
            if math.hypot(*tool.tip.position[:2]) > _NEGLIGIBLE or turned > _NEGLIGIBLE:
                findings.append(can.bent(name=name, about=about))
        return replace(tool, load=None)

    def frames(self, given: Mapping[str, Frame]) -> dict[str, Frame]:
        """With poses that can be written, as one where the language has one alone."""
        made, can = {}, self.can.mounts
        for name, frame in given.items():
            if name.lower() == BASE and frame.pose == IDENTITY:
                continue
            about = Declared(name, "frames")
            if can is not None and (frame.held or frame.mechanism):
                self.job.findings.append(can.held(name=name, about=about))
            if can is not None and frame.object != IDENTITY:
                self.job.findings.append(can.joined(name=name, about=about))
                frame = replace(frame, user=frame.pose, object=IDENTITY)
            user, object = (
                self.pose(pose, f"the frame `{name}`", about) or pose
                for pose in (frame.user, frame.object)
            )
            made[name] = replace(frame, user=user, object=object)
        return made


def _accepted_load(job: Legalisation, can: Loads, name: str, load: Load | None) -> Load:
    """A load that the controller takes, with the decimals that are written."""
    about, least = Declared(name, "tools"), can.least
    if load is None:
        job.findings.append(can.missing(name=name, about=about))
        load = least
    if load.mass < least.mass:
        job.changed(
            f"the mass of tool `{name}`", f"{least.mass} kg", "state the tool's mass", about
        )
        load = replace(load, mass=least.mass)
    # Controllers refuse a load whose centre of gravity is the flange itself.
    if not any(load.centre):
        job.changed(
            f"the centre of gravity of tool `{name}`, which is none",
            can.centre,
            "state the tool's centre of gravity",
            about,
        )
        load = replace(load, centre=least.centre)
    return can.written(load)
