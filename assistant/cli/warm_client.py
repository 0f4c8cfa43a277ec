"""Hand a command over to a warm server, a process that has loaded this program already.

If `ROBOT_ASSISTANT_SERVER` is `auto`, the first command starts a server in the background. A fork
of the server runs each later command with the arguments, environment, working folder and standard
streams of its client, the process that the user started. The client passes signals on and ends as
the fork does. Without a server, the client runs the command.

The socket's name depends on everything that a fork cannot take over from its client: the version,
the interpreter, its search path, limits of the system. Other circumstances have another server.
Each command imports this module, so it imports little.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from socket import socket

SERVER_VARIABLE: Final = "ROBOT_ASSISTANT_SERVER"
SETTINGS: Final = ("auto", "off")
"""Values of the variable; `off` is the same as none."""
SERVED: Final = frozenset(
    {
        *("compile", "translate", "compare", "show", "check", "explain", "fmt", "coverage"),
        *("simulate", "info", "reach", "robots", "pose", "build", "-h", "--help", "--version"),
    }
)
"""First arguments of commands that a server may run: they ask nothing and reach no controller."""
_ASKING: Final = "--ask"
"""The option by which such a command asks all the same."""
_READ_AT_IMPORT: Final = (
    *("PYTHON", "LC_", "LANG", "LD_", "HOME", "TZ", "TMPDIR"),
    *("XDG_CONFIG", "XDG_DATA", "XDG_CACHE", "EZDXF", "OPENBLAS", "OMP_", "NPY"),
)
"""Beginnings of the variables that Python or a library reads once, when it is loaded."""
_ANSWER_WITHIN: Final = 2.0
"""Seconds for a server to fork; after that the command runs without it."""
_PATIENCE: Final = 0.2
"""Seconds for a server to accept a connection."""
STATUS_BYTES: Final = 4
COMPLETE: Final = "\0."
"""End of a request: a process that is killed sends a part of one."""
_LONGEST_PATH: Final = 107
"""Bytes of the path of a socket, by `unix(7)`."""
_PASSED_ON: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")


def hand_over() -> None:
    """End this process as a fork of the server does, or return where no server can be asked."""
    if not _is_wanted():
        return
    place = _place()
    if place is None:
        return
    connection = _connected(place)
    if connection is None:
        _start(place)
        return
    with connection:
        _ask(connection)


def _is_wanted() -> bool:
    """Return True if a server may run this command; never in CI, where no server would stay."""
    if os.environ.get(SERVER_VARIABLE) != "auto" or os.environ.get("CI"):
        return False
    # `python -m assistant` imports from the working folder as well, and a server starts without
    # flags of the interpreter. ezdxf reads a file there.
    return (
        sys.platform == "linux"
        and len(sys.argv) > 1
        and sys.argv[1] in SERVED
        and _ASKING not in sys.argv
        and sys.orig_argv[1:2] == sys.argv[:1]
        and None not in (sys.stdin, sys.stdout, sys.stderr)
        and not os.path.exists("ezdxf.ini")  # noqa: PTH110
    )


def _place() -> str | None:
    """The path of the socket, in a folder of this user alone; None if there can be none."""
    import hashlib
    import stat

    named = hashlib.sha256(repr(_circumstances()).encode("utf-8", "surrogateescape")).hexdigest()
    above = os.environ.get("XDG_RUNTIME_DIR") or os.environ.get("TMPDIR") or "/tmp"  # noqa: S108
    folder = f"{above}/robot-assistant-{os.getuid()}"
    try:
        os.makedirs(folder, 0o700, exist_ok=True)  # noqa: PTH103
        found = os.lstat(folder)
    except OSError:
        return None
    private = stat.S_IMODE(found.st_mode) & 0o077 == 0 and found.st_uid == os.getuid()
    place = f"{folder}/{named[:16]}"
    fits = len(os.fsencode(place)) <= _LONGEST_PATH
    return place if stat.S_ISDIR(found.st_mode) and private and fits else None


def _circumstances() -> tuple[object, ...]:
    """What a fork inherits from the server instead of the process that asks."""
    import resource

    from assistant import __version__

    limits = [getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")]
    variables = sorted(
        (name, value) for name, value in os.environ.items() if name.startswith(_READ_AT_IMPORT)
    )
    return (
        *(__version__, __file__, sys.version, sys.executable, sys.path, tuple(sys.flags)),
        *(sys.warnoptions, sorted(sys._xoptions.items()), variables),
        *(os.getuid(), os.getgid(), os.geteuid(), os.getegid(), sorted(os.getgroups())),
        [resource.getrlimit(one) for one in sorted(set(limits))],
        os.getpriority(os.PRIO_PROCESS, 0),
        sorted(os.sched_getaffinity(0)),
    )


def _connected(place: str) -> socket | None:
    import socket

    connection = socket.socket(socket.AF_UNIX)
    connection.settimeout(_PATIENCE)
    try:
        connection.connect(place)
    except OSError:
        connection.close()
        return None
    return connection


def _start(place: str) -> None:
    """Start a server for later commands; it ends at once if another one has the socket."""
    import subprocess
    from contextlib import suppress

    from assistant.base.worker_processes import without_passwords

    script = (
        "import sys; sys.path[:] = sys.argv[2:]; "
        "from assistant.cli.warm_server import serve; serve(sys.argv[1])"
    )
    with suppress(OSError):
        subprocess.Popen(  # noqa: S603 (ourselves)
            [sys.executable, "-c", script, place, *sys.path],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd="/",
            env=without_passwords(),
            start_new_session=True,
        )


def _ask(connection: socket) -> None:
    """Hand the command over and end as its fork does; return if the server forked nothing."""
    import socket
    from contextlib import suppress

    connection.settimeout(_ANSWER_WITHIN)
    try:
        socket.send_fds(connection, [b"."], [0, 1, 2])
        child = _received(connection)
    except OSError:
        return
    # Nothing was carried out yet: the fork waits for what follows.
    if child is None:
        return
    try:
        folder = os.getcwd()  # noqa: PTH109
    except OSError:
        return
    connection.settimeout(None)
    _pass_signals(child)
    status = None
    with suppress(OSError):  # the server is gone
        connection.sendall(_request(folder))
        connection.shutdown(socket.SHUT_WR)
        status = _received(connection)
    if status is None:
        _stop(child)
    elif status >= 0:
        os._exit(status)
    else:
        _end_by(-status)


def _request(folder: str) -> bytes:
    """Arguments, environment and the like as texts with a zero byte between them."""
    import signal

    ignored = [one.name for one in signal.Signals if signal.getsignal(one) == signal.SIG_IGN]
    mask = os.umask(0)
    os.umask(mask)
    variables = [f"{name}={value}" for name, value in os.environ.items()]
    texts = [folder, str(mask), " ".join(ignored), str(len(sys.argv)), *sys.argv, *variables]
    return ("\0".join(texts) + COMPLETE).encode("utf-8", "surrogateescape")


def _received(connection: socket) -> int | None:
    """Return a number that the server sent, a fork's process or exit status; None if it is gone."""
    data = b""
    while len(data) < STATUS_BYTES:
        more = connection.recv(STATUS_BYTES - len(data))
        if not more:
            return None
        data += more
    return int.from_bytes(data, "little", signed=True)


def _pass_signals(child: int) -> None:
    """Pass signals that end or halt this process on to the fork from now on."""
    import signal
    from contextlib import suppress

    def send(number: int) -> None:
        with suppress(OSError):  # it has ended
            os.kill(child, number)

    def halt(*_: object) -> None:
        send(signal.SIGSTOP)
        os.kill(os.getpid(), signal.SIGSTOP)
        send(signal.SIGCONT)

    initial = (signal.SIG_DFL, signal.default_int_handler)
    for name in _PASSED_ON:
        number = getattr(signal, name)
        if signal.getsignal(number) in initial:
            signal.signal(number, lambda number, _: send(number))
    if signal.getsignal(signal.SIGTSTP) in initial:
        signal.signal(signal.SIGTSTP, halt)


def _end_by(number: int) -> None:
    """End by the signal that ended the fork, so that a shell sees what it would have seen."""
    import signal

    if number != signal.SIGKILL:
        signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _stop(child: int) -> None:
    """End a fork whose exit status cannot be known any more, as the server is gone."""
    import signal
    from contextlib import suppress

    with suppress(OSError):
        os.kill(child, signal.SIGTERM)
    sys.stderr.write("the warm server ended in the middle of this command; run it again\n")
    sys.stderr.flush()
    os._exit(2)
