"""What somebody shows to cameras, for the commands that store it."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cli.presentation import Format, print_findings, say

if TYPE_CHECKING:
    from assistant.compiler.taught_targets import ShownTarget, TargetOptions
    from assistant.controllers.trajectory_execution import LinkOptions
    from assistant.robots import Robot
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.camera_file import Rig
    from assistant.vision.pointing.devices import Device
    from assistant.vision.pointing.holding import Held, Still
    from assistant.vision.pointing.locating import Limits
    from assistant.vision.pointing.tracking import Look


@dataclass(frozen=True, slots=True)
class PointingOptions:
    """cameras: file of cameras. use: names of those that look, () for all. device: name or file.
    frames: moments of a hold. rate: pictures a second of files. robot: named by hand. world: frame
    of the cameras in the file. stroke: a way instead of places, with waypoints each `step` mm.
    go: the arm is led to each place, by a mode, from `above` mm before it, at `speed` percent.
    servo: file of servoing by which it is led from there on, by what the cameras see of its tool.
    """

    cameras: Path
    into: Path
    wanted: TargetOptions
    use: tuple[str, ...] = ()
    device: str = "wand"
    frames: int = 30
    rate: float = 30.0
    residual: float = 0.5
    fastest: float = 1500.0
    robot: str | None = None
    world: str | None = None
    stroke: bool = False
    step: float = 5.0
    go: bool = False
    by: str = "data-link"
    wishes: LinkOptions | None = None
    above: float = 50.0
    speed: float = 10.0
    servo: Path | None = None
    yes: bool = False
    format: Format = Format.TEXT


@dataclass(slots=True)
class ShownPlaces:
    """Places that come from cameras, and what was told of them meanwhile."""

    rig: Rig
    cameras: tuple[Camera, ...]
    device: Device
    options: PointingOptions
    good: int = 0
    count: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def looks(self) -> Iterator[Iterator[Look]]:
        from assistant.vision.pointing.locating import check_cameras
        from assistant.vision.pointing.moments import moments
        from assistant.vision.pointing.tracking import tracked

        check_cameras(self.cameras)
        with moments(self.rig, self.cameras, self.options.rate) as given:
            fastest = self.options.fastest
            looks = tracked(given, self.device, self.cameras, self.limits, fastest)
            yield self._counted(looks)

    def _counted(self, looks: Iterator[Look]) -> Iterator[Look]:
        for look in looks:
            self.count += 1
            if isinstance(look.seen, Diagnostic):
                self.reasons[look.seen.message] += 1
            else:
                self.good += 1
            yield look

    @contextmanager
    def holds(self) -> Iterator[Iterator[Held]]:
        from assistant.vision.pointing.holding import holds

        with self.looks() as looks:
            yield holds(looks, self.device, self.cameras, self.limits, self.still, self.tell)

    @property
    def still(self) -> Still:
        from assistant.vision.pointing.holding import Still

        return Still(self.options.frames)

    @property
    def limits(self) -> Limits:
        from assistant.vision.pointing.locating import Limits

        return Limits(residual=self.options.residual)

    def tell(self, finding: Diagnostic) -> None:
        sys.stdout.flush()
        print_findings([finding])

    def ended(self, name: str) -> Refused:
        """What to say when the pictures ended before something was shown."""
        from assistant.vision.pointing.rules import NOT_SHOWN

        most = self.reasons.most_common(1)
        mostly = f"; mostly {most[0][0]}" if most else ""
        return Refused(
            NOT_SHOWN(
                name=name,
                seen=self.good,
                count=self.count,
                mostly=mostly,
                frames=self.options.frames,
            )
        )


def next_place(
    name: str,
    holds: Iterator[Held],
    shown: ShownPlaces,
    robot: Robot | None,
    near: Sequence[float] | None = None,
) -> tuple[Held, ShownTarget] | None:
    """The next place that is shown and reached; None when there are no pictures any more."""
    import numpy as np

    from assistant.compiler.taught_targets import DEVICE_TILTED, OUT_OF_REACH, target_of_shown

    options = shown.options
    if options.format is Format.TEXT:
        say(f"{name}: hold the {shown.device.name} still; Ctrl-C ends")
        sys.stdout.flush()
    start = None if near is None else np.array(near)
    for held in holds:
        try:
            place = target_of_shown(
                options.into, name, held.pose, robot, options.wanted, start, options.world
            )
        except Refused as refused:
            if not {f.code for f in refused.findings} <= {OUT_OF_REACH.code, DEVICE_TILTED.code}:
                raise
            print_findings(refused.findings)
            continue
        print_findings(place.findings)
        return held, place
    return None


def place_line(place: ShownTarget) -> str:
    x, y, z = place.pose.position
    q = ", ".join(f"{part:.5f}" for part in place.pose.quaternion)
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} mm  quaternion ({q})"


def certainty(held: Held) -> str:
    return f"{held.frames} moments within {held.spread:.2f} mm, mean known to {held.sigma:.2f} mm"


def pointing_record(held: Held, place: ShownTarget) -> dict[str, object]:
    return {
        "name": place.name,
        "position": list(place.pose.position),
        "quaternion": list(place.pose.quaternion),
        "joints": None if place.joints is None else place.joints.tolist(),
        "frames": held.frames,
        "spread_mm": held.spread,
        "turned_degrees": held.turned,
        "residual_px": held.residual,
        "covariance": held.covariance.tolist(),
    }
