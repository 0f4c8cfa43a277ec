"""Execution of a motion on a controller, by each mode that moves the arm along given samples.

`MODES` lists the modes: poses by files, EGM, the data link, Mxt. Each takes a session with the
controller and stops the arm itself however the run ends.
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import field
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.address import SCHEMES
from assistant.controllers.controller import Controller, Programs

Progress = Callable[[float], None]
"""Receives the completed part of the motion, 0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class TimedMotion:
    """k moments of a motion from where the arm is now.

    axes: J1, J2 … of the arm, sliding: (a,) which of them slide. seconds: (k,) from 0. joints:
    (k, a) degrees or mm. positions: (k, 3) mm and quaternions: (k, 4) of the tool in the base.
    speeds, accelerations: (a,) a second (squared) that no axis may exceed, None if not known.
    limits: (a, 2). controller: series of the arm's controller, such as CR800.
    """

    controller: str
    axes: tuple[str, ...]
    sliding: tuple[bool, ...]
    seconds: Floats
    joints: Floats
    positions: Floats
    quaternions: Floats
    speeds: Floats
    accelerations: Floats | None
    limits: Floats
    findings: tuple[Diagnostic, ...] = ()

    @property
    def places(self) -> list[int]:
        """Columns of the axes where J1 is the first, whichever the arm lacks."""
        return [int(axis[1:]) - 1 for axis in self.axes]

    def numbered(self, values: Floats, missing: float) -> Floats:
        """Values of axes (…, a) with a column for each number; missing: of the others."""
        from assistant.controllers.cyclic.trajectory import numbered

        return numbered(self.axes, values, missing)


@dataclass(frozen=True, slots=True)
class LinkOptions:
    """port: where the other side listens, or this one; None for the usual. lines: targets of the
    lines of data, one a purpose; () for the usual. cycle: seconds, None for the usual.
    replace: programs of ours on the controller take the place of others of their names.
    """

    port: int | None = None
    lines: tuple[str, ...] = ()
    cycle: float | None = None
    replace: bool = False


@dataclass(frozen=True, slots=True)
class Done:
    """Summary of a motion in words, and its recording as (n,) columns by name."""

    said: str
    columns: Mapping[str, Floats] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()

    def save(self, path: FilePath) -> None:
        """Writes the columns as .csv or .npz; raises Refused."""
        from assistant.controllers.recording import save_columns

        save_columns(path, self.columns)


Run = Callable[[Programs, TimedMotion, LinkOptions, Progress], Done]
Check = Callable[[Programs, LinkOptions], None]
"""Raises Refused for a controller that cannot be led that way, or that not all is known of."""


_OPTIONS: Final = {"port": "--port", "lines": "--line", "cycle": "--cycle"}
"""Fields of `LinkOptions` → their command-line options."""


def check_of(*names: str, then: Check | None = None) -> Check:
    """A check that refuses wishes which this way would ignore; names: of those that it takes.

    then: what else is to be checked.
    """

    def check(session: Programs, wishes: LinkOptions) -> None:
        for name, option in _OPTIONS.items():
            if name not in names and getattr(wishes, name):
                reason = f"`{option}` belongs to another way to lead it"
                raise _not_here(session, reason, "leave it out, or choose another way by --by")
        if then is not None:
            then(session, wishes)

    return check


@dataclass(frozen=True, slots=True)
class Mode:
    """A way to lead an arm.

    period: seconds between the moments that it is given. check: is asked before anybody confirms.
    operates: whether the session must be one that operates the controller. unbegun: codes of
    refusals after which nothing has been sent or started, so that nothing is to be stopped.
    """

    title: str
    run: Run
    period: float
    check: Check
    operates: bool = True
    unbegun: frozenset[str] = frozenset()


# ------------------------------------------------------------------------------------- ABB

_NOTHING_SENT: Final = "nothing that moves the robot was sent"


def _exchange(
    session: Programs,
    led: TimedMotion,
    wishes: LinkOptions,  # noqa: ARG001
    progress: Progress,
) -> Done:
    """Send poses by files, one after the other; the program of the exchange already runs.

    An interrupting error gets a note on the known condition of the robot.
    """
    from assistant.controllers.abb.exchange import PoseExchange

    exchange, begun = PoseExchange(session), False
    try:
        with exchange:
            begun = True
            recording = exchange.follow(
                (led.positions, led.quaternions),
                through=True,
                progress=lambda done, count, _: progress(done / count),
            )
    except BaseException as error:
        note = exchange.ended if begun else _NOTHING_SENT
        if note and note not in getattr(error, "__notes__", ()):
            error.add_note(note)
        raise
    columns = dict(zip(recording.labels, recording.rows().T, strict=True))
    return Done(f"{len(recording)} poses were answered", columns)


def _egm(session: Programs, led: TimedMotion, wishes: LinkOptions, progress: Progress) -> Done:
    """Joints cycle by cycle; a program on the controller is to come and ask for them."""
    from assistant.controllers.abb import egm
    from assistant.controllers.cyclic import Limits, Trajectory

    report = egm.guide(
        session.address.host,
        Trajectory.of_joints(led.numbered(led.joints, 0.0), led.seconds, unit="deg"),
        Limits.of_robot(led),
        port=wishes.port or egm.PORT,
        cycle=wishes.cycle or egm.CYCLE,
        watch=lambda now: progress(max(0.0, now.row) / max(1, now.rows)),
    )
    return Done(str(report), report.columns, report.findings)


# ------------------------------------------------------------------------------ Mitsubishi

_CONTROL_PORT, _STATUS_PORT = 10002, 10003
"""Ports of the lines OPT12 and OPT13, which must be COM1 and COM2 of the programs; the controller
link is on OPT11.
"""
_LINES_NEEDED: Final = (
    "set COMDEV = OPT12, OPT13 and CPRCE12 = CPRCE13 = 2 on the controller and switch it off and "
    "on (a virtual one: --line COM1=PORT --line COM2=PORT), or name the two lines by --line"
)
_STEP_TOLERANCE: Final = 0.1
"""Degrees that the arm may have moved since the points were worked out."""


def lines_of(session: Programs, wishes: LinkOptions) -> tuple[str, str]:
    """Targets of the control line and of the status line; raises Refused."""
    from assistant.controllers.mitsubishi.data_link import stream_to

    address, named = session.address, wishes.lines
    is_device = SCHEMES[address.scheme].device
    # On a serial line the controller link uses the line itself: it is no line of data as well.
    if is_device and (len(named) < 2 or address.host in named):
        reason = "its address is a serial line, which tells no host and stays in use"
        raise _not_here(session, reason, "name two other lines of data, the control line first")
    if not is_device and f"{address.host}:{address.port}" in named:
        reason = "a line of data is its controller link, which stays in use"
        raise _not_here(session, reason, "name a line that is for data link (CPRCE.. = 2)")
    usual = (f"{address.host}:{_CONTROL_PORT}", f"{address.host}:{_STATUS_PORT}")
    control, status = (*named, *usual[len(named) :])
    for target in named:
        stream_to(target)
    if control == status:
        raise _not_here(session, "both lines of data are the same", "name two lines")
    return control, status


def _has_lines(session: Programs, wishes: LinkOptions) -> None:
    """Raises Refused where the lines of the programs cannot be those that are named.

    A line on a port of the controller itself needs an Ethernet option behind `COM1:` or `COM2:`
    (COMDEV); without one the program ends with error 3140 at its `Open`, after it was started. A
    target elsewhere may be a converter at the serial line.
    """
    _of_cr(session)
    targets = lines_of(session, wishes)
    own = session.address.host
    text = _operated(session).parameters(["COMDEV"]).get("COMDEV", "")
    devices = [part.strip() for part in text.split(",")]
    for number, target in enumerate(targets):
        device = devices[number] if number < len(devices) else ""
        # Another host may be a converter at the serial line: the device is then a serial one.
        if target.rpartition(":")[0] == own and not device.startswith("OPT"):
            name = f"`COM{number + 1}:` of its programs is {device or 'no line'} (COMDEV = {text})"
            raise _not_here(session, f"{name}, to which {target} does not lead", _LINES_NEEDED)


def _of_cr(session: Programs) -> None:
    """Raises Refused for a controller that another program than one in MELFA-BASIC would lead."""
    if not session.address.scheme.startswith("melfa"):
        reason = f"{SCHEMES[session.address.scheme].title} takes no programs of a CR controller"
        raise _not_here(session, reason, "choose another way by --by")


def on_network(session: Programs, wishes: LinkOptions) -> None:  # noqa: ARG001 - as of each way
    """Raises Refused for an address that packets do not get to."""
    _of_cr(session)
    if SCHEMES[session.address.scheme].device:
        reason = "its address is a serial line, and packets go over the network"
        raise _not_here(session, reason, "give its address on the network, `melfa://host`")


def _not_here(session: Programs, reason: str, cure: str) -> Refused:
    place, what = str(session.address), "lead the arm this way"
    finding = rules.NOT_HERE(place=place, address=place, what=what, reason=reason, cure=cure)
    return Refused(finding, exit_status=2)


def _data_link(
    session: Programs, led: TimedMotion, wishes: LinkOptions, progress: Progress
) -> Done:
    """Joint positions on one line, the status on another; the programs are installed."""
    from assistant.controllers.mitsubishi.control_mode import ControlMode

    control, status = lines_of(session, wishes)
    controller = _operated(session)
    limits = led.numbered(led.limits.T, np.nan).T
    limits[np.isnan(limits[:, 0])] = (-1.0, 1.0)
    points = led.numbered(led.joints, np.nan)
    # NaN columns belong to axes that the arm lacks.
    farthest = float(np.nan_to_num(np.abs(np.diff(points, axis=0))).max()) + _STEP_TOLERANCE
    mode = ControlMode(
        controller, control, status, limits=limits, most_step=farthest, replace=wishes.replace
    )
    with mode:
        mode.follow(points, progress=lambda done, count: progress(done / count))
    recording = mode.recording
    columns = dict(zip(recording.labels, recording.rows().T, strict=True))
    return Done(f"{len(points)} points, {len(recording)} statuses", columns)


MXT_PROGRAM: Final = "FOLLOW"
"""Name of the program that waits for the packets."""
FIRST_PACKET_TIMEOUT: Final = 10.0
"""Seconds in which a program that was started must answer the first packet."""


def _mxt(session: Programs, led: TimedMotion, wishes: LinkOptions, progress: Progress) -> Done:
    """Joints cycle by cycle; the program that waits for them is installed and started."""
    from assistant.controllers.cyclic import Limits, Settings, Trajectory
    from assistant.controllers.mitsubishi import external_control

    on_network(session, wishes)
    controller, host = _operated(session), session.address.host
    joints = led.numbered(led.joints, 0.0)
    sliding = tuple(
        place + 1 for place, slides in zip(led.places, led.sliding, strict=True) if slides
    )
    mxt = external_control.Mxt(
        host,
        port=wishes.port or external_control.PORT,
        limits=Limits.of_robot(led),
        cycle=wishes.cycle or external_control.usual_cycle(led.controller),
        axes=joints.shape[1],
        sliding=sliding,
        settings=Settings(opening=FIRST_PACKET_TIMEOUT),
    )
    with mxt_installed(controller, wishes):
        controller.load(MXT_PROGRAM)
        controller.start()
        try:
            with mxt:
                report = mxt.follow(
                    Trajectory.of_joints(joints, led.seconds, unit="deg"),
                    end=True,
                    watch=lambda now: progress(max(0.0, now.row) / max(1, now.rows)),
                )
        # A program that was started must not wait for packets after a failure.
        except BaseException:
            controller.stop()
            raise
    return Done(str(report), report.columns, report.findings)


@contextmanager
def mxt_installed(controller: Controller, wishes: LinkOptions) -> Iterator[None]:
    """Install the program that waits for packets of this computer; restore the controller after it.

    A program of that name stays if it has the same steps, whatever the values of its variables.
    Raises Refused for another one, unless it may be replaced.
    """
    from assistant.controllers.mitsubishi.external_control import program
    from assistant.controllers.mitsubishi.operation import borrowed

    text = program(_own_address(controller.address.host)).encode("ascii")
    with borrowed(controller, (MXT_PROGRAM,)):
        there = controller.read(MXT_PROGRAM)
        if there is None or _steps_of(controller, there) != _steps_of(controller, text):
            if there is not None and not wishes.replace:
                place = str(controller.address)
                raise Refused(rules.OTHER_PROGRAM(place=place, name=MXT_PROGRAM))
            controller.write(MXT_PROGRAM, text)
        yield


def _steps_of(controller: Controller, program: bytes) -> list[bytes]:
    """Return the lines of a program without its variables, whose values change as it runs."""
    return [line for line in controller.stored(program).splitlines() if line[:1].isdigit()]


def _own_address(host: str) -> str:
    """The address of this computer as the host sees it; nothing is sent."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        try:
            # Connecting a UDP socket sends nothing: it
            # only makes the system choose its own address.
            probe.connect((host, 9))
        except OSError as error:
            reason = error.strerror or str(error)
            raise rules.Lost(rules.UNREACHABLE(place=host, address=host, reason=reason)) from None
        return str(probe.getsockname()[0])


def _operated(session: Programs) -> Controller:
    assert isinstance(session, Controller)
    return session


MODES: Final[Mapping[str, Mode]] = {
    "exchange": Mode(
        "poses by files, one after the other", _exchange, 0.5, check_of(), operates=False
    ),
    "data-link": Mode(
        "joint positions on a line of data", _data_link, 0.1, check_of("lines", then=_has_lines)
    ),
    "mxt": Mode("joints cycle by cycle", _mxt, 0.01, check_of("port", "cycle", then=on_network)),
    "egm": Mode(
        "joints cycle by cycle, as a program asks for them",
        _egm,
        0.01,
        check_of("port", "cycle"),
        operates=False,
        unbegun=frozenset({"CN701", "CN702", "CN703", "CN704", "CN711"}),
    ),
}
