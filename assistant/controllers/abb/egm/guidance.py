"""Guiding an ABB arm by EGM: along a trajectory, or by corrections worked out meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from assistant.controllers.abb.egm.link import Egm
from assistant.controllers.cyclic import (
    Ended,
    Endpoint,
    Leading,
    Limits,
    Progress,
    Report,
    Settings,
    Trajectory,
    follow,
    rules,
)

CYCLE: Final = 0.004
"""Seconds, of all controllers that know it."""
PORT: Final = 6510
"""Of this computer, as the UdpUc device of a new system names it."""
OPENING_TIMEOUT: Final = 60.0
"""Seconds in which the program on the controller has to begin."""
HOLD_AT_END: Final = 0.3
"""Seconds for which the last point is held. The program on the controller sees the end as its
communication time-out, or as convergence where its \\CondTime is shorter.
"""
OF_THE_CONTROLLER: Final = {rules.STOPPED.code, rules.SILENT.code}
"""What an end by the controller itself looks like from here."""


def guide(
    host: str,
    trajectory: Trajectory,
    limits: Limits,
    *,
    port: int = PORT,
    local_host: str = "",
    cycle: float = 0.004,
    settings: Settings | None = None,
    watch: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Report:
    """Waits for the controller, leads the arm along the trajectory, and holds it at its end.

    host: the controller's address; packets of others are not heard. port, local_host: of this
    computer. limits: of the joints, or of the tool. settings: None to wait a minute for the program
    on the controller.
    Raises Refused before anything is sent, Ended afterwards.
    """
    chosen = settings or Settings(opening=OPENING_TIMEOUT, settle=HOLD_AT_END)
    link = Egm(trajectory.kind, trajectory.rows.shape[1], cycle)
    endpoint = Endpoint(host, 0, local_host, port)
    try:
        return follow(link, endpoint, trajectory, limits, chosen, watch=watch, stop=stop)
    except Ended as ended:
        report = ended.report
        code = ended.findings[0].code
        if report is None or report.done < report.rows or code not in OF_THE_CONTROLLER:
            raise
        if not _is_there(report, trajectory, chosen):
            raise
        return replace(report, done=report.rows)


def guide_by_corrections(
    host: str,
    axes: int,
    limits: Limits,
    *,
    port: int = PORT,
    local_host: str = "",
    cycle: float = 0.004,
    settings: Settings | None = None,
) -> Leading:
    """The arm, to be led by corrections of its joints once the controller begins.

    limits: with the range of the joints. Else as `guide`.
    """
    chosen = settings or Settings(opening=OPENING_TIMEOUT, settle=HOLD_AT_END)
    return Leading(
        Egm("joints", axes, cycle), Endpoint(host, 0, local_host, port), axes, limits, chosen
    )


def _is_there(report: Report, trajectory: Trajectory, settings: Settings) -> bool:
    """Whether the arm was at the last point when the controller ended."""
    last = trajectory.rows[-1].tolist()
    columns = list(report.columns.values())[2 : 2 + len(last)]
    places = range(3) if trajectory.kind == "poses" else range(len(last))
    return all(len(columns[i]) and abs(columns[i][-1] - last[i]) <= settings.slack for i in places)
