"""Opening a drawing: text and binary DXF, damaged ones through repair."""

from __future__ import annotations

import io
import logging
import re
import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.budgets import DRAWING, within
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.base.source_text import read_bytes
from assistant.sources.drawing.findings import (
    BROKEN,
    LOST,
    NO_DXF,
    NOTED,
    REPAIRED,
    TRUNCATED,
    shown,
)
from assistant.sources.drawing.group_codes import ESCAPE_MARK, malformed_numbers, unescaped

if TYPE_CHECKING:
    from ezdxf.document import Drawing

BINARY_SENTINEL: Final = b"AutoCAD Binary DXF\r\n\x1a\x00"
DWG_SIGNATURE: Final = re.compile(rb"AC10\d\d\x00|AC1\.\d\d")
SECTION: Final = re.compile(rb"(?:^|[\r\n])[ \t]*0[ \t]*\r?[\r\n][ \t]*SECTION[ \t]*\r?[\r\n]")
HEADER_VARIABLE: Final = re.compile(rb"[\r\n][ \t]*9[ \t]*\r?[\r\n][ \t]*\$[A-Z]")
BINARY_HEADER_VARIABLE: Final = re.compile(rb"\x09\x00?\$[A-Z]")
"""The name of a variable of the header."""
END_MARK: Final = re.compile(rb"[\r\n][ \t]*0[ \t]*\r?[\r\n][ \t]*EOF[ \t]*(?:[\r\n]|$)")
TAIL_BYTES: Final = 1 << 16
"""Bytes at the end of a file in which the end mark has to stand."""

PADDING: Final = b"\x00\x1a \t\r\n"
"""What old systems and transfers fill the last block of a file with."""

DAMAGE_ERRORS: Final = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    OSError,
    RuntimeError,  # also of generators, and of what is nested too deeply
    StopIteration,
    TypeError,
    ValueError,
    struct.error,
)
"""What a damaged file or entity raises inside ezdxf, besides its own errors."""

LOSING_REPAIRS: Final = frozenset(
    {
        "UNDEFINED_BLOCK",
        "UNDEFINED_BLOCK_NAME",
        "INVALID_BLOCK_REFERENCE_CYCLE",
        "INVALID_MAJOR_AXIS",
        "INVALID_SPLINE_DEFINITION",
        "INVALID_SPLINE_CONTROL_POINT_COUNT",
        "INVALID_SPLINE_FIT_POINT_COUNT",
        "INVALID_SPLINE_KNOT_VALUE_COUNT",
        "INVALID_SPLINE_WEIGHT_COUNT",
        "REMOVED_ENTITY_WITH_INVALID_OWNER_HANDLE",
        "REMOVED_STANDALONE_ATTRIB_ENTITY",
        "TAG_ATTRIBUTE_MISSING",
    }
)
"""Repairs that delete something a robot might have to follow."""

HANDLE_OR_LINE: Final = re.compile(r"#[0-9A-Fa-f]+|\bline \d+")

MOST_REPAIRS: Final = 3
"""Kinds of repairs that a finding names."""
MOST_NOTES: Final = 20
"""How many notes are told one by one."""


def open_drawing(path: FilePath) -> tuple[Drawing, tuple[Diagnostic, ...]]:
    """The document, and what had to be repaired to read it; raises Unreadable or Refused."""
    data = read_bytes(path)
    binary = data.startswith(BINARY_SENTINEL)
    notes: list[str] = []
    with within(DRAWING, str(path), len(data)), _logged_warnings(notes):
        _check_kind(path, data, binary)
        _check_end(path, data, binary)
        if not binary and (wrong := malformed_numbers(data, str(path))):
            raise Refused(*wrong)
        document, repairs = _load(path, data, binary)
    if (BINARY_HEADER_VARIABLE if binary else HEADER_VARIABLE).search(data) is None:
        _forget_header(document)
    return document, (*repairs, *_note_findings(notes, str(path)))


def _forget_header(document: Drawing) -> None:
    """Takes away the variables that ezdxf makes up for a file without a header.

    Among them is a unit, metres, which the drawing never named.
    """
    for name in [*document.header.varnames()]:
        del document.header[name]


def _note_findings(notes: list[str], path: str) -> list[Diagnostic]:
    """A finding for each kind of note, with a count where they differ in handle or line only."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for note in notes:
        kind = HANDLE_OR_LINE.sub("", note)
        first.setdefault(kind, note)
        counts[kind] += 1
    told = []
    for kind, note in first.items():
        times = f" ({counts[kind]} times)" if counts[kind] > 1 else ""
        told.append(NOTED(path=path, place="file", what=shown(note) + times))
    return told[:MOST_NOTES]


def library_errors() -> tuple[type[Exception], ...]:
    """What ezdxf raises for a damaged file or entity."""
    from ezdxf.lldxf.const import DXFError

    return (DXFError, *DAMAGE_ERRORS)


def _check_kind(path: FilePath, data: bytes, binary: bool) -> None:
    if binary or SECTION.search(data):
        return
    reason = "it has no section"
    if DWG_SIGNATURE.match(data):
        reason = "it is a DWG drawing"
    raise Unreadable(NO_DXF(path=str(path), name=shown(path.name), reason=reason))


def _check_end(path: FilePath, data: bytes, binary: bool) -> None:
    """A file without its end mark would read as a drawing with fewer entities."""
    if binary:
        whole = data.rstrip(b"\x1a \t\r\n\x00").endswith(b"\x00EOF")
    else:
        whole = END_MARK.search(data[-TAIL_BYTES:].rstrip(PADDING)) is not None
    if not whole:
        raise Unreadable(TRUNCATED(path=str(path), name=shown(path.name)))


def _load(path: FilePath, data: bytes, binary: bool) -> tuple[Drawing, tuple[Diagnostic, ...]]:
    from ezdxf import recover
    from ezdxf.filemanagement import dxf_file_info, read, readfile

    try:
        if binary or ESCAPE_MARK not in data:
            return _with_checked_names(readfile(path)), ()
        text = data.decode(dxf_file_info(str(path)).encoding, errors="surrogateescape")
        lines = (unescaped(line) + "\n" for line in text.replace("\r\n", "\n").split("\n"))
        return _with_checked_names(read(io.StringIO("".join(lines)))), ()
    except library_errors() as error:
        strict = error
    if binary:  # ezdxf repairs text only
        raise _broken_finding(path, strict) from strict
    try:
        document, auditor = recover.readfile(path)
        _with_checked_names(document)
    except library_errors() as error:
        raise _broken_finding(path, error) from error
    name = str(path)
    repairs = [*auditor.fixes, *auditor.errors]
    lost = [entry for entry in repairs if _audit_code(entry.code) in LOSING_REPAIRS]
    told = [LOST(path=name, place=_audit_code(e.code), what=shown(e.message)) for e in lost]
    mended = [
        _error_text(strict),
        *(e.message for e in repairs if _audit_code(e.code) not in LOSING_REPAIRS),
    ]
    return document, (_repaired(mended, name), *told)


def _repaired(notes: list[str], path: str) -> Diagnostic:
    """One finding for all repairs: the first of each kind, and how many there are."""
    kinds = {HANDLE_OR_LINE.sub("", note): note for note in reversed(notes)}
    some = [shown(note) for note in [*reversed(kinds.values())][:MOST_REPAIRS]]
    more = f"; and more, {len(notes)} repairs in all" if len(notes) > len(some) else ""
    return REPAIRED(path=path, place="file", what="; ".join(some) + more)


def _with_checked_names(document: Drawing) -> Drawing:
    """The document, if all its spaces and layers have names; raises DXFStructureError.

    ezdxf reads block records and layers without one, and fails where it is asked for.
    """
    from ezdxf.lldxf.const import DXFStructureError

    names = {"space": [layout.block_record_name for layout in document.layouts]}
    names["layer"] = [layer.dxf.name for layer in document.layers]
    for kind, given in names.items():
        if not all(isinstance(name, str) for name in given):
            raise DXFStructureError(f"a {kind} has no name")
    return document


def _audit_code(code: int) -> str:
    from ezdxf.audit import AuditError

    return AuditError(code).name


def _error_text(error: Exception) -> str:
    return str(error) or type(error).__name__


def _broken_finding(path: FilePath, error: Exception) -> Unreadable:
    reason = shown(_error_text(error))
    return Unreadable(BROKEN(path=str(path), name=shown(path.name), reason=reason))


@contextmanager
def _logged_warnings(notes: list[str]) -> Iterator[None]:
    """Collects what ezdxf logs as a warning or worse, which else would go to the terminal."""
    logger = logging.getLogger("ezdxf")
    listener = _LogCollector(notes)
    propagates, logger.propagate = logger.propagate, False
    logger.addHandler(listener)
    try:
        yield
    finally:
        logger.removeHandler(listener)
        logger.propagate = propagates


class _LogCollector(logging.Handler):
    def __init__(self, notes: list[str]) -> None:
        super().__init__(logging.WARNING)
        self.notes = notes

    def emit(self, record: logging.LogRecord) -> None:
        self.notes.append(record.getMessage())
