"""A whole CR controller in a folder: programs, parameters and variables as plain text.

identity.json             what the controller is
parameters.txt            the changed ones, `NAME=value` each, sorted
programs/NAME.prg         as the controller lists it: steps, then positions; NAME_ for CON, NUL …
variables/NAME.txt        the other variables of that program, where it has any
variables/externals.txt   variables that belong to no program
not-kept.txt              files of the controller that are no programs, if there are any: names only
backup.json               hashes of the other files
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers import folders
from assistant.controllers.mitsubishi import listing, parameters, programs, state, variables
from assistant.controllers.mitsubishi.helpers import SCRATCH
from assistant.controllers.mitsubishi.kept_back import SECRET_PARAMETER
from assistant.controllers.mitsubishi.session import Session

KIND: Final = "melfa"
IDENTITY: Final = "identity.json"
PARAMETERS: Final = "parameters.txt"
DEVICE: Final = re.compile(r"CON|PRN|AUX|NUL|(?:COM|LPT)[0-9]")
"""Names that stand for devices in Windows, where no file can have them ("Naming Files, Paths, and
Namespaces" of Microsoft)."""
AFTER_DEVICE: Final = "_"
EXTERNALS: Final = "variables/externals.txt"
NOT_KEPT: Final = "not-kept.txt"


def backup(session: Session, folder: str | FilePath) -> tuple[str, ...]:
    """Writes the folder, which appears whole or not at all; its files, relative to it."""
    with folders.appearing_folder(folder, KIND) as place, session.scope():
        identity = asdict(state.identify(session))
        folders.put_file(place, IDENTITY, (json.dumps(identity, indent=2) + "\n").encode())
        there, others = programs.directory(session)
        if others:
            text = "".join(f"{name}\n" for name in others)
            folders.put_file(place, NOT_KEPT, text.encode())
        for name in (entry.name for entry in there if entry.name != SCRATCH):
            folders.put_file(place, program_file(name), programs.listed(session, name))
            _put_lines(place, variable_file(name), variables.program_variables(session, name))
        _put_lines(place, EXTERNALS, variables.external_variables(session))
        told = parameters.read_parameters(
            session, without_secrets(parameters.changed_parameters(session))
        )
        folders.put_file(place, PARAMETERS, parameter_text(told))
    return (folders.INDEX, *folders.backup_files(FilePath(folder)))


def program_file(name: str) -> str:
    return f"programs/{_stem(name)}.prg"


def variable_file(name: str) -> str:
    return f"variables/{_stem(name)}.txt"


def _stem(name: str) -> str:
    """What a file of a program is called, in every system."""
    return f"{name}{AFTER_DEVICE}" if DEVICE.fullmatch(name) else name


def program_of(file: str) -> str:
    """The program that a file is of."""
    return FilePath(file).stem.removesuffix(AFTER_DEVICE)


def without_secrets(names: Iterable[str]) -> list[str]:
    return [name for name in names if not SECRET_PARAMETER.fullmatch(name)]


def parameter_text(values: Mapping[str, str]) -> bytes:
    """`NAME=value` each, sorted."""
    lines = (f"{name}={values[name]}\n" for name in sorted(values))
    return "".join(lines).encode(listing.ENCODING)


def assignments(data: bytes) -> dict[str, str]:
    """Name → value of the lines of a file."""
    pairs = (line.text.partition("=") for line in listing.program_lines(data))
    blanks = listing.BLANKS
    return {name.strip(blanks): value.strip(blanks) for name, _, value in pairs}


def variable_text(lines: Iterable[str]) -> bytes:
    """The lines sorted by name, P2 before P10."""
    ordered = sorted(lines, key=lambda line: listing.natural_order(line.partition("=")[0].upper()))
    return "".join(f"{line}\n" for line in ordered).encode(listing.ENCODING)


def _put_lines(place: FilePath, name: str, lines: list[str]) -> None:
    if lines:
        folders.put_file(place, name, variable_text(lines))
