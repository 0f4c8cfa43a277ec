"""Services that run until Ctrl-C: `studio`, `lsp`, `gateway` and `answer`.

`studio` serves one window for a project to the browser; `lsp` answers an editor over the Language
Server Protocol; `gateway` connects a socket to a controller whose lines carry text; `answer` tells
running programs where objects are. None of them moves a robot.
"""

from __future__ import annotations

import math
import sys
import webbrowser
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.command import argument, command, option
from assistant.cli.options import CellOption, FormatOption, RobotOption
from assistant.cli.presentation import Format, print_findings, say

if TYPE_CHECKING:
    from assistant.controllers.gateway import Gateway as RunningGateway
    from assistant.program.geometry import Pose
    from assistant.sources.seen_settings import Trust
    from assistant.sources.sights import Sight
    from assistant.studio.studio import Studio as OpenStudio
    from assistant.vision.pose_server import Answer as GivenAnswer


@command
class Studio:
    """Open the studio: drawing, program, cell and controller in one window of the browser."""

    project: Path = argument("Its folder; default this one.", default=Path(), metavar="[PROJECT]")
    host: str | None = option(
        "Address by which others open it, encrypted; default nobody else can."
    )
    port: int = option("Port; default one that is free.", default=0, min=0, max=65535)
    open: bool = option("Open the browser.", "--open/--no-open", default=True)
    format: FormatOption

    def run(self) -> int:
        from assistant.base.termination import is_ctrl_c, raise_on_termination, wait_for_termination
        from assistant.cli.presentation import print_findings, print_json, say
        from assistant.studio.server import serving

        studio: OpenStudio | None = None
        try:
            with (
                raise_on_termination() as ending,
                serving(self.project, self.host, self.port) as served,
            ):
                studio = served.studio
                if self.format is Format.JSON:
                    print_json({"folder": str(served.studio.folder), "address": served.address})
                else:
                    where = f"listening on {served.address} until Ctrl-C"
                    say(f"studio of {served.studio.folder}, {where}")
                sys.stdout.flush()
                if self.open:  # a browser of the terminal would come back only when it is closed
                    Thread(target=webbrowser.open, args=(served.address,), daemon=True).start()
                try:
                    wait_for_termination()
                finally:
                    ending.hold()  # an arm is let go of, whatever else comes
        except KeyboardInterrupt as caught:
            left_on = () if studio is None else studio.left_on
            print_findings(left_on)
            if not is_ctrl_c(caught):
                raise
            return 1 if left_on else 0
        return 0


@command
class Lsp:
    """Answer an editor over the Language Server Protocol; see docs/editors.md."""

    tcp: int | None = option(
        "Listen for one editor on this computer instead of pipes; 0 takes a free port.",
        metavar="PORT",
        min=0,
        max=65535,
    )
    extension: Path | None = option(
        "Write the extension for VS Code, FILE.vsix, and end.", metavar="FILE"
    )

    def run(self) -> int:
        return run_lsp(self.tcp) if self.extension is None else run_extension(self.extension)


def run_lsp(tcp: int | None) -> int:
    """0 when the editor has left. Raises Refused without the library, or for a port in use."""
    from assistant import __version__
    from assistant.base.diagnostics import Refused
    from assistant.editing import symbols

    try:
        from assistant.editing.language_server import serve_line, serve_pipes
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise Refused(symbols.NO_LIBRARY(name="pygls"), exit_status=2) from None
    if tcp is None:
        serve_pipes(__version__)
    else:
        serve_line(__version__, tcp, lambda port: say(f"listening on 127.0.0.1:{port}"))
    return 0


def run_extension(file: Path) -> int:
    """0 when the file is there. Raises Refused where it cannot be written."""
    from assistant import __version__
    from assistant.base.file_sets import write_files
    from assistant.editing.vscode.extension import packed

    (path,) = write_files({file.name: packed(__version__)}, file.parent)
    say(f"wrote {path}")
    return 0


_NOT_AN_ADDRESS: Final = error(
    "CL291", "`{text}` is no address with a port", "write it as 192.168.0.20:10003"
)
_NOT_STARTED: Final = error(
    "CL292", "the gateway cannot listen at port {port}: {reason}", "name another port"
)
_NO_CONNECTION_LINE: Final = error(
    "CL293",
    "the gateway connects to one place, but {named}",
    "name the controller's line, or with `--to` the other end of a line that connects to here",
)
_PORTS: Final = range(1, 65536)


@command
class Gateway:
    """Hand bytes on between a socket and a controller whose lines carry texts alone."""

    line: str = argument(
        "The controller's line that waits for a connection, as 192.168.0.20:11002.", default=""
    )
    listen: int = option(
        "Port here: of the other end, or with --to of the line; 0 for any free one.",
        default=0,
        min=0,
        max=_PORTS.stop - 1,
    )
    to: str = option(
        "The other end, for a line that connects to this computer.", default="", metavar="HOST:PORT"
    )
    host: str = option("Address of this computer to listen at; default all of them.", default="")

    def run(self) -> int:
        if bool(self.line) == bool(self.to):
            named = f"`{self.line}` and `{self.to}` are named" if self.line else "none is named"
            raise Refused(_NO_CONNECTION_LINE(named=named), exit_status=2)
        return _serve_lines(
            (self.host, self.listen), _host_and_port(self.line or self.to), bool(self.to)
        )


def _host_and_port(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) not in _PORTS:
        raise Refused(_NOT_AN_ADDRESS(text=text), exit_status=2)
    return host, int(port)


def _serve_lines(at: tuple[str, int], to: tuple[str, int], for_controller: bool) -> int:
    """at: where it listens. to: what it connects to. for_controller: who connects is one."""
    import asyncio

    from assistant.controllers import gateway as gateways

    gateway = gateways.Gateway(at, to, for_controller=for_controller)
    gateway.report = _print_flushed
    try:
        asyncio.run(_serve_gateway(gateway))
    except OSError as failed:
        reason = failed.strerror or str(failed)
        raise Refused(_NOT_STARTED(port=at[1], reason=reason)) from None
    except KeyboardInterrupt as caught:
        say("ended")
        if not is_ctrl_c(caught):
            raise
    return 0


async def _serve_gateway(gateway: RunningGateway) -> None:
    server = await gateway.start()
    _print_flushed(f"listens at port {gateway.at[1]}; end it with Ctrl-C")
    async with server:
        await server.serve_forever()


def _print_flushed(line: str) -> None:
    say(line)
    sys.stdout.flush()


_SIGHT_STATES: Final = {None: "not answered", 0: "not in sight", 1: "found", 2: "doubtful"}


@command
class Answer:
    """Answer programs that ask as they run where objects are. No robot is moved by it."""

    seen: Path = argument("Where objects were found; read at each question.")
    at: str = option(
        "listen:ADDRESS:PORT for programs that come here, or HOST:PORT of one that waits."
    )
    process: Path | None = option(
        "Process file that says how far sights are trusted.", "--process", "-p"
    )
    robot: RobotOption
    cell: CellOption
    times: int = option("Programs to answer; 0 until Ctrl-C.", default=0, min=0)
    patience: float | None = option("Seconds without a word; default for ever.", min=0.1)

    def run(self) -> int:
        """Run the answering service; return 0 if everything requested was found, else 1."""
        from assistant.sources.process.file import read_process
        from assistant.sources.seen_settings import DEFAULT_TRUST
        from assistant.sources.sights import read_sights

        trust = DEFAULT_TRUST if self.process is None else read_process(self.process).seen.trust
        base = _robot_base(self.robot, self.cell)
        read_sights(self.seen)  # what is wrong in it is told before any program waits
        try:
            return self._serve(trust, base)
        except KeyboardInterrupt as caught:
            say("ended")
            if not is_ctrl_c(caught):
                raise
        return 0

    def _serve(self, trust: Trust, base: Pose | None) -> int:
        from assistant.controllers.mitsubishi.data_link import DataLink
        from assistant.vision.pose_server import serve_program as answers

        status = done = 0
        patience = math.inf if self.patience is None else self.patience
        link = DataLink(self.at)
        link.prepare()
        say(
            f"listening for questions at {self.at}" + ("" if self.times else "; end it with Ctrl-C")
        )
        while not self.times or done < self.times:
            sys.stdout.flush()
            for told in answers(link, self._look, trust=trust, base=base, patience=patience):
                status = max(status, _print_answer(told))
            done += 1
        return status

    def _look(self, name: str) -> Sight | None:
        """Return the sight that the file holds now."""
        from assistant.sources.sights import read_sights

        sights = {key.casefold(): one for key, one in read_sights(self.seen).items()}
        return sights.get(name.casefold())


def _print_answer(told: GivenAnswer) -> int:
    print_findings(told.findings)
    where = ""
    if told.pose is not None:
        where = " at " + ", ".join(f"{value:.2f}" for value in told.pose.position) + " mm"
    say(f"{told.name or 'a line'}: {_SIGHT_STATES[told.state]}{where}")
    sys.stdout.flush()
    return 0 if told.state == 1 else 1


def _robot_base(robot: str | None, cell: Path | None) -> Pose | None:
    """Return the pose of the robot in the world of a cell; None if unknown."""
    if cell is None:
        return None
    from assistant.cell.clearances import robot_of as robot_in
    from assistant.compiler.arms import open_cell

    stands = open_cell(cell, robot)
    if stands.scene is None:
        return None
    arm = stands.robot
    if arm is None and len(stands.scene.robots) == 1:
        return stands.scene.robots[0].base
    try:
        return None if arm is None else robot_in(stands.scene, arm).base
    except LookupError:
        return None
