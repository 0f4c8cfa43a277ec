"""Runs Python in forks of one process that has everything imported.

A command of a page takes a third of a second to start and a few milliseconds to do what it is
asked, and there are hundreds of them. `Forks` starts a process that imports the package once. Its
`python` and `robot-assistant` are small programs that hand their arguments, environment, working
folder and standard streams to a fork of that process, and end as the fork does.
"""

from __future__ import annotations

import ast
import atexit
import gc
import importlib
import os
import pkgutil
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import types
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Never, Self

PROJECT = Path(__file__).parent.parent
HAND_OVER = """\
#!{python} -ISs
import os, socket, sys
words = [*{first!r}, *sys.argv[1:]], os.getcwd(), dict(os.environ)
with socket.socket(socket.AF_UNIX) as line:
    line.connect({path!r})
    socket.send_fds(line, [b"."], [0, 1, 2])
    line.sendall(repr(words).encode("utf-8", "surrogateescape"))
    line.shutdown(socket.SHUT_WR)
    ended = line.recv(1)
os._exit(ended[0] if ended else 99)
"""


class Forks:
    """The process and the folder of its programs, which go first in PATH; a context manager."""

    def __enter__(self) -> Self:
        self.folder = Path(tempfile.mkdtemp(prefix="forks"))
        path = str(self.folder / "line")
        script = shutil.which("robot-assistant", path=str(Path(sys.executable).parent))
        assert script is not None
        for name, first in (("python", []), ("robot-assistant", [script])):
            program = self.folder / name
            program.write_text(HAND_OVER.format(python=sys.executable, first=first, path=path))
            program.chmod(0o755)
        self._process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", "tests.forks", path],
            cwd=PROJECT,
            stdout=subprocess.PIPE,
        )
        assert self._process.stdout is not None and self._process.stdout.read(5) == b"ready"
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._process:
            self._process.kill()
        shutil.rmtree(self.folder)

    def environment(self, **variables: str) -> dict[str, str]:
        """The one that a shell needs to find the programs."""
        path = f"{self.folder}{os.pathsep}{os.environ['PATH']}"
        return {**os.environ, "PATH": path, **variables}

    def python(self, *words: str, cwd: Path = PROJECT) -> subprocess.CompletedProcess[str]:
        """What `python` with these arguments ends as and prints."""
        program = str(self.folder / "python")
        return subprocess.run([program, *words], cwd=cwd, capture_output=True, text=True)


def serve(path: str) -> Never:
    """Answers until it is killed."""
    for module in pkgutil.walk_packages([str(PROJECT / "assistant")], "assistant."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    gc.freeze()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(path)
        listening.listen(64)
        os.write(1, b"ready")
        while True:
            line, _ = listening.accept()
            with line:
                if os.fork() == 0:
                    listening.close()
                    _answer(line)


def _answer(line: socket.socket) -> None:
    """Tells how a fork of this process ended; the fork comes back from here to run."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    _, streams, _, _ = socket.recv_fds(line, 1, 3)
    with line.makefile("rb") as file:
        words, folder, variables = ast.literal_eval(file.read().decode("utf-8", "surrogateescape"))
    if (child := os.fork()) != 0:
        _, status = os.waitpid(child, 0)
        line.sendall(bytes([os.waitstatus_to_exitcode(status) & 0xFF]))
        os._exit(0)
    line.close()
    for stream, number in zip(streams, (0, 1, 2), strict=True):
        os.dup2(stream, number)
        os.close(stream)
    try:
        _run(words, folder, variables)
    except SystemExit as ended:
        _end(ended.code)


def _end(code: str | int | None) -> Never:
    """Ends as the interpreter does, but leaves its objects, whose memory is shared, alone."""
    if isinstance(code, str):
        sys.stderr.write(f"{code}\n")
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    with suppress(OSError, ValueError):
        sys.stdout.flush()
    with suppress(OSError, ValueError):
        sys.stderr.flush()
    os._exit(code if isinstance(code, int) else int(code is not None))


def _run(words: Sequence[str], folder: str, variables: Mapping[str, str]) -> Never:
    """Does in this process what `python` with these arguments does, and ends it."""
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(variables)
    sys.stdin = sys.__stdin__ = open(0, encoding="utf-8")  # noqa: SIM115
    sys.stdout = sys.__stdout__ = open(1, "w", encoding="utf-8")  # noqa: SIM115
    sys.stderr = sys.__stderr__ = open(2, "w", 1, "utf-8", "backslashreplace")  # noqa: SIM115
    sys.path[0] = ""
    match words:
        case ["-c", text, *rest]:
            sys.argv = ["-c", *rest]
            main = sys.modules["__main__"] = types.ModuleType("__main__")
            exec(compile(text, "<string>", "exec"), main.__dict__)
        case ["-m", module, *rest]:
            sys.argv = ["-m", *rest]
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        case [script, *rest]:
            sys.argv = [script, *rest]
            runpy.run_path(script, run_name="__main__")
    sys.exit(0)


if __name__ == "__main__":
    serve(sys.argv[1])
