"""An FMU in a small C program, and in fmpy."""

from __future__ import annotations

import atexit
import functools
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from assistant.blocks.fmu import Model, compiled
from assistant.blocks.fmu.co_simulation import this_platform
from tests.blocks.code.compiled import compiled as built
from tests.blocks.code.compiled import compiler

SOURCE = Path(__file__).with_name("host.c")
LETTERS = {"Real": "r", "Integer": "i", "Boolean": "b", "String": "s"}


@dataclass(frozen=True)
class Speed:
    """steps: a second of the processor. nanoseconds: of a step. bytes: of an instance. peak: KiB of
    the process.
    """

    steps: float
    nanoseconds: float
    bytes: int
    peak: int


@functools.cache
def host() -> Path:
    """The program, compiled once a process."""
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    return built([SOURCE], Path(folder.name) / "host", "-O1", "-ldl")


_PACKED: dict[str, bytes] = {}


def packed(model: Model) -> bytes:
    """The FMU of a model, compiled once a process."""
    compiler()
    if model.guid not in _PACKED:
        data, findings = compiled(model)
        assert findings == ()
        _PACKED[model.guid] = data
    return _PACKED[model.guid]


class Hosted:
    """An FMU whose library is loaded by a program without Python."""

    def __init__(self, model: Model, folder: Path) -> None:
        self.model, self.folder = model, folder
        self.file = folder / "model.fmu"
        data = packed(model)
        self.file.write_bytes(data)
        self.size = len(data)
        with zipfile.ZipFile(self.file) as archive:
            archive.extractall(folder / "unpacked")
        (self.library,) = (folder / "unpacked" / "binaries" / this_platform()).iterdir()
        self.program = host()

    def place(self, name: str) -> str:
        one = next(one for one in self.model.variables if one.name == name)
        return f"{LETTERS[one.type]}{one.reference}"

    def outputs(self) -> list[str]:
        return [one.name for one in self.model.variables if one.causality == "output"]

    def run(
        self,
        inputs: Sequence[str],
        rows: np.ndarray,
        step: float,
        parameters: Mapping[str, float | str] | None = None,
        repeats: int = 0,
    ) -> tuple[np.ndarray, Speed | None]:
        """The outputs (n + 1, k) before and after each step, and how fast it was repeated."""
        names = self.outputs()
        given = ",".join(f"{self.place(name)}={v}" for name, v in (parameters or {}).items())
        done = subprocess.run(
            [
                *(str(self.program), str(self.library), self.model.guid, repr(step), str(repeats)),
                ",".join(map(self.place, inputs)),
                ",".join(map(self.place, names)),
                given,
            ],
            input=np.ascontiguousarray(rows, dtype=np.float64).tobytes(),
            capture_output=True,
        )
        assert done.returncode == 0, done.stderr.decode()
        self.said = done.stderr.decode()
        told = [float(word) for word in self.said.splitlines()[-1].split()] if repeats else []
        speed = Speed(told[0], told[1], int(told[2]), int(told[3])) if repeats else None
        return np.frombuffer(done.stdout).reshape(-1, len(names)), speed

    def in_fmpy(
        self,
        inputs: Sequence[str],
        rows: np.ndarray,
        step: float,
        parameters: Mapping[str, float | str] | None = None,
    ) -> np.ndarray:
        """The outputs (n + 1, k) of the same steps in fmpy."""
        fmpy = pytest.importorskip("fmpy", reason="fmpy comes with the extra `test`")
        kinds = {one.name: one.type for one in self.model.variables}
        types = {"Real": np.float64, "Integer": np.int32, "Boolean": np.bool_}
        times = np.arange(len(rows)) * step
        columns = [("time", np.float64), *((name, types[kinds[name]]) for name in inputs)]
        signals = np.zeros(len(rows), dtype=columns)
        signals["time"] = times
        for name, column in zip(inputs, np.asarray(rows).T, strict=True):
            signals[name] = column
        names = self.outputs()
        found = fmpy.simulate_fmu(
            str(self.file),
            start_time=0.0,
            stop_time=len(rows) * step,
            step_size=step,
            output_interval=step,
            input=signals,
            output=names,
            start_values=dict(parameters or {}),
        )
        return np.column_stack([np.asarray(found[name], dtype=np.float64) for name in names])
