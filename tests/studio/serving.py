"""A studio as a user starts it: a process of its own, and what a page asks of it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any
from urllib.error import HTTPError
from urllib.parse import urlencode, urlsplit
from urllib.request import Request, urlopen

from websockets.sync.client import ClientConnection, connect


@dataclass(frozen=True)
class Answer:
    status: int
    value: Any


@dataclass
class Page:
    """What a page of this origin asks of the studio.

    window: its name, once its line is open. writes: whether it is the one that changes something.
    """

    address: str
    window: str = ""
    writes: bool = False

    @property
    def origin(self) -> str:
        parts = urlsplit(self.address)
        return f"{parts.scheme}://{parts.netloc}"

    def get(self, path: str, /, **values: str) -> Answer:
        return self._answer(f"{path}?{urlencode(values)}" if values else path)

    def post(self, path: str, /, **values: Any) -> Answer:
        kind = {"Content-Type": "application/json"}
        return self._answer(path, json.dumps(values).encode(), kind)

    def send(self, path: str, data: bytes, /, **values: str) -> Answer:
        kind = {"Content-Type": "application/octet-stream"}
        return self._answer(f"{path}?{urlencode(values)}", data, kind)

    @contextmanager
    def line(self) -> Iterator[ClientConnection]:
        """Opens its line to the studio, by which it gets its name."""
        address = self.address.replace("http", "ws", 1) + "window"
        with connect(address, additional_headers={"Origin": self.origin}, max_queue=None) as line:
            self.hear(line)
            yield line

    def hear(self, line: ClientConnection) -> Any:
        """The next that the studio tells this window."""
        message = json.loads(line.recv(10.0))
        if message["kind"] == "window":
            self.window, self.writes = message["name"], message["writes"]
        return message

    def _answer(
        self, path: str, data: bytes | None = None, headers: dict[str, str] | None = None
    ) -> Answer:
        told = {"Origin": self.origin, "X-Window": self.window, **(headers or {})}
        asked = Request(self.address + path, data=data, headers=told)
        return answered(asked)


def answered(asked: Request) -> Answer:
    """Whatever comes, refusals as well."""
    try:
        with urlopen(asked, timeout=60) as response:
            return Answer(response.status, _value(response.read()))
    except HTTPError as refused:
        return Answer(refused.code, _value(refused.read()))


def _value(data: bytes) -> Any:
    try:
        return json.loads(data)
    except ValueError:
        return data.decode("utf-8", "replace")


@contextmanager
def served(folder: Path, *options: str) -> Iterator[str]:
    """The address of a studio of a folder, served by the command."""
    command = [sys.executable, "-m", "assistant", "studio", str(folder)]
    with tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen(
            [*command, "--no-open", "--format", "json", *options],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        try:
            yield _address(process, log)
        finally:
            process.terminate()
            process.communicate(timeout=20)
        log.seek(0)
        assert "Traceback" not in log.read()


def _address(process: subprocess.Popen[str], log: IO[str]) -> str:
    assert process.stdout is not None
    said = ""
    while not said.endswith("}\n"):
        line = process.stdout.readline()
        if not line:
            log.seek(0)
            raise AssertionError(log.read())
        said += line
    address: str = json.loads(said)["address"]
    return address
