"""The system's C compiler, and what it makes, called through `ctypes`."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from assistant.robots import Robot

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
Columns = tuple[np.ndarray, ...]


def compiler() -> str:
    """The one of the system; skips a test where there is none."""
    found = shutil.which("gcc") or shutil.which("cc")
    if found is None:
        pytest.skip("this machine has no C compiler")
    return found


def compiled(files: Sequence[Path], output: Path, *more: str) -> Path:
    """C files made into one file, without a warning."""
    words = [compiler(), *STRICT, *more, *map(str, files), "-lm", "-o", str(output)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return output


class Library:
    """Functions of the source of an arm in a shared library, over columns."""

    def __init__(self, library: ctypes.CDLL, prefix: str, robot: Robot) -> None:
        self.library, self.prefix, self.robot = library, prefix, robot

    def __getattr__(self, name: str) -> ctypes._CFuncPtr:
        return getattr(self.library, f"{self.prefix}_{name}")

    def forward(self, joints: np.ndarray) -> Columns:
        """Positions, quaternions, configurations and Jacobians."""
        n, a = joints.shape
        p, q, c = np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 6), dtype=np.int32)
        rates = np.empty((n, 6, a))
        for i, row in enumerate(np.ascontiguousarray(joints)):
            self.fk(at(row), at(p[i]), at(q[i]))
            self.configuration(at(row), at(c[i]))
            self.jacobian(at(row), at(rates[i]))
        return p, q, c, rates

    def inverse(self, positions: np.ndarray, quaternions: np.ndarray) -> Columns:
        """Joints of every branch, and which are valid."""
        n, b, a = len(positions), self.robot.branches, len(self.robot.axes)
        joints, valid = np.empty((n, b, a)), np.empty((n, b), dtype=np.int32)
        for i in range(n):
            count = self.ik(at(positions[i]), at(quaternions[i]), at(joints[i]), at(valid[i]))
            assert count == valid[i].sum()
        return joints, valid == 1


def at(row: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(row.ctypes.data)
