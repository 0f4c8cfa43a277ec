"""The house keeps its order: rooms import downwards only, and modules never in a circle."""

from __future__ import annotations

import ast
import functools
import importlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path as FilePath

import pytest

from assistant.base.budgets import without_gc

PACKAGE = FilePath(__file__).parent.parent / "assistant"

ROOMS: dict[str, frozenset[str]] = {
    "base": frozenset(),
    "program": frozenset({"base"}),
    "sources": frozenset({"base", "program"}),
    "robots": frozenset({"base", "program"}),
    "languages": frozenset({"base", "program", "robots"}),
    "cell": frozenset({"base", "program", "sources", "robots"}),
    "checks": frozenset({"base", "program", "robots", "cell"}),
    "virtual": frozenset({"base", "program", "robots", "languages"}),
    "controllers": frozenset({"base", "program"}),
    "vision": frozenset({"base", "program", "sources", "robots", "cell", "controllers"}),
    "learning": frozenset({"base", "program", "robots", "vision"}),
    "deploy": frozenset({"base", "program", "languages", "controllers"}),
    "compiler": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages", "checks"),
            *("virtual", "controllers"),
        }
    ),
    "blocks": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages"),
            *("virtual", "controllers", "compiler", "vision"),
        }
    ),
    "findings": frozenset(
        {"base", "program", "sources", "robots", "cell", "languages", "compiler"}
    ),
    "project": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages"),
            *("virtual", "controllers", "deploy", "compiler", "findings"),
        }
    ),
    "editing": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages", "checks"),
            *("compiler", "findings", "project"),
        }
    ),
    "report": frozenset({"base", "program", "sources", "robots", "cell", "compiler", "findings"}),
    "view": frozenset(
        {"base", "program", "robots", "cell", "checks", "compiler", "findings", "report"}
    ),
    "api": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "checks", "compiler", "findings"),
            *("report",),
        }
    ),
    "studio": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages", "checks"),
            *("virtual", "controllers", "deploy", "compiler", "findings", "report"),
            *("project", "view", "vision", "learning", "blocks", "editing"),
        }
    ),
    "cli": frozenset(
        {
            *("base", "program", "sources", "robots", "cell", "languages", "checks"),
            *("virtual", "controllers", "deploy", "compiler", "findings", "report"),
            *("project", "view", "vision", "learning", "blocks", "editing", "studio"),
        }
    ),
}
"""Room → the rooms that it may import."""

LANGUAGE: tuple[str, ...] = (
    *("rules", "tables", "tree", "reading", "text", "checks", "lift", "convert", "lower"),
)
"""Rooms of every language; each may import those before it, also lazily and for types."""
SHARED_ROOMS = frozenset({"checks", "recovery", "runs", "texts"})
"""Folders beside the languages that are none: what one room of all of them shares."""
NOT_IN_ALL = frozenset({"convert"})
"""From one dialect to another: a language without dialects has none."""

CLOSED_LATE = frozenset({"", "robots", "virtual"})
"""Rooms with circles that lazy imports or types close: `Robot.check`, the machine of an interpreter
and its statements. Elsewhere such imports count as others do.
"""

SHARED = frozenset({"lazy", "resources"})
"""Modules of the top folder that every room may import."""

TOP_MAY_IMPORT = frozenset(
    {
        *(
            "lazy",
            "base",
            "program",
            "languages",
            "robots",
            "cell",
            "controllers",
            "deploy",
            "compiler",
        ),
        *("api",),
    }
)
"""What `assistant/__init__.py` offers to users, loaded when first used, and what loads it."""


@dataclass(frozen=True, slots=True)
class Import:
    """One import: the module that it stands in, the one that it names, its line.

    at_once: it runs when the module is loaded, not in a function, nor for types only.
    """

    by: str
    of: str
    line: int
    at_once: bool

    def __str__(self) -> str:
        return f"{self.by}:{self.line} imports {self.of}"


def modules(package: FilePath) -> dict[str, FilePath]:
    """Every module of a package by its dotted name."""
    found = {}
    for file in sorted(package.rglob("*.py")):
        parts = file.relative_to(package.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imports(package: FilePath) -> Sequence[Import]:
    """Imports of a package's own modules, also inside functions and behind TYPE_CHECKING.

    Also a text that is the name of a module is one: that is how lazy tables name them.
    """
    return _of_this_package() if package == PACKAGE else list(_imports(package))


@functools.cache
def _of_this_package() -> Sequence[Import]:
    """Reading it takes a second."""
    with without_gc():
        return list(_imports(PACKAGE))


NAMED = re.compile(r"(?m)^(?!\s*(?:from|import)\b).*\bassistant\b")
"""A line that names the package and is no import: only there can a text name a module."""


def _imports(package: FilePath) -> Iterator[Import]:
    known = modules(package)
    for name, file in known.items():
        text = file.read_text(encoding="utf-8")
        tree = ast.parse(text, str(file))
        is_package = file.name == "__init__.py"
        at_once = set(map(id, _at_import(tree.body)))
        for node in ast.walk(tree) if NAMED.search(text) else _statements(tree):
            for named in _named(node, name, is_package, known):
                if named.split(".")[0] == package.name and named != name:
                    yield Import(name, named, getattr(node, "lineno", 0), id(node) in at_once)


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """The statements of a module, also those inside others, without their expressions."""
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        yield node
        for part in BODIES:
            pending.extend(getattr(node, part, ()))


BODIES = ("body", "orelse", "finalbody", "handlers", "cases")
"""Fields that hold statements, and what holds statements."""


def _named(
    node: ast.AST, module: str, is_package: bool, known: Mapping[str, FilePath]
) -> Iterator[str]:
    match node:
        case ast.Import(names):
            yield from (alias.name for alias in names)
        case ast.ImportFrom(level=level, module=of, names=names):
            parts = module.split(".")
            above = parts[: len(parts) - level + is_package] if level else []
            start = ".".join([*above, *([of] if of else [])])
            for alias in names:
                full = f"{start}.{alias.name}"
                yield full if full in known else start
        case ast.Constant(value=str(text)) if text in known and "." in text:
            yield text


def faults(package: FilePath, rooms: Mapping[str, frozenset[str]] = ROOMS) -> list[str]:
    """What breaks the order: an import upwards or sideways, an unknown room, a circle."""
    found = [f"`{name}` is no room" for name in _unknown_rooms(package, rooms)]
    graph: dict[str, set[str]] = {name: set() for name in modules(package)}
    for one in imports(package):
        if not _is_allowed(_room(one.by), _room(one.of), rooms):
            found.append(str(one))
        if one.at_once or _room(one.by) not in CLOSED_LATE:
            graph[one.by].add(one.of)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found.append("circle: " + " -> ".join(error.args[1]))
    return found


def language_faults(package: FilePath, rooms: Sequence[str] = LANGUAGE) -> Iterator[str]:
    """What breaks the plan of a language: a room that is not in it or missing, an import of a later
    one, or of a language by what all of them share.
    """
    folders = {f.name for f in (package / "languages").iterdir() if (f / "__init__.py").exists()}
    names = folders - SHARED_ROOMS
    for name in sorted(names):
        inside = package / "languages" / name
        there = {f.stem for f in inside.iterdir() if f.name not in ("__init__.py", "__pycache__")}
        yield from (f"`{name}` has a room `{room}`" for room in sorted(there - set(rooms)))
        missing = set(rooms) - there - NOT_IN_ALL
        yield from (f"`{name}` has no room `{room}`" for room in sorted(missing))
    for one in imports(package):
        by, of = one.by.split("."), one.of.split(".")
        if by[1:2] == of[1:2] == ["languages"] and min(len(by), len(of)) > 2:
            if by[2] != of[2] and of[2] in names:
                yield str(one)
        inside = by[:3] == of[:3] and by[1:2] == ["languages"] and min(len(by), len(of)) > 3
        if inside and by[2] in names and {by[3], of[3]} <= set(rooms):
            if rooms.index(by[3]) < rooms.index(of[3]):
                yield str(one)


def _is_allowed(by: str, of: str, rooms: Mapping[str, frozenset[str]]) -> bool:
    if by == "":
        return of in TOP_MAY_IMPORT
    if by == "__main__":
        return of == "cli"
    if by in SHARED:
        return False
    if of in ("", *SHARED):  # `assistant` itself is asked for its version only
        return True
    return by == of or of in rooms.get(by, frozenset())


def _at_import(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a module is imported."""
    for node in body:
        yield node
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from _at_import(node.orelse)
        elif isinstance(node, ast.If | ast.Try | ast.With | ast.ClassDef):
            for part in ("body", "orelse", "finalbody"):
                yield from _at_import(getattr(node, part, []))
            for handler in getattr(node, "handlers", []):
                yield from _at_import(handler.body)


def _room(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else ""


def _unknown_rooms(package: FilePath, rooms: Mapping[str, frozenset[str]]) -> list[str]:
    data = {"grammars", "templates", "__pycache__"}
    folders = {f.name for f in package.iterdir() if f.is_dir()} - data
    files = {f.stem for f in package.glob("*.py")} - {"__init__", "__main__"}
    return sorted((folders - set(rooms)) | (files - SHARED))


# ------------------------------------------------------------------------------------ the house


def test_the_house_keeps_its_order() -> None:
    assert faults(PACKAGE) == []


def test_every_language_is_laid_out_alike() -> None:
    assert list(language_faults(PACKAGE)) == []


def lift_faults(package: FilePath, passes: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Imports of a later pass in the lift of a language, and passes that are not listed or not
    there. passes: of each language, in their order.
    """
    for name, listed in passes.items():
        lift = f"{package.name}.languages.{name}.lift"
        inside = (module.removeprefix(lift + ".") for module in modules(package))
        there = {one.split(".")[0] for one in inside if not one.startswith(package.name)}
        yield from (f"`{name}` does not list `{one}`" for one in sorted(there - set(listed)))
        yield from (f"`{name}` has no `{one}`" for one in sorted(set(listed) - there))
        for one in imports(package):
            if one.by.startswith(lift + ".") and one.of.startswith(lift + "."):
                by, of = (m.removeprefix(lift + ".").split(".")[0] for m in (one.by, one.of))
                if {by, of} <= set(listed) and listed.index(by) < listed.index(of):
                    yield str(one)


def test_no_pass_of_a_lift_asks_a_later_one() -> None:
    passes = {
        name: importlib.import_module(f"assistant.languages.{name}.lift").PASSES
        for name in ("melfa_basic", "rapid")
    }
    assert list(lift_faults(PACKAGE, passes)) == []


READINGS = re.compile(
    r"assistant\.languages\.\w+\.(lift|lower|convert)\b"
    r"|assistant\.program\.(expressions|statements|program|pseudo)\b"
    r"|assistant\.compiler\b"
)
"""What a program is read into, and what comes of that: judged by running it, so not run by it."""


def test_interpreters_share_no_reading_with_what_they_judge() -> None:
    judges = re.compile(r"assistant\.virtual\.(rapid|melfa|events|proving)\b")
    found = [one for one in imports(PACKAGE) if judges.match(one.by)]
    assert len({one.by for one in found}) > 10
    assert [str(one) for one in found if READINGS.match(one.of)] == []


def test_the_graph_is_read_at_all() -> None:
    seen = {(one.by, one.of) for one in imports(PACKAGE)}
    assert ("assistant.program.statements", "assistant.program.motion") in seen
    assert ("assistant.languages.language", "assistant.robots") in seen  # for types only
    assert ("assistant.sources", "assistant.sources.process.file") in seen  # in a function
    assert ("assistant", "assistant.compiler") in seen  # as a text in a table


# ---------------------------------------------------------------------- the checker can fail


@pytest.fixture
def house(tmp_path: FilePath) -> FilePath:
    """A small house in order."""
    files = {
        "__init__.py": "_LAZY = {'robots': ('assistant.robots', None)}",
        "resources.py": "",
        "program/__init__.py": "from assistant.resources import x",
        "program/path.py": "import numpy",
        "program/program.py": "from assistant.program import path",
        "robots/__init__.py": "from assistant.program.motion import Path",
        "languages/__init__.py": "from .language import Language",
        "languages/language.py": "from assistant.program.program import Program",
        "cli/__init__.py": "def main():\n    from assistant import languages, robots",
    }
    for name, text in files.items():
        file = tmp_path / "assistant" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return tmp_path / "assistant"


def test_a_house_in_order_has_no_fault(house: FilePath) -> None:
    assert faults(house) == []


@pytest.mark.parametrize(
    ("file", "text", "line", "of"),
    [
        ("program/path.py", "import assistant.robots", 1, "robots"),
        ("program/path.py", "from assistant import robots", 1, "robots"),
        ("program/path.py", "from ..robots import get", 1, "robots"),
        ("program/__init__.py", "from ..robots import get", 1, "robots"),
        ("program/__init__.py", "\ndef f():\n  from .. import cli", 3, "cli"),
        ("robots/__init__.py", "try:\n  import assistant.cli as c\nfinally: ...", 2, "cli"),
        ("robots/__init__.py", "try: ...\nexcept E:\n  from .. import cli", 3, "cli"),
        ("robots/__init__.py", "match x:\n  case 1:\n    from .. import cli", 3, "cli"),
        (
            "robots/__init__.py",
            "if TYPE_CHECKING:\n  import assistant.languages.language",
            2,
            "languages.language",
        ),
        ("robots/__init__.py", "import_module('assistant.languages')", 1, "languages"),
        ("resources.py", "from assistant.program import path", 1, "program.path"),
        ("__init__.py", "from assistant import cli", 1, "cli"),
        ("__main__.py", "from assistant import robots", 1, "robots"),
    ],
)
def test_a_breach_is_found(house: FilePath, file: str, text: str, line: int, of: str) -> None:
    (house / file).write_text(text, encoding="utf-8")
    by = ".".join(["assistant", *FilePath(file).with_suffix("").parts]).removesuffix(".__init__")
    found = [fault for fault in faults(house) if not fault.startswith("circle")]
    assert found == [f"{by}:{line} imports assistant.{of}"]


def test_an_unknown_room_is_found(house: FilePath) -> None:
    (house / "helpers").mkdir()
    (house / "misc.py").touch()
    assert faults(house) == ["`helpers` is no room", "`misc` is no room"]


def test_a_circle_is_found(house: FilePath) -> None:
    (house / "program" / "path.py").write_text("from .program import Program", encoding="utf-8")
    (found,) = faults(house)
    assert found.startswith("circle: ") and "assistant.program.path" in found


CLOSING = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n  from .{0} import x"


def test_a_circle_that_only_types_close_is_found(house: FilePath) -> None:
    (house / "program" / "path.py").write_text(CLOSING.format("program"), encoding="utf-8")
    (found,) = faults(house)
    assert found.startswith("circle: ")


def test_a_circle_that_only_types_close_is_none_where_that_is_allowed(house: FilePath) -> None:
    (house / "robots" / "robot.py").write_text("from .arm import y", encoding="utf-8")
    (house / "robots" / "arm.py").write_text(CLOSING.format("robot"), encoding="utf-8")
    assert faults(house) == []


# ---------------------------------------------------------------------- the plan of a language


@pytest.fixture
def spoken(house: FilePath) -> FilePath:
    """A house with one language in order."""
    for room in sorted(set(LANGUAGE) - NOT_IN_ALL):
        file = house / "languages" / "plain" / room / "__init__.py"
        file.parent.mkdir(parents=True)
        file.touch()
    (house / "languages" / "plain" / "__init__.py").touch()
    (house / "languages" / "plain" / "lift" / "moves.py").touch()
    return house


def test_a_language_in_order_has_no_fault(spoken: FilePath) -> None:
    assert list(language_faults(spoken)) == []


@pytest.mark.parametrize(
    "text",
    [
        "from assistant.languages.plain.lower import x",
        "def f():\n  from assistant.languages.plain import lower",
        "if TYPE_CHECKING:\n  import assistant.languages.plain.lower",
    ],
)
def test_an_import_of_a_later_room_is_found(spoken: FilePath, text: str) -> None:
    (spoken / "languages" / "plain" / "lift" / "moves.py").write_text(text, encoding="utf-8")
    (found,) = language_faults(spoken)
    assert found.endswith("imports assistant.languages.plain.lower")


@pytest.mark.parametrize("by", ["walking.py", "checks/damage.py", "other/lift/moves.py"])
def test_an_import_of_a_language_by_what_it_shares_is_found(spoken: FilePath, by: str) -> None:
    file = spoken / "languages" / by
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("from assistant.languages.plain.tree import x", encoding="utf-8")
    (found,) = language_faults(spoken)
    assert found.endswith("imports assistant.languages.plain.tree")


def test_a_room_that_is_not_in_the_plan_is_found(spoken: FilePath) -> None:
    (spoken / "languages" / "plain" / "helpers.py").touch()
    (spoken / "languages" / "plain" / "text" / "__init__.py").unlink()
    (spoken / "languages" / "plain" / "text").rmdir()
    assert list(language_faults(spoken)) == [
        "`plain` has a room `helpers`",
        "`plain` has no room `text`",
    ]


@pytest.mark.parametrize(
    ("listed", "text", "found"),
    [
        (("moves",), "import assistant.languages.plain.tree", []),
        ((), "", ["`plain` does not list `moves`"]),
        (("moves", "arcs"), "", ["`plain` has no `arcs`"]),
    ],
)
def test_a_pass_that_is_not_listed_is_found(
    spoken: FilePath, listed: tuple[str, ...], text: str, found: list[str]
) -> None:
    (spoken / "languages" / "plain" / "lift" / "moves.py").write_text(text, encoding="utf-8")
    assert list(lift_faults(spoken, {"plain": listed})) == found


def test_a_pass_that_asks_a_later_one_is_found(spoken: FilePath) -> None:
    lift = spoken / "languages" / "plain" / "lift"
    (lift / "arcs.py").touch()
    (lift / "moves.py").write_text("def f():\n  from . import arcs", encoding="utf-8")
    (found,) = lift_faults(spoken, {"plain": ("moves", "arcs")})
    assert found.endswith("lift.moves:2 imports assistant.languages.plain.lift.arcs")
