"""Cases: a RAPID module of declared targets and moves, from bytes to columns with findings."""

from __future__ import annotations

import re
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from benchmarks.emission import Case, emit, program

_FOLDER: Final = tempfile.TemporaryDirectory(prefix="reading")


def module(n: int) -> FilePath:
    """A file of n declared targets and a move through each, written by another process.

    So the memory of writing it does not count, nor does the time to load the grammar.
    """
    languages.get("rapid").parse("MODULE m\nENDMODULE\n")
    path = FilePath(_FOLDER.name) / "scan.mod"
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        pool.submit(_write, n, path).result()
    return path


def _write(n: int, path: FilePath) -> None:
    rapid = languages.get("rapid")
    said = rapid.adapt(program(n), most_targets=n).program
    (content,) = emit((rapid, said)).values()
    path.write_bytes(content)


def read(path: FilePath) -> None:
    """What `rapid.read` and `rapid.parse` give: columns, spans and findings."""
    rapid = languages.get("rapid")
    tree = rapid.parse(rapid.read(path))
    if tree.findings:
        raise SystemExit(f"findings in a sound module: {tree.findings[:3]}")


def grammar_only(path: FilePath) -> None:
    """The same tree from lark alone, every line by the grammar."""
    from assistant.languages.rapid.parser import parse

    parse(languages.get("rapid").read(path), runs=False)


_NUMBER: Final = rb"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)"
_PARTS: Final = rb"\],\[".join(rb",".join([_NUMBER] * n) for n in (3, 4, 4, 6))
_LINE: Final = re.compile(
    rb"CONST robtarget (\w+):=\[\[" + _PARTS + rb"\]\];"
    rb"|Move([LJ]) (\w+),(\w+),(\w+),(\w+)(?:\\WObj:=(\w+))?;"
)


def bare_scan(path: FilePath) -> None:
    """Names and numbers of each line as bytes, nothing checked and nothing converted."""
    for match in _LINE.finditer(path.read_bytes()):
        match.groups()


READING: Final[dict[str, Case]] = {
    "read RAPID": (module, read),
    "a bare regular expression over the same bytes": (module, bare_scan),
    "lark alone": (module, grammar_only),
}

SIZES: Final = {
    "read RAPID": (1_000_000, 10_000),
    "a bare regular expression over the same bytes": (1_000_000, 10_000),
    "lark alone": (2_000, 10_000),
}
"""Targets of each case; lark alone would take half an hour for a million."""
