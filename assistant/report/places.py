"""Places that were looked at, as text, columns and pictures."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from assistant.cell.placement import Place, Places
from assistant.program.geometry import Pose
from assistant.report import figures

MOST_PLACES_SHOWN: Final = 10
PLACE_AXES: Final = ("x", "y", "z", "turn")
PLACE_UNITS: Final = ("mm", "mm", "mm", "degrees")
NO_PLACE_COLOUR: Final = "#e4e7ea"


def place_text(place: Place) -> str:
    """Where a place is, from where the thing stands now."""
    said = [
        f"{name} {value:+g}"
        for name, value in zip(PLACE_AXES, place.offset.tolist(), strict=True)
        if value
    ]
    return ", ".join(said) or "where it is"


def place_lines(found: Places) -> Iterator[str]:
    """The best places, a row each."""
    some = found.places[:MOST_PLACES_SHOWN]
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
    if len(found.places) > MOST_PLACES_SHOWN:
        yield f"and {len(found.places) - MOST_PLACES_SHOWN:,} more"


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
        view.set_facecolor(NO_PLACE_COLOUR)
        shown = view.pcolormesh(*edges, column.T, cmap="viridis", vmin=0.0, vmax=1.0)
        drawn.colorbar(shown, ax=view)
        view.set(
            title=name,
            xlabel=f"{PLACE_AXES[across]} from where it is, {PLACE_UNITS[across]}",
            ylabel=f"{PLACE_AXES[up]} from where it is, {PLACE_UNITS[up]}",
        )
        if found.best is not None:
            view.plot(*found.best.offset[[across, up]], "x", color="#b3261e", markersize=9.0)
    drawn.suptitle(title)
    return figures.picture(drawn, format)
