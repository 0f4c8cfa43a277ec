"""Cameras: calibrate them, look through them, check them, and draw what they would see.

`camera calibrate` finds lenses and mounts from pictures of a board; `camera check` compares the
cameras with each other; `camera draw` draws pictures for tests without a camera.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.cli.command import Argument, argument, command_group, command_of, option
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, print_answer, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.program.geometry import Pose
    from assistant.vision.cameras.calibration import RigFound
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.camera_file import Rig
    from assistant.vision.cameras.capture import Agreement, Frame
    from assistant.vision.cameras.synthetic_pictures import VisibleBody


camera: Final = command_group(
    "Calibrate, look through and check cameras; draw what they would see of a cell."
)
CamerasArgument = Annotated[Path, Argument("File of the cameras, .toml.", metavar="CAMERAS")]


class MountingChoice(StrEnum):
    """Mounting of a camera that an arm calibrates."""

    HAND = "hand"
    STAND = "stand"


class DrawnThing(StrEnum):
    """Thing shown to drawn cameras."""

    BALL = "ball"
    WAND = "wand"
    BOARD = "board"


@command_of(camera)
class Calibrate:
    """Find lenses from pictures of a board, and where the cameras stand."""

    pictures: tuple[str, ...] = argument(
        "A camera and its pictures of the board.", metavar="NAME=FOLDER"
    )
    board: str = option("`chessboard 9x6 25` or `charuco 7x5 40 30`: mm.")
    output: Path = option("File of the cameras, .toml.", "--output", "-o")
    poses: Path | None = option(
        "Table of the poses of the flange, a row a picture: CSV, NPY, JSON."
    )
    mounting: MountingChoice = option(
        "With --poses: the first camera is in the hand, or stands.", default=MountingChoice.STAND
    )
    flange: str = option("How the cell calls the flange that carries the camera.", default="flange")
    format: FormatOption

    def run(self) -> int:
        from assistant.vision.cameras.calibration import (
            Board,
            calibrate_rig,
            find_board_in_folder,
            with_sources,
        )
        from assistant.vision.cameras.camera_file import write_cameras

        wanted = Board.parse(self.board)
        folders = _picture_folders(self.pictures)
        looked = [find_board_in_folder(wanted, name, folder) for name, folder in folders.items()]
        told = [finding for one in looked for finding in one.findings]
        print_findings(told)
        flanges = None if self.poses is None else _read_poses(self.poses)
        found = calibrate_rig(
            wanted, looked, flanges=flanges, mounting=self.mounting.value, flange=self.flange
        )
        sources = {
            name: _relative_folder(folder, self.output.parent) for name, folder in folders.items()
        }
        write_cameras(self.output, with_sources(found.rig, sources))
        print_findings([finding for finding in found.findings if finding not in told])
        lines = (*_calibration_lines(found), f"wrote {self.output}")
        print_answer(self.format, _calibration_record(found), lines)
        return 0


@command_of(camera)
class View:
    """Write a camera's picture with the axes of the camera's parent frame drawn over it."""

    cameras: CamerasArgument
    name: str = argument("Of the camera.")
    output: Path = option("Picture to write, .png.", "--output", "-o")
    source: str | None = option("Device, stream, file or folder instead of the file's.")
    format: FormatOption

    def run(self) -> int:
        from assistant.vision.cameras.camera_file import read_cameras
        from assistant.vision.cameras.capture import exposure_findings
        from assistant.vision.cameras.synthetic_pictures import with_axes

        if self.output.suffix.lower() != ".png":
            raise Refused(_NO_PNG(name=self.output), exit_status=2)
        rig = read_cameras(self.cameras)
        camera = rig[self.name]
        frame = _next_frame(rig, camera, self.source)
        _write_png(self.output, with_axes(camera, frame.picture))
        print_findings(exposure_findings(camera, frame.picture))
        size = list(camera.lens.size)
        answer = {"camera": self.name, "picture": str(self.output), "size": size}
        line = f"{self.name}: {frame.name or 'a picture'}, wrote {self.output}"
        print_answer(self.format, answer, (line,))
        return 0


@command_of(camera)
class Check:
    """Look whether cameras give pictures that are good enough, and whether they agree."""

    cameras: CamerasArgument
    board: str | None = option("A board that all of them see now: whether they agree.")
    format: FormatOption

    def run(self) -> int:
        from assistant.vision.cameras.camera_file import read_cameras
        from assistant.vision.cameras.capture import pictures_findings

        rig = read_cameras(self.cameras)
        frames = {name: _next_frame(rig, camera, None) for name, camera in rig.cameras.items()}
        findings = list(pictures_findings(rig.cameras, frames))
        agreements: list[Agreement] = []
        if self.board is not None:
            agreements, more = _camera_agreements(rig, frames, self.board)
            findings += more
        print_findings(findings)
        if self.format is Format.JSON:
            print_json(
                {
                    "cameras": list(rig.cameras),
                    "agreements": [
                        {
                            "cameras": one.cameras,
                            "corners": one.corners,
                            "px": one.pixels,
                            "mm": one.mm,
                        }
                        for one in agreements
                    ],
                }
            )
        else:
            for name, record in rig.records.items():
                left = "" if record.residual is None else f", {record.residual:.3f} px left"
                day = "never" if record.date is None else f"on {record.date}"
                say(f"{name}: calibrated {day}{left}")
            for one in agreements:
                said = f"{one.corners} corners, {one.pixels:.2f} px and {one.mm:.2f} mm left"
                say(f"{one.cameras[0]} and {one.cameras[1]}: {said}")
        return int(bool(findings))


@command_of(camera)
class Draw:
    """Draw what cameras would see: to try all of it without a camera."""

    cameras: CamerasArgument
    output: Path = option("Folder; a folder of pictures each camera.", "--output", "-o")
    cell: Path | None = option("Cell file of what else is seen.")
    show: DrawnThing = option("What is shown.", default=DrawnThing.WAND)
    at: Path | None = option("Table of the poses at which it is shown, a row a picture.")
    poses: Path | None = option(
        "Table of poses of the flange that carries cameras, a row a picture."
    )
    board: str = option("With --show board: which one.", default="charuco 7x5 40 30")
    noise: float = option("Grey levels, one sigma.", default=2.0, min=0.0)
    seed: int = option("Of the noise.", default=0, min=0)
    format: FormatOption

    def run(self) -> int:
        shown = None if self.at is None else (self.show.value, self.at, self.board)
        from assistant.cell.cell_file import read_scene
        from assistant.vision.cameras.camera_file import read_cameras
        from assistant.vision.cameras.synthetic_pictures import Optics, bodies_of_scene, draw

        rig = read_cameras(self.cameras)
        if shown is None and self.cell is None:
            raise Refused(_NOTHING_TO_DRAW(), exit_status=2)
        scene, findings = (None, ()) if self.cell is None else read_scene(self.cell)
        print_findings(findings)
        around = [] if scene is None else bodies_of_scene(scene)
        moments = _drawn_moments(shown, self.poses)
        for number, (place, flange) in enumerate(moments):
            things = [
                *around,
                *([] if shown is None or place is None else _drawn_things(shown, place)),
            ]
            for name, camera in rig.cameras.items():
                stands = _camera_in_world(camera, scene, flange)
                picture = draw(stands, things, Optics(noise=self.noise), seed=self.seed + number)
                _write_png(self.output / name / f"{number:04}.png", picture)
        lines = (f"{name}: {len(moments)} pictures in {self.output / name}" for name in rig.cameras)
        print_answer(self.format, {"cameras": list(rig.cameras), "pictures": len(moments)}, lines)
        return 0


_NOT_A_CAMERA_FOLDER: Final = error(
    "CL500", "`{given}` names no camera and folder", "write NAME=FOLDER, as left=pictures/left"
)
_CAMERA_TWICE: Final = error(
    "CL506", "two cameras are named `{name}`", "give each a name of its own"
)
_NO_SOURCE: Final = error(
    "CL501",
    "the file does not say where pictures of camera `{name}` come from",
    "write source = … under it, or name it by --source",
)
_NO_POSES: Final = error("CL502", "there are no poses in {file}", "write a row for each of them")
_NO_PNG: Final = error("CL504", "a picture is not written as `{name}`", "end its name in .png")


def _calibration_lines(found: RigFound) -> list[str]:
    from assistant.vision.cameras.calibration import LENS_PARAMETERS

    lines = list[str]()
    for name, one in found.lenses.items():
        (fx, fy), (cx, cy), sigma = one.lens.focal, one.lens.centre, one.sigma
        bends = zip(LENS_PARAMETERS[4:], one.lens.distortion, sigma[4:], strict=True)
        lines += [
            f"{name}: {one.residual:.3f} px left in {len(one.poses)} views, focal length "
            f"{fx:.1f} ± {sigma[0]:.1f} and {fy:.1f} ± {sigma[1]:.1f} px",
            f"  centre {cx:.1f} ± {sigma[2]:.1f} and {cy:.1f} ± {sigma[3]:.1f} px; "
            f"{100.0 * one.coverage:.0f} % of the picture covered",
            "  distortion " + ", ".join(f"{k} {v:.4f} ± {s:.4f}" for k, v, s in bends if s > 0.0),
        ]
    for name, pair in found.pairs.items():
        x, y, z = pair.pose.position
        place = f"{x:.1f} {y:.1f} {z:.1f} mm"
        lines += [
            f"{name}: {pair.residual:.3f} px left in {pair.views} pairs, at {place}",
            f"  base line {pair.base_line:.2f} ± {pair.sigma_mm:.2f} mm, "
            f"turn ± {pair.sigma_deg:.3f} degrees",
        ]
    if found.hand_eye is not None:
        lines += [
            f"{'→' if one is found.hand_eye.best else ' '} {one.method}: {one.mm:.3f} mm and "
            f"{one.degrees:.4f} degrees left"
            for one in found.hand_eye.solutions
        ]
        mm, degrees = found.hand_eye.held_out
        lines.append(f"views that were not used: {mm:.3f} mm and {degrees:.4f} degrees")
        mm, degrees = found.hand_eye.sigma
        lines.append(f"the camera is known to ± {mm:.2f} mm and ± {degrees:.3f} degrees")
    return lines


def _calibration_record(found: RigFound) -> dict[str, object]:
    from assistant.vision.cameras.calibration import LENS_PARAMETERS

    answer: dict[str, object] = {
        "lenses": {
            name: {
                "residual_px": one.residual,
                "views": len(one.poses),
                "focal": one.lens.focal,
                "sigma": dict(zip(LENS_PARAMETERS, map(float, one.sigma), strict=True)),
                "coverage": one.coverage,
            }
            for name, one in found.lenses.items()
        },
        "pairs": {
            name: {
                "residual_px": one.residual,
                "position": one.pose.position,
                "sigma_mm": one.sigma_mm,
                "sigma_deg": one.sigma_deg,
            }
            for name, one in found.pairs.items()
        },
    }
    if found.hand_eye is not None:
        answer["hand_eye"] = {
            "best": found.hand_eye.best.method,
            "left": {
                one.method: {"mm": one.mm, "degrees": one.degrees}
                for one in found.hand_eye.solutions
            },
            "held_out": {"mm": found.hand_eye.held_out[0], "degrees": found.hand_eye.held_out[1]},
            "sigma": {"mm": found.hand_eye.sigma[0], "degrees": found.hand_eye.sigma[1]},
            "left_out": [row + 1 for row in found.hand_eye.left_out],
        }
    return answer


def _picture_folders(given: Sequence[str]) -> dict[str, str]:
    from assistant.program.program import IDENTIFIER

    found: dict[str, str] = {}
    for one in given:
        name, equals, folder = one.partition("=")
        if not (equals and folder and IDENTIFIER.fullmatch(name)):
            raise Refused(_NOT_A_CAMERA_FOLDER(given=one), exit_status=2)
        if name.lower() in {other.lower() for other in found}:
            raise Refused(_CAMERA_TWICE(name=name), exit_status=2)
        found[name] = folder
    return found


def _relative_folder(folder: str, file: Path) -> str:
    """Return a folder as named in a file, relative to it; a bare number would be a device."""
    if Path(folder).is_absolute():
        return folder
    found = Path(os.path.relpath(folder, file)).as_posix()
    return f"./{found}" if found.isdigit() else found


def _read_poses(file: Path) -> list[Pose]:
    """The rows of a table of waypoints, or its targets in their order."""
    from assistant.program.geometry import Pose
    from assistant.program.statements import Follow
    from assistant.sources import read

    program = read(file).program
    ways = [one.path for body in program.procedures for one in body.body if isinstance(one, Follow)]
    rows = [row for way in ways for row in zip(way.positions, way.quaternions, strict=True)]
    found = [Pose.of(position, quaternion) for position, quaternion in rows]
    found = found or [target.pose for target in program.targets.values()]
    if not found:
        raise Refused(_NO_POSES(file=file), exit_status=2)
    return found


def _next_frame(rig: Rig, camera: Camera, source: str | None) -> Frame:
    from assistant.vision.cameras.capture import open_frames

    named = source or rig.sources.get(camera.name, "")
    if not named:
        raise Refused(_NO_SOURCE(name=camera.name), exit_status=2)
    folder = Path() if source else rig.folder
    with open_frames(camera, named, folder) as frames:
        return next(frames)


def _camera_agreements(
    rig: Rig, frames: Mapping[str, Frame], board: str
) -> tuple[list[Agreement], list[Diagnostic]]:
    from itertools import combinations

    import numpy as np

    from assistant.vision import rules
    from assistant.vision.cameras.calibration import Board, find_board
    from assistant.vision.cameras.capture import check_agreement

    wanted = Board.parse(board)
    views = {name: find_board(wanted, one.picture, name) for name, one in frames.items()}
    findings = [rules.NO_BOARD(name=name) for name, view in views.items() if view is None]
    agreements = []
    seen = {name: view for name, view in views.items() if view is not None}
    for one, other in combinations(seen, 2):
        first, second = seen[one], seen[other]
        rows = np.intersect1d(first.rows, second.rows)
        pixels = [
            view.pixels[[int(np.flatnonzero(view.rows == row)[0]) for row in rows]]
            for view in (first, second)
        ]
        found, more = check_agreement([rig[one], rig[other]], pixels, wanted.corners[rows])
        agreements.append(found)
        findings += more
    return agreements, findings


def _write_png(file: Path, picture: object) -> None:
    """Write the complete PNG, or nothing."""
    from assistant.base.file_sets import write_files
    from assistant.vision.opencv import opencv

    done, data = opencv().imencode(".png", picture)
    assert done, "a picture of eight bits can be written as PNG"
    write_files({file.name: bytes(data)}, file.parent)


_NOTHING_TO_DRAW: Final = error(
    "CL503", "there is nothing to draw", "name a table of poses by --at, or a cell by --cell"
)
_UNEQUAL_ROWS: Final = error(
    "CL505",
    "{at} has {count} rows and {poses} has {other}",
    "write as many in both, or a single one in one of them",
)
_DrawnScene = tuple[str, Path, str]
"""Thing to draw, table of its poses, and the board if it is one."""


def _drawn_moments(
    shown: _DrawnScene | None, poses: Path | None
) -> Sequence[tuple[Pose | None, Pose | None]]:
    """Return the pose of the drawn thing and of the flange for each picture, None for a missing
    one.
    """
    at: list[Pose | None] = [None] if shown is None else [*_read_poses(shown[1])]
    flanges: list[Pose | None] = [None] if poses is None else [*_read_poses(poses)]
    count = max(len(at), len(flanges))
    if not {len(at), len(flanges)} <= {1, count}:
        places = "" if shown is None else str(shown[1])
        finding = _UNEQUAL_ROWS(at=places, count=len(at), poses=str(poses), other=len(flanges))
        raise Refused(finding, exit_status=2)
    return [(at[min(i, len(at) - 1)], flanges[min(i, len(flanges) - 1)]) for i in range(count)]


def _camera_in_world(camera: Camera, scene: Scene | None, flange: Pose | None) -> Camera:
    from assistant.vision import rules
    from assistant.vision.cameras.camera import WORLD
    from assistant.vision.cameras.synthetic_pictures import camera_in_world

    if camera.parent == WORLD:
        return camera
    if flange is not None:
        return camera.carried(flange)
    if scene is None:
        finding = rules.UNKNOWN_CARRIER(name=camera.name, parent=camera.parent)
        raise Refused(finding, exit_status=2)
    return camera_in_world(camera, scene)


def _drawn_things(shown: _DrawnScene, place: Pose) -> list[VisibleBody]:
    from assistant.vision.cameras.calibration import Board
    from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody
    from assistant.vision.pointing.devices import DEVICES, bodies_of_device

    what, _, board = shown
    if what != "board":
        return bodies_of_device(DEVICES[what](), place)
    wanted = Board.parse(board)
    return [VisibleBody(Card(wanted.size, wanted.picture(40)), place @ wanted.on_card.inverse())]
