"""Work that a cluster shares: the same answers and files as from one process here.

The cluster is real, but all of it runs on this computer. Its processes work elsewhere, and get to
know the files by what is sent to them alone.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import psutil
import pytest

import assistant
from assistant.base.cluster import Cluster, on_address, versions
from assistant.base.mirrored_files import SentFiles, Want, answer, result_of
from assistant.base.worker_processes import Worker, WorkerDied
from assistant.cli import main
from tests.forks import PROJECT

SAMPLES = PROJECT / "samples"
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="tried on Linux alone")
slow = pytest.mark.slow
COMMANDS = (
    "check . -r irb1200-7-0.7",
    "check {here}/a.dxf {here}/gone.dxf far/linked.dxf secret.dxf pipe.dxf one ../../gone.prg",
    "translate one two --to rapid -o out --prove",
    "compile a.dxf {here}/b.dxf far/linked.dxf -l rapid -r irb1200-7-0.7 -o out --cell cell.toml",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A project with drawings, programs, a cell, a link, and an unreadable pipe."""
    made = tmp_path / "made"
    for name in ("far", "one", "two"):
        (made / name).mkdir(parents=True)
    for name in "ab":
        shutil.copy(SAMPLES / "plate.dxf", made / f"{name}.dxf")
        shutil.copy(SAMPLES / "plate.process.toml", made / f"{name}.process.toml")
    (made / "far/linked.dxf").symlink_to("../a.dxf")
    (made / "assistant.toml").write_text('[severity]\nDX202 = "off"\n')
    (made / "cell.toml").write_text('[robots.arm]\nrobot = "irb1200-7-0.7"\n')
    (made / "secret.dxf").touch(0)
    os.mkfifo(made / "pipe.dxf")
    for name in ("one", "two"):
        shutil.copy(SAMPLES / "melfa/PALLET.prg", made / name)
    (made / "broken.mod").write_text("MODULE broken\nPROC main()\n  MoveL;\nENDPROC\n")
    return made


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a cluster with two workers."""
    with started(tmp_path_factory.mktemp("cluster")) as address:
        yield address


class started:
    """A scheduler and workers, each a process. path: from which they import the program."""

    def __init__(self, folder: Path, path: Path = PROJECT) -> None:
        self._folder, self._path = folder, path

    def __enter__(self) -> str:
        file = self._folder / "scheduler.json"
        listening = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.scheduler = self._start("scheduler", *listening, "--scheduler-file", str(file))
        until = time.monotonic() + 300
        while not file.exists() or not file.read_text().endswith("}"):
            assert time.monotonic() < until
            time.sleep(0.05)
        self.workers = self._start(
            *("worker", "--scheduler-file", str(file), "--nworkers", "2", "--nthreads", "1"),
            *("--no-dashboard", "--memory-limit", "0", "--local-directory", str(self._folder)),
        )
        address = json.loads(file.read_text())["address"]
        with pytest.importorskip("distributed").Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=300)
        return f"dask{address.removeprefix('tcp')}"

    def _start(self, *words: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *words],
            cwd=self._folder,
            env={**os.environ, "PYTHONPATH": str(self._path)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def __exit__(self, *_: object) -> None:
        for process in (self.workers, self.scheduler):
            process.terminate()
            process.wait()


def told(capfd, *words: str) -> tuple[int, str, str]:
    """Status and output of a command in this process."""
    with pytest.raises(SystemExit) as ended:
        main([*words])
    out, err = capfd.readouterr()
    assert isinstance(ended.value.code, int)
    return ended.value.code, out, err


def answered(folder: Path, words: str, *more: str) -> tuple[object, ...]:
    """Status, output and files of a command, which works in a copy of the folder."""
    copy = folder.parent / "copy"
    subprocess.run(["cp", "-a", str(folder), str(copy)], check=True)
    given = words.format(here=copy).split()
    done = subprocess.run(
        [sys.executable, "-m", "assistant", *given, *more],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
    )
    files = files_of(copy)
    subprocess.run(["rm", "-r", str(copy)], check=True)
    said = done.stdout.replace(" ".join(("", *more)), "").replace(" --jobs 2 --on dask", "")
    return done.returncode, said, done.stderr, files


def files_of(folder: Path) -> Mapping[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*.*")
        if path.is_file() and os.access(path, os.R_OK)
    }


@slow
@pytest.mark.parametrize("words", COMMANDS)
def test_a_cluster_answers_as_one_process_does(cluster, folder, words):
    alone = answered(folder, words, "--jobs", "1")
    assert alone[0] in (0, 1, 2)
    assert answered(folder, words, "--jobs", "2") == alone
    there = answered(folder, words, "--on", cluster)
    here = alone[1].replace("--jobs 1", f"--on {cluster}")
    assert (there[0], there[2], there[3]) == (alone[0], alone[2], alone[3])
    assert there[1] == here
    assert answered(folder, words, "--on", "dask", "--jobs", "2")[2:] == alone[2:]


@slow
def test_workers_that_are_killed_lose_nothing(tmp_path):
    drawings = tmp_path / "drawings"
    drawings.mkdir()
    for number in range(6):
        shutil.copy(SAMPLES / "plate.dxf", drawings / f"d{number}.dxf")
    words = ["compile", *sorted(str(one) for one in drawings.iterdir()), "-l", "rapid"]
    command = [sys.executable, "-m", "assistant", *words, "-r", "irb1200-7-0.7"]
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    outputs = [tmp_path / "alone", tmp_path / "there"]
    draw = random.Random(44)
    with started(tmp_path) as address:
        begun = time.monotonic()
        whole = subprocess.run([*command, "-o", outputs[0]], env=environment, capture_output=True)
        lasts = time.monotonic() - begun
        for _ in range(2):
            shutil.rmtree(outputs[1], ignore_errors=True)
            process = subprocess.Popen(
                [*command, "-o", outputs[1], "--on", address],
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
            time.sleep(draw.uniform(0.0, lasts))
            kill_one_of(tmp_path, draw)
            said, errors = process.communicate()
            assert (process.returncode, errors) == (whole.returncode, whole.stderr)
            assert said.replace(b"there", b"alone") == whole.stdout
            assert files_of(outputs[1]) == files_of(outputs[0])


def kill_one_of(folder: Path, draw: random.Random) -> None:
    """Kill a worker of the cluster that works in a folder, or one of its processes."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            words = (path / "cmdline").read_bytes()
            inside = (path / "cwd").readlink()
        except OSError:
            continue
        if inside.is_relative_to(folder) and (b"spawn_main" in words or b"serve()" in words):
            found.append(int(path.name))
    if found:
        os.kill(draw.choice(sorted(found)), signal.SIGKILL)


@slow
def test_what_is_finished_before_the_scheduler_is_lost_is_written(tmp_path, folder):
    cell = started(tmp_path)
    for number in range(16):
        shutil.copy(SAMPLES / "plate.dxf", folder / f"d{number:02}.dxf")
        shutil.copy(SAMPLES / "plate.process.toml", folder / f"d{number:02}.process.toml")
    with cell as address:
        client = pytest.importorskip("distributed").Client(
            f"tcp{address.removeprefix('dask')}", set_as_default=False
        )
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "assistant", "compile"),
                *sorted(one.name for one in folder.glob("d*.dxf")),
                *("-l", "rapid", "-r", "irb1200-7-0.7", "-o", "out", "--on", address),
            ],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(PROJECT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        until = time.monotonic() + 300
        while latest(client) < 8:
            assert time.monotonic() < until and process.poll() is None
            time.sleep(0.05)
        client.close()
        cell.scheduler.kill()
        _, errors = process.communicate()
    assert process.returncode == 1, errors
    lost = errors.count("LM013 error")
    assert 0 < lost < 16
    assert len(list((folder / "out").glob("*.mod"))) == 16 - lost


def latest(client) -> int:
    """The last of the calls that a cluster works on."""
    keys = [key.split("-") for some in client.processing().values() for key in some]
    return max((int(key[3]) for key in keys if len(key) == 6), default=0)


@slow
def test_a_worker_of_another_version_is_refused(tmp_path, folder, capfd, monkeypatch):
    other = tmp_path / "other"
    shutil.copytree(PROJECT / "assistant", other / "assistant")
    with (other / "assistant/resources.py").open("a") as file:
        file.write("# not the same\n")
    monkeypatch.chdir(folder)
    (tmp_path / "run").mkdir()
    with started(tmp_path / "run", other) as address:
        status, out, err = told(capfd, "check", "a.dxf", "--on", address)
    assert (status, out) == (2, "")
    here = versions()["robot-assistant"]
    assert err.startswith(
        "LM012 error: the scheduler has another version than here: robot-assistant "
    )
    assert f", here {here}" in err
    assert "LM012 error: the worker tcp://" in err


@slow
def test_python_has_a_cluster_check(cluster, folder):
    distributed = pytest.importorskip("distributed")
    files = [folder / "a.dxf", folder / "one"]
    alone = assistant.check(files, robot="irb1200-7-0.7")
    address = f"tcp{cluster.removeprefix('dask')}"
    with distributed.Client(address, set_as_default=False) as client, assistant.on(client):
        there = assistant.check(files, robot="irb1200-7-0.7")
    assert there == alone and there.files


@slow
def test_a_process_that_dies_at_a_call_twice_has_it_reported(cluster):
    distributed = pytest.importorskip("distributed")
    address = f"tcp{cluster.removeprefix('dask')}"
    with distributed.Client(address, set_as_default=False) as client:
        answers = Cluster(client).answers(end, [1, 0, 3], _why)
    assert answers == ["1", "exit status 9", "3"]


def _why(_: int, died: WorkerDied) -> str:
    return str(died)


def end(number: int) -> str:
    if number == 0:
        os._exit(9)
    return str(number)


@slow
def test_where_no_scheduler_is_that_is_said(capfd, folder, monkeypatch):
    monkeypatch.chdir(folder)
    status, _, err = told(capfd, "check", "a.dxf", "--on", "dask://127.0.0.1:9")
    assert (status, err[:5]) == (2, "LM010")


def test_without_dask_the_command_that_installs_it_is_said(capfd, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.chdir(folder)
    status, out, err = told(capfd, "check", "a.dxf", "--on", "dask")
    assert (status, out, err[:5]) == (2, "", "LM009")
    assert f"[{'cluster'}]" in err and "install" in err


@pytest.mark.parametrize("on", ["", "tcp://h:1", "dask:/h:1", "dask://h", "dask://u@h:1"])
def test_what_names_no_cluster_is_refused(capfd, folder, monkeypatch, on):
    monkeypatch.chdir(folder)
    status, out, err = told(capfd, "check", "a.dxf", "--on", on)
    assert (status, out, err[:5]) == (2, "", "CL078")


def test_processes_are_no_matter_of_a_scheduler(capfd, folder, monkeypatch):
    monkeypatch.chdir(folder)
    status, _, err = told(capfd, "check", "a.dxf", "--on", "dask://h:1", "--jobs", "2")
    assert (status, err[:5]) == (2, "CL079")


@slow
def test_only_what_a_function_looks_at_is_sent(folder, monkeypatch, tmp_path):
    monkeypatch.chdir(folder)
    (folder / "b.dxf").write_text("not looked at")
    sent, worker, asked = SentFiles(), Worker(), []
    packed = sent.packed(looked, "a.dxf")
    (tmp_path / "mirror").mkdir()
    try:
        while True:
            done = worker.answer(answer, (str(tmp_path / "mirror"), sent.call(packed)))
            if done.result is not None:
                break
            asked += done.wants
            assert sent.learn(packed, done.wants)
    finally:
        worker.close()
    assert result_of(done.result) == looked("a.dxf")
    assert Want("entry", str(folder.parent / "gone.toml")) in asked
    assert Want("bytes", str(folder / "cell.toml")) in asked
    assert not any(path.endswith("b.dxf") for _, path in asked)
    there = tmp_path / "mirror" / str(folder / "b.dxf").lstrip("/")
    assert there.read_bytes() == b"\0" * len("not looked at")  # its size, and nothing more


def looked(name: str) -> tuple[object, ...]:
    """Ask about files in many ways."""
    path = Path(name)
    cell = path.absolute().with_name("cell.toml")
    return (
        path.read_bytes(),
        cell,
        cell.read_text(),
        (cell.parent.parent / "gone.toml").exists(),
        sorted(path.parent.iterdir()),
        [one.name for one in os.scandir("far")],
        Path("far/linked.dxf").resolve(),
        Path("far/linked.dxf").read_bytes() == path.read_bytes(),
        Path("b.dxf").stat().st_size,
        str(Path.cwd()),
    )


def test_the_ports_of_a_cluster_in_the_command_have_no_pages() -> None:
    def listening() -> set[int]:
        found = psutil.Process().net_connections("tcp")
        assert all(one.laddr.ip == "127.0.0.1" for one in found if one.status == "LISTEN")
        return {one.laddr.port for one in found if one.status == "LISTEN"}

    before = listening()
    with on_address("dask", 1):
        opened = listening() - before
        for port in opened:
            for page in ("/", "/status", "/info/main/workers.html", "/json/counts.json"):
                with pytest.raises(HTTPError, match="404"):
                    urlopen(f"http://127.0.0.1:{port}{page}", timeout=10)
    assert opened
