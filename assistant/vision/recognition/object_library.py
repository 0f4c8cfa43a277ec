"""The object library: a folder with its version, and two files for each object.

library.toml      version = 1
bracket.toml      for the user to edit: height of the object, places and lines of work on it
bracket.npz       outline and texture for recognition: columns of numbers; nothing in it is executed

height = 3.0                     # mm of the face above the surface the object lies on

[places.grasp]
position = [20, 30, 0]           # mm, in the frame of the object
euler_zyx = [0, 0, 180]          # or quaternion; left out: the tool points into the face
approach = 30                    # mm before and after

[lines.glue]
points = [[5, 5], [75, 5]]       # mm, x and y, or with z
vias = []                        # numbers of points, from 0, that arcs pass through
speed = 50                       # mm/s; left out: that of the targets
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable, has_errors
from assistant.base.file_sets import write_files
from assistant.base.source_text import decode, is_file, is_folder, read_bytes
from assistant.base.toml_edits import rounded, toml_item, toml_rows, toml_text
from assistant.program import settings_tables
from assistant.program.geometry import Pose
from assistant.program.program import IDENTIFIER
from assistant.program.settings_tables import ENCODINGS, Read, Table, Wrong, kind_of, read_toml
from assistant.sources.tables.npy_files import read_npz
from assistant.vision.recognition.known_objects import (
    TOOL_INTO_FACE,
    USUAL_APPROACH,
    KnownObject,
    Line,
    Outline,
    Place,
    Texture,
)
from assistant.vision.recognition.outline_edges import symmetry_of
from assistant.vision.rules import (
    BAD_OBJECT_NAME,
    EMPTY_LIBRARY,
    NO_OBJECT,
    NO_OBJECT_LIBRARY,
    OBJECT_EXISTS,
    OTHER_LIBRARY_VERSION,
)

_VERSION: Final = 1
_ARCHIVE_KIND: Final = "known object"
_INDEX_FILE: Final = "library.toml"
_MOST_OBJECTS: Final = 1000
_MOST_POINTS: Final = 100_000
_LARGEST_OBJECT: Final = 1e5
"""mm of an object."""


@dataclass(frozen=True, slots=True)
class Library:
    """Objects by name, in the order of the names; findings: warnings about its files."""

    objects: Mapping[str, KnownObject]
    findings: tuple[Diagnostic, ...] = ()


def read_library(folder: str | FilePath) -> Library:
    """Read all objects of a library; raises Unreadable or Refused, with a finding, for an invalid
    library.
    """
    place = FilePath(folder)
    _check_version(place)
    names = _names_in(place)
    if not names:
        raise Refused(EMPTY_LIBRARY(path=str(folder)), exit_status=2)
    read = [_read_object(place, name) for name in names]
    objects = {one.name: one for one, _ in read}
    return Library(objects, tuple(finding for _, found in read for finding in found))


def _names_in(folder: FilePath) -> list[str]:
    """The objects of a library by the names of their files; raises Refused for too many."""
    names = sorted(
        one.stem for one in folder.glob("*.toml") if one.name != _INDEX_FILE and is_file(one)
    )
    if len(names) > _MOST_OBJECTS:
        reason = f"it has more than {_MOST_OBJECTS} objects"
        raise Refused(
            NO_OBJECT_LIBRARY(path=str(folder), name=folder, reason=reason), exit_status=2
        )
    for name in names:
        check_name(name, str(folder))
    return names


def check_name(name: str, path: str | None = None) -> None:
    """Raises Refused for what cannot name an object."""
    if IDENTIFIER.fullmatch(name) is None or name.lower() == FilePath(_INDEX_FILE).stem:
        raise Refused(BAD_OBJECT_NAME(path=path, name=settings_tables.shown(name)), exit_status=2)


def add_objects(
    folder: str | FilePath, objects: Iterable[KnownObject], *, again: bool = False
) -> tuple[FilePath, ...]:
    """Write objects into a library, which is created if it is missing; all of them or none.

    again: True to replace objects of the same names. Raises Refused or Unreadable.
    """
    place = FilePath(folder)
    there: set[str] = set()
    if is_folder(place) and any(place.iterdir()):
        _check_version(place)
        there = {name.lower() for name in _names_in(place)}
    files = {_INDEX_FILE: f"version = {_VERSION}\n".encode()}
    for one in objects:
        check_name(one.name)
        if one.name.lower() in there and not again:
            raise Refused(OBJECT_EXISTS(path=str(folder), name=one.name), exit_status=2)
        files[f"{one.name}.toml"] = _object_toml(one).encode()
        files[f"{one.name}.npz"] = _archive(one)
    return write_files(files, place)


def _object_toml(one: KnownObject) -> str:
    """Return the part of an object that people may edit, as TOML."""
    height = toml_item(round(one.height, 6))
    height.comment("mm of its face above what it lies on")
    places = {
        name: {
            "position": rounded(place.pose.position, 4),
            "quaternion": rounded(place.pose.quaternion, 9),
            "approach": round(place.approach, 6),
        }
        for name, place in one.places.items()
    }
    lines = {
        name: {
            "points": toml_rows([rounded(point, 4) for point in line.points]),
            "vias": sorted(line.vias) or None,
            "quaternion": rounded(line.quaternion, 9),
            "approach": round(line.approach, 6),
            "speed": None if line.speed is None else round(line.speed, 6),
        }
        for name, line in one.lines.items()
    }
    head = f"# {one.source}\n" if one.source.isprintable() and one.source else ""
    return head + toml_text({"height": height, "places": places or None, "lines": lines or None})


def _check_version(folder: FilePath) -> None:
    index, name = folder / _INDEX_FILE, str(folder)
    if not is_folder(folder):
        raise Unreadable(
            NO_OBJECT_LIBRARY(path=name, name=folder, reason="there is no such folder")
        )
    if not is_file(index):
        raise Unreadable(
            NO_OBJECT_LIBRARY(path=name, name=folder, reason=f"it has no {_INDEX_FILE}")
        )
    top = read_toml(decode(read_bytes(index, most=SETTINGS_FILE), str(index), ENCODINGS))
    version = top.content.get("version")
    if isinstance(version, bool) or not isinstance(version, int):
        reason = f"{_INDEX_FILE} says no version"
        raise Unreadable(NO_OBJECT_LIBRARY(path=str(index), name=folder, reason=reason))
    if version != _VERSION:
        found = OTHER_LIBRARY_VERSION(path=str(index), version=version, known=_VERSION)
        raise Refused(found, exit_status=2)


def _read_object(folder: FilePath, name: str) -> tuple[KnownObject, list[Diagnostic]]:
    path = folder / f"{name}.toml"
    source = decode(read_bytes(path, allow_empty=True, most=SETTINGS_FILE), str(path), ENCODINGS)
    top = read_toml(source)
    found = top.read({"height": _HEIGHT, "places": _as_it_is, "lines": _as_it_is})
    places = {n: _read_place(t) for n, t in top.table("places").named()}
    lines = {n: _read_line(t) for n, t in top.table("lines").named()}
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    outline, texture = _read_features(folder / f"{name}.npz")
    one = KnownObject(
        *(name, outline, texture, found.get("height", 0.0)),
        symmetry=1 if outline is None or texture is not None else symmetry_of(outline),
        places=places,
        lines=lines,
        source=str(path),
    )
    return one, top.page.findings


_HEIGHT: Final = settings_tables.number("mm", least=0.0, most=_LARGEST_OBJECT)


def _as_it_is(value: Any) -> Any:
    return value


def _points(value: Any) -> Floats:
    cure = "write points of two or three numbers in brackets"
    if not isinstance(value, list) or len(value) < 2 or len(value) > _MOST_POINTS:
        raise Wrong("is no list of two points and more", cure)
    one = settings_tables.number("mm", least=-_LARGEST_OBJECT, most=_LARGEST_OBJECT)
    read = []
    for point in value:
        if not isinstance(point, list) or len(point) not in (2, 3):
            raise Wrong(f"holds {kind_of(point)} that is no point", cure)
        read.append([*(one(v) for v in point), 0.0][:3])
    return np.array(read)


def _via_numbers(value: Any) -> frozenset[int]:
    if not isinstance(value, list):
        raise Wrong(f"is {kind_of(value)}", "write the numbers of points in brackets")
    return frozenset(settings_tables.whole(0, _MOST_POINTS)(v) for v in value)


_TURN_KEYS: Final[Mapping[str, Read]] = {
    "quaternion": lambda value: settings_tables.quaternion(value)[0],
    "euler_zyx": settings_tables.euler_zyx,
    "approach": settings_tables.number("mm", least=0.0, most=_LARGEST_OBJECT),
}
_PLACE_KEYS: Final[Mapping[str, Read]] = {"position": settings_tables.position, **_TURN_KEYS}
_LINE_KEYS: Final[Mapping[str, Read]] = {
    "points": _points,
    "vias": _via_numbers,
    "speed": settings_tables.number("mm/s", above=0.0),
    **_TURN_KEYS,
}


def _read_place(table: Table) -> Place:
    found = table.read(_PLACE_KEYS)
    pose = Pose(found.get("position", (0.0, 0.0, 0.0)), _read_turn(table, found))
    return Place(pose, found.get("approach", USUAL_APPROACH))


def _read_turn(table: Table, found: Mapping[str, Any]) -> tuple[float, float, float, float]:
    if "quaternion" in found and "euler_zyx" in found:
        table.say(NO_OBJECT, "euler_zyx", reason="it gives an orientation twice")
    turn: tuple[float, float, float, float] = found.get(
        "quaternion", found.get("euler_zyx", TOOL_INTO_FACE)
    )
    return turn


def _read_line(table: Table) -> Line:
    found = table.read(_LINE_KEYS)
    points, vias = found.get("points", np.zeros((2, 3))), found.get("vias", frozenset())
    if "points" not in table.content:
        table.say(NO_OBJECT, reason=f"the line `{table.path[-1]}` has no points")
    # An arc has an end, and none begins in the middle of another.
    if any(not 0 < via < len(points) - 1 or via + 1 in vias for via in vias):
        table.say(NO_OBJECT, "vias", reason="arcs pass through points between their ends only")
    rest = _read_turn(table, found), found.get("approach", USUAL_APPROACH), found.get("speed")
    return Line(points, vias, *rest)


def _archive(one: KnownObject) -> bytes:
    buffer = io.BytesIO()
    columns: dict[str, Any] = {
        "kind": np.array(_ARCHIVE_KIND),
        "version": np.array([float(_VERSION)]),
    }
    if one.outline is not None:
        columns["outline"] = one.outline.points
        columns["rings"] = np.array([len(ring) for ring in one.outline.rings], dtype=np.int64)
    if one.texture is not None:
        columns["points"] = one.texture.points
        columns["descriptors"] = one.texture.descriptors
        if one.texture.picture is not None:
            columns["picture"] = one.texture.picture
            columns["size"] = np.array(one.texture.size)
    np.savez_compressed(buffer, **columns)
    return buffer.getvalue()


def _read_features(path: FilePath) -> tuple[Outline | None, Texture | None]:
    arrays, texts = read_npz(read_bytes(path), str(path))
    reason = "" if texts.get("kind") == _ARCHIVE_KIND else "the archive says to be something else"
    version = arrays.get("version", np.zeros(0))
    if not reason and version.shape == (1,) and version[0] != _VERSION:
        told = OTHER_LIBRARY_VERSION(path=str(path), version=f"{version[0]:g}", known=_VERSION)
        raise Refused(told, exit_status=2)
    reason = reason or _archive_fault(arrays)
    if reason:
        raise Unreadable(NO_OBJECT(path=str(path), reason=reason))
    outline = texture = None
    if "outline" in arrays:
        ends = np.cumsum(arrays["rings"].astype(np.int64))[:-1]
        outline = Outline(tuple(np.split(arrays["outline"], ends)))
    if "points" in arrays:
        flat = "picture" in arrays
        texture = Texture(
            arrays["points"],
            arrays["descriptors"].astype(np.uint8),
            arrays["picture"].astype(np.uint8) if flat else None,
            (float(arrays["size"][0]), float(arrays["size"][1])) if flat else None,
        )
    return outline, texture


def _archive_fault(arrays: Mapping[str, Floats]) -> str:
    """Return the fault that makes columns unusable as an object, empty if they are one."""
    if not all(np.isfinite(one).all() and one.size <= 2e8 for one in arrays.values()):
        return "it holds what is no number"
    if "outline" not in arrays and "points" not in arrays:
        return "it has neither an outline nor keypoints"
    if "outline" in arrays:
        outline, rings = arrays["outline"], arrays.get("rings", np.zeros(0))
        if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) > _MOST_POINTS:
            return "its outline has no two columns"
        if rings.ndim != 1 or not len(rings) or (rings < 3).any() or (rings % 1 != 0).any():
            return "its rings are no numbers of points"
        if rings.sum() != len(outline):
            return "its rings and its outline differ in length"
        if np.abs(outline).max() > _LARGEST_OBJECT or np.ptp(outline, axis=0).min() < 1e-3:
            return "its outline has no area"
    if "points" in arrays:
        points, descriptors = arrays["points"], arrays.get("descriptors", np.zeros(0))
        if points.ndim != 2 or points.shape[1] != 3 or not 2 <= len(points) <= _MOST_POINTS:
            return "its keypoints are no places"
        if descriptors.shape != (len(points), 128):
            return "its descriptors are not one for each keypoint"
        if (
            (descriptors < 0).any()
            or (descriptors > 255).any()
            or np.abs(points).max() > _LARGEST_OBJECT
        ):
            return "its descriptors or places are out of range"
    if "picture" in arrays:
        picture, size = arrays["picture"], arrays.get("size", np.zeros(0))
        if picture.ndim != 2 or min(picture.shape) < 16 or size.shape != (2,) or (size <= 0).any():
            return "its picture has no size"
        if (picture < 0).any() or (picture > 255).any():
            return "its picture has no grey levels"
    return ""
