"""Maps of reach as text, columns and pictures."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, evenly_spaced
from assistant.cell.reach_map import ReachMap
from assistant.report import figures

MOST_MAP_SLICES: Final = 9
MOST_NEAR_PAIRS: Final = 5
"""Pairs of bodies that are told to be too near."""
NOT_REACHED_COLOUR, TOUCHING_COLOUR = "#e4e7ea", "#d9776c"


def map_lines(found: ReachMap) -> Iterator[str]:
    """A row of each direction, and how many points all of them reach."""
    n, wide = len(found.points), max(9, *(len(name) for name in found.directions.names))
    yield f"{'direction':{wide}}  {'reached':>9}  {'share':>7}  {'too near':>8}  {'room':>5}"
    for i, name in enumerate(found.directions.names):
        reached, near = int(found.reached[:, i].sum()), int(found.touching[:, i].sum())
        room = f"{np.nanmean(found.room[:, i]):.2f}" if reached else "-"
        share = f"{100.0 * reached / n:.1f} %"
        yield f"{name:{wide}}  {reached:>9,}  {share:>7}  {near:>8,}  {room:>5}"
    if len(found.directions.names) > 1:
        for word, which in (("all", found.reached.all(axis=1)), ("any", found.reached.any(axis=1))):
            share = f"{100.0 * which.mean():.1f} %"
            yield f"{word:{wide}}  {int(which.sum()):>9,}  {share:>7}"
    if found.nearest:
        yield ""
        whole = sum(found.nearest.values())
        for (one, other), count in list(found.nearest.items())[:MOST_NEAR_PAIRS]:
            yield f"too near: {one} to {other}, {100.0 * count / whole:.0f} %"
    some = found.points[found.reached.any(axis=1)]
    if len(some):
        low, high = some.min(axis=0), some.max(axis=0)
        yield ""
        for axis, least, most in zip("xyz", low, high, strict=True):
            yield f"{axis} of what is reached: {least:g} to {most:g} mm"


def map_record(found: ReachMap) -> dict[str, Any]:
    """The same as `lines`, for programs."""
    return {
        "points": len(found.points),
        "directions": [
            {
                "direction": name,
                "axis": found.directions.axes[i].tolist(),
                "reached": int(found.reached[:, i].sum()),
                "too_near": int(found.touching[:, i].sum()),
                "room": float(np.nanmean(found.room[:, i])) if found.reached[:, i].any() else None,
            }
            for i, name in enumerate(found.directions.names)
        ],
        "nearest": [
            {"one": one, "other": other, "count": count}
            for (one, other), count in found.nearest.items()
        ],
        "all": int(found.reached.all(axis=1).sum()),
        "any": int(found.reached.any(axis=1).sum()),
    }


def map_csv(found: ReachMap) -> bytes:
    """A line for each point and direction; figures are empty where it is not reached."""
    text = io.StringIO(newline="")
    text.write("x_mm,y_mm,z_mm,direction,reached,too_near,room,limits,singularity,clearance_mm\n")
    columns = (found.room, found.limits, found.away, found.clearance)
    for i, (x, y, z) in enumerate((found.points + 0.0).tolist()):
        for k, name in enumerate(found.directions.names):
            figures_ = ",".join(f"{c[i, k]:.6g}" if np.isfinite(c[i, k]) else "" for c in columns)
            state = f"{int(found.reached[i, k])},{int(found.touching[i, k])}"
            named = f'"{name}"' if "," in name else name
            text.write(f"{x:.6g},{y:.6g},{z:.6g},{named},{state},{figures_}\n")
    return text.getvalue().encode()


def map_npz(found: ReachMap) -> bytes:
    """The columns of `ReachMap` as a NumPy archive."""
    data = io.BytesIO()
    names = ("points", "reached", "touching", "room", "limits", "away", "clearance", "joints")
    np.savez_compressed(
        data,
        **{name: getattr(found, name) for name in names},
        directions=np.array(found.directions.names),
        axes=found.directions.axes,
    )
    return data.getvalue()


def map_picture(found: ReachMap, title: str, format: str = "png") -> bytes:
    """Slices of the region, coloured by the room, the mean over the directions (0 if not reached).

    Slices are level, at most `MOST_SLICES` of them, or along another plane if that has one layer.
    Raises Refused, naming the extra, without matplotlib.
    """
    from matplotlib.colors import ListedColormap

    values = [np.unique(found.points[:, axis]) for axis in range(3)]
    across, up, through = _slice_axes([len(v) for v in values])
    levels = values[through]
    some = evenly_spaced(len(levels), MOST_MAP_SLICES)
    columns = min(3, len(some))
    rows = -(-len(some) // columns)
    drawn = figures.new_figure(1.6 + 3.4 * columns, 0.9 + 3.2 * rows)
    views = np.atleast_1d(drawn.subplots(rows, columns, squeeze=False)).reshape(-1)
    shown = None
    for view in views[len(some) :]:
        view.set_visible(False)
    for view, level in zip(views, levels[some], strict=False):
        rows_ = np.flatnonzero(found.points[:, through] == level)
        shape = (len(values[across]), len(values[up]))
        room, touching = _slice_pictures(found, rows_, values, across, up, shape)
        edges = [figures.cell_edges(values[axis]) for axis in (across, up)]
        empty = np.where(touching, 1.0, 0.0)
        view.pcolormesh(
            *edges,
            empty.T,
            cmap=ListedColormap([NOT_REACHED_COLOUR, TOUCHING_COLOUR]),
            vmin=0,
            vmax=1,
        )
        shown = view.pcolormesh(*edges, room.T, cmap="viridis", vmin=0.0, vmax=1.0)
        view.set(
            aspect="equal",
            xlabel=f"{'xyz'[across]} in mm",
            ylabel=f"{'xyz'[up]} in mm",
            title=f"{'xyz'[through]} = {level:g} mm",
        )
    if shown is not None:
        drawn.colorbar(shown, ax=views.tolist(), label="room (red: reached, but too near)")
    drawn.suptitle(title)
    return figures.picture(drawn, format)


def _slice_axes(counts: list[int]) -> tuple[int, int, int]:
    """Which axis goes across, which up, and which from picture to picture."""
    through = 2 if counts[2] == 1 or min(counts[:2]) > 1 else counts.index(min(counts[:2]))
    across, up = (axis for axis in range(3) if axis != through)
    return across, up, through


def _slice_pictures(
    found: ReachMap, rows: Any, values: list[Floats], across: int, up: int, shape: tuple[int, int]
) -> tuple[Floats, Any]:
    """Room, NaN where nothing is reached, and whether that is for something too near."""
    i = np.searchsorted(values[across], found.points[rows, across])
    k = np.searchsorted(values[up], found.points[rows, up])
    room, touching = np.full(shape, np.nan), np.zeros(shape, dtype=bool)
    mean = np.nan_to_num(found.room[rows]).mean(axis=1)
    room[i, k] = np.where(found.reached[rows].any(axis=1), mean, np.nan)
    touching[i, k] = found.touching[rows].any(axis=1)
    return room, touching
