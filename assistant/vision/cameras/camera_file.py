"""Camera files: lens and pose of each camera, date and residuals of its calibration, its pictures.

[cameras.left]
size = [640, 480]
focal = [801.2, 800.7]        # pixels
centre = [318.9, 241.3]       # pixels, from the middle of the upper left one
distortion = [-0.2, 0.05, 0.0, 0.0, 0.0]   # k1, k2, p1, p2, k3
position = [-300, -950, 300]  # mm, in its parent; z of the camera looks ahead, y down
quaternion = [0.7, -0.7, 0, 0]
parent = "world"              # or a link of a robot: arm.flange
calibrated = 2026-11-25
residual_px = 0.21            # of the lens; pair_px of the pose to the first camera
hand_eye_mm = 0.3             # of the pose to the arm; hand_eye_degrees as well
source = "pictures/left"      # a folder, a file, an address, or the number of a device
"""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.file_sets import write_files
from assistant.base.near_names import near_names
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.base.toml_edits import toml_text
from assistant.cell.body_tables import PLACE_KEYS, pose_of
from assistant.program import settings_tables
from assistant.program.geometry import Pose
from assistant.program.settings_tables import ENCODINGS, Table, Wrong, kind_of, read_toml
from assistant.vision import rules
from assistant.vision.cameras.camera import WORLD, Camera, Lens

_MOST_PIXELS: Final = 32_768
"""Along one side."""
_LONGEST_FOCAL: Final = 100.0
"""Focal length as so many times the width of the picture; no lens of a cell is longer."""


@dataclass(frozen=True, slots=True)
class CalibrationRecord:
    """Record of a camera's calibration: its date, and the residuals, root mean square.

    residual: pixels, of its lens. pair: pixels, of its pose relative to the first camera. mm,
    degrees: of its pose relative to the arm.
    """

    date: datetime.date | None = None
    residual: float | None = None
    pair: float | None = None
    mm: float | None = None
    degrees: float | None = None


@dataclass(frozen=True, slots=True)
class Rig:
    """Cameras by name, with how each was calibrated, and where its pictures come from ("" if the
    file does not say). Files that `sources` names stand relative to `folder`.
    """

    cameras: Mapping[str, Camera]
    records: Mapping[str, CalibrationRecord] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    folder: FilePath = FilePath()

    def __getitem__(self, name: str) -> Camera:
        """Return the camera of a name; raises Refused (exit status 2) for an unknown name."""
        if name not in self.cameras:
            known = ", ".join(near_names(name, self.cameras) or self.cameras)
            raise Refused(rules.NO_CAMERA(name=name, known=known), exit_status=2)
        return self.cameras[name]


def read_cameras(path: str | FilePath) -> Rig:
    """The cameras of a file; raises Unreadable, or Refused with a finding for each wrong key."""
    data = read_bytes(path, most=SETTINGS_FILE)
    return cameras_in(decode(data, str(path), ENCODINGS), FilePath(path).parent)


def cameras_in(source: SourceText, folder: FilePath = FilePath()) -> Rig:
    """The cameras of a text."""
    top = read_toml(source)
    top.read({"cameras": lambda value: value})
    tables = list(top.table("cameras").named())
    cameras, records, sources = (
        dict[str, Camera](),
        dict[str, CalibrationRecord](),
        dict[str, str](),
    )
    for name, table in tables:
        said = table.read(_KEYS)
        if (camera := _camera(name, table, said)) is not None:
            cameras[name] = camera
            records[name] = CalibrationRecord(
                said.get("calibrated"), *(said.get(key) for key in _RESIDUAL_KEYS)
            )
            sources[name] = said.get("source", "")
    if not tables:
        top.say(rules.NO_CAMERAS)
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    return Rig(cameras, records, sources, folder)


def write_cameras(path: str | FilePath, rig: Rig) -> None:
    """Writes the file whole or not at all; numbers come back as they are."""
    file = FilePath(path)
    write_files({file.name: rig_toml(rig).encode("utf-8")}, file.parent)


def rig_toml(rig: Rig) -> str:
    """The file of a rig, as `read_cameras` reads it."""
    return toml_text({"cameras": {name: _camera_table(rig, name) for name in rig.cameras} or None})


def _camera_table(rig: Rig, name: str) -> dict[str, Any]:
    camera, record = rig.cameras[name], rig.records.get(name, CalibrationRecord())
    lens, pose = camera.lens, camera.pose
    residuals = (record.residual, record.pair, record.mm, record.degrees)
    return {
        "size": lens.size,
        "focal": lens.focal,
        "centre": lens.centre,
        "distortion": lens.distortion,
        "position": pose.position,
        "quaternion": pose.quaternion,
        "parent": camera.parent,
        "calibrated": record.date,
        **dict(zip(_RESIDUAL_KEYS, residuals, strict=True)),
        "source": rig.sources.get(name) or None,
    }


# ----------------------------------------------------------------------------------- keys


def _numbers(count: int, least: float, most: float) -> settings_tables.Read:
    one = settings_tables.number("", least=least, most=most)

    def read(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            what = (
                f"has {len(value)} entries" if isinstance(value, list) else f"is {kind_of(value)}"
            )
            raise Wrong(what, f"write {count} numbers in brackets")
        return tuple(map(one, value))

    return read


def _size(value: Any) -> tuple[int, int]:
    one = settings_tables.whole(16, _MOST_PIXELS)
    if not isinstance(value, list) or len(value) != 2:
        raise Wrong("is no size", "write width and height in pixels: [640, 480]")
    return one(value[0]), one(value[1])


def _date(value: Any) -> datetime.date:
    if not isinstance(value, datetime.date):
        raise Wrong(f"is {kind_of(value)}", "write a date without quotes: 2026-11-25")
    return value.date() if isinstance(value, datetime.datetime) else value


def _source(value: Any) -> str:
    """A device is a number."""
    if isinstance(value, int) and not isinstance(value, bool):
        return str(settings_tables.whole(0, 99)(value))
    return settings_tables.text(value)


_RESIDUAL_KEYS: Final = ("residual_px", "pair_px", "hand_eye_mm", "hand_eye_degrees")
"""Keys of the residuals of `CalibrationRecord`, in the order of its fields."""
_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "size": _size,
    "focal": _numbers(2, 1.0, 1e7),
    "centre": _numbers(2, -1e6, 1e6),
    "distortion": _numbers(5, -1e4, 1e4),
    **PLACE_KEYS,
    "parent": settings_tables.text,
    "calibrated": _date,
    "residual_px": settings_tables.number("pixels", least=0.0, most=1e4),
    "pair_px": settings_tables.number("pixels", least=0.0, most=1e4),
    "hand_eye_mm": settings_tables.number("mm", least=0.0, most=1e4),
    "hand_eye_degrees": settings_tables.number("degrees", least=0.0, most=180.0),
    "source": _source,
}
_NEEDED: Final = ("size", "focal", "centre")


def _camera(name: str, table: Table, said: Mapping[str, Any]) -> Camera | None:
    missing = [key for key in _NEEDED if key not in table.content]
    if missing:
        table.say(
            rules.INCOMPLETE_CAMERA, name=name, keys=" and no ".join(f"`{k}`" for k in missing)
        )
    if any(key not in said for key in _NEEDED):
        return None
    lens = Lens(said["size"], said["focal"], said["centre"], said.get("distortion", (0.0,) * 5))
    if (what := _lens_fault(lens)) is not None:
        table.say(rules.BAD_LENS, "focal", name=name, what=what)
        return None
    placed = any(key in said for key in PLACE_KEYS)
    return Camera(name, lens, pose_of(said) if placed else Pose(), said.get("parent", WORLD))


def _lens_fault(lens: Lens) -> str | None:
    """Return the fault of a lens that no camera of a cell can have, None if it has none of them."""
    width, height = lens.size
    if not all(width / 20.0 <= focal <= _LONGEST_FOCAL * width for focal in lens.focal):
        return f"has a focal length of {max(lens.focal):g} pixels for {width} pixels of width"
    if not max(lens.focal) <= 2.0 * min(lens.focal):
        return "has pixels that are twice as long as they are wide"
    if not (-width <= lens.centre[0] <= 2 * width and -height <= lens.centre[1] <= 2 * height):
        return "has its axis far outside of the picture"
    if not lens.whole:
        return "shows two directions in one pixel: its distortion is that of no lens"
    return None
