"""Workspace: maps of reach, best places, swept and explored space as text, columns and pictures.

Maps and places are written as CSV, NumPy archives or pictures, swept space also as glTF. Lengths
are mm. In pictures grey is what is not reached.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Floats, Ints, evenly_spaced
from assistant.cell.exploration.occupancy import CellState, Occupancy
from assistant.cell.placement import Place, Places
from assistant.cell.reach_map import ReachMap
from assistant.cell.scene import Body, Mesh, Part, Scene
from assistant.cell.scene_export import gltf
from assistant.cell.swept_space import SweptSpace
from assistant.program.geometry import Pose
from assistant.report import figures
from assistant.report.figures import new_figure, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MOST_MAP_SLICES: Final = 9
_MOST_NEAR_PAIRS: Final = 5
"""Most pairs of bodies reported as too near."""
_NOT_REACHED_COLOUR, _TOUCHING_COLOUR = "#e4e7ea", "#d9776c"


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
        for (one, other), count in list(found.nearest.items())[:_MOST_NEAR_PAIRS]:
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

    Slices are level, at most `_MOST_MAP_SLICES` of them, or along another plane if that has one
    layer. Raises Refused, naming the extra, without matplotlib.
    """
    from matplotlib.colors import ListedColormap

    values = [np.unique(found.points[:, axis]) for axis in range(3)]
    across, up, through = _slice_axes([len(v) for v in values])
    levels = values[through]
    some = evenly_spaced(len(levels), _MOST_MAP_SLICES)
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
            cmap=ListedColormap([_NOT_REACHED_COLOUR, _TOUCHING_COLOUR]),
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


_MOST_PLACES_SHOWN: Final = 10
_PLACE_AXES: Final = ("x", "y", "z", "turn")
_PLACE_UNITS: Final = ("mm", "mm", "mm", "degrees")
_NO_PLACE_COLOUR: Final = "#e4e7ea"


def place_text(place: Place) -> str:
    """Return the position of a place relative to the present one."""
    said = [
        f"{name} {value:+g}"
        for name, value in zip(_PLACE_AXES, place.offset.tolist(), strict=True)
        if value
    ]
    return ", ".join(said) or "where it is"


def place_lines(found: Places) -> Iterator[str]:
    """The best places, a row each."""
    some = found.places[:_MOST_PLACES_SHOWN]
    if not some:
        return
    wide = max(5, *(len(place_text(place)) for place in some))
    yield (
        f"{'place':{wide}}  {'reached':>9}  {'room':>5}  {'limits':>6}  {'singularity':>11}  "
        f"{'clearance':>9}  least at"
    )
    for place in some:
        reached = f"{place.reached}/{found.total}"
        if not place.reached:
            yield f"{place_text(place):{wide}}  {reached:>9}"
            continue
        clear = f"{place.clearance:.1f} mm" if np.isfinite(place.clearance) else "-"
        at = place.worst if place.reached == found.total else f"(not {place.worst})"
        yield (
            f"{place_text(place):{wide}}  {reached:>9}  {place.room:>5.2f}  {place.limits:>6.2f}  "
            f"{place.away:>11.2f}  {clear:>9}  {at}"
        )
    if len(found.places) > _MOST_PLACES_SHOWN:
        yield f"and {len(found.places) - _MOST_PLACES_SHOWN:,} more"


def pose_text(pose: Pose) -> Iterator[str]:
    """A pose as a cell file states it."""
    yield f"position = {_joined(pose.position)}"
    yield f"quaternion = {_joined(pose.quaternion)}"


def _joined(values: tuple[float, ...]) -> str:
    return f"[{', '.join(f'{value + 0.0:.9g}' for value in values)}]"


def places_record(found: Places) -> dict[str, Any]:
    """The same as `lines`, of all places, for programs."""
    return {"targets": found.total, "places": [_place_record(place) for place in found.places]}


def _place_record(place: Place) -> dict[str, Any]:
    said: dict[str, Any] = {
        "offset": place.offset.tolist(),
        "position": list(place.pose.position),
        "quaternion": list(place.pose.quaternion),
        "reached": place.reached,
        "worst": place.worst,
    }
    if place.reached:
        said |= {
            "room": place.room,
            "mean": place.mean,
            "limits": place.limits,
            "singularity": place.away,
            "clearance_mm": place.clearance if np.isfinite(place.clearance) else None,
        }
    return said


def places_csv(found: Places) -> bytes:
    """A line for each place, the best first."""
    text = io.StringIO(newline="")
    text.write(
        "dx_mm,dy_mm,dz_mm,turn_deg,x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,reached,targets,"
        "room,room_mean,limits,singularity,clearance_mm\n"
    )
    for place in found.places:
        pose = (*place.pose.position, *place.pose.quaternion)
        where = [f"{value + 0.0:.9g}" for value in (*place.offset.tolist(), *pose)]
        numbers = (place.room, place.mean, place.limits, place.away, place.clearance)
        said = [f"{value:.6g}" if place.reached and np.isfinite(value) else "" for value in numbers]
        text.write(",".join([*where, str(place.reached), str(found.total), *said]) + "\n")
    return text.getvalue().encode()


def places_picture(found: Places, title: str, format: str = "png") -> bytes:
    """The share of the targets that is reached, and the room, over the two axes with most places.

    Over what else varies the best is drawn. Raises Refused, naming the extra, without matplotlib.
    """
    drawn = figures.new_figure(10.0, 4.6)
    offsets = np.array([place.offset for place in found.places]).reshape(-1, 4)
    values = [np.unique(offsets[:, axis]) for axis in range(4)]
    across, up = sorted(sorted(range(4), key=lambda axis: (-len(values[axis]), axis))[:2])
    share, room = np.full((2, len(values[across]), len(values[up])), np.nan)
    for place in reversed(found.places):  # the best last, which stays
        i = np.searchsorted(values[across], place.offset[across])
        k = np.searchsorted(values[up], place.offset[up])
        share[i, k] = place.reached / found.total
        room[i, k] = place.room if place.reached == found.total else np.nan
    edges = [figures.cell_edges(values[axis]) for axis in (across, up)]
    pictures = (("share of the targets that is reached", share), ("room where all are", room))
    for view, (name, column) in zip(drawn.subplots(1, 2), pictures, strict=True):
        view.set_facecolor(_NO_PLACE_COLOUR)
        shown = view.pcolormesh(*edges, column.T, cmap="viridis", vmin=0.0, vmax=1.0)
        drawn.colorbar(shown, ax=view)
        view.set(
            title=name,
            xlabel=f"{_PLACE_AXES[across]} from where it is, {_PLACE_UNITS[across]}",
            ylabel=f"{_PLACE_AXES[up]} from where it is, {_PLACE_UNITS[up]}",
        )
        if found.best is not None:
            view.plot(*found.best.offset[[across, up]], "x", color="#b3261e", markersize=9.0)
    drawn.suptitle(title)
    return figures.picture(drawn, format)


_SWEPT_COLOUR: Final = (230, 120, 40)
_SWEPT_BODY: Final = "swept"
_CELL_FACES: Final = (
    *((0, 1, ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1))),),
    *((0, -1, ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0))),),
    *((1, 1, ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0))),),
    *((1, -1, ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1))),),
    *((2, 1, ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))),),
    *((2, -1, ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0))),),
)
"""Axis and side of the faces of a cell, with their corners, counter-clockwise from outside."""


def swept_lines(found: SweptSpace) -> Iterator[str]:
    """The volume that each body sweeps, and that of all, with the box about it."""
    wide = max(6, *(len(name) for name in found.bodies), 0) if found.bodies else 6
    yield f"{'body':{wide}}  {'cells':>10}  {'litres':>8}"
    for name, which in found.bodies.items():
        yield f"{name:{wide}}  {int(which.sum()):>10,}  {found.litres(name):>8.1f}"
    yield f"{'all':{wide}}  {len(found.cells):>10,}  {found.litres():>8.1f}"
    if len(found.cells):
        low = found.cells.min(axis=0) * found.size
        high = (found.cells.max(axis=0) + 1) * found.size
        yield ""
        for axis, least, most in zip("xyz", low, high, strict=True):
            yield f"{axis}: {least:g} to {most:g} mm"


def swept_record(found: SweptSpace) -> dict[str, Any]:
    """The same as `lines`, for programs."""
    some = len(found.cells) > 0
    return {
        "size_mm": found.size,
        "cells": len(found.cells),
        "litres": found.litres(),
        "bodies": {name: found.litres(name) for name in found.bodies},
        "low": (found.cells.min(axis=0) * found.size).tolist() if some else None,
        "high": ((found.cells.max(axis=0) + 1) * found.size).tolist() if some else None,
    }


def swept_csv(found: SweptSpace) -> bytes:
    """A line for each cell, by its middle, with a column of 0 and 1 for each body."""
    text = io.StringIO(newline="")
    names = [f'"{name}"' if "," in name else name for name in found.bodies]
    columns = np.column_stack([found.middles, *found.bodies.values()])
    forms = ["%.6g"] * 3 + ["%d"] * len(names)
    header = ",".join(["x_mm", "y_mm", "z_mm", *names])
    np.savetxt(text, columns + 0.0, fmt=forms, delimiter=",", header=header, comments="")
    return text.getvalue().encode()


def swept_npz(found: SweptSpace) -> bytes:
    """The columns of `SweptSpace` as a NumPy archive; a row of `swept` for each of `bodies`."""
    data = io.BytesIO()
    np.savez_compressed(
        data,
        size=np.array(found.size),
        cells=found.cells,
        bodies=np.array(list(found.bodies)),
        swept=np.array(list(found.bodies.values())).reshape(len(found.bodies), len(found.cells)),
    )
    return data.getvalue()


def swept_glb(found: SweptSpace) -> bytes:
    """The surface of the cells as binary glTF, a body `swept`."""
    if not len(found.cells):
        return gltf(Scene())
    return gltf(Scene((Body(_SWEPT_BODY, (Part(swept_surface(found)),), colour=_SWEPT_COLOUR),)))


def swept_surface(found: SweptSpace) -> Mesh:
    """The faces of cells beside which none is swept, as two triangles each."""
    low = found.cells.min(axis=0) - 1
    cells = found.cells - low
    marks = np.zeros(cells.max(axis=0) + 2, dtype=np.bool_)
    marks[tuple(cells.T)] = True
    corners = list[Ints]()
    for axis, side, around in _CELL_FACES:
        beside = cells.copy()
        beside[:, axis] += side
        open_ = found.cells[~marks[tuple(beside.T)]]
        corners.append(open_[:, None] + np.array(around)[None])
    faces = np.concatenate(corners)
    points, where = np.unique(faces.reshape(-1, 3), axis=0, return_inverse=True)
    a, b, c, d = where.reshape(-1, 4).T
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(np.asarray(points * found.size), triangles)


def swept_picture(found: SweptSpace, title: str, format: str = "png") -> bytes:
    """Draw the swept depth in mm, from above and from both sides.

    Raises Refused, naming the extra, without matplotlib.
    """
    drawn = figures.new_figure(13.0, 4.4)
    low = found.cells.min(axis=0) if len(found.cells) else np.zeros(3, dtype=np.int64)
    cells = found.cells - low
    shape = cells.max(axis=0) + 1 if len(cells) else np.ones(3, dtype=np.int64)
    marks = np.zeros(shape, dtype=np.bool_)
    marks[tuple(cells.T)] = True
    views = ((0, 1, 2, "from above"), (0, 2, 1, "from the side"), (1, 2, 0, "from the front"))
    edges = [(low[i] + np.arange(shape[i] + 1)) * found.size for i in range(3)]
    for view, (across, up, along, name) in zip(drawn.subplots(1, 3), views, strict=True):
        deep = marks.sum(axis=along) * found.size
        deep = np.where(deep > 0.0, deep, np.nan)
        shown = view.pcolormesh(edges[across], edges[up], deep.T, cmap="viridis", vmin=0.0)
        drawn.colorbar(shown, ax=view, label=f"swept along {'xyz'[along]}, mm")
        view.set(
            title=name,
            aspect="equal",
            xlabel=f"{'xyz'[across]} in mm",
            ylabel=f"{'xyz'[up]} in mm",
        )
    drawn.suptitle(title)
    return figures.picture(drawn, format)


_EXPLORED_VIEWS: Final = (("from above", 0, 1, 2), ("from the side", 0, 2, 1))
"""Title, axes to the right and up, and the axis that is looked along."""
_AXIS_LETTERS: Final = "xyz"
_EXPLORED_COLOURS: Final = "YlGnBu"


def explored_picture(occupancy: Occupancy, format: str = "png") -> bytes:
    """Free cells of a chart as mm of free space along two lines of sight, contacts as dots.

    The cross is the origin of the robot's base. Raises Refused, naming the extra, without
    matplotlib.
    """
    drawn = new_figure(10.0, 5.0)
    for axes, (title, right, up, along) in zip(drawn.subplots(1, 2), _EXPLORED_VIEWS, strict=True):
        _draw_view(axes, occupancy, right, up)
        axes.set_title(f"{title}: mm of free space along {_AXIS_LETTERS[along]}", fontsize=10)
    return picture(drawn, format)


def _draw_view(axes: Axes, occupancy: Occupancy, right: int, up: int) -> None:
    size = occupancy.size
    free, touched = (occupancy.cells(state) for state in (CellState.FREE, CellState.OCCUPIED))
    if len(free):
        first = free.min(axis=0)
        shape = free.max(axis=0) - first + 1
        depth: Floats = np.zeros((shape[up], shape[right]))
        np.add.at(depth, (free[:, up] - first[up], free[:, right] - first[right]), size)
        low, high = first * size, (first + shape) * size
        extent = (low[right], high[right], low[up], high[up])
        shown = np.ma.masked_equal(depth, 0.0)
        image = axes.imshow(
            shown, _EXPLORED_COLOURS, origin="lower", extent=extent, interpolation="nearest"
        )
        axes.figure.colorbar(image, ax=axes, shrink=0.8)
    if len(touched):
        middle = (touched + 0.5) * size
        axes.plot(middle[:, right], middle[:, up], ".", color="#c03020", label="contacts")
        axes.legend(loc="upper right", fontsize=8)
    axes.plot(0.0, 0.0, "+", color="black", markersize=12)
    axes.set_aspect("equal")
    axes.set_xlabel(f"{_AXIS_LETTERS[right]} / mm")
    axes.set_ylabel(f"{_AXIS_LETTERS[up]} / mm")
