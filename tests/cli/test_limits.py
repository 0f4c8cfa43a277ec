"""What is without end through the command ends in a finding: pipes, devices, what multiplies."""

from __future__ import annotations

import os
import threading
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from assistant import languages
from assistant.base.budgets import FACTOR_VARIABLE
from tests.cli.tables import each
from tests.cli.test_commands import run

MODULE = "MODULE m\n{data}\nPROC main()\n{body}\nENDPROC\nENDMODULE\n"
ROBOT = 'name = "mine"\nurdf = "{}"\n'
TABLE = "x,y,z\n400,0,300\n410,0,300\n"

needs_pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has none")


@pytest.fixture
def pipe(tmp_path: Path) -> Iterator[Path]:
    """A named pipe `x.mod` that somebody has open for writing, for 20 seconds at most."""
    path = tmp_path / "x.mod"
    os.mkfifo(path)
    with os.fdopen(os.open(path, os.O_RDWR), "wb", buffering=0) as end:
        end.write(MODULE.format(data="", body="").encode())
        closing = threading.Timer(20, end.close)
        closing.start()
        yield path
        closing.cancel()
        closing.join()


PIPES = [
    "check PIPE",
    "fmt --check PIPE",
    "show PIPE",
    "coverage PIPE",
    "run PIPE",
    "simulate PIPE",
    "translate PIPE --to melfa-basic-5 -o OUT",
    "compile PIPE -l rapid -o OUT",
    "compile TABLE -l rapid -o OUT --process PIPE",
    "compile TABLE -l rapid -o OUT --robot robot.toml",
    "check TABLE --robot PIPE.toml",
    "run TABLE --signals PIPE",
    "robots show robot.toml",
    "deploy PIPE --to melfa://127.0.0.1:1",
    "plan PIPE --to melfa://127.0.0.1:1",
]


@needs_pipes
def test_no_command_waits_at_a_pipe(pipe, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.mod.toml").symlink_to(pipe)
    (tmp_path / "robot.toml").write_text(ROBOT.format(pipe.name), encoding="utf-8")
    (tmp_path / "t.csv").write_text(TABLE, encoding="utf-8")

    def check(words):
        named = words.replace("PIPE", pipe.name).replace("OUT", "out").replace("TABLE", "t.csv")
        status, _, err = run(capsys, *named.split())
        assert status == 2 and "IN009" in err and "a named pipe" in err
        assert not (tmp_path / "out").exists()

    each(PIPES, check)


DEVICES = (
    "check /dev/zero",
    "compile t.csv -l rapid -o out --process /dev/zero",
    "robots show robot.toml",
)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="the system has no such device")
def test_no_command_reads_a_device(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.toml").write_text(ROBOT.format("/dev/zero"), encoding="utf-8")
    (tmp_path / "t.csv").write_text(TABLE, encoding="utf-8")
    for words in DEVICES:
        status, _, err = run(capsys, *words.split())
        assert status == 2 and "IN009" in err and "a device" in err, words


def test_an_array_is_not_multiplied_out(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv(FACTOR_VARIABLE, "0.3")
    file = tmp_path / "arr.mod"
    for size in ("100000,100000,100000", "2000000000"):
        at = ",".join("1" for _ in size.split(","))
        file.write_text(MODULE.format(data=f"VAR num a{{{size}}};", body=f"a{{{at}}}:=2;"))
        status, out, err = run(capsys, "translate", file, "--to", "melfa-basic-5", "-o", tmp_path)
        assert status == 1 and "MB209" in out + err and "LM0" not in out + err, size


def test_a_long_string_takes_the_memory_of_its_characters():
    text = MODULE.format(data="", body='TPWrite "' + "x" * 300_000 + '";')
    rapid = languages.get("rapid")
    rapid.parse(MODULE.format(data="", body='TPWrite "";'))
    tracemalloc.start()
    tree = rapid.parse(text)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert not tree.findings[1:] and peak < 40 * len(text)


def test_an_archive_is_measured_before_it_is_unpacked(tmp_path, capsys, monkeypatch):
    file = tmp_path / "zeros.npz"
    np.savez_compressed(file, positions=np.zeros((500_000, 3)))
    monkeypatch.setenv(FACTOR_VARIABLE, "0.01")
    status, _, err = run(capsys, "compile", file, "-l", "rapid", "-o", tmp_path / "out")
    assert (status, "TB407" in err) == (2, True)


def test_a_budget_is_an_option_and_a_variable(tmp_path, capsys, monkeypatch):
    file = tmp_path / "t.csv"
    file.write_text("x,y,z\n" + "400,0,300\n" * 26_300, encoding="utf-8")
    for given, variable, wanted in (
        (("--budget", "0.001"), None, "IN010"),
        ((), "0.001", "IN010"),
        (("--budget", "1"), "0.001", ""),
        (("--budget", "nan"), None, "LM006"),
        ((), "-1", "LM006"),
    ):
        if variable is None:
            monkeypatch.delenv(FACTOR_VARIABLE, raising=False)
        else:
            monkeypatch.setenv(FACTOR_VARIABLE, variable)
        status, _, err = run(capsys, *given, "check", file)
        assert (status == 2) == bool(wanted) and wanted in err
        assert os.environ.get(FACTOR_VARIABLE) == variable  # the next command has its own


def test_what_is_nested_too_deeply_or_too_great_is_no_failure_of_ours(tmp_path, capsys):
    deep = tmp_path / "deep.mod"
    deep.write_text(MODULE.format(data="", body="x:=" + "(" * 3000 + "1" + ")" * 3000 + ";"))
    great = tmp_path / "great.pseudo"
    great.write_text("program a\nif a > 1" + "0" * 400 + "\nend\n", encoding="utf-8")
    for file in (deep, great):
        for command in (("check",), ("translate", "--to", "melfa-basic-5", "-o", tmp_path / "o")):
            status, out, err = run(capsys, command[0], file, *command[1:])
            assert status in (1, 2) and "CL900" not in out + err
