"""The command line on a file: what it prints is sound, however it ends."""

from __future__ import annotations

import contextlib
import io
import json
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from assistant.cli import main
from tests.fuzz.target import ROOT, Target, folder, promise

FORMS: Final = ("text", "json", "sarif", "github")
COMMANDS: Final[Sequence[tuple[str, ...]]] = (
    ("check", "{file}", "--format", "{form}"),
    ("check", "{file}", "--robot", "irb1200-7-0.7", "--format", "{form}"),
    ("show", "{file}"),
    ("show", "{file}", "--to", "melfa-basic-5"),
    ("fmt", "{file}", "--diff"),
    ("compile", "{file}", "--language", "rapid", "-o", "{out}", "--format", "{form}"),
    ("compile", "{file}", "--language", "melfa-basic-4", "-o", "{out}", "--robot", "rv-2aj"),
    ("translate", "{file}", "--to", "melfa-basic-6", "-o", "{out}", "--frames", "product"),
    ("translate", "{file}", "--to", "rapid", "-o", "{out}", "--draft", "--format", "{form}"),
)
SUFFIXES: Final = (".mod", ".prg", ".mb5", ".pseudo", ".csv", ".toml", ".json", ".dxf", ".pgf", "")


def run(data: bytes) -> None:
    """The first two bytes say which command and which kind of file, the rest is the file."""
    command, kind = (data[:2] + b"\0\0")[:2]
    form = FORMS[command // len(COMMANDS) % len(FORMS)]
    path, out = folder() / f"input{SUFFIXES[kind % len(SUFFIXES)]}", folder() / "out"
    path.write_bytes(data[2:])
    words = {"file": str(path), "out": str(out), "form": form}
    arguments = [word.format(**words) for word in COMMANDS[command % len(COMMANDS)]]
    shutil.rmtree(out, ignore_errors=True)
    try:
        status, said = ran(arguments)
    finally:
        path.unlink()
    promise(status in (0, 1, 2), "another exit status", status)
    if "--format" in arguments and form in ("json", "sarif"):
        try:
            json.loads(said)
        except ValueError as error:
            promise(False, f"{form} that is none", error)


def ran(arguments: Sequence[str]) -> tuple[object, str]:
    """The exit status of a command, and what it printed on standard output."""
    said, told = (io.TextIOWrapper(io.BytesIO(), "utf-8", "surrogateescape") for _ in range(2))
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(told):
        try:
            main(list(arguments))
            status: object = 0
        except SystemExit as end:
            status = end.code or 0
    said.flush()
    buffer = said.buffer
    assert isinstance(buffer, io.BytesIO)
    return status, buffer.getvalue().decode("utf-8", "surrogateescape")


def _seeds() -> Iterator[bytes]:
    """A small file of each kind with some of the commands."""
    for kind, name in enumerate(_SEEDS):
        small = min((ROOT / "tests" / "fuzz" / "seeds" / name).iterdir(), key=_size).read_bytes()
        for command in range(kind % 3, len(COMMANDS) * len(FORMS), 3):
            yield bytes([command, kind]) + small


def _size(file: Path) -> int:
    return file.stat().st_size


_SEEDS: Final = (
    *("rapid", "melfa-basic", "melfa-basic", "pseudo", "csv", "taught", "json", "dxf"),
)

TARGETS: Final = (Target("command", run, lambda: list(_seeds()), most=2000, tried=10),)
