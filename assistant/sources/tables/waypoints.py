"""Waypoints: arrays (NPY, NPZ), JSON, and pose objects; each becomes a path in columns.

An array is (n, 7), position in mm and quaternion w x y z, or (n, 4, 4), homogeneous matrices with
the position in mm in the last column.

NPZ: `positions` (n, 3) with `quaternions` (n, 4), or any number of arrays as above, each a path of
its own name. JSON: a list of poses, or an object with `poses` (a list) or `paths` (lists by name).
A pose is `{"position": [x, y, z], "quaternion": [w, x, y, z]}`, a list of 7 or four rows of 4.
Both kinds of file may state a `unit`: `"mm"` or `"m"`.
"""

from __future__ import annotations

import json
import pathlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Severity,
    Span,
    Unreadable,
    error,
    has_errors,
)
from assistant.base.length_units import UNITS
from assistant.base.source_text import decode, read_bytes
from assistant.program.motion import Kind, Path
from assistant.program.program import Program, identifier
from assistant.program.se3 import METRE, NO_UNIT, AnyPoses, Unit, stacked
from assistant.sources.contours.path_tolerance import shortest_piece
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.reading import Reading
from assistant.sources.tables import rows
from assistant.sources.tables.headers import shown
from assistant.sources.tables.npy_files import read_npy, read_npz
from assistant.sources.tables.rows import (
    metres_finding,
    poses_of_matrices,
    position_findings,
    unit_quaternions,
)

ERROR: Final = Severity.ERROR
_SHAPE = error(
    "TB411",
    "the shape is {shape}, neither (n, 7) nor (n, 4, 4)",
    "give rows of x y z w x y z, or homogeneous matrices",
)
_NO_POSES = error("TB412", "there is no pose in it", "write the file again")
_NO_PART = error(
    "TB415", "there is no array {name}", "give both `positions` (n, 3) and `quaternions` (n, 4)"
)
_UNKNOWN_UNIT = error("TB413", "the unit {unit} is not known", "write `mm` or `m`")
_UNEVEN = error(
    "TB414",
    "{positions} positions but {quaternions} quaternions",
    "give as many of the one as of the other",
)
_NOT_JSON = error("TB421", "this is no JSON: {reason}", "mend it at this place")
_JSON_FORM = error(
    "TB422",
    "{what} is no list of poses",
    "give a list of poses, or an object with `poses` or `paths`",
)
_UNKNOWN_KEY = error("TB423", "the key {name} is not known", "write one of {known}")
_POSE_FORM = error(
    "TB424",
    "the pose is not of the form {wanted}",
    "write every pose as the first one, with all its numbers",
)
_KEY_TWICE = error("TB425", "the key {name} stands twice in one object", "keep one of them")
_UNITS: Final = tuple(METRE)


def read(path: pathlib.Path, process: Process) -> Reading:
    """The pseudo-program of an NPY, NPZ or JSON file; raises Unreadable or Refused."""
    return _READERS[path.suffix.lower()](read_bytes(path), str(path), path.stem, process)


def from_poses(
    poses: AnyPoses, process: Process = NO_PROCESS, name: str = "path", *, unit: Unit
) -> Program:
    """The program that follows poses; `read_poses` tells what was found on the way as well."""
    return read_poses(poses, process, name, unit=unit).program


def read_poses(
    poses: AnyPoses, process: Process = NO_PROCESS, name: str = "path", *, unit: Unit | None
) -> Reading:
    """The program that follows a sequence of poses.

    poses: of any form of `se3.columns_of`. unit: of their positions, None if each is a `Pose`; it
    is not guessed, roboticstoolbox uses metres. Raises Refused.
    """
    if unit is not None and unit not in _UNITS:
        raise Refused(_UNKNOWN_UNIT(place="unit", unit=shown(str(unit))))
    given, in_mm = stacked(poses)
    if unit is None and not in_mm:
        raise Refused(NO_UNIT(place="unit", what="poses"))
    measured: Unit | None = "mm" if in_mm else unit
    path, findings = _path_of(identifier(str(name)), given, process, measured, None, "poses")
    return _reading(name, [path], process, None, findings)


def _read_npy(data: bytes, path: str, stem: str, process: Process) -> Reading:
    name, notes = rows.program_name(stem, path)
    one, findings = _path_of(name, read_npy(data, path), process, None, path, "")
    return _reading(name, [one], process, path, [*notes, *findings])


def _read_npz(data: bytes, path: str, stem: str, process: Process) -> Reading:
    arrays, texts = read_npz(data, path)
    unit = texts.pop("unit", None)
    name, notes = rows.program_name(stem, path)
    for text in texts:
        notes.append(_UNKNOWN_KEY(path=path, name=shown(text), known="`unit` or arrays"))
    if {"positions", "quaternions"} & set(arrays):
        given = _joined_parts(arrays, path)
        parts = {"": given}
    else:
        parts = arrays
    return _program_of_arrays(name, parts, process, unit, path, notes)


def _joined_parts(arrays: Mapping[str, Floats], path: str) -> Floats:
    """`positions` (n, 3) and `quaternions` (n, 4) as one array (n, 7)."""
    known = {"positions": 3, "quaternions": 4}
    findings = [
        _UNKNOWN_KEY(path=path, name=shown(name), known="`positions`, `quaternions`, `unit`")
        for name in arrays
        if name not in known
    ]
    for name, width in known.items():
        if name not in arrays:
            findings.append(_NO_PART(path=path, name=shown(name)))
        elif arrays[name].ndim != 2 or arrays[name].shape[1] != width:
            findings.append(_SHAPE(path=path, place=shown(name), shape=_shape(arrays[name])))
    if not findings and len(arrays["positions"]) != len(arrays["quaternions"]):
        counts: dict[str, Any] = {name: len(arrays[name]) for name in known}
        findings.append(_UNEVEN(path=path, **counts))
    if findings:
        raise Refused(*findings)
    return np.concatenate([arrays["positions"], arrays["quaternions"]], axis=1)


def _read_json(data: bytes, path: str, stem: str, process: Process) -> Reading:
    source = decode(data, path, ("utf-8-sig", "utf-8"))
    try:
        document = json.loads(
            source.text, object_pairs_hook=lambda pairs: _unique_keys(pairs, path)
        )
    except json.JSONDecodeError as error:
        found = source.finding(_NOT_JSON, Span(error.pos, error.pos + 1), reason=error.msg)
        excerpt = found.excerpt or ""
        shows = excerpt if excerpt.isprintable() and len(excerpt) <= 200 else None
        raise Unreadable(replace(found, excerpt=shows)) from None
    except Refused:
        # Refused is a ValueError, and has its finding already.
        raise
    except (RecursionError, ValueError) as error:
        reason = "too many levels" if isinstance(error, RecursionError) else "a number too long"
        raise Unreadable(_NOT_JSON(path=path, reason=reason)) from None
    name, notes = rows.program_name(stem, path)
    unit = None
    if isinstance(document, dict):
        unit = document.pop("unit", None)
        if "poses" in document and "paths" not in document:
            lists = {"": document.pop("poses")}
        else:
            lists = document.pop("paths", None)
        notes += [
            _UNKNOWN_KEY(path=path, name=shown(key), known="`unit`, `poses`, `paths`")
            for key in document
        ]
    else:
        lists = {"": document}
    if has_errors(notes):
        raise Refused(*notes)
    if not isinstance(lists, dict):
        raise Refused(_JSON_FORM(path=path, what="the file"))
    parts = {key: _array_of_json(value, path, key) for key, value in lists.items()}
    return _program_of_arrays(name, parts, process, unit, path, notes)


def _unique_keys(pairs: list[tuple[str, Any]], path: str) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        keys = [key for key, _ in pairs]
        name = next(key for key in keys if keys.count(key) > 1)
        raise Refused(_KEY_TWICE(path=path, name=shown(name)))
    return found


def _array_of_json(poses: Any, path: str, key: str) -> Floats:
    """A list of poses, all of the form of the first, as an array (n, 7) or (n, 4, 4)."""
    what = shown(key) if key else "the file"
    if not isinstance(poses, list):
        raise Refused(_JSON_FORM(path=path, what=what))
    if not poses:
        raise Refused(_NO_POSES(path=path, place=shown(key) if key else None))
    first = poses[0]
    if isinstance(first, dict):
        wanted = '{"position": [x, y, z], "quaternion": [w, x, y, z]}'
        fits = _is_named_pose
        numbers: Any = (p["position"] + p["quaternion"] for p in poses)
    elif isinstance(first, list) and len(first) == 4:
        wanted, fits, numbers = "four rows of 4 numbers", _is_matrix, poses
    else:
        wanted, fits, numbers = "[x, y, z, w, x, y, z]", _is_seven, poses
    for index, pose in enumerate(poses):
        if not fits(pose):
            raise Refused(_POSE_FORM(path=path, place=f"{key}[{index}]", wanted=wanted))
    try:
        return np.array(list(numbers), dtype=np.float64)
    except OverflowError:
        raise Refused(
            _POSE_FORM(path=path, place=key or None, wanted="of finite numbers")
        ) from None


def _is_list(value: Any, size: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) == size
        and all(type(v) is float or type(v) is int for v in value)
    )


def _is_seven(pose: Any) -> bool:
    return _is_list(pose, 7)


def _is_matrix(pose: Any) -> bool:
    return isinstance(pose, list) and len(pose) == 4 and all(_is_list(row, 4) for row in pose)


def _is_named_pose(pose: Any) -> bool:
    return (
        isinstance(pose, dict)
        and pose.keys() == {"position", "quaternion"}
        and _is_list(pose["position"], 3)
        and _is_list(pose["quaternion"], 4)
    )


def _program_of_arrays(
    name: str,
    parts: Mapping[str, Floats],
    process: Process,
    unit: Any,
    path: str,
    notes: list[Diagnostic],
) -> Reading:
    """A program of one path for each array; an array without a name gets the program's."""
    if unit is not None and unit not in _UNITS:
        raise Refused(_UNKNOWN_UNIT(path=path, place="`unit`", unit=shown(str(unit))))
    if not parts:
        raise Refused(_NO_POSES(path=path))
    names, paths, findings = rows.RowNames(), list[Path](), list(notes)
    first = next(iter(parts))
    for key, array in parts.items():
        path_name = names.of(key, {"path": path, "place": shown(key)}, shown(key)) if key else name
        one, found = _path_of(path_name, array, process, unit, path, key, first=key == first)
        findings += found
        # A path that begins where the one before ends would begin with a stop.
        if process.merges and paths and len(one) > 1 and _begins_where(paths[-1], one):
            findings.append(rows.REPEATED(path=path, place=f"{key}[0]", count=1, first="row 0"))
            one = one.rows(1, len(one), one.name)
        paths.append(one)
    return _reading(name, paths, process, path, [*findings, *names.findings])


def _begins_where(before: Path, path: Path) -> bool:
    """True if a path begins where the one before it ends."""
    both = (
        np.stack([p[i] for p, i in ((a, -1), (b, 0))])
        for a, b in ((before.positions, path.positions), (before.quaternions, path.quaternions))
    )
    positions, quaternions = both
    return not rows.moving_rows(positions, quaternions, np.full(2, Kind.LINEAR, np.uint8))[1]


def _path_of(
    name: str,
    array: Floats,
    process: Process,
    unit: Unit | None,
    path: str | None,
    place: str,
    *,
    first: bool = True,
) -> tuple[Path, list[Diagnostic]]:
    """A path in columns of an array (n, 7) or (n, 4, 4); place: what to call the array.

    first: the program begins with it. Raises Refused with everything that is wrong with its rows.
    """
    where: dict[str, Any] = {"path": path, "place": place or None}

    def locate(row: int) -> dict[str, Any]:
        return {"path": path, "place": f"{place}[{row}]"}

    if array.ndim not in (2, 3) or array.shape[1:] not in ((7,), (4, 4)):
        raise Refused(_SHAPE(**where, shape=_shape(array)))
    if not len(array):
        raise Refused(_NO_POSES(**where))
    if array.ndim == 3:
        positions, quaternions, findings = poses_of_matrices(array, locate)
    else:
        positions = array[:, :3]
        quaternions, findings = unit_quaternions(array[:, 3:], locate)
    measured = unit or process.unit
    with np.errstate(over="ignore"):  # what overflows is refused as not finite
        positions = positions * UNITS[measured or "mm"][1]
    if array.ndim == 2 or not has_errors(findings):
        findings += position_findings(positions, locate)
    findings += rows.default_findings(process, path)
    if has_errors(findings):
        raise Refused(*findings)
    if measured is None:
        findings += metres_finding(positions, where)
    kinds = np.full(len(array), rows.default_kind(process), dtype=np.uint8)
    kept = np.ones(len(array), dtype=np.bool_)
    if process.merges:
        kept = rows.moving_rows(positions, quaternions, kinds)
    if not kept.all():
        row, count = int(np.argmin(kept)), int(np.count_nonzero(~kept))
        findings.append(rows.REPEATED(**locate(row), count=count, first=f"row {row}"))
        positions, quaternions, kinds = positions[kept], quaternions[kept], kinds[kept]
    motions, off = rows.default_motions(len(kinds), process), 0.0
    if process.merges:
        needed, off = rows.needed_rows(positions, quaternions, kinds, motions, process.tolerance)
        if not needed.all():
            row = int(np.flatnonzero(kept)[int(np.argmin(needed))])
            about: dict[str, Any] = {"short": shortest_piece(process.tolerance), "deviation": off}
            count = int(np.count_nonzero(~needed))
            told = rows.THINNED_ROWS(**locate(row), count=count, first=f"row {row}", **about)
            findings.append(told)
            positions, quaternions, kinds = positions[needed], quaternions[needed], kinds[needed]
            motions = motions.those(needed)
    kinds = rows.beginning_kinds(kinds) if first else kinds
    travels = first and rows.begins_with_approach(kinds)
    # A path begins and ends at a stop, also beside other paths.
    motions = motions.approached(process.defaults.travel if travels else None).stopped()
    columns = motions.rounded(positions, kinds, process.tolerance - off)
    return Path.of(name, positions, quaternions, kinds=kinds, **columns), findings


def _reading(
    name: str,
    paths: list[Path],
    process: Process,
    path: str | None,
    findings: list[Diagnostic],
) -> Reading:
    placed = tuple(f.within(path) for f in findings)
    if has_errors(placed):
        raise Refused(*placed)
    return Reading(rows.paths_program(identifier(name), paths, process), placed)


def _shape(array: Floats) -> str:
    return "(" + ", ".join(str(extent) for extent in array.shape) + ")"


_READERS: Final = {".npy": _read_npy, ".npz": _read_npz, ".json": _read_json}
