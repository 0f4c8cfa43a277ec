"""Output of recognition: taught targets on found objects, a file of their poses, an overlay.

Each found object becomes a frame, so a build with another sight changes frames only. Files that
`see` did not write are not replaced. The overlay draws outlines, axes, names and lines over the
picture of a camera.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path as FilePath
from types import ModuleType
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.file_sets import write_all
from assistant.base.source_text import is_file, read_bytes
from assistant.base.toml_edits import rounded, toml_rows, toml_text
from assistant.program.geometry import IDENTITY, Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.known_objects import Line, Place
from assistant.vision.recognition.photo import Picture
from assistant.vision.recognition.recogniser import (
    FoundObject,
    Recognition,
    face_centre,
    object_rim,
)
from assistant.vision.rules import FOREIGN_FILE

_FILE_HEAD: Final = "# Seen by robot-assistant"
"""First words of files that `see` writes, and replaces."""
_MM_DECIMALS: Final = 4
"""Decimals of mm."""


@dataclass(frozen=True, slots=True)
class OutputFrame:
    """Frame of the written poses. name: "world", or "base" of a robot; pose: its base in the
    world.
    """

    name: str = "world"
    pose: Pose = IDENTITY

    def of(self, pose: Pose) -> Pose:
        return self.pose.inverse() @ pose


def targets_text(
    found: Sequence[FoundObject],
    base: OutputFrame,
    when: datetime.datetime,
    robot: str | None = None,
) -> str:
    """Return taught targets: a frame for each object, then the actions on one object after the
    other.

    Before and after each place and line is a target above it, at the approach distance along the
    tool. Poses are in the frame of the object, so that a build with another sighting only changes
    frames.
    """
    content = {
        "robot": robot,
        "frames": {one.name: _pose_keys(base.of(one.pose)) for one in found} or None,
        "targets": [target for one in found for target in _target_tables(one)] or None,
    }
    head = f"{_FILE_HEAD} at {when.isoformat(timespec='seconds')}: {len(found)} objects.\n"
    return f"{head}\n{toml_text(content)}"


def found_text(found: Iterable[FoundObject], base: OutputFrame, when: datetime.datetime) -> str:
    """Return the poses of objects: [found.NAME] with pose, standard deviations, covariance,
    confidence.
    """
    tables = {one.name: _found_table(one, base, when) for one in found}
    return (
        f"{_FILE_HEAD}: where known objects are, in mm.\n\n{toml_text({'found': tables or None})}"
    )


def _found_table(one: FoundObject, base: OutputFrame, when: datetime.datetime) -> dict[str, Any]:
    rows = _covariance_in_frame(one.estimate.covariance, base)
    covariance = toml_rows([[_short_number(value) for value in row] for row in rows])
    covariance.comment("mm along and degrees about x, y and z of the frame")
    return {
        "object": one.object.name,
        **_pose_keys(base.of(one.pose)),
        "frame": base.name,
        "sigma_mm": _short_number(one.estimate.sigma_mm),
        "sigma_deg": _short_number(one.estimate.sigma_deg),
        "confidence": round(min(one.confidence, 1.0), 3),
        "seen": when.replace(microsecond=0),
        "cameras": one.cameras,
        "covariance": covariance,
    }


def _pose_keys(pose: Pose) -> dict[str, Any]:
    return {
        "position": rounded(pose.position, _MM_DECIMALS),
        "quaternion": rounded(pose.quaternion, 9),
    }


def _short_number(value: float) -> float:
    return float(f"{value:.4g}")


def _covariance_in_frame(covariance: Floats, base: OutputFrame) -> Floats:
    """A covariance (6, 6) along and about the axes of the world, for those of a base."""
    from assistant.base import rotations

    turn = rotations.to_matrix(np.array(base.pose.quaternion)).T
    both = np.kron(np.eye(2), turn)
    return np.asarray(both @ covariance @ both.T)


def write_seen_files(files: dict[FilePath, str]) -> tuple[FilePath, ...]:
    """Writes files, all or none; raises Refused if one of another origin is there."""
    for path in files:
        if is_file(path) and not read_bytes(path, allow_empty=True).startswith(_FILE_HEAD.encode()):
            raise Refused(FOREIGN_FILE(path=str(path), name=path.name), exit_status=2)
    return write_all({path: text.encode() for path, text in files.items()})


def _target_tables(one: FoundObject) -> Iterator[dict[str, Any]]:
    """Targets of the places and lines of an object, in its frame."""
    for name, place in one.object.places.items():
        yield from _place_targets(f"{one.name}_{name}", place, one.name)
    for name, line in one.object.lines.items():
        yield from _line_targets(f"{one.name}_{name}", line, one.name)


def _place_targets(name: str, place: Place, frame: str) -> Iterator[dict[str, Any]]:
    above = _backed_off(place.pose, place.approach)
    yield _target(f"{name}_before", above, frame, "joint")
    yield _target(name, place.pose, frame, "linear")
    yield _target(f"{name}_after", above, frame, "linear")


def _line_targets(name: str, line: Line, frame: str) -> Iterator[dict[str, Any]]:
    poses = [Pose.of(point, np.array(line.quaternion)) for point in line.points]
    yield _target(f"{name}_before", _backed_off(poses[0], line.approach), frame, "joint")
    for i, pose in enumerate(poses):
        kind = "via" if i in line.vias else "end" if i - 1 in line.vias else "linear"
        yield _target(f"{name}_{i + 1}", pose, frame, kind) | {"speed": line.speed if i else None}
    yield _target(f"{name}_after", _backed_off(poses[-1], line.approach), frame, "linear")


def _backed_off(pose: Pose, by: float) -> Pose:
    return pose.offset(z=-by)


def _target(name: str, pose: Pose, frame: str, kind: str) -> dict[str, Any]:
    return {"name": name, "kind": kind, "frame": frame, **_pose_keys(pose)}


_OUTLINE_COLOUR: Final = (80, 220, 80)
_AXIS_COLOURS: Final = ((60, 60, 240), (80, 200, 80), (240, 120, 60))
"""Colours of x, y and z; blue, green, red."""
_LINE_COLOUR: Final = (220, 50, 200)
_AXIS_LENGTH: Final = 20.0
"""mm of an axis."""
_SUBPIXEL_BITS: Final = 4


def draw_found(cv: ModuleType, camera: Camera, picture: Picture, sight: Recognition) -> Picture:
    """Outlines, axes, names and lines; unknown things are left as they are."""
    drawn = picture.copy()
    for one in sight.found:
        for ring in _outline_rings(one):
            _draw_polygon(
                cv, drawn, camera.project(one.pose.moved(ring)), _OUTLINE_COLOUR, closed=True
            )
        for line in one.object.lines.values():
            _draw_polygon(
                cv,
                drawn,
                camera.project(one.pose.moved(_line_points(line))),
                _LINE_COLOUR,
                closed=False,
            )
        _draw_axes(cv, drawn, camera, one)
        at = camera.project(one.pose.moved(face_centre(one.object)[None]))[0]
        if np.isfinite(at).all():
            u, v = (int(value) for value in at)
            text = f"{one.name} {one.confidence:.2f}"
            for colour, thick in (((0, 0, 0), 3), ((255, 255, 255), 1)):
                cv.putText(drawn, text, (u - 30, v), 0, 0.5, colour, thick, cv.LINE_AA)
    return np.asarray(drawn)


def _outline_rings(one: FoundObject) -> list[Floats]:
    if one.object.outline is None:
        return [object_rim(one.object)]
    rings = one.object.outline.rings
    return [np.column_stack([ring, np.zeros(len(ring))]) for ring in rings]


def _line_points(line: Line) -> Floats:
    """Points along a line, its arcs by chords."""
    points = [line.points[:1]]
    for i in range(1, len(line.points)):
        if i in line.vias:
            continue
        if i - 1 in line.vias:
            a, b, c = line.points[i - 2 : i + 1]
            t = np.linspace(0.0, 1.0, 24)[1:, None]
            # Through the middle by a parabola: near enough to be looked at.
            points.append((1 - t) * (1 - 2 * t) * a + 4 * t * (1 - t) * b + t * (2 * t - 1) * c)
        else:
            points.append(line.points[i : i + 1])
    return np.concatenate(points)


def _draw_axes(cv: ModuleType, drawn: Picture, camera: Camera, one: FoundObject) -> None:
    tips = np.vstack([np.zeros(3), _AXIS_LENGTH * np.eye(3)])
    seen = camera.project(one.pose.moved(tips))
    for number, colour in enumerate(_AXIS_COLOURS, 1):
        _draw_polygon(cv, drawn, seen[[0, number]], colour, closed=False)


def _draw_polygon(
    cv: ModuleType,
    drawn: Picture,
    pixels: Floats,
    colour: tuple[int, int, int],
    *,
    closed: bool,
) -> None:
    if np.isfinite(pixels).all():
        whole = np.rint(pixels * (1 << _SUBPIXEL_BITS)).astype(np.int32)
        cv.polylines(drawn, [whole], closed, colour, 2, cv.LINE_AA, _SUBPIXEL_BITS)
