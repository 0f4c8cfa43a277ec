"""The sweep in short, and as a whole: `make sweep` prints the same by itself."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest

from tests.sweep import shim

SHORT = ("--every", "40", "fmt")
AT_LEAST = 11
ALL_AT_LEAST = 400
pytestmark = [
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="calls are met on Linux only"),
    pytest.mark.skipif(shim.compiler() is None, reason="no C compiler: 0 faults"),
]


def swept(*words: str) -> tuple[int, str]:
    """How many faults there were; all that was said."""
    command = [sys.executable, "-W", "ignore", "-m", "tests.sweep", *words]
    done = subprocess.run(command, capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    return int(said.splitlines()[-1].split()[0]), said


def test_some_calls_of_one_command(tell: Callable[[str], None]) -> None:
    faults, said = swept(*SHORT)
    tell(said)
    assert faults >= AT_LEAST


@pytest.mark.slow
def test_one_of_ten_calls_of_all_commands(tell: Callable[[str], None]) -> None:
    faults, said = swept("--every", "10")
    tell(said)
    assert faults >= ALL_AT_LEAST
