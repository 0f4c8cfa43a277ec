"""What the tables of a project's file may hold: each key with its reader and its JSON schema.

[programs.plate]                  # a source, with options as `compile` has them
source = "drawings/plate.dxf"     # paths go from the folder of the project's file
process = "drawings/plate.process.toml"

[targets.cell1]                   # what a controller gets
controller = "cell1"              # of [controllers]; default the name of the target
programs = ["plate", "hand/seam.mod"]
task = "T_ROB1"                   # that modules are loaded in; default the first one
load = true                       # also modules that are not loaded yet

[style]                           # comments and frames of written programs, see compiler/style.py
template = "style"

[deploy]
parallel = 4                      # controllers at a time
canary = "cell1"                  # the target that goes first, alone
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, get_args

from assistant import languages
from assistant.base.length_units import UNITS
from assistant.compiler.style import STYLE_KEYS
from assistant.controllers.named import LONGEST_TIMEOUT, keys
from assistant.languages.language_types import Frames
from assistant.program import settings_tables
from assistant.program.program import IDENTIFIER
from assistant.program.settings_tables import Read, Wrong

PROJECT_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")
"""Of programs and targets: they become names of folders."""
TASK_NAME: Final = re.compile(r"[A-Za-z]\w{0,31}", re.ASCII)
MOST_TARGETS: Final = 10_000_000
MOST_AT_ONCE: Final = 256
MOST_SEED: Final = 2**31 - 1
TEXT_FORM: Final[Mapping[str, object]] = {"type": "string", "pattern": r"\S"}


@dataclass(frozen=True, slots=True)
class ProjectKey:
    """A key of a table. form: JSON schema of its values. about: what it says, for editors."""

    read: Read
    form: Mapping[str, object]
    about: str


def task_name(value: Any) -> str:
    given = settings_tables.text(value)
    if TASK_NAME.fullmatch(given) is None:
        raise Wrong(
            f'is "{settings_tables.shown(given)}", which is no task', 'write a name, as "T_ROB1"'
        )
    return given


def _text_key(about: str) -> ProjectKey:
    return ProjectKey(settings_tables.text, TEXT_FORM, about)


def _choice_key(words: tuple[str, ...], about: str) -> ProjectKey:
    return ProjectKey(settings_tables.choice(*words), {"enum": list(words)}, about)


def _language_key(about: str) -> ProjectKey:
    """In any case, although editors offer the names as they are."""
    return ProjectKey(
        settings_tables.caseless(*LANGUAGE_NAMES), {"enum": list(LANGUAGE_NAMES)}, about
    )


def _whole_number_key(least: int, most: int, about: str) -> ProjectKey:
    form = {"type": "integer", "minimum": least, "maximum": most}
    return ProjectKey(settings_tables.whole(least, most), form, about)


def _truth_key(about: str) -> ProjectKey:
    return ProjectKey(settings_tables.truth, {"type": "boolean"}, about)


LANGUAGE_NAMES: Final = languages.names()

PROGRAM_KEYS: Final[Mapping[str, ProjectKey]] = {
    "source": _text_key(
        "Drawing, table, pseudo-program or robot program, from the project's folder."
    ),
    "also": ProjectKey(
        settings_tables.texts,
        {"type": "array", "items": TEXT_FORM},
        "Drawings and tables that are in the same program, each with a routine of its own.",
    ),
    "language": _language_key("To write; default what the target's controller takes."),
    "robot": _text_key("Arm that runs it, by name or file; default that of the controller."),
    "process": _text_key("Process file; default NAME.process.toml beside the source."),
    "cell": _text_key(
        "File of the cell that it runs in: nothing is made that touches anything there."
    ),
    "unit": _choice_key(tuple(UNITS), "That a drawing is in, whatever it says itself."),
    "from": _language_key("Language of the source, if its name does not tell."),
    "from_robot": _text_key("Arm that a robot program was written for, by name or file."),
    "entry": _text_key("Procedure that the program begins with; default its main."),
    "as": ProjectKey(
        settings_tables.name,
        {"type": "string", "pattern": f"^{IDENTIFIER.pattern}$"},
        "What others call the program; default main, or what its process file says.",
    ),
    "main": _truth_key("false: no main; others call the procedures of the layers."),
    "most_targets": _whole_number_key(
        10, MOST_TARGETS, "Of one unit; default the language's own limit."
    ),
    "frames": _choice_key(get_args(Frames), "How a language without work objects says them."),
    "prove": _truth_key("Run the source and what is written, and compare what they do."),
    "signals": _text_key("With prove: a script of the inputs; default a search for all branches."),
    "seed": _whole_number_key(0, MOST_SEED, "With prove: of what the search draws."),
}
TARGET_KEYS: Final[Mapping[str, ProjectKey]] = {
    "controller": _text_key("Name in [controllers]; default the name of the target."),
    "programs": ProjectKey(
        settings_tables.texts,
        {"type": "array", "items": TEXT_FORM, "minItems": 1},
        "Names of [programs], or program files from the project's folder.",
    ),
    "task": ProjectKey(
        task_name,
        {"type": "string", "pattern": f"^{TASK_NAME.pattern}$"},
        "That modules are loaded in; default the first one.",
    ),
    "load": _truth_key("Also load modules that are not loaded yet."),
}
CONTROLLER_FORMS: Final[Mapping[str, tuple[Mapping[str, object], str]]] = {
    "address": (TEXT_FORM, "Such as rws://192.168.125.1, or virtual:irc5 for a virtual one."),
    "robot": (TEXT_FORM, "That it moves: a robot of the catalogue, or its file."),
    "user": (TEXT_FORM, "Of its file server or services; never write a password into this file."),
    "certificate": (TEXT_FORM, "File of the certificate that it is trusted by."),
    "timeout": (
        {"type": "number", "exclusiveMinimum": 0, "maximum": LONGEST_TIMEOUT},
        "Seconds to wait for an answer.",
    ),
    "serial": (TEXT_FORM, "Number that it must tell of itself; another one is refused."),
}
DEPLOY_KEYS: Final[Mapping[str, ProjectKey]] = {
    "parallel": _whole_number_key(1, MOST_AT_ONCE, "Controllers at a time."),
    "canary": _text_key("Target that goes first, alone; the others follow if it goes well."),
}
STYLE_TABLE_KEYS: Final[Mapping[str, ProjectKey]] = {
    "template": ProjectKey(
        STYLE_KEYS["template"], TEXT_FORM, "Folder with the templates of written programs."
    ),
    "project": ProjectKey(STYLE_KEYS["project"], TEXT_FORM, "Name of the project, for templates."),
    "author": ProjectKey(
        STYLE_KEYS["author"], TEXT_FORM, "Who is responsible for the programs, for templates."
    ),
    "revision": ProjectKey(
        STYLE_KEYS["revision"], TEXT_FORM, "Revision of the programs, for templates."
    ),
}
CONTROLLER_KEYS: Final[Mapping[str, ProjectKey]] = {
    name: ProjectKey(read, *CONTROLLER_FORMS[name]) for name, read in keys().items()
}
FILE_KEYS: Final = ("source", "process", "cell", "signals")
"""Keys of a program that name files."""
ROBOT_KEYS: Final = ("robot", "from_robot")
"""Keys that name a robot of the catalogue, or its file."""


def readers_of(keys: Mapping[str, ProjectKey]) -> dict[str, Read]:
    return {name: key.read for name, key in keys.items()}
