"""Commands in processes of their own, which have everything imported as they begin."""

from __future__ import annotations

import os
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

from tests.forks import Forks

MAIN = """
import os, pathlib, sys
pathlib.Path(sys.argv.pop(1)).write_text(str(os.getpid()))
sys.argv[0] = "robot-assistant"
from assistant.cli import main
main()
"""


class Command(subprocess.Popen[str]):
    """`robot-assistant` in a fork of the process of `forks`, which gets the signals.

    What is started is the program that hands over to the fork, and ends as that does.
    """

    def __init__(self, forks: Forks, *words: object, **options: Any) -> None:
        handle, name = tempfile.mkstemp(dir=forks.folder)
        os.close(handle)
        self._number = Path(name)
        python = str(forks.folder / "python")
        super().__init__([python, "-c", MAIN, name, *map(str, words)], text=True, **options)

    def send_signal(self, sig: int) -> None:
        """To a command that has printed something."""
        if self.poll() is None:
            with suppress(ProcessLookupError):
                os.kill(int(self._number.read_text()), sig)
