"""What `camera draw` does."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.cameras import read_poses, write_png
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.program.geometry import Pose
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.drawing import Thing

NOTHING_TO_DRAW: Final = error(
    "CL503", "there is nothing to draw", "name a table of poses by --at, or a cell by --cell"
)
UNEQUAL_ROWS: Final = error(
    "CL505",
    "{at} has {count} rows and {poses} has {other}",
    "write as many in both, or a single one in one of them",
)
DrawnScene = tuple[str, Path, str]
"""What is shown, the table of where, and the board that it may be."""


def run_draw(
    file: Path,
    output: Path,
    cell: Path | None,
    shown: DrawnScene | None,
    poses: Path | None,
    noise: float,
    seed: int,
    format: Format,
) -> int:
    from assistant.cell.cell_file import read_scene
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.cameras.drawing import Optics, draw, things_of

    rig = read_cameras(file)
    if shown is None and cell is None:
        raise Refused(NOTHING_TO_DRAW(), exit_status=2)
    scene, findings = (None, ()) if cell is None else read_scene(cell)
    print_findings(findings)
    around = [] if scene is None else things_of(scene)
    moments = _drawn_moments(shown, poses)
    for number, (place, flange) in enumerate(moments):
        things = [*around, *([] if shown is None or place is None else _drawn_things(shown, place))]
        for name, camera in rig.cameras.items():
            stands = _camera_in_world(camera, scene, flange)
            picture = draw(stands, things, Optics(noise=noise), seed=seed + number)
            write_png(output / name / f"{number:04}.png", picture)
    if format is Format.JSON:
        print_json({"cameras": list(rig.cameras), "pictures": len(moments)})
    else:
        for name in rig.cameras:
            say(f"{name}: {len(moments)} pictures in {output / name}")
    return 0


def _drawn_moments(
    shown: DrawnScene | None, poses: Path | None
) -> Sequence[tuple[Pose | None, Pose | None]]:
    """Of each picture where something is shown and where the flange is, None for neither."""
    at: list[Pose | None] = [None] if shown is None else [*read_poses(shown[1])]
    flanges: list[Pose | None] = [None] if poses is None else [*read_poses(poses)]
    count = max(len(at), len(flanges))
    if not {len(at), len(flanges)} <= {1, count}:
        places = "" if shown is None else str(shown[1])
        finding = UNEQUAL_ROWS(at=places, count=len(at), poses=str(poses), other=len(flanges))
        raise Refused(finding, exit_status=2)
    return [(at[min(i, len(at) - 1)], flanges[min(i, len(flanges) - 1)]) for i in range(count)]


def _camera_in_world(camera: Camera, scene: Scene | None, flange: Pose | None) -> Camera:
    from assistant.vision.cameras import rules
    from assistant.vision.cameras.camera import WORLD
    from assistant.vision.cameras.standing import in_world

    if camera.parent == WORLD:
        return camera
    if flange is not None:
        return camera.carried(flange)
    if scene is None:
        finding = rules.NOT_DRAWN(name=camera.name, parent=camera.parent)
        raise Refused(finding, exit_status=2)
    return in_world(camera, scene)


def _drawn_things(shown: DrawnScene, place: Pose) -> list[Thing]:
    from assistant.vision.calibration.boards import Board
    from assistant.vision.cameras.drawing import Card, Thing
    from assistant.vision.pointing.devices import DEVICES
    from assistant.vision.pointing.showing import things_of_device

    what, _, board = shown
    if what != "board":
        return things_of_device(DEVICES[what](), place)
    wanted = Board.parse(board)
    return [Thing(Card(wanted.size, wanted.picture(40)), place @ wanted.on_card.inverse())]
