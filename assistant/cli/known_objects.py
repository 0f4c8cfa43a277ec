"""Known objects: learn them by drawing or pictures, list them, and find them with cameras.

`see` writes targets only if what was found is certain enough; otherwise it exits with 1. Without a
cell file poses are in the frame of the cameras. Lengths are mm.
"""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.command import (
    Argument,
    Option,
    argument,
    command,
    command_group,
    command_of,
    option,
)
from assistant.cli.options import CellOption, FormatOption, UnitOption
from assistant.cli.presentation import Format, print_answer, print_findings, say

if TYPE_CHECKING:
    from assistant.cell.scene import PlacedRobot
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.camera_file import Rig
    from assistant.vision.cameras.synthetic_pictures import Picture
    from assistant.vision.recognition.known_objects import KnownObject
    from assistant.vision.recognition.pose_estimation import Plane
    from assistant.vision.recognition.recogniser import FoundObject, Recognition
    from assistant.vision.recognition.recognition_output import OutputFrame


objects: Final = command_group(
    "Learn objects by their drawings or by showing them; list those of a library."
)
LibraryArgument = Annotated[Path, Argument("Folder of the library.", metavar="LIBRARY")]
CamerasOption = Annotated[Path | None, Option("File of the cameras, .toml.", "--cameras")]
PlaneOption = Annotated[
    float, Option("Height of what objects lie on, mm in the world.", "--plane", default=0.0)
]


@command_of(objects)
class Add:
    """Learn an object: by its drawing, by pictures of its face, or as it lies before cameras."""

    library: LibraryArgument
    name: str = argument("How the object is called.")
    files: tuple[str, ...] = argument("Its drawing, .dxf, or pictures: FILE or CAMERA=FILE.")
    contour: str | None = option("Layer of the outline; default the one with closed contours.")
    line: tuple[str, ...] = option("Layer whose curves are ways on the part; repeatable.")
    width: float | None = option("mm that the face is wide which fills the first picture.")
    height: float | None = option("mm of the face above what the part lies on.", min=0.0)
    cameras: CamerasOption
    plane: PlaneOption
    solid: bool = option("It is not flat: marks in space, by two cameras.")
    unit: UnitOption
    again: bool = option("Replace one of that name.")
    format: FormatOption

    def run(self) -> int:
        from assistant.vision.recognition.object_library import add_objects, check_name

        check_name(self.name)
        one, findings = _learn_object(self)
        add_objects(self.library, [one], again=self.again)
        print_findings(findings)
        answer = {"library": str(self.library), **_object_record(one)}
        lines = (_object_line(one), f"wrote {self.library / one.name}.toml")
        print_answer(self.format, answer, lines)
        return 0


@command_of(objects)
class List:
    """List the objects of a library: what they are known by, and what is done on them."""

    library: LibraryArgument
    format: FormatOption

    def run(self) -> int:
        from assistant.vision.recognition.object_library import read_library

        read = read_library(self.library)
        print_findings(read.findings)
        known = read.objects.values()
        answer = {"library": str(self.library), "objects": list(map(_object_record, known))}
        print_answer(self.format, answer, map(_object_line, known))
        return 0
        for one in read.objects.values():
            say(_object_line(one))
        return 0


@command
class See:
    """Find known objects in pictures; what is done on them becomes targets. Nothing moves."""

    cameras: Path = option("File of the cameras, .toml.")
    library: Path = option("Folder of the library.", "--objects")
    images: tuple[str, ...] = argument(
        "A picture of each camera: FILE or CAMERA=FILE; default theirs.",
        default=(),
        metavar="IMAGES",
    )
    to: Path | None = option("Taught targets to write, .toml: what is done.")
    found: Path | None = option("File to write, .toml: where objects are.")
    picture: Path | None = option("The picture with what was found, .png.", "--draw")
    plane: PlaneOption
    plane_sigma: float = option(
        "mm, one sigma, that the plane may be off.", default=0.05, min=0.001
    )
    cell: CellOption
    robot: str | None = option("Its name in the cell, if there are several.", "--robot", "-r")
    joints: str | None = option("Where the arm was that carries a camera: degrees with commas.")
    expect: tuple[str, ...] = option("An object that has to be there; repeatable.")
    most_mm: float = option(
        "mm, one sigma, that an object may be unsure by.", default=1.0, min=0.001
    )
    most_deg: float = option(
        "Degrees, one sigma, that it may be unsure by.", default=1.0, min=0.001
    )
    format: FormatOption

    def run(self) -> int:
        """0 if what was found may be acted on, else 1, and no file is written."""
        from assistant.vision.cameras.camera_file import read_cameras
        from assistant.vision.opencv import opencv
        from assistant.vision.recognition.object_library import read_library
        from assistant.vision.recognition.recogniser import Recogniser

        _check_see_options(self)
        rig = read_cameras(self.cameras)
        library = read_library(self.library)
        placed = _robot_in_cell(self)
        pictures = _take_pictures(self, rig)
        cameras = {name: _camera_in_world(rig.cameras[name], placed, self) for name in pictures}
        recogniser = Recogniser(opencv(), library)
        when = datetime.datetime.now(datetime.UTC)
        sight = recogniser.see(pictures, cameras, _plane_at(self.plane, self.plane_sigma))
        findings = [*library.findings, *sight.findings, *_doubtful_findings(self, sight)]
        written = _write_found(self, sight, placed, when, findings)
        if self.picture is not None:
            from assistant.vision.recognition.recognition_output import draw_found

            name = next(iter(pictures))
            _write_png(self.picture, draw_found(opencv(), cameras[name], pictures[name], sight))
            written.append(self.picture)
        print_findings(findings)
        _print_found(sight, _robot_base(placed), written, self.format)
        return int(has_errors(findings))


_TARGETS_NOT_TOML: Final = error("CL550", "`{name}` is written as TOML", "end its name in .toml")
_PICTURE_NOT_PNG: Final = error(
    "CL551", "a picture is not written as `{name}`", "end its name in .png"
)
_BAD_JOINTS: Final = error(
    "CL552",
    "`{given}` are no joints of `{robot}`",
    "write {count} numbers of degrees with commas, in the order of the axes",
)
_WHICH_ROBOT: Final = error(
    "CL553", "the cell does not tell which robot is meant", "name one of {names} by --robot"
)
_NO_PICTURES: Final = error(
    "CL554",
    "the file does not say where pictures of camera `{name}` come from",
    "name a picture, or write source = … under the camera",
)
_DRAWING_SUFFIX: Final = ".dxf"


def _learn_object(asked: Add) -> tuple[KnownObject, tuple[Diagnostic, ...]]:
    from assistant.vision import rules

    drawings = [one for one in asked.files if Path(one).suffix.lower() == _DRAWING_SUFFIX]
    if drawings:
        if len(asked.files) > 1:
            raise Refused(rules.DRAWING_AND_PICTURES(cure="name one drawing alone"), exit_status=2)
        from assistant.vision.recognition.objects_from_drawings import read_part

        drawn = read_part(
            *(drawings[0], asked.name),
            contour=asked.contour,
            lines=asked.line,
            height=asked.height or 0.0,
            unit=asked.unit,
        )
        return drawn.object, drawn.findings
    if asked.contour is not None or asked.line:
        cure = "leave out --contour and --line, which are of drawings"
        raise Refused(rules.DRAWING_AND_PICTURES(cure=cure), exit_status=2)
    return _learn_from_pictures(asked)


def _learn_from_pictures(asked: Add) -> tuple[KnownObject, tuple[Diagnostic, ...]]:
    from assistant.vision import rules
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.cameras.capture import read_picture
    from assistant.vision.opencv import opencv
    from assistant.vision.recognition.objects_from_pictures import (
        ObjectView,
        learn_face,
        learn_lying,
        learn_solid,
    )
    from assistant.vision.recognition.photo import read_picture_of_camera, split_camera_and_file

    cv, height = opencv(), asked.height or 0.0
    if asked.cameras is None:
        if asked.width is None:
            raise Refused(rules.NO_FACE_SIZE(), exit_status=2)
        views = [ObjectView(file, read_picture(file)) for file in asked.files]
        learnt = learn_face(cv, asked.name, views, asked.width, height)
        return learnt.object, learnt.findings
    cameras = dict(read_cameras(asked.cameras).cameras)
    views = []
    for given in asked.files:
        name, file = split_camera_and_file(given, cameras, alone=True)
        views.append(ObjectView(file, read_picture_of_camera(file, cameras[name]), cameras[name]))
    plane, findings = _plane_at(asked.plane), list[Diagnostic]()
    if asked.solid:
        learnt = learn_solid(cv, asked.name, views, plane)
        return learnt.object, learnt.findings
    if asked.height is None and len({view.camera.name for view in views if view.camera}) > 1:
        height = _height_by_depth(asked.name, views, plane, findings)
    learnt = learn_lying(cv, asked.name, views, plane, height)
    return learnt.object, (*findings, *learnt.findings)


def _height_by_depth(
    name: str, views: list[Any], plane: Plane, findings: list[Diagnostic]
) -> float:
    """By depth from the first two pictures of two cameras."""
    from assistant.vision.opencv import opencv
    from assistant.vision.recognition.stereo_depth import face_height
    from assistant.vision.rules import UNKNOWN_FACE_HEIGHT

    one = views[0]
    other = next(view for view in views if view.camera.name != one.camera.name)
    pair = (one.camera, other.camera), (one.picture, other.picture)
    found = face_height(opencv(), *pair, plane)
    if found is None:
        findings.append(UNKNOWN_FACE_HEIGHT(name=name))
    return max(found or 0.0, 0.0)


def _object_record(one: KnownObject) -> dict[str, Any]:
    return {
        "name": one.name,
        "height": one.height,
        "outline_mm": None if one.outline is None else one.outline.diameter,
        "marks": 0 if one.texture is None else len(one.texture.points),
        "symmetry": one.symmetry,
        "places": list(one.places),
        "lines": list(one.lines),
    }


def _object_line(one: KnownObject) -> str:
    known = []
    if one.outline is not None:
        known.append(f"an outline {one.outline.diameter:.1f} mm long")
    if one.texture is not None:
        known.append(f"{len(one.texture.points)} marks")
    done = [*one.places, *one.lines]
    return f"{one.name}: {' and '.join(known)}; on it {', '.join(done) if done else 'nothing'}"


def _check_see_options(asked: See) -> None:
    for path in (asked.to, asked.found):
        if path is not None and path.suffix.lower() != ".toml":
            raise Refused(_TARGETS_NOT_TOML(name=path), exit_status=2)
    if asked.picture is not None and asked.picture.suffix.lower() != ".png":
        raise Refused(_PICTURE_NOT_PNG(name=asked.picture), exit_status=2)


def _plane_at(height: float, sigma: float = 0.05) -> Plane:
    from assistant.program.geometry import Pose
    from assistant.vision.recognition.pose_estimation import Plane

    return Plane(Pose((0.0, 0.0, height)), sigma)


def _robot_in_cell(asked: See) -> PlacedRobot | None:
    """Return the robot of the cell in whose base poses are given."""
    if asked.cell is None:
        return None
    from assistant.cell.cell_file import read_scene

    scene, findings = read_scene(asked.cell)
    print_findings(findings)
    robots = [one for one in scene.robots if asked.robot in (None, one.name)]
    if len(robots) != 1:
        names = ", ".join(one.name for one in scene.robots) or "none"
        raise Refused(_WHICH_ROBOT(path=str(asked.cell), names=names), exit_status=2)
    return robots[0]


def _camera_in_world(camera: Camera, placed: PlacedRobot | None, asked: See) -> Camera:
    """The camera in the world; raises Refused for one that hangs on nobody knows where."""
    import numpy as np

    from assistant.program.geometry import Pose
    from assistant.vision.cameras.camera import WORLD
    from assistant.vision.rules import UNKNOWN_MOUNTING

    if camera.parent == WORLD:
        return camera
    carriers = () if placed is None else ("flange", f"{placed.name}.flange")
    if placed is None or asked.joints is None or camera.parent not in carriers:
        found = UNKNOWN_MOUNTING(path=str(asked.cameras), camera=camera.name, parent=camera.parent)
        raise Refused(found, exit_status=2)
    try:
        joints = [float(part) for part in asked.joints.split(",")]
    except ValueError:
        joints = []
    count = len(placed.robot.home)
    if len(joints) != count or not np.isfinite(joints).all():
        told = _BAD_JOINTS(given=asked.joints, robot=placed.name, count=count)
        raise Refused(told, exit_status=2)
    position, quaternion = placed.robot.fk(np.array([joints]))
    return camera.carried(placed.base @ Pose.of(position[0], quaternion[0]))


def _take_pictures(asked: See, rig: Rig) -> dict[str, Picture]:
    from assistant.vision.cameras.capture import open_frames
    from assistant.vision.recognition.photo import check_exposure, read_pictures_of_cameras

    if asked.images:
        return read_pictures_of_cameras(asked.images, rig.cameras)
    found = {}
    for name, camera in rig.cameras.items():
        if not rig.sources.get(name):
            raise Refused(_NO_PICTURES(path=str(asked.cameras), name=name), exit_status=2)
        with open_frames(camera, rig.sources[name], rig.folder) as frames:
            found[name] = check_exposure(next(frames).picture, camera, rig.sources[name])
    return found


def _doubtful_findings(asked: See, sight: Recognition) -> list[Diagnostic]:
    """Return findings for expected objects not seen and for poses that are too uncertain."""
    from assistant.vision import rules

    findings = []
    if not sight.found:
        findings.append(rules.NOTHING_FOUND(count=len(sight.unknown)))
    there = {one.name.casefold() for one in sight.found}
    findings += [rules.OBJECT_NOT_SEEN(name=n) for n in asked.expect if n.casefold() not in there]
    for one in sight.found:
        told = [(one.estimate.sigma_mm, asked.most_mm, "mm", "most-mm")]
        if one.object.symmetry != 0:
            told.append((one.estimate.sigma_deg, asked.most_deg, "degrees", "most-deg"))
        findings += [
            rules.UNCERTAIN_POSE(name=one.name, sigma=sigma, most=most, unit=unit, option=option)
            for sigma, most, unit, option in told
            if sigma > most and one.larger is None
        ]
    done = any(one.object.places or one.object.lines for one in sight.found)
    if asked.to is not None and sight.found and not done:
        findings.append(rules.NOTHING_TO_DO())
    return findings


def _robot_base(placed: PlacedRobot | None) -> OutputFrame:
    """The robot's base, which is the world of the cameras where no cell says another."""
    from assistant.program.geometry import IDENTITY
    from assistant.vision.recognition.recognition_output import OutputFrame

    return OutputFrame("base", IDENTITY if placed is None else placed.base)


def _write_found(
    asked: See,
    sight: Recognition,
    placed: PlacedRobot | None,
    when: datetime.datetime,
    findings: list[Diagnostic],
) -> list[Path]:
    from assistant.vision.recognition.recognition_output import (
        found_text,
        targets_text,
        write_seen_files,
    )

    if has_errors(findings):
        return []
    base, files = _robot_base(placed), dict[Path, str]()
    robot = None if placed is None else placed.robot.name
    if asked.to is not None and any(one.object.places or one.object.lines for one in sight.found):
        files[asked.to] = targets_text(sight.found, base, when, robot)
    if asked.found is not None:
        files[asked.found] = found_text(sight.found, base, when)
    return list(write_seen_files(files)) if files else []


def _write_png(file: Path, picture: object) -> None:
    from assistant.base.file_sets import write_files
    from assistant.vision.opencv import opencv

    done, data = opencv().imencode(".png", picture)
    assert done, "a picture of eight bits can be written as PNG"
    write_files({file.name: bytes(data)}, file.parent)


def _print_found(
    sight: Recognition, base: OutputFrame, written: list[Path], format: Format
) -> None:
    answer = {
        "found": [_found_record(one, base) for one in sight.found],
        "unknown": [{"x": one.x, "y": one.y, "size": one.size} for one in sight.unknown],
    }
    print_answer(format, answer, (_found_line(one, base) for one in sight.found), written=written)


def _found_line(one: FoundObject, base: OutputFrame) -> str:
    x, y, z = base.of(one.pose).position
    return (
        f"{one.name}: x {x:.2f}, y {y:.2f}, z {z:.2f} mm, turned {_z_turn(one, base):.2f} "
        f"degrees; ± {one.estimate.sigma_mm:.2f} mm, {one.estimate.sigma_deg:.2f} degrees, "
        f"confidence {one.confidence:.2f}"
    )


def _z_turn(one: FoundObject, base: OutputFrame) -> float:
    """Degrees about the z axis of the base."""
    import numpy as np

    from assistant.base import rotations

    return float(rotations.to_euler(np.array(base.of(one.pose).quaternion), "ZYX")[0])


def _found_record(one: FoundObject, base: OutputFrame) -> dict[str, Any]:
    pose = base.of(one.pose)
    return {
        "name": one.name,
        "object": one.object.name,
        "position": list(pose.position),
        "quaternion": list(pose.quaternion),
        "sigma_mm": one.estimate.sigma_mm,
        "sigma_deg": one.estimate.sigma_deg,
        "confidence": min(one.confidence, 1.0),
        "cameras": list(one.cameras),
    }
