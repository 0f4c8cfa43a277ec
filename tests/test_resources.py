"""Tables of grammars: kept where Python keeps bytecode, made anew where that cannot be read."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.forks import Forks

MODULE = "MODULE m\n  PROC main()\n  ENDPROC\nENDMODULE\n"


def check(folder: Path, **variables: str) -> tuple[int, str]:
    """`check` of a small module in a process of its own, bytecode in the folder."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(
        [sys.executable, "-m", "assistant", "check", "-", "--from", "rapid"],
        input=MODULE.encode(),
        capture_output=True,
        env={**environment, "PYTHONPYCACHEPREFIX": str(folder), **variables},
    )
    return done.returncode, (done.stdout + done.stderr).decode()


QUICK = """\
import sys
from assistant.cli import main
from assistant.languages.rapid.reading.scanner import grammar
grammar.cache_clear()
sys.pycache_prefix, sys.dont_write_bytecode = sys.argv.pop(1), False
try:
    main()
finally:
    assert grammar.cache_info().misses == 1
"""


def quick(forks: Forks, folder: Path) -> tuple[int, str]:
    """The same where only the tables are not there yet, and no bytecode has to be made."""
    module = folder.parent / "m.mod"
    module.write_text(MODULE)
    done = forks.python("-c", QUICK, str(folder), "check", str(module))
    return done.returncode, done.stdout + done.stderr


def kept(folder: Path) -> list[Path]:
    return list(folder.rglob("rapid*.lalr"))


@pytest.mark.slow
def test_tables_are_kept_and_a_damaged_file_of_them_is_made_anew(tmp_path):
    first = check(tmp_path)
    [tables] = kept(tmp_path)
    whole = tables.read_bytes()
    tables.write_bytes(whole[: len(whole) // 2])
    assert check(tmp_path) == first == (0, "1 checked, 0 findings\n")
    anew = tables.read_bytes()
    assert len(anew) > 0.9 * len(whole)
    assert check(tmp_path) == first and tables.read_bytes() == anew


@pytest.mark.one_in(4)
@pytest.mark.parametrize("foreign", ["[]", "{}", '{"of": [1, "start: NAME", "start"]}', "\0"])
def test_tables_of_something_else_are_made_anew(tmp_path, forks, foreign):
    folder = tmp_path / "used"
    first = quick(forks, folder)
    assert first == (0, "1 checked, 0 findings\n")
    [tables] = kept(folder)
    right = json.loads(tables.read_bytes())
    tables.write_text(foreign)
    assert quick(forks, folder) == first
    assert json.loads(tables.read_bytes())["of"] == right["of"]
    assert [file for file in tables.parent.iterdir() if file.name.startswith("rapid")] == [tables]


@pytest.mark.slow
def test_where_no_bytecode_is_wanted_none_is_kept(tmp_path):
    assert check(tmp_path, PYTHONDONTWRITEBYTECODE="1")[0] == 0
    assert kept(tmp_path) == []


def test_where_nothing_can_be_kept_programs_are_read_all_the_same(tmp_path, forks):
    no_folder = tmp_path / "file"
    no_folder.write_text("")
    assert quick(forks, no_folder) == (0, "1 checked, 0 findings\n")
