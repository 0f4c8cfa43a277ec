"""Cases: programs of written-out targets and moves, and of ordinary code, from bytes to trees.

Each language has the same three beside each other: what `read` and `parse` give, a bare regular
expression over the same bytes, the grammar alone, every line by lark's tables, and lark alone:
its own lexer and parser with the same grammar, which build its own tree.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path as FilePath
from typing import Any, Final

from lark import Lark

from assistant import languages
from assistant.resources import read_grammar
from benchmarks.code import LINES, code
from benchmarks.emission import Case, emit, program

_FOLDER: Final = tempfile.TemporaryDirectory(prefix="reading")

_NUMBER: Final = rb"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)"
_PARTS: Final = rb"\],\[".join(rb",".join([_NUMBER] * n) for n in (3, 4, 4, 6))


@dataclass(frozen=True, slots=True)
class Spoken:
    """A language as its cases need it.

    room: of its parser. most: targets of one file, None for all in one. smallest: the shortest
    sound program. arguments: of the parser beside the source. line: a target or a move.
    """

    name: str
    title: str
    room: str
    most: int | None
    smallest: str
    arguments: tuple[str, ...]
    line: re.Pattern[bytes]


SPOKEN: Final = (
    Spoken(
        "rapid",
        "RAPID",
        "rapid",
        None,
        "MODULE m\nENDMODULE\n",
        (),
        re.compile(
            rb"CONST robtarget (\w+):=\[\[" + _PARTS + rb"\]\];"
            rb"|Move([LJ]) (\w+),(\w+),(\w+),(\w+)(?:\\WObj:=(\w+))?;"
        ),
    ),
    Spoken(
        "melfa-basic-6",
        "MELFA-BASIC VI",
        "melfa_basic",
        30_000,
        "1 End\r\n",
        ("melfa-basic-6",),
        re.compile(
            rb"(\w+)=\(" + rb",".join([_NUMBER] * 6) + rb"\)\(([0-9]+),([0-9]+)\)\r?\n"
            rb"|([0-9]+) M(?:ov|vs) (\w+)\r?\n"
        ),
    ),
)


# ----------------------------------------------------------------------------- files


def written(spoken: Spoken, write: Callable[[int, str, FilePath, int], None]) -> Any:
    """What prepares a case: files in a folder, written by another process.

    So the memory of writing them does not count, nor does the time to load the grammar.
    """

    def prepare(n: int) -> list[FilePath]:
        languages.get(spoken.name).parse(spoken.smallest)
        folder = FilePath(_FOLDER.name)
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            pool.submit(write, n, spoken.name, folder, spoken.most or n).result()
        return sorted(folder.iterdir())

    return prepare


def with_lark(spoken: Spoken) -> Any:
    """The files of the other cases, with lark's tables made before the time is taken."""
    prepare = written(spoken, targets)

    def prepared(n: int) -> list[FilePath]:
        trees_of(spoken.room)
        return list(prepare(n))

    return prepared


def targets(n: int, name: str, folder: FilePath, most: int) -> None:
    """Files of n targets that are written out and a move through each."""
    language = languages.get(name)
    said = language.adapt(program(n), most_targets=most).program
    for file, content in emit((language, said)).items():
        (folder / file).write_bytes(content)


def ordinary(n: int, name: str, folder: FilePath, _: int) -> None:
    """Files of n lines of code, no two of them alike."""
    for file, content in code(name, n).items():
        (folder / file).write_bytes(content)


# -------------------------------------------------------------------------------- work


def reading(spoken: Spoken) -> Callable[[list[FilePath]], None]:
    """What `read` and `parse` give: columns, spans and findings, all of it kept."""

    def read(files: list[FilePath]) -> None:
        language = languages.get(spoken.name)
        trees = [language.parse(language.read(file)) for file in files]
        for tree in trees:
            if tree.findings:
                raise SystemExit(f"findings in a sound program: {tree.findings[:3]}")

    return read


def grammar_only(spoken: Spoken) -> Callable[[list[FilePath]], None]:
    """The same trees without columns, every line by the grammar."""

    def read(files: list[FilePath]) -> None:
        parse = import_module(f"assistant.languages.{spoken.room}.reading.parser").parse
        language = languages.get(spoken.name)
        kept = [parse(language.read(file), *spoken.arguments, runs=False) for file in files]
        assert kept

    return read


def bare_scan(spoken: Spoken) -> Callable[[list[FilePath]], None]:
    """Names and numbers of each line as bytes, nothing checked and nothing converted."""

    def scan(files: list[FilePath]) -> None:
        for file in files:
            for match in spoken.line.finditer(file.read_bytes()):
                match.groups()

    return scan


def lark_alone(spoken: Spoken) -> Callable[[list[FilePath]], None]:
    """The trees that lark builds by itself, none of them turned into ours."""

    def read(files: list[FilePath]) -> None:
        language = languages.get(spoken.name)
        trees = trees_of(spoken.room)
        kept = [trees(language.read(file).text) for file in files]
        assert kept

    return read


@cache
def trees_of(room: str) -> Callable[[str], Any]:
    """Lark with the grammar of a language, which reads a program at once."""
    options = {"lexer": "contextual", "maybe_placeholders": True, "propagate_positions": True}
    parser = Lark(read_grammar(f"{room}.lark"), start="start", parser="lalr", **options)
    return lambda text: parser.parse(text, start="start")


# ------------------------------------------------------------------------------- cases


@dataclass(frozen=True, slots=True)
class Reading:
    """What is measured. sizes: numbers of what is counted, `targets` or `lines`."""

    case: Case
    sizes: tuple[int, ...]
    counted: str = "targets"


def _cases(spoken: Spoken) -> dict[str, Reading]:
    prepare = written(spoken, targets)
    lines = Reading((written(spoken, ordinary), reading(spoken)), (LINES,), "lines")
    large, small = (1_000_000, 10_000), (2_000, 10_000)
    return {
        f"read {spoken.title}": Reading((prepare, reading(spoken)), large),
        f"bare regular expression, the same {spoken.title}": Reading(
            (prepare, bare_scan(spoken)), large
        ),
        f"grammar alone, the same {spoken.title}": Reading((prepare, grammar_only(spoken)), small),
        f"lark alone, the same {spoken.title}": Reading(
            (with_lark(spoken), lark_alone(spoken)), small
        ),
        f"read {spoken.title}, ordinary code": lines,
    }


READING: Final[dict[str, dict[str, Reading]]] = {spoken.title: _cases(spoken) for spoken in SPOKEN}
"""Title → the cases of that language; the grammar or lark alone would take long for a million."""
