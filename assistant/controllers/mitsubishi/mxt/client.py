"""Real-time external control: leading an arm of a CR controller cycle by cycle (BFP-A3379-A, 4.2).

with Mxt("192.168.0.20", limits=Limits((420, 336, 250, 540, 623, 720))) as mxt:
    report = mxt.follow(Trajectory.of_joints(angles, times))

A program on the controller has to be waiting in `Mxt`, see `program`.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Final, Self

from assistant.base.diagnostics import Refused
from assistant.controllers import cyclic
from assistant.controllers.cyclic import Endpoint, Limits, Progress, Report, Settings, Trajectory
from assistant.controllers.cyclic.rules import BROKEN, NO_ANSWER
from assistant.controllers.cyclic.wire import PacketSocket
from assistant.controllers.mitsubishi.mxt.link import WATCHED_OFFSETS, Mode, MxtLink, Watched
from assistant.controllers.mitsubishi.mxt.packet import COMMAND_TYPES, DATA_FORMS
from assistant.controllers.mitsubishi.mxt.rules import BAD_SETTING, WRONG_KIND, require
from assistant.program.motion import Path

PORT: Final = 10000
"""First element of NETPORT as delivered."""
CYCLES: Final = {"CR750": 64 / 9000, "CR800": 0.0035}
"""Series → seconds of a cycle: CRn-500, CRn-700 and CR750 7.11 ms; CR800 3.5 ms, but 7.11 ms with
a user mechanism."""
KINDS: Final = {"pose": "poses", "joint": "joints", "pulse": "joints"}
END_PACKETS: Final = 2
"""Packets that end the control, if the first one is not answered."""


class Mxt:
    """Real-time external control of one arm; a context manager that ends it on every way out.

    host: name or address of the controller. mode: what the program's `Mxt` names, 1 for joint.
    limits: of the joints in degrees (mm of axes that slide, or pulses), or of a pose; they can be
    given with each trajectory as well. cycle: seconds, see `CYCLES`. axes: of the arm, and more
    ones. sliding: those of them, counted from 1, that slide. flags: structure flags 1 and 2 of
    poses. watched: what is compared with the command: what the encoders feed back, what comes
    behind the filter, or the command alone, where a controller knows nothing else.
    also: up to three more types of data to be recorded (10 and 11 are the currents).
    outputs: first of 16 output signals, mask, word: these are set in every cycle. inputs: first of
    16 input signals that are recorded as `signals`; with outputs, the same numbers are read.
    short: packets of 64 bytes, for the CRn-500 series. local_port: of this machine, 0 for any.
    Raises Refused for what cannot be.
    """

    def __init__(
        self,
        host: str,
        *,
        port: int = PORT,
        mode: Mode = "joint",
        limits: Limits | None = None,
        cycle: float = CYCLES["CR750"],
        axes: int = 6,
        sliding: tuple[int, ...] = (),
        flags: tuple[int, int] = (0, 0),
        watched: Watched = "feedback",
        also: tuple[int, ...] = (),
        outputs: tuple[int, int, int] | None = None,
        inputs: int | None = None,
        short: bool = False,
        settings: Settings | None = None,
        local_port: int = 0,
    ) -> None:
        require("mode", mode, mode in COMMAND_TYPES, "it is pose, joint or pulse")
        require(
            "watched",
            watched,
            watched in WATCHED_OFFSETS,
            f"it is one of {', '.join(WATCHED_OFFSETS)}",
        )
        require("port", port, 0 < port < 65536, "it is a number from 1 to 65535")
        require("local_port", local_port, 0 <= local_port < 65536, "it is 0 or a port")
        require("cycle", cycle, 0.001 <= cycle <= 0.1, "it is seconds, 0.0035 or 0.00711")
        require("axes", axes, 1 <= axes <= 8, "a packet has room for 1 to 8")
        require("sliding", sliding, set(sliding) <= set(range(1, axes + 1)), "axes are from 1 on")
        require(
            "also", also, len(also) <= 3 and set(also) <= set(DATA_FORMS), "three types, 1 to 11"
        )
        require("also", also, not (short and also), "short packets carry one type only")
        first, mask, word = outputs or (inputs or 0, 0, 0)
        numbers = all(0 <= value <= 0xFFFF for value in (first, mask, word, *flags))
        require("outputs", (first, mask, word), numbers, "numbers from 0 to 65535")
        same = outputs is None or inputs is None or outputs[0] == inputs
        require("inputs", inputs, same, "a packet names one first signal for both")
        self._link = MxtLink(
            mode,
            cycle,
            axes,
            tuple(sliding),
            flags,
            watched,
            tuple(also),
            2 if inputs is not None else 0,
            first,
            mask,
            word,
            short,
        )
        self._limits = limits
        self._settings = settings or Settings()
        self._endpoint = Endpoint(host, port, local_port=local_port)
        self._open = False
        self._count = 0
        self._told: tuple[float, ...] = ()

    def __enter__(self) -> Self:
        """Takes a port of this machine, which all packets come from; sends nothing yet."""
        if not self._endpoint.local_port:
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind(("", 0))
                self._endpoint = replace(self._endpoint, local_port=probe.getsockname()[1])
        return self

    def __exit__(self, *error: object) -> None:
        if self._open:
            self.end()

    @property
    def link(self) -> MxtLink:
        return self._link

    def position(self) -> tuple[float, ...]:
        """Where the arm is commanded to be: joints, or x, y, z and w, x, y, z. Moves nothing."""
        with self._wire() as wire:
            try:
                reason = self._asked(wire)
            except OSError as error:
                reason = error.strerror or str(error)
        if reason:
            raise Refused(NO_ANSWER(address=self._endpoint, reason=reason), exit_status=2)
        self._open = True
        return self._told

    def _asked(self, wire: PacketSocket) -> str:
        """Has the controller tell where the arm is; why it did not, "" if it did."""
        left = self._settings.timeout
        each = self._settings.lapse * self._link.cycle
        wire.hush(self._link.cycle)  # answers to what was asked before
        while left > 0.0:
            wire.send(self._link.hello(self._count))
            self._count += 1
            got = wire.receive(min(each, left))
            measured = None if got is None else self._link.read(got[0])
            if measured is not None:
                self._told = measured.values
                return ""
            left -= each
        if wire.refused:
            return "nothing listens on that port"
        return f"nothing came within {self._settings.timeout:g} s"

    def follow(
        self,
        trajectory: Trajectory | Path,
        limits: Limits | None = None,
        *,
        end: bool = False,
        watch: Callable[[Progress], None] | None = None,
        stop: threading.Event | None = None,
    ) -> Report:
        """Leads the arm along a trajectory from where it is, and comes back when it stands.

        end: whether `Mxt` ends behind the last point; else the controller holds and waits for the
        next one until the context ends, without packets: with MXTTOUT set, end each one.
        watch, stop, and what it raises: see `cyclic.follow`.
        """
        led = Trajectory.of_path(trajectory) if isinstance(trajectory, Path) else trajectory
        if led.kind != KINDS[self._link.mode]:
            raise Refused(WRONG_KIND(kind=led.kind, mode=self._link.mode), exit_status=2)
        width = led.rows.shape[1]
        if led.kind == "joints":
            require("axes", self._link.axes, width == self._link.axes, f"it has {width} columns")
        bounds = limits or self._limits
        if bounds is None:
            refusal = BAD_SETTING(name="limits", value=None, reason="nothing moves without them")
            raise Refused(refusal, exit_status=2)
        settings = replace(self._settings, end=end)
        opened, self._open = self._open, True
        try:
            report = cyclic.follow(
                self._link, self._endpoint, led, bounds, settings, watch=watch, stop=stop
            )
        except cyclic.Ended as ended:
            # Where the loop itself failed, nobody may have ended the control.
            self._open = ended.findings[0].code == BROKEN.code
            self._told = ()
            raise
        except Refused:
            self._open = opened
            raise
        self._open = not end
        told = [values[-1] for name, values in report.columns.items() if name.startswith("to_")]
        self._told = tuple(map(float, told))
        return report

    def leading(self, limits: Limits | None = None) -> cyclic.Leading:
        """The arm, to be led by corrections of its joints; `Mxt` ends when that context does.

        limits: with the range of the joints. Raises Refused.
        """
        bounds = limits or self._limits
        if KINDS[self._link.mode] != "joints" or bounds is None:
            wrong = WRONG_KIND(kind="joints", mode=self._link.mode)
            none = BAD_SETTING(name="limits", value=None, reason="nothing moves without them")
            raise Refused(none if bounds is None else wrong, exit_status=2)
        settings = replace(self._settings, end=True)
        return cyclic.Leading(self._link, self._endpoint, self._link.axes, bounds, settings)

    def end(self) -> bool:
        """Ends `Mxt`, so that the program goes on behind it; whether the controller answered."""
        self._open = False
        with self._wire() as wire, contextlib.suppress(OSError):
            if not self._told and self._asked(wire):
                return False
            for _ in range(END_PACKETS):
                wire.send(self._link.end(self._told, self._count))
                self._count += 1
                if wire.receive(4 * self._link.cycle) is not None:
                    return True
        return False

    def _wire(self) -> PacketSocket:
        try:
            return PacketSocket(self._endpoint)
        except OSError as error:
            reason = error.strerror or str(error)
            refusal = NO_ANSWER(address=self._endpoint, reason=reason)
            raise Refused(refusal, exit_status=2) from None
