"""A warm server: what it answers is what the same command answers without it."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from assistant.cli.warm_client import SERVED
from tests.forks import PROJECT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="servers are for Linux")
SCRIPT = "from assistant.cli import main\nmain()\n"
SERVE = "import sys; from assistant.cli.warm_server import serve; serve(sys.argv[1], 0.4)"
slow = pytest.mark.slow
WAIT = 30.0
"""Seconds until what must come has come."""


class Place:
    """A folder for sockets, and the environment of commands that use it.

    package: folder that the program is imported from.
    """

    def __init__(self, folder: Path, package: Path = PROJECT) -> None:
        self.folder = folder
        self._script = folder / "robot-assistant"
        self._script.write_text(SCRIPT)
        self.environment = {
            **{name: value for name, value in os.environ.items() if name != "CI"},
            "XDG_RUNTIME_DIR": str(folder),
            "PYTHONPATH": str(package),
            "ROBOT_ASSISTANT_SERVER": "auto",
        }

    def command(self, *words: object) -> list[str]:
        return [sys.executable, str(self._script), *map(str, words)]

    def run(
        self, *words: object, cwd: Path = PROJECT, text: str = "", **variables: str
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            self.command(*words),
            cwd=cwd,
            env={**self.environment, **variables},
            capture_output=True,
            text=True,
            input=text,
        )

    def cold(
        self, *words: object, cwd: Path = PROJECT, text: str = "", **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """The same without a server."""
        return self.run(*words, cwd=cwd, text=text, ROBOT_ASSISTANT_SERVER="off", **variables)

    def sockets(self) -> list[Path]:
        return [path for path in self.folder.glob("robot-assistant-*/*") if path.is_socket()]

    def servers(self) -> list[int]:
        """Process numbers of the servers and of their forks."""
        return [number for number, words in processes() if str(self.folder) in words]

    def warmed(self) -> Place:
        """This place, with a server that answers."""
        self.run("--version")
        wait_for(lambda: bool(self.sockets()))
        return self

    def close(self) -> None:
        for number in self.servers():
            os.kill(number, signal.SIGKILL)
        wait_for(lambda: not self.servers())
        shutil.rmtree(self.folder)


def processes() -> Iterator[tuple[int, str]]:
    """Numbers and arguments of processes that run `serve`."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().decode(errors="replace")
        except OSError:
            continue  # it has ended
        if "warm_server" in words:
            yield int(path.parent.name), words


def wait_for(what: Callable[[], bool]) -> None:
    until = time.monotonic() + WAIT
    while not what():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.02)


def short_folder() -> Path:
    """A folder with a name that leaves room for that of a socket."""
    return Path(tempfile.mkdtemp(prefix="warm"))


@pytest.fixture(scope="module")
def warm() -> Iterator[Place]:
    place = Place(short_folder())
    try:
        yield place.warmed()
    finally:
        place.close()


@pytest.fixture
def fresh() -> Iterator[Place]:
    """A place without a server."""
    place = Place(short_folder())
    try:
        yield place
    finally:
        place.close()


QUICK = (
    "check samples/rapid/drilling.mod samples/melfa/LOADER.prg",
    "check no.mod",
    "check --help",
    "compile samples/plate.dxf -l melfa-basic-5 -r rv-4fr -o {out}",
    "explain CT206",
)
SLOW = (
    "--help",
    "check",
    "check samples/ring.dxf --robot rv-2aj",
    "check samples/ring.dxf --robot rv-2aj --format sarif",
    "translate samples/rapid/gluing.mod --to melfa-basic-6 -o {out}",
    "show samples/plate.dxf",
    "simulate samples/plate.dxf -r irb1200-7-0.7",
    "compare samples/rapid/drilling.mod samples/rapid/drilling.mod",
    "fmt --diff samples/rapid",
    "info samples/plate.dxf",
    "pose 100 200 300 0 0 0 --from kuka --to rapid",
    "robots show rv-2aj",
    "coverage samples/melfa/PALLET.prg --to rapid",
)
COMMANDS = (*QUICK, *(pytest.param(words, marks=slow) for words in SLOW))


@pytest.mark.parametrize("words", COMMANDS)
def test_status_output_and_files_are_those_of_a_command_without_it(warm, tmp_path, words):
    answers = []
    for run in (warm.cold, warm.run):
        # The same name both times, since messages name it.
        out = tmp_path / "out"
        done = run(*words.format(out=out).split())
        files = {path.name: path.read_bytes() for path in out.rglob("*") if path.is_file()}
        answers.append((done.returncode, done.stdout, done.stderr, files))
        shutil.rmtree(out, ignore_errors=True)
    assert answers[0] == answers[1]


def test_a_fork_has_the_folder_streams_mask_and_variables_of_who_asks(warm, tmp_path):
    (tmp_path / "a.mod").write_bytes((PROJECT / "samples/rapid/drilling.mod").read_bytes())
    text = (tmp_path / "a.mod").read_text()
    assert warm.run("check", "a.mod", cwd=tmp_path).returncode == 0
    assert warm.run("check", "-", text=text).stdout == "1 checked, 0 findings\n"
    assert warm.run("check", "-", text="MODULE a").returncode == 1
    refused = warm.run("check", "a.mod", cwd=tmp_path, ROBOT_ASSISTANT_BUDGET="many")
    assert refused.returncode == 2 and "many" in refused.stderr
    before = os.umask(0o077)
    try:
        warm.run("show", "a.mod", "-o", "private.pseudo", cwd=tmp_path)
    finally:
        os.umask(before)
    assert (tmp_path / "private.pseudo").stat().st_mode & 0o777 == 0o600


def test_a_file_that_has_changed_is_read_again(warm, tmp_path):
    module = tmp_path / "a.mod"
    for text, status in (("MODULE a\nENDMODULE\n", 0), ("MODULE a\n", 1), ("", 2)):
        module.write_text(text)
        assert warm.cold("check", module).returncode == status
        assert warm.run("check", module).returncode == status


def waiting(place: Place) -> subprocess.Popen[str]:
    """A command that a fork has begun, and that waits for the end of its input."""
    before = set(place.servers())
    process = subprocess.Popen(
        place.command("check", "-"),
        env=place.environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(lambda: any(reads_a_pipe(fork) for fork in set(place.servers()) - before))
    return process


def reads_a_pipe(number: int) -> bool:
    return "pipe" in Path(f"/proc/{number}/wchan").read_text()


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_signals_end_a_fork_and_are_reported(warm, name):
    process = waiting(warm)
    process.send_signal(getattr(signal, name))
    process.wait(WAIT)  # before its input ends, which the fork could meet first
    _, said = process.communicate()
    assert process.returncode == 128 + getattr(signal, name)
    assert said == f"ended by {name}\n"


def test_a_fork_that_is_killed_ends_the_command_in_the_same_way(warm):
    before = set(warm.servers())
    process = waiting(warm)
    (fork,) = set(warm.servers()) - before
    os.kill(fork, signal.SIGKILL)
    process.wait(WAIT)
    process.communicate()
    assert process.returncode == -signal.SIGKILL


def test_a_fork_ends_with_the_command(warm):
    before = set(warm.servers())
    process = waiting(warm)
    process.kill()
    process.communicate(timeout=WAIT)
    wait_for(lambda: set(warm.servers()) == before)


def test_ctrl_z_halts_a_fork_and_fg_lets_it_go_on(warm):
    before = set(warm.servers())
    process = waiting(warm)
    (fork,) = set(warm.servers()) - before
    process.send_signal(signal.SIGTSTP)
    wait_for(lambda: state(process.pid) == state(fork) == "T")
    process.send_signal(signal.SIGCONT)
    wait_for(lambda: state(fork) != "T")
    said, _ = process.communicate("MODULE a\nENDMODULE\n", timeout=WAIT)
    assert (process.returncode, said) == (0, "1 checked, 0 findings\n")


def state(number: int) -> str:
    """The letter of `ps` for the state of a process."""
    return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]


def test_a_server_that_ends_is_reported_and_another_starts(fresh):
    fresh.warmed()
    server = fresh.servers()
    process = waiting(fresh)
    for number in server:
        os.kill(number, signal.SIGKILL)
    process.wait(WAIT)
    _, said = process.communicate()
    assert process.returncode == 2 and "run it again" in said
    wait_for(lambda: not fresh.servers())
    assert fresh.run("check", "samples/rapid/drilling.mod").returncode == 0  # by itself
    wait_for(lambda: bool(fresh.servers()))


def test_a_server_ends_when_nobody_asks(fresh):
    place = fresh.folder / "socket"
    words = [sys.executable, "-c", SERVE, str(place)]
    server = subprocess.Popen(words, env=fresh.environment, stdout=subprocess.DEVNULL)
    assert server.wait(WAIT) == 0
    assert not place.exists()


@slow
def test_a_program_that_has_changed_is_not_served(fresh):
    package = fresh.folder / "copy"
    for name in ("assistant", "grammars", "templates", "samples"):
        shutil.copytree(PROJECT / name, package / name, symlinks=True)
    place = Place(fresh.folder, package)
    place.warmed()
    assert place.run("--version").stdout == "robot-assistant 0.1.0\n"
    server = place.servers()
    first = package / "assistant" / "cli" / "app.py"
    first.write_text(first.read_text().replace("robot-assistant {__v", "changed {__v"))
    assert place.run("--version").stdout == "changed 0.1.0\n"
    wait_for(lambda: not set(server) & set(place.servers()))


@pytest.mark.parametrize(
    "change", ["ci", "open folder", "python -m", "ezdxf.ini", "a longer path", "a question"]
)
def test_where_no_server_may_be_used_none_is_started(fresh, tmp_path, change):
    environment, command = dict(fresh.environment), fresh.command("--version")
    if change == "ci":
        environment["CI"] = "true"
    elif change == "open folder":
        (fresh.folder / f"robot-assistant-{os.getuid()}").mkdir(mode=0o755)
    elif change == "python -m":
        command = [sys.executable, "-m", "assistant", "--version"]
    elif change == "a question":
        command = fresh.command("translate", "no.mod", "--to", "rapid", "--ask")
    elif change == "ezdxf.ini":
        (tmp_path / "ezdxf.ini").touch()
    else:
        environment["XDG_RUNTIME_DIR"] = str(fresh.folder / ("x" * 100))
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout == ("" if change == "a question" else "robot-assistant 0.1.0\n")
    assert not fresh.servers()


def test_a_setting_that_does_not_exist_is_refused(fresh):
    done = fresh.run("--version", ROBOT_ASSISTANT_SERVER="on")
    assert done.returncode == 2
    assert "CL903" in done.stderr and "`auto` or `off`" in done.stderr


def test_commands_that_ask_or_reach_a_controller_are_not_served():
    page = (PROJECT / "docs/security.md").read_text()
    rows = re.findall(r"^\| `([a-z]+)[^|]*\|[^|]*\|([^|]*)\|([^|]*)\|$", page, re.MULTILINE)
    reaching = {name for name, on_controller, asks in rows if "nothing" not in on_controller}
    asking = {name for name, _, asks in rows if asks.strip() != "no"}
    assert len(rows) > 50 and {"jog", "start"} <= reaching & asking
    assert not SERVED & (reaching | asking)
