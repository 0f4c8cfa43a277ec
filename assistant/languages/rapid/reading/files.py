"""Files and folders of RAPID: encodings, program lists, binary files, the folders of a task.

A backup keeps the modules of a task in `RAPID/TASKn/PROGMOD` and `SYSMOD`, and those that all tasks
share in `RAPID/TASK0`. A list of a program (`.pgf`) names its program modules only: the system
parameters load the system modules.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, decode
from assistant.languages.language_types import (
    ControllerConfiguration,
    SharedData,
    TaskLoading,
    Texts,
)
from assistant.languages.rapid import rules

_LOOKED_AT: Final = 1 << 16
_MODULE_BEGIN: Final = re.compile(
    r"^\ufeff?[ \t]*(?:module[ \t]+\w|%%%|(?:local[ \t]+)?(?:proc|func|trap)[ \t]+\w"
    r"|(?:(?:local|task)[ \t]+)?(?:const|pers|var)[ \t]+\w+[ \t]+\w+[^;\n]*;)",
    re.IGNORECASE | re.MULTILINE,
)
_LIST: Final = re.compile(r"\A\ufeff?\s*<(?:\?xml|!--|Program\b)", re.IGNORECASE)
_LISTED: Final = re.compile(r"<Module\b[^>]*>\s*([^<]*?)\s*</Module\s*>", re.IGNORECASE)
_CONTROL: Final = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")
_MOST_CONTROL: Final = 0.02
"""Share of control characters from which on a file is no text."""
RUN_MARKS: Final = ("\x02", "\x03", "\x04", "\x05")
"""Characters that stand for runs of like rows in what the grammar reads."""
# With the plain codec `utf-16`, decoding removes the mark and the file is not written back byte for
# byte.
_UTF16: Final = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
"""Marks at the begin; the mark stays in the text, so that the same bytes are written."""


def read_text(data: bytes, path: str | None, encodings: Sequence[str]) -> SourceText:
    """The text of a file; raises Unreadable only where no encoding fits."""
    wide = _UTF16.get(data[:2])
    source = decode(data, path, (wide, *encodings) if wide else encodings)
    return SourceText(source.text, path, source.encoding, newline_of(source.text))


def newline_of(text: str) -> str:
    """The line end that new lines of a text get."""
    if "\r\n" in text or not ("\n" in text or "\r" in text):
        return "\r\n"
    return "\n" if "\n" in text else "\r"


def recognises(data: bytes) -> bool:
    """True if the beginning of a file looks like a module, a part of one, or a list of modules.

    An encrypted module qualifies as well: reading it reports the encryption.
    """
    wide = _UTF16.get(data[:2])
    text = data[:_LOOKED_AT].decode(wide or "latin-1", errors="replace")
    text = text.removeprefix("\xef\xbb\xbf")  # a UTF-8 byte order mark, as Latin-1 shows it
    if _MODULE_BEGIN.search(text):
        return True
    program = _LIST.match(text) is not None and re.search(r"<Program\b", text) is not None
    return program or bool(_controls(text))


def _controls(text: str) -> list[int]:
    """Return the offsets of control characters, empty if they are no more than a text has."""
    found = [match.start() for match in _CONTROL.finditer(text)]
    return found if len(found) > max(2, _MOST_CONTROL * len(text)) else []


def is_list(text: str) -> bool:
    """True if a text is the XML of a `.pgf`."""
    return _LIST.match(text) is not None


def listed(text: str) -> tuple[str, ...]:
    """The files that a program list names."""
    return tuple(map(_without_entities, filter(None, _LISTED.findall(text))))


def _without_entities(name: str) -> str:
    for entity, mark in _ENTITIES:
        name = name.replace(entity, mark)
    return name


# `&amp;` comes last: replaced first, it would turn `&amp;lt;` into `<`.
_ENTITIES: Final = (("&gt;", ">"), ("&lt;", "<"), ("&amp;", "&"))
"""XML entities and their characters, in the order of replacement."""


def unreadable(source: SourceText) -> Diagnostic | None:
    """Report why a text cannot be read as RAPID at all."""
    begin = source.text[:_LOOKED_AT]
    if controls := _controls(begin):
        at = controls[0]
        # UTF-16 without a byte order mark: every other byte of ASCII text is zero.
        empty = begin.count("\0") * 3 > len(begin)
        return source.finding(
            rules.UNREADABLE,
            Span(at, at + 1),
            why="every other byte is zero" if empty else "it is encrypted or another kind of file",
            hint="save it as UTF-8 or ISO 8859-1"
            if empty
            else "an encrypted module runs on the controller only; ask its maker for the text",
        )
    if is_list(source.text) and not listed(source.text):
        return source.finding(
            rules.UNREADABLE,
            Span(0, 1),
            why="it is XML that lists no module",
            hint="write <Program><Module>name.mod</Module></Program>, or give the modules",
        )
    # The parser puts these characters in place of runs; in a source they would name runs that do
    # not exist.
    if (at := max(source.text.find(mark) for mark in RUN_MARKS)) >= 0:
        return source.finding(
            rules.SYNTAX,
            Span(at, at + 1),
            found="a control character",
            expected="text",
            hint="delete it",
        )
    return None


def notes(source: SourceText) -> Iterable[Diagnostic]:
    """Report bytes in a readable file that a controller rejects."""
    if source.encoding.startswith("utf-16"):
        yield source.finding(rules.ENCODING, Span(0, 1))
    if (at := source.text.find("\r\r\n")) >= 0:
        yield source.finding(rules.LINE_END, Span(at, at + 1))


_TASK_FOLDERS: Final = frozenset(("PROGMOD", "SYSMOD"))
_SYSTEM_FOLDER: Final = "SYSMOD"
_SYSTEM_SUFFIXES: Final = (".sys", ".sysx")
_TASK_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/TASK(\d+)$")


def task_folder(path: FilePath) -> FilePath:
    """The modules of a folder are one task; a backup keeps a task's in two folders."""
    folder = path.parent
    return folder.parent if folder.name.upper() in _TASK_FOLDERS else folder


def _is_shared_folder(folder: FilePath) -> bool:
    """True if a folder is TASK0 of a backup."""
    found = _TASK_FOLDER.search(folder.as_posix())
    return found is not None and int(found[1]) == 0


def _is_task_folder(folder: FilePath) -> bool:
    """True if a folder is a task of a backup."""
    return _TASK_FOLDER.search(folder.as_posix()) is not None


def _is_system_module(path: FilePath) -> bool:
    """True if a file is a system module by its folder or suffix."""
    return path.parent.name.upper() == _SYSTEM_FOLDER or path.suffix.lower() in _SYSTEM_SUFFIXES


def surroundings(module: FilePath, read: Texts) -> ControllerConfiguration:
    from assistant.languages.rapid.reading.controller_backup import backup_configuration

    return backup_configuration(module, read)


def _with_shared_data_of_tasks(tasks: Sequence[tuple[str, Sequence[Any]]]) -> list[SharedData]:
    """See `controller_backup`, which needs the tree: loaded only for several tasks."""
    from assistant.languages.rapid.reading.controller_backup import with_shared_data

    return with_shared_data(tasks)


LOADING: Final = TaskLoading(
    "main",
    (".pgf",),
    _is_shared_folder,
    _is_task_folder,
    _is_system_module,
    _with_shared_data_of_tasks,
)
