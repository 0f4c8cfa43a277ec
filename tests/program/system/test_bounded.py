"""Reading that ends: pipes, devices, and files that are or become too large."""

from __future__ import annotations

import io
import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path as FilePath

import pytest

from assistant.base.budgets import FACTOR_VARIABLE
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.file_access import NoFile, TooLarge, read_file, read_stream
from assistant.base.source_text import read_bytes


def a_pipe(path: FilePath) -> None:
    os.mkfifo(path)


def a_socket(path: FilePath) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(os.path.relpath(path))


def a_device(path: FilePath) -> None:
    path.symlink_to("/dev/zero")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no such files")
@pytest.mark.parametrize("make", [a_pipe, a_socket, a_device])
def test_only_regular_files_are_read(make: Callable[[FilePath], None], tmp_path: FilePath) -> None:
    path = tmp_path / "x"
    make(path)
    with pytest.raises(NoFile):
        read_file(path)
    with pytest.raises(Unreadable) as refused:
        read_bytes(path)
    (finding,) = refused.value.findings
    assert (finding.code, finding.path) == ("IN009", str(path))


def test_a_file_has_a_limit_before_it_is_read(
    tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "x"
    with file.open("wb") as hollow:
        hollow.truncate(1 << 40)
    with pytest.raises(Unreadable) as refused:
        read_bytes(file)
    assert refused.value.findings[0].code == "IN010"
    file.write_bytes(bytes(1001))
    with pytest.raises(TooLarge):
        read_file(file, 1000)
    monkeypatch.setenv(FACTOR_VARIABLE, "2")
    assert len(read_file(file, 1000)) == 1001
    monkeypatch.setenv(FACTOR_VARIABLE, "no")
    with pytest.raises(Refused) as wrong:
        read_file(file, 1000)
    assert wrong.value.findings[0].code == "LM006"


def test_a_file_has_a_limit_while_it_is_read() -> None:
    status = FilePath("/proc/self/status")
    if not status.is_file():
        pytest.skip("the system has no files that say that they are empty")
    assert status.stat().st_size == 0
    assert read_file(status).startswith(b"Name:")
    with pytest.raises(TooLarge):
        read_file(status, 100)


def test_what_comes_in_parts_is_read_up_to_a_limit() -> None:
    assert read_stream(io.BytesIO(b"x" * 3_000_000)) == b"x" * 3_000_000
    reading, writing = os.pipe()
    with os.fdopen(reading, "rb") as stream, os.fdopen(writing, "wb", buffering=0) as end:
        threading.Timer(0, end.write, [bytes(50_000)]).start()
        with pytest.raises(TooLarge):
            read_stream(stream, 40_000)  # its end never comes
