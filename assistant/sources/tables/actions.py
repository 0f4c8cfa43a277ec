"""What the rows of a table do beside moving: signals that they set, waits."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.program.motion import Kind
from assistant.sources.process import Process
from assistant.sources.tables import rows
from assistant.sources.tables.cells import Cells
from assistant.sources.tables.headers import Column, shown
from assistant.sources.tables.poses import position_findings


def signal_findings(
    cells: Cells, columns: list[Column], values: Floats, process: Process
) -> list[Diagnostic]:
    """Signals that are set but not declared as outputs, or to what they cannot be."""
    findings = []
    for index, column in enumerate(columns):
        if column.group != "set":
            continue
        name = output_signal(column.detail, process)
        if name is None:
            cure = rows.cure_for("signal", column.detail, process.signals)
            place = cells.header_place(index)
            findings.append(rows.UNKNOWN_SIGNAL(**place, name=shown(column.detail), cure=cure))
            continue
        signal, given = process.signals[name], values[:, index]
        most = rows.most_value(signal)
        with np.errstate(invalid="ignore"):
            wrong = ~np.isnan(given) & ((given < 0) | (given > most) | (given != np.rint(given)))
        if most < np.inf and wrong.any():
            row = int(np.argmax(wrong))
            fields: dict[str, Any] = {"kind": signal.kind, "name": shown(name), "most": most}
            place = cells.place(row, index)
            findings.append(rows.NOT_ITS_VALUE(**place, **fields, value=float(given[row])))
        if not np.isfinite(given[~np.isnan(given)]).all():
            findings += position_findings(
                np.nan_to_num(given, nan=0.0, posinf=np.inf)[:, None],
                partial(cells.place, column=index),
                shown(cells.header[index]),
            )
    return findings


def via_findings(
    cells: Cells, columns: list[Column], values: Floats, kinds: NDArray[np.uint8]
) -> list[Diagnostic]:
    """Signals and waits in the middle of an arc."""
    findings = []
    for index, column in enumerate(columns):
        if column.group in ("set", "wait"):
            wrong = (kinds == Kind.VIA) & ~np.isnan(values[:, index])
            if wrong.any():
                place = cells.place(int(np.argmax(wrong)), index)
                findings.append(rows.VIA_ACTION(**place, what=shown(cells.header[index])))
    return findings


def output_signal(name: str, process: Process) -> str | None:
    found = next((s for s in process.signals if s.lower() == name.lower()), None)
    return found if found and process.signals[found].direction == "output" else None
