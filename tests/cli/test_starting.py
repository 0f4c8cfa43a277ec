"""What a command loads before it does its work: little, so that it starts fast."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.test_commands import run

SAMPLES = Path(__file__).parents[2] / "samples"
RAPID = str(SAMPLES / "rapid" / "drilling.mod")
MELFA = str(SAMPLES / "melfa" / "PALLET.prg")
RUN = """
import sys
from assistant.cli import main
try:
    main()
finally:
    print("\\n" + " ".join(sys.modules), file=sys.stderr)
"""

NETWORK = {"ssl", "urllib.request", "http.client"}
READERS = {"ezdxf", "assistant.sources.drawing", "assistant.program.pseudo.parser"}
WRITERS = {
    "jinja2",
    "matplotlib",
    "assistant.compiler.compilation",
    "assistant.compiler.translation",
}
RAPID_ROOMS = {"assistant.languages.rapid.tree.syntax", "assistant.languages.rapid.checks"}
MELFA_ROOMS = {
    "assistant.languages.melfa_basic.tree.syntax",
    "assistant.languages.melfa_basic.checks",
}


def loaded(*arguments: str) -> set[str]:
    """The modules that a process has when a command has come to its end."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments], capture_output=True, text=True, check=True
    )
    return set(done.stderr.splitlines()[-1].split())


def test_check_loads_what_the_language_of_the_file_needs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for file, others in ((RAPID, MELFA_ROOMS), (MELFA, RAPID_ROOMS)):
        run(capsys, "check", file)  # what it works out lies beside the bytecode from then on
        modules = loaded("check", file)
        own = (RAPID_ROOMS | MELFA_ROOMS) - others
        assert modules >= own
        assert not modules & {*others, *NETWORK, *READERS, *WRITERS, "rich.console"}
        if not sys.dont_write_bytecode:
            assert "lark" not in modules


def test_help_loads_no_language_and_no_columns() -> None:
    for arguments in (("--help",), ("check", "--help"), ("--version",)):
        modules = loaded(*arguments)
        languages = {"numpy", "lark", "assistant.compiler.checker", "assistant.languages"}
        assert not modules & languages, arguments
        assert not modules & {*NETWORK, *READERS, *WRITERS}, arguments
