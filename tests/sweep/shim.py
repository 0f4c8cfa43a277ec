"""The library that lets calls fail: made here, loaded before others, told by memory in common."""

from __future__ import annotations

import ctypes
import mmap
import os
import shutil
import subprocess
from pathlib import Path
from typing import Final

SOURCE: Final = Path(__file__).with_name("shim.c")
PRELOAD: Final = "LD_PRELOAD"
NAME: Final = "shim.so"
NOTHING, SIGNAL, ONCE, ALWAYS, FULL = range(5)
"""What happens at a call: as in the source of the library."""


def compiler() -> str | None:
    return shutil.which("cc") or shutil.which("gcc")


def made(folder: Path) -> Path:
    """The library, compiled into a folder."""
    found = compiler()
    assert found is not None
    library = folder / NAME
    words = [found, "-O1", "-shared", "-fPIC", "-Wall", "-Werror", str(SOURCE), "-o", str(library)]
    subprocess.run([*words, "-ldl"], check=True)
    return library


class Fault(ctypes.Structure):
    """What is to happen, and what did; in memory that a fork of this process has in common."""

    count: int
    at: int
    kind: int
    what: int
    again: int
    fired: int
    call: bytes
    _fields_ = [
        *((name, ctypes.c_long) for name in ("count", "at", "kind", "what", "again", "fired")),
        ("call", ctypes.c_char * 32),
    ]


def common() -> Fault:
    """The memory that the library, which is loaded, looks at in the forks of this process."""
    return Fault.from_buffer(mmap.mmap(-1, mmap.PAGESIZE))


def begin(fault: Fault) -> None:
    """From here on calls of this process are counted."""
    library = ctypes.CDLL(os.environ[PRELOAD])
    library.fault_at(ctypes.byref(fault))
