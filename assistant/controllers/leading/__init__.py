"""Leading an arm step by step, by each of the ways that controllers know.

MODES lists them: each makes a `Carrier` of a session with the controller. A new way is a file here
and a row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers.controller import Controller, JogsJoints, Programs
from assistant.controllers.following import MODES as FOLLOWING
from assistant.controllers.following import Check, LinkOptions, check_of, lines_of
from assistant.controllers.leading import rules
from assistant.controllers.leading.carrier import Arm, Carrier
from assistant.controllers.rules import NOT_HERE

__all__ = ["MODES", "Arm", "Carrier", "Mode"]

MakeCarrier = Callable[[Programs, Arm, LinkOptions, Floats], Carrier]
"""Of a session, the arm, what is wished, and joints (a,) near to which the arm is."""
SpeedKeeper = Literal["cycles", "percent", "program"]
SLOWEST_OVERRIDE: Final = 0.01
"""Part of its full speed: the least that a controller can be set to."""


@dataclass(frozen=True, slots=True)
class Mode:
    """title: in words. make: a carrier that is not entered. operates: whether the session must be
    one that operates the controller. check: is asked before anybody confirms. unbegun: codes of
    refusals after which nothing has been sent or started. waits: as of its carrier. keeps: who
    keeps the speed: each cycle, a percentage of the controller, or a program of its own.
    """

    title: str
    make: MakeCarrier
    operates: bool
    check: Check
    unbegun: frozenset[str] = frozenset()
    waits: bool = False
    keeps: SpeedKeeper = "cycles"

    def faster(self, arm: Arm, place: str) -> Iterator[Diagnostic]:
        """Report where the arm may be faster than what `arm` may do: the way cannot keep to it."""
        if self.keeps == "percent" and arm.part < SLOWEST_OVERRIDE:
            times = f"{SLOWEST_OVERRIDE / arm.part:.1f}"
            yield rules.NO_SLOWER(place=place, percent=100.0 * SLOWEST_OVERRIDE, times=times)
        elif self.keeps == "program":
            yield rules.OWN_SPEED(place=place)


def _jog(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001
    from assistant.controllers.leading.jogs import JogCarrier

    assert isinstance(session, JogsJoints)
    return JogCarrier(session, arm)


def _jogs_joints(session: Programs, wishes: LinkOptions) -> None:  # noqa: ARG001 - as of each way
    """Raises Refused for a controller that cannot."""
    if not isinstance(session, JogsJoints):
        place, what = str(session.address), "jog several joints at once"
        reason, cure = "its protocol has no such command", "choose another way by --by"
        finding = NOT_HERE(place=place, address=place, what=what, reason=reason, cure=cure)
        raise Refused(finding, exit_status=2)


def _data_link(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001
    from assistant.controllers.leading.data_link import DataLinkCarrier

    assert isinstance(session, Controller)
    return DataLinkCarrier(session, *lines_of(session, wishes), arm, replace=wishes.replace)


def _mxt(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001
    from assistant.controllers.leading.cycles import by_mxt

    assert isinstance(session, Controller)
    return by_mxt(session, arm, wishes)


def _egm(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001
    from assistant.controllers.leading.cycles import by_egm

    return by_egm(session.address.host, arm, wishes.port, wishes.cycle)


def _exchange(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001
    from assistant.controllers.leading.poses import PoseCarrier

    return PoseCarrier(session, arm, near)


def _mode(
    name: str, title: str, make: MakeCarrier, *, waits: bool = False, keeps: SpeedKeeper = "cycles"
) -> Mode:
    """Needs what following a trajectory by the same way does."""
    other = FOLLOWING[name]
    return Mode(title, make, other.operates, other.check, other.unbegun, waits, keeps)


MODES: Final[Mapping[str, Mode]] = {
    "jog": Mode(
        "jogs of its joints, step by step",
        _jog,
        True,
        check_of(then=_jogs_joints),
        waits=True,
        keeps="percent",
    ),
    "data-link": _mode(
        "data-link", "joint positions on a line of data", _data_link, keeps="percent"
    ),
    "mxt": _mode("mxt", "joints cycle by cycle", _mxt),
    "egm": _mode("egm", "joints cycle by cycle, as a program asks for them", _egm),
    "exchange": _mode(
        "exchange", "poses by files, one after the other", _exchange, waits=True, keeps="program"
    ),
}
