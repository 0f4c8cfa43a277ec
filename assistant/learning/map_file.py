"""Files of learned maps: NPZ archives of numbers and texts, with a version.

Nothing in an archive is executed; sizes in headers are compared with the data before an array is
made.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path as FilePath
from tokenize import TokenError
from typing import Any, Final

import numpy as np

from assistant.base.budgets import most_unpacked
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.file_sets import write_all
from assistant.base.source_text import read_bytes
from assistant.learning.extended_map import ExtendedMap, MapScale, MapTask
from assistant.learning.map_training import MOST_UNITS
from assistant.learning.rules import NO_MAP, OTHER_MAP_VERSION

_VERSION: Final = 1
_FILE_KIND: Final = "learned map"
COLUMNS: Final = (
    *("shape", "middle", "frame", "low", "high", "places", "answers", "wins", "missed"),
    *("about", "kind", "robot", "axes", "cameras"),
)
_LONGEST_TEXT: Final = 1000
"""Characters of a text."""
_MOST_NUMBERS: Final = 1000
"""Largest number of values of a picture."""
_LARGEST_NUMBER: Final = 1e9
"""No number of a map that learns comes near it."""
_READ_ERRORS: Final = (
    *(zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError),
    *(OSError, ValueError, SyntaxError, TypeError, MemoryError, RecursionError, TokenError),
)
"""Exceptions that readers of archives and headers raise for damaged and foreign content."""


def save_map(
    net: ExtendedMap, path: str | FilePath, beside: Mapping[FilePath, bytes] | None = None
) -> None:
    """Writes a map; the file appears whole or not at all. Raises Refused if it cannot be.

    beside: other files, which appear with it.
    """
    buffer, task, scale = io.BytesIO(), net.task, net.scale
    columns: dict[str, Any] = {
        "kind": np.array(_FILE_KIND),
        "about": np.array([_VERSION, net.steps, task.points], dtype=np.float64),
        "robot": np.array(task.robot),
        "axes": np.array("\n".join(task.axes)),
        "cameras": np.array("\n".join(task.cameras)),
        "shape": np.array(net.shape, dtype=np.float64),
        **{name: getattr(scale, name) for name in ("middle", "frame", "low", "high")},
        **{name: getattr(net, name) for name in ("places", "answers", "wins", "missed")},
    }
    np.savez_compressed(buffer, **columns)
    write_all({FilePath(path): buffer.getvalue(), **(beside or {})})


def load_map(path: str | FilePath) -> ExtendedMap:
    """Read the map of a file. Raises Unreadable or Refused, with a finding, for a file that is not
    a map.
    """
    try:
        columns = _read_columns(read_bytes(path))
    except Refused:
        raise
    except _READ_ERRORS as wrong:
        reason = " ".join(str(wrong).split())[:120] or type(wrong).__name__
        raise Unreadable(NO_MAP(path=str(path), reason=reason)) from None
    about = columns.get("about", np.zeros(0))
    if str(columns.get("kind")) == _FILE_KIND and about.shape == (3,) and about[0] != _VERSION:
        finding = OTHER_MAP_VERSION(path=str(path), version=float(about[0]), known=_VERSION)
        raise Refused(finding, exit_status=2)
    reason = _map_fault(columns)
    if reason:
        raise Unreadable(NO_MAP(path=str(path), reason=reason))
    axes, cameras = (tuple(str(columns[name]).split("\n")) for name in ("axes", "cameras"))
    task = MapTask(str(columns["robot"]), axes, cameras, int(about[2]))
    scale = MapScale(*(columns[name] for name in ("middle", "frame", "low", "high")))
    places, answers, wins, missed = (columns[n] for n in ("places", "answers", "wins", "missed"))
    shape = tuple(int(count) for count in columns["shape"])
    return ExtendedMap(task, shape, scale, places, answers, wins, missed, int(about[1]))


def _read_columns(data: bytes) -> dict[str, Any]:
    """Return the members of an archive by name; no content is executed."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = archive.infolist()
        if sum(member.file_size for member in members) > most_unpacked():
            raise ValueError("it unpacks to more than is read")
        return {
            member.filename.removesuffix(".npy"): _read_array(archive.read(member))
            for member in members
        }


def _read_array(data: bytes) -> Any:
    """Return a column of float64, or a text; raises ValueError for anything else.

    The size in its header is compared with the available data before an array is made.
    """
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("a column has another format than numpy writes")
    shape, fortran, kind = np.lib.format.read_array_header_1_0(
        stream, max_header_size=_LONGEST_TEXT
    )
    text = kind.kind == "U" and shape == () and kind.itemsize <= 4 * _LONGEST_TEXT
    if kind.hasobject or not (kind == np.float64 or text):
        raise ValueError(f"a column holds `{str(kind)[:40]}`, which no map has")
    if len(data) - stream.tell() != math.prod(shape) * kind.itemsize:
        raise ValueError("a column is shorter or longer than it says")
    flat = np.frombuffer(data, kind, offset=stream.tell())
    return flat.reshape(shape, order="F" if fortran else "C").copy()


def _map_fault(columns: dict[str, Any]) -> str:
    """Return the fault that makes columns unusable as a map, empty if they are a map."""
    if str(columns.get("kind")) != _FILE_KIND:
        return "it says to be something else"
    missing = [name for name in COLUMNS if name not in columns]
    if missing:
        return f"it lacks {', '.join(missing)}"
    numbers = {n: c for n, c in columns.items() if c.dtype == np.float64}
    if {"robot", "axes", "cameras"} & numbers.keys() or len(numbers) < len(COLUMNS) - 4:
        return "texts and numbers are mixed up"
    if not all(
        (np.abs(c) <= _LARGEST_NUMBER).all() for name, c in numbers.items() if name != "missed"
    ):
        return "it holds numbers that are none"
    shape, about = columns["shape"], columns["about"]
    if about.shape != (3,) or not (about[1] >= 0.0 and 1.0 <= about[2] <= _MOST_NUMBERS):
        return "its `about` is not version, steps and points"
    if shape.ndim != 1 or not 1 <= len(shape) <= 6 or (shape < 2.0).any():
        return "its lattice is none"
    if shape.prod() > MOST_UNITS or (shape != np.floor(shape)).any():
        return "its lattice is none"
    axes, cameras = (len(str(columns[name]).split("\n")) for name in ("axes", "cameras"))
    n, d, a = int(shape.prod()), int(2 * cameras * about[2]), axes
    wanted = {
        "middle": (d,),
        "frame": (d, d),
        "low": (a,),
        "high": (a,),
        "places": (n, d),
        "answers": (n, a + a * d),
        "wins": (n,),
        "missed": (n,),
    }
    wrong = [name for name, size in wanted.items() if columns[name].shape != size]
    if wrong:
        return f"{', '.join(wrong)} of it do not fit the rest"
    if not (columns["low"] < columns["high"]).all():
        return "its ranges of joints are empty"
    if abs(np.linalg.det(columns["frame"])) == 0.0 or (columns["wins"] < 0.0).any():
        return "its scales are none"
    return ""
