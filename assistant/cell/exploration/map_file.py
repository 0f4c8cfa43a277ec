"""Maps of explored space as files: NPZ archives with the columns of `Occupancy` and a version."""

from __future__ import annotations

import io
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Ints
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.file_sets import write_all
from assistant.base.source_text import read_bytes
from assistant.cell.exploration.occupancy import Occupancy
from assistant.cell.exploration.rules import NEWER_MAP, NO_MAP
from assistant.sources.tables.arrays import read_npz

MAP_VERSION: Final = 1
MAP_KIND: Final = "explored space"
MAP_COLUMNS: Final = ("keys", "filled", "touched", "free")
LARGEST_EXACT: Final = 2.0**53
"""The largest number that columns keep exactly: they are read as float64."""


def save_map(occupancy: Occupancy, path: str | FilePath) -> None:
    """Writes a map; the file appears whole or not at all. Raises Refused if it cannot be."""
    buffer = io.BytesIO()
    columns: dict[str, Any] = {name: getattr(occupancy, name) for name in MAP_COLUMNS}
    columns["keys"] = np.stack([occupancy.keys >> 32, occupancy.keys & 0xFFFFFFFF])
    columns["free"] = occupancy.free.astype(np.uint8)
    numbers = np.array([MAP_VERSION, occupancy.size, occupancy.runs], dtype=np.float64)
    np.savez_compressed(
        buffer, kind=np.array(MAP_KIND), robot=np.array(occupancy.robot), about=numbers, **columns
    )
    write_all({FilePath(path): buffer.getvalue()})


def load_map(path: str | FilePath) -> Occupancy:
    """The map of a file. Raises Unreadable or Refused, with a finding, for whatever is none."""
    arrays, texts = read_npz(read_bytes(path), str(path))
    if texts.get("kind") != MAP_KIND or "robot" not in texts:
        raise Unreadable(NO_MAP(path=str(path), reason="it says to be something else"))
    about = arrays.get("about", np.zeros(0))
    if about.shape == (3,) and about[0] > MAP_VERSION:
        raise Refused(
            NEWER_MAP(path=str(path), version=float(about[0]), known=MAP_VERSION), exit_status=2
        )
    reason = _map_fault(arrays, about)
    if reason:
        raise Unreadable(NO_MAP(path=str(path), reason=reason))
    return Occupancy(
        float(about[1]),
        texts["robot"],
        _keys(arrays["keys"]),
        _whole(arrays["filled"]),
        _whole(arrays["touched"]),
        arrays["free"] != 0.0,
        int(about[2]),
    )


def _map_fault(arrays: dict[str, Floats], about: Floats) -> str:
    """What keeps columns from being a map, nothing if they are one."""
    if about.shape != (3,) or not (np.isfinite(about).all() and about[1] > 0.0 and about[2] >= 0.0):
        return "its `about` is not version, size of cells and number of runs"
    missing = [name for name in MAP_COLUMNS if name not in arrays]
    if missing:
        return f"it lacks {', '.join(missing)}"
    keys, count = arrays["keys"], arrays["keys"].shape[-1] if arrays["keys"].ndim else 0
    if keys.shape != (2, count) or any(arrays[name].shape != (count,) for name in MAP_COLUMNS[1:]):
        return "its columns differ in length"
    for name in MAP_COLUMNS:
        values = arrays[name]
        if not (np.isfinite(values) & (values >= 0.0) & (values < LARGEST_EXACT)).all():
            return f"`{name}` holds what no number of cells is"
        if (values != np.floor(values)).any():
            return f"`{name}` holds what is no whole number"
    if (keys >= [[2.0**31], [2.0**32]]).any() or (np.diff(_keys(keys)) <= 0).any():
        return "its cells are not in order"
    return ""


def _keys(halves: Floats) -> Ints:
    upper, lower = (_whole(row) for row in halves)
    return (upper << 32) | lower


def _whole(values: Floats) -> Ints:
    return values.astype(np.int64)
