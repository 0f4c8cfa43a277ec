"""Words of the vendors' languages stand in the rooms of the vendors only.

A literal with such a word elsewhere is behaviour that knows a vendor: another one's would
silently be left out there. The words are those of the languages' own tables.
"""

from __future__ import annotations

import ast
import functools
import itertools
import re
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Final

import pytest

from assistant import languages
from assistant.base.budgets import without_gc
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.rapid.tables.constants import RESERVED, SPEEDS, ZONES
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.robots import robot

PACKAGE = FilePath(__file__).parent.parent / "assistant"
VENDORS = ("languages/", "virtual/", "controllers/")
"""Rooms that may know vendors; what robots know of them is data, no Python."""
SHARED = re.compile(r"languages/(?:(?:checks|recovery|runs|texts)/)?\w+\.py")
"""What all languages share knows none of them."""

COMMON: Final = frozenset(
    """
    abs acos add and as asin atan atan2 base bitand bitor bitxor break calibrate case clock close
    com cos default deg dim distance div do double edge else elseif end error exit exp false fine
    float fn for from goto high if inout input is left ln load local log long low map max min mod
    module next not off on open or pose present print rad record remove return right round save
    servo set sin sqrt step stop string switch tan task then title to tool true trunc type wait
    while with work write xor zone
    """.split()  # noqa: SIM905
)
"""Words of vendors that are also English, mathematics, or the pseudo-program's own."""

EXCEPTIONS: Final = {
    ("__init__.py", "connect"): "the name of our own function",
    ("base/data_classes.py", "def"): "a word of Python",
    ("base/data_classes.py", "eq"): "a method of Python",
    ("checks/clearances.py", "clear"): "apart",
    ("checks/program_rules.py", "rapid"): "says whose limit it is",
    ("cli/app.py", "rapid"): "help: what the program is for",
    ("cli/app.py", "reset"): "the name of a command",
    ("cli/app.py", "melfa"): "help: what the program is for",
    ("cli/demo.py", "j_curr"): "what the second program on its virtual controller sends",
    ("cli/controller_state.py", "reset"): "the name of our own command",
    ("cli/options.py", "melfa"): "help: whose frames the option is about",
    ("cli/warm_server.py", "rapid"): "the samples that load what commands use",
    ("cli/warm_server.py", "melfa"): "the samples that load what commands use",
    ("editing/answers.py", "function"): "a sort of word",
    ("editing/answers.py", "readonly"): "what editors call it",
    ("editing/code_assist.py", "function"): "a sort of word",
    ("editing/lsp_types.py", "function"): "a sort of word",
    ("editing/lsp_types.py", "readonly"): "what editors call it",
    ("editing/service.py", "fix"): "what editors call it",
    ("editing/vscode/extension.py", "function"): "a sort of word",
    ("languages/__init__.py", "melfa"): "the table of languages",
    ("languages/__init__.py", "rapid"): "the table of languages",
    ("languages/texts/printed_trees.py", "str"): "a type of Python",
    ("learning/calibration_output.py", "tool0"): "what robot files call the flange",
    ("program/editor_support.py", "function"): "a sort of word",
    ("program/geometry.py", "tool0"): "the flange's own name in a pseudo-program",
    ("program/pseudo/words.py", "function"): "what pseudo-programs have as well",
    ("program/pseudo/words.py", "tool0"): "the flange's own name in a pseudo-program",
    ("base/budgets.py", "proc"): "where Linux tells of processes",
    ("report/robots.py", "confdata"): "tells people what the maker calls it",
    ("robots/urdf.py", "tool0"): "what robot files call the flange, whosever the robot is",
    ("sources/drawing/drafting.py", "dot"): "the name of a line type",
    ("sources/drawing/attributes.py", "movej"): "what people write into drawings",
    ("sources/drawing/attributes.py", "movel"): "what people write into drawings",
    ("sources/drawing/attributes.py", "mov"): "what people write into drawings",
    ("sources/drawing/attributes.py", "mvs"): "what people write into drawings",
    ("studio/controller_routes.py", "connect"): "the name of a route",
    ("studio/app.py", "connect"): "a word of the policy that browsers keep to",
}
"""File and word → why it stays."""


def vendor_words() -> frozenset[str]:
    """Lower-case words of every language's tables, and what the languages are called."""
    found = {*taken_names(), *RESERVED} - {*SPEEDS, *ZONES}
    for row in vocabulary.statements().values():
        found.update(row.word.lower().split())
    found |= {name.lower() for name in (*vocabulary.functions(), *vocabulary.variables())}
    for name in languages.names():
        found |= set(re.findall(r"[a-z]{3,}", name))
    return frozenset(found) - COMMON - {"basic"}


WORDS: Final = vendor_words()


def literals(tree: ast.AST) -> Iterator[ast.Constant]:
    """The texts of a module but for docstrings."""
    told: set[int] = set()
    for node in ast.walk(tree):  # an expression comes before what is in it
        if isinstance(node, ast.Expr):
            told.add(id(node.value))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) not in told:
                yield node


def is_vendors(name: str) -> bool:
    return name.startswith(VENDORS) and SHARED.fullmatch(name) is None


@functools.cache
@without_gc()
def words_in(package: FilePath) -> Mapping[str, frozenset[str]]:
    """File outside the vendors' rooms → the lower-case words of its texts."""
    found = {}
    for file in sorted(package.rglob("*.py")):
        name = file.relative_to(package).as_posix()
        if not is_vendors(name):
            texts = literals(ast.parse(file.read_text(encoding="utf-8"), name))
            words = (re.findall(r"[a-z_]\w*", str(text.value).lower()) for text in texts)
            found[name] = frozenset(itertools.chain.from_iterable(words))
    return found


def found_in(package: FilePath) -> set[tuple[str, str]]:
    """File and vendor word of each text outside the vendors' rooms that has one."""
    return {(name, word) for name, words in words_in(package).items() for word in words & WORDS}


def test_vendor_words_stand_in_the_rooms_of_the_vendors_only() -> None:
    assert found_in(PACKAGE) - set(EXCEPTIONS) == set()


def test_every_exception_is_needed() -> None:
    assert set(EXCEPTIONS) - found_in(PACKAGE) == set()


def test_every_common_word_is_one_of_a_vendor_that_is_used() -> None:
    assert COMMON - frozenset().union(*words_in(PACKAGE).values()) == set()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ('if "rapid" in robot.languages: ...', "rapid"),
        ('name = "melfa-basic-5"', "melfa"),
        (r're.compile(r"\s*(?:mov|mv[acrst]|trigg|search)")', "mov"),
        ('f"  MoveL {name}"', "movel"),
        ('{"tooldata": 1}', "tooldata"),
        ('signal = "M_Out(8)"', "m_out"),
    ],
)
def test_a_vendor_word_is_found(tmp_path: FilePath, text: str, word: str) -> None:
    for room in ("robots", "languages/plain", "virtual"):
        (tmp_path / room).mkdir(parents=True)
        (tmp_path / room / "module.py").write_text(f'"""MoveL."""\n{text}\n', encoding="utf-8")
    assert found_in(tmp_path) == {("robots/module.py", word)}


def test_robots_know_the_languages_that_there_are() -> None:
    assert set(robot.programming_languages()) == set(languages.names())
