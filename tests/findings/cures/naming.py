"""What a cure names: options, commands, keys, tables, extras, words of a language, and literals.

Each thing that stands out in a cure (in backticks, with two dashes, in brackets, behind the name of
the program, or before an equals sign) is looked up in what really reads it: the parser of the
command line, the tables of keys that the readers of files use, the words of the languages.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Final

import click

from assistant.base.diagnostics import Rule
from assistant.cell import body_tables as of_cells
from assistant.cli.app import app
from assistant.compiler import simulated_run
from assistant.controllers.address import SCHEMES
from assistant.controllers.cyclic.setpoint_source import Settings
from assistant.program.pseudo.words import FIRST_WORDS
from assistant.project.project_file import project_schema
from assistant.sources import cell_values as of_data
from assistant.sources import process
from assistant.sources.process import file, placement
from assistant.sources.process import file as of_processes
from assistant.sources.tables import headers, taught

ROOT: Final = Path(__file__).parents[3]
FOLLOWED: Final = ("option", "command", "key", "table")
"""Kinds of things that somebody can be told to write, and that a test can write as well."""

OPTION: Final = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
_SPAN: Final = re.compile(r"`([^`]+)`")
_TABLE: Final = re.compile(r"\[{1,2}([a-z_]+)\]{1,2}")
_PROGRAM: Final = re.compile(r"robot-assistant(?= [a-z-])((?: (?:--)?[a-z][a-z-]*)+)")
_ASSIGNED: Final = re.compile(r"(?<![\w.\[*#])([a-z_]{2,}) = (?!\w = )")
_FIELD: Final = re.compile(r"\{[^{}]*\}")


@dataclass(frozen=True, slots=True)
class Named:
    """kind: one of FOLLOWED, or python, extra, address, word, field, literal; or None: nobody
    knows it."""

    text: str
    kind: str | None


def named(rule: Rule) -> tuple[Named, ...]:
    """Everything that the cure of a rule names, each once."""
    return tuple(dict.fromkeys(_named(rule.cure, rule.code[:2])))


def in_text(text: str) -> tuple[Named, ...]:
    """The options and commands of the program that any text names."""
    words = [words[1].split() for words in _PROGRAM.finditer(text)]
    return tuple(
        one
        for one in (
            *(Named(o, "option" if o in all_options() else None) for o in OPTION.findall(text)),
            *(one for command in words for one in _command(command)),
        )
    )


def followable(rule: Rule) -> bool:
    """Whether the cure names an option, a command or a key."""
    return any(one.kind in FOLLOWED for one in named(rule))


def _named(cure: str, family: str) -> Iterator[Named]:
    rest = cure
    for span in _SPAN.finditer(cure):
        rest = rest.replace(span[0], " ")
        yield from _spanned(span[1], family)
    for words in _PROGRAM.finditer(rest):
        rest = rest.replace(words[0], " ")
        yield from _command(words[1].split())
    for option in OPTION.findall(rest):
        yield Named(option, "option" if option in all_options() else None)
    for extras in re.findall(r"robot-assistant\[([a-z,]+)\]", rest):
        yield from _extras(extras)
    for table in _TABLE.findall(re.sub(r"robot-assistant\[[a-z,]+\]", "", rest)):
        yield Named(table, "table" if table in tables() else None)
    for key in _ASSIGNED.findall(rest):
        yield Named(key, "key" if key in keys() else None)


def _spanned(text: str, family: str) -> Iterator[Named]:
    plain = _FIELD.sub("", text).strip()
    if extras := re.search(r"robot-assistant\[([a-z,]+)\]", text):
        yield from _extras(extras[1])
    elif not re.search(r"\w", plain.replace("_", "")):
        yield Named(text, "field" if "{" in text else "word")
    elif plain.startswith("robot-assistant "):
        yield from _command(plain.split()[1:])
    elif OPTION.match(plain):
        yield from (
            Named(o, "option" if o in all_options() else None) for o in OPTION.findall(plain)
        )
    elif assigned := _ASSIGNED.match(plain):
        yield Named(assigned[1], "key" if assigned[1] in keys() else None)
    elif setting := re.fullmatch(r"Settings\((\w+)=…\)", plain):
        known = {field.name for field in fields(Settings)}
        yield Named(plain, "python" if setting[1] in known else None)
    elif _is_command(plain):
        yield from _command(plain.split())
    elif plain in _LITERALS:
        yield Named(plain, "literal")
    elif scheme := re.match(r"([a-z-]+)://", plain):
        yield Named(text, "address" if scheme[1] in SCHEMES else None)
    elif family in _SPEAKERS and _words(plain) and _words(plain) <= _SPEAKERS[family]():
        yield Named(text, "word")
    elif plain in keys():
        yield Named(plain, "key")
    else:
        yield Named(text, None)


def _command(words: list[str]) -> Iterator[Named]:
    """A command with what it is named with: options that it has itself, or all of it has."""
    path: tuple[str, ...] = ()
    for word in words:
        if word.startswith("--"):
            yield Named(word, "option" if word in commands()[path] | commands()[()] else None)
        elif (*path, word) in commands():
            path = (*path, word)
    if path:
        yield Named(" ".join(path), "command")
    elif not any(word.startswith("--") for word in words):
        yield Named(" ".join(words), None)


def _is_command(text: str) -> bool:
    """One command, or one with its options; a key of the same name stands in no such place."""
    first, *others = text.split()
    return (first,) in commands() and all(
        other.startswith("--") or (first, other) in commands() or other.isupper()
        for other in others
    )


def _extras(text: str) -> Iterator[Named]:
    there = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    for extra in text.split(","):
        yield Named(extra, "extra" if extra in there["optional-dependencies"] else None)


@cache
def commands() -> Mapping[tuple[str, ...], frozenset[str]]:
    """The options of each command of the real parser, by its words; of the program itself by ()."""

    def walked(command: Any, path: tuple[str, ...]) -> Iterator[tuple[Any, ...]]:
        said = {
            option
            for parameter in command.params
            for option in (*parameter.opts, *parameter.secondary_opts, "--help")
        }
        yield path, frozenset(option for option in said if option.startswith("--"))
        if isinstance(command, click.Group):
            context = click.Context(command)
            for name in command.list_commands(context):
                yield from walked(command.get_command(context, name), (*path, name))

    return dict(walked(app, ()))


@cache
def all_options() -> frozenset[str]:
    return frozenset().union(*commands().values())


@cache
def keys() -> frozenset[str]:
    """Every key of every kind of file that is read."""
    read = (
        *(
            of_processes.TOP_KEYS,
            of_processes.DRAWING_KEYS,
            of_processes.TOOL_KEYS,
            of_processes.FRAME_KEYS,
        ),
        *(
            of_processes.DEFAULT_MOTION_KEYS,
            of_processes.SIGNAL_KEYS,
            file.LAYER_KEYS,
            placement.PLACEMENT_KEYS,
            file.PROGRAM_KEYS,
            process.SEEN_KEYS,
            process.LEFT_OUT_KEYS,
        ),
        *(
            of_cells.PLACE_KEYS,
            of_cells.WORLD_KEYS,
            of_cells.ROBOT_KEYS,
            of_cells.PART_KEYS,
            of_cells.BODY_KEYS,
        ),
        *(
            of_data.POSITION_KEYS,
            of_data.DATA_KEYS,
            of_data.ROUTINE_KEYS,
            of_data.RECORD_KEYS,
            of_data.ARM_KEYS,
        ),
        *(simulated_run.CHANGE_KEYS, simulated_run.ANSWER_KEYS, taught.TARGET_KEYS, headers.KNOWN),
        taught.VISIT_KEYS,
        ("moves",),
        ROBOTS,
        WAYPOINTS,
    )
    return frozenset().union(*read, _properties(project_schema()))


@cache
def tables() -> frozenset[str]:
    """Every table of every kind of file that is read."""
    said = {
        *of_processes.TOP_TABLES,
        of_processes.PLACEMENT_TABLE,
        *of_data.TABLE_OF_KIND.values(),
        *project_schema()["properties"],
        *simulated_run.SCRIPT_KEYS,
    }
    return frozenset({*said, "targets", "moves", "world", "robots", "bodies"})


def _properties(form: Any) -> Iterator[str]:
    if isinstance(form, dict):
        yield from form.get("properties", {})
        for inner in form.values():
            yield from _properties(inner)
    elif isinstance(form, list):
        for inner in form:
            yield from _properties(inner)


def _words(text: str) -> frozenset[str]:
    """The words in an example of a language, without the names that it makes up."""
    said = re.findall(r"[A-Za-z_]+[$]?", re.sub(r'"[^"]*"', "", text))
    return frozenset(word.casefold() for word in said)


def _of_files(folder: str) -> frozenset[str]:
    files = sorted(resources.files("assistant").joinpath(folder).iterdir(), key=lambda f: f.name)
    said = [file.read_text("utf-8") for file in files if file.name.endswith((".txt", ".py"))]
    return frozenset(word.casefold() for text in said for word in re.findall(r"\w+[$]?", text))


@cache
def _melfa() -> frozenset[str]:
    return _of_files("languages/melfa_basic/tables/vocabulary") | {"rad", "while", "main", "true"}


@cache
def _rapid() -> frozenset[str]:
    grammar = (ROOT / "grammars" / "rapid.lark").read_text("utf-8").casefold()
    return _of_files("languages/rapid/tables") | frozenset(re.findall(r"\w+", grammar))


@cache
def _pseudo() -> frozenset[str]:
    grammar = (ROOT / "grammars" / "pseudo.lark").read_text("utf-8")
    return frozenset(re.findall(r"\w+", grammar)) | frozenset().union(*FIRST_WORDS.values())


_SPEAKERS: Final = {"MB": _melfa, "RA": _rapid, "PS": _pseudo}

ROBOTS: Final = ("urdf", "coupling")
"""Keys of robot files that cures name; `test_cures.py` has them read."""
WAYPOINTS: Final = ("positions", "quaternions", "poses", "paths", "unit")
"""Keys of waypoint files that cures name; `test_cures.py` has them read."""
_LITERALS: Final[Mapping[str, str]] = {
    "fine": "a value of `blend`",
    "world": "the name that a cell file has for the room, a value of `parent`",
    "travel to": "a statement of the pseudo-program",
    "host:port": "what a line of `gateway` may be",
    "listen:address:port": "what a line of `gateway` may be",
    "/dev/ttyS0": "what a line of `gateway` may be",
    "COM3": "what a line of `gateway` may be",
    "M_TIMER | P_CURR | J_FBC": "what `follow` may be asked for",
    "rtprio": "a setting of the system",
    "dask": "what `--on` may be",
    "dask://HOST:PORT": "what `--on` may be",
    "dask worker HOST:PORT": "a command of Dask",
    "auto": "a value of the variable ROBOT_ASSISTANT_SERVER",
    "ignore": "the word of a comment that ignores findings",
    "assistant: ignore RA204, RA205": "a comment that ignores findings",
    "here(tool0, base)": "an expression of the pseudo-program",
    '%":…"%': "how RAPID calls by a name in a text",
    "<!DOCTYPE …>": "a line of XML",
    "xacro arm.urdf.xacro > arm.urdf": "a command of ROS",
    "numpy.save": "a function of numpy",
    "numpy.savez": "a function of numpy",
    '"5"" pipe"': "how a table writes a quotation mark",
    "-12.5": "a number",
    **dict.fromkeys(("joint", "linear", "via", "end"), "a value of a table's column `motion`"),
    **dict.fromkeys(("mm", "m"), "a value of `unit`"),
    "MODULE name … ENDMODULE": "RAPID",
    "<Program><Module>name.mod</Module></Program>": "a program file of RAPID",
}
"""What stands in backticks and is none of these, with what it is."""
