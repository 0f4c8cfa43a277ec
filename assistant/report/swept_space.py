"""Swept space as text, columns, a surface and a picture."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Ints
from assistant.cell.scene import Body, Mesh, Part, Scene
from assistant.cell.scene_export import gltf
from assistant.cell.swept_space import SweptSpace
from assistant.report import figures

SWEPT_COLOUR: Final = (230, 120, 40)
SWEPT_BODY: Final = "swept"
CELL_FACES: Final = (
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
    """The columns of `Swept` as a NumPy archive; a row of `swept` for each of `bodies`."""
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
    return gltf(Scene((Body(SWEPT_BODY, (Part(swept_surface(found)),), colour=SWEPT_COLOUR),)))


def swept_surface(found: SweptSpace) -> Mesh:
    """The faces of cells beside which none is swept, as two triangles each."""
    low = found.cells.min(axis=0) - 1
    cells = found.cells - low
    marks = np.zeros(cells.max(axis=0) + 2, dtype=np.bool_)
    marks[tuple(cells.T)] = True
    corners = list[Ints]()
    for axis, side, around in CELL_FACES:
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
    """How many mm are swept above each other, from above and from both sides.

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
