"""DXF documents: opened as text or binary, checked, repaired if damaged; and their unit.

Group codes say what a value is (DXF reference, "Group code value types"). Libraries cut a number
off at its first wrong character, so that `50,5` becomes 50; therefore each number of a text DXF is
checked here. `unit_of` reads $INSUNITS (DXF reference, header section).
"""

from __future__ import annotations

import io
import logging
import re
import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.budgets import DRAWING, within
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.base.length_units import UNITS
from assistant.base.source_text import read_bytes
from assistant.sources.drawing.findings import (
    BROKEN,
    LOST,
    MALFORMED,
    NO_DXF,
    NO_UNITS,
    NOTED,
    OTHER_UNIT,
    REPAIRED,
    TRUNCATED,
    UNKNOWN_UNITS,
    shown,
)

if TYPE_CHECKING:
    from ezdxf.document import Drawing


_NUMBER_CODES: Final = (
    *((10, 59), (60, 79), (90, 99), (110, 149), (160, 179), (210, 239), (270, 289)),
    *((290, 299), (370, 389), (400, 409), (420, 429), (440, 469), (1010, 1071)),
)
"""First and last code of those that are numbers."""
_PLAIN_NUMBER: Final = re.compile(
    rb"[ \t]*[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|(?i:nan|inf|infinity))[ \t\x00\x1a]*"
)
"""A number as the reference has it; that one is not finite is found where it is used."""
_MOST_MALFORMED: Final = 10
"""Malformed numbers that have a finding each."""

_ESCAPED_CHARACTERS: Final = re.compile(r"(?:\\U\+[0-9A-Fa-f]{4})+")
_ESCAPE_MARK: Final = b"\\U+"
"""Prefix of a character that the code page of a file does not have."""


def malformed_numbers(data: bytes, path: str) -> list[Diagnostic]:
    """Return findings for the first values that are not numbers but have to be.

    It ends where lines are no longer codes and values in turn: that is damage of another kind.
    """
    known: dict[bytes, int | None] = {}
    wrong: list[tuple[int, int, bytes]] = []
    lines = data.splitlines()
    for row, (code, value) in enumerate(zip(lines[::2], lines[1::2], strict=False)):
        # Codes repeat: each different one is looked up once.
        if code not in known:
            number = _group_code(code)
            # Lines are no longer in pairs: `_load` reports that damage.
            if number is None:
                break
            known[code] = number if any(a <= number <= b for a, b in _NUMBER_CODES) else None
        kind = known[code]
        if kind is not None and _PLAIN_NUMBER.fullmatch(value) is None:
            wrong.append((2 * row + 2, kind, value))
    return [*_malformed_findings(wrong, path)]


def _group_code(text: bytes) -> int | None:
    try:
        return int(text)
    except ValueError:
        return None


def _malformed_findings(wrong: list[tuple[int, int, bytes]], path: str) -> Iterator[Diagnostic]:
    for place, (line, code, value) in enumerate(wrong[:_MOST_MALFORMED]):
        given = value.decode("latin-1").strip()
        rest = len(wrong) - _MOST_MALFORMED
        more = f" ({rest} more such values)" if rest > 0 and place == _MOST_MALFORMED - 1 else ""
        yield MALFORMED(
            path=path, line=line, given=shown(given), code=code, more=more, cure=_number_cure(given)
        )


def _number_cure(given: str) -> str:
    """What to write instead, where that is plain."""
    if re.fullmatch(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", given):
        return f"write a decimal point, {given.replace(',', '.')}"
    # A thousands separator, or the exponent of Fortran.
    meant = given.replace(",", "") if "." in given else given
    meant = re.sub(r"[dD](?=[+-]?\d+$)", "E", meant)
    if meant != given and _PLAIN_NUMBER.fullmatch(meant.encode("latin-1")):
        return f"write {meant}"
    return "write a number such as 12.5, or export the drawing anew"


def unescaped(text: str) -> str:
    r"""A text with the characters that `\U+XXXX` stand for, as far as they can be printed."""
    return _ESCAPED_CHARACTERS.sub(_unescaped_characters, text)


def _unescaped_characters(found: re.Match[str]) -> str:
    units = bytes.fromhex("".join(found[0].split("\\U+")))
    made = units.decode("utf-16-be", errors="replace")
    return made if made.isprintable() and "�" not in made else found[0]


_BINARY_SENTINEL: Final = b"AutoCAD Binary DXF\r\n\x1a\x00"
_DWG_SIGNATURE: Final = re.compile(rb"AC10\d\d\x00|AC1\.\d\d")
_SECTION: Final = re.compile(rb"(?:^|[\r\n])[ \t]*0[ \t]*\r?[\r\n][ \t]*SECTION[ \t]*\r?[\r\n]")
_HEADER_VARIABLE: Final = re.compile(rb"[\r\n][ \t]*9[ \t]*\r?[\r\n][ \t]*\$[A-Z]")
_BINARY_HEADER_VARIABLE: Final = re.compile(rb"\x09\x00?\$[A-Z]")
"""The name of a variable of the header."""
_END_MARK: Final = re.compile(rb"[\r\n][ \t]*0[ \t]*\r?[\r\n][ \t]*EOF[ \t]*(?:[\r\n]|$)")
_TAIL_BYTES: Final = 1 << 16
"""Bytes at the end of a file in which the end mark has to stand."""

_PADDING: Final = b"\x00\x1a \t\r\n"
"""Bytes with which old systems and transfers pad the last block of a file."""

_DAMAGE_ERRORS: Final = (
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
"""Exceptions that a damaged file or entity raises inside ezdxf, besides its own errors."""

_LOSING_REPAIRS: Final = frozenset(
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

_HANDLE_OR_LINE: Final = re.compile(r"#[0-9A-Fa-f]+|\bline \d+")

_MOST_REPAIRS: Final = 3
"""Kinds of repairs that a finding names."""
_MOST_NOTES: Final = 20
"""Largest number of notes that are reported individually."""


def open_drawing(path: FilePath) -> tuple[Drawing, tuple[Diagnostic, ...]]:
    """The document, and what had to be repaired to read it; raises Unreadable or Refused."""
    data = read_bytes(path)
    binary = data.startswith(_BINARY_SENTINEL)
    notes: list[str] = []
    with within(DRAWING, str(path), len(data)), _logged_warnings(notes):
        _check_kind(path, data, binary)
        _check_end(path, data, binary)
        if not binary and (wrong := malformed_numbers(data, str(path))):
            raise Refused(*wrong)
        document, repairs = _load(path, data, binary)
    # Without a header, ezdxf adds its own defaults.
    if (_BINARY_HEADER_VARIABLE if binary else _HEADER_VARIABLE).search(data) is None:
        _forget_header(document)
    elif _SAVED.encode() not in data and _SAVED in document.header:
        del document.header[_SAVED]
    return document, (*repairs, *_note_findings(notes, str(path)))


def saved_on(document: Drawing) -> date | None:
    """Return the day on which the drawing was saved last; None if it does not state a day.

    A Julian date that changes at midnight: DXF reference, header variable $TDUPDATE.
    """
    stated = document.header.get(_SAVED, None)
    if not isinstance(stated, float) or not stated < _LAST_JULIAN_DAY:
        return None
    day = int(stated) - _JULIAN_DAY_OF_ORDINAL
    return date.fromordinal(day) if day >= _FIRST_DAY else None


_SAVED: Final = "$TDUPDATE"
_JULIAN_DAY_OF_ORDINAL: Final = 1721425
_LAST_JULIAN_DAY: Final = 2_500_000.0
_FIRST_DAY: Final = date(1982, 1, 1).toordinal()
"""Before it there was no DXF."""


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
        kind = _HANDLE_OR_LINE.sub("", note)
        first.setdefault(kind, note)
        counts[kind] += 1
    told = []
    for kind, note in first.items():
        times = f" ({counts[kind]} times)" if counts[kind] > 1 else ""
        told.append(NOTED(path=path, place="file", what=shown(note) + times))
    return told[:_MOST_NOTES]


def library_errors() -> tuple[type[Exception], ...]:
    """Return the exceptions that ezdxf raises for a damaged file or entity."""
    from ezdxf.lldxf.const import DXFError

    return (DXFError, *_DAMAGE_ERRORS)


def _check_kind(path: FilePath, data: bytes, binary: bool) -> None:
    if binary or _SECTION.search(data):
        return
    reason = "it has no section"
    if _DWG_SIGNATURE.match(data):
        reason = "it is a DWG drawing"
    raise Unreadable(NO_DXF(path=str(path), name=shown(path.name), reason=reason))


def _check_end(path: FilePath, data: bytes, binary: bool) -> None:
    """A file without its end mark would read as a drawing with fewer entities."""
    if binary:
        whole = data.rstrip(b"\x1a \t\r\n\x00").endswith(b"\x00EOF")
    else:
        whole = _END_MARK.search(data[-_TAIL_BYTES:].rstrip(_PADDING)) is not None
    if not whole:
        raise Unreadable(TRUNCATED(path=str(path), name=shown(path.name)))


def _load(path: FilePath, data: bytes, binary: bool) -> tuple[Drawing, tuple[Diagnostic, ...]]:
    from ezdxf import recover
    from ezdxf.filemanagement import dxf_file_info, read, readfile

    try:
        # Without escapes the reader of ezdxf takes the file as it is.
        if binary or _ESCAPE_MARK not in data:
            return _with_checked_names(readfile(path)), ()
        text = data.decode(dxf_file_info(str(path)).encoding, errors="surrogateescape")
        lines = (unescaped(line) + "\n" for line in text.replace("\r\n", "\n").split("\n"))
        return _with_checked_names(read(io.StringIO("".join(lines)))), ()
    except library_errors() as error:
        strict = error
    if binary:  # ezdxf repairs text only
        raise _broken_finding(path, strict) from strict
    # `recover` repairs what the strict reader refuses.
    try:
        document, auditor = recover.readfile(path)
        _with_checked_names(document)
    except library_errors() as error:
        raise _broken_finding(path, error) from error
    name = str(path)
    repairs = [*auditor.fixes, *auditor.errors]
    lost = [entry for entry in repairs if _audit_code(entry.code) in _LOSING_REPAIRS]
    told = [LOST(path=name, place=_audit_code(e.code), what=shown(e.message)) for e in lost]
    mended = [
        _error_text(strict),
        *(e.message for e in repairs if _audit_code(e.code) not in _LOSING_REPAIRS),
    ]
    return document, (_repaired(mended, name), *told)


def _repaired(notes: list[str], path: str) -> Diagnostic:
    """One finding for all repairs: the first of each kind, and how many there are."""
    # Reversed twice: the first note of each kind stays, in its place.
    kinds = {_HANDLE_OR_LINE.sub("", note): note for note in reversed(notes)}
    some = [shown(note) for note in [*reversed(kinds.values())][:_MOST_REPAIRS]]
    more = f"; and more, {len(notes)} repairs in all" if len(notes) > len(some) else ""
    return REPAIRED(path=path, place="file", what="; ".join(some) + more)


def _with_checked_names(document: Drawing) -> Drawing:
    """Return the document, if all its spaces and layers have names; raises DXFStructureError.

    ezdxf reads block records and layers without a name, and fails when the name is requested.
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


_SURVEY_FOOT: Final = 1_200_000.0 / 3937.0
"""mm; 1200/3937 m by its definition of 1893."""
_INCH: Final = UNITS["in"][1]
_FOOT: Final = UNITS["ft"][1]
_METRE: Final = UNITS["m"][1]
_ASTRONOMICAL_UNIT: Final = 149_597_870_700.0 * _METRE

_MILLIMETRES: Final[dict[int, tuple[str, float]]] = {
    1: UNITS["in"],
    2: UNITS["ft"],
    3: ("miles", _FOOT * 5280),
    4: UNITS["mm"],
    5: UNITS["cm"],
    6: UNITS["m"],
    7: ("kilometres", _METRE * 1e3),
    8: ("microinches", _INCH * 1e-6),
    9: UNITS["mil"],
    10: UNITS["yd"],
    11: ("ångströms", 1e-7),
    12: ("nanometres", 1e-6),
    13: UNITS["um"],
    14: UNITS["dm"],
    15: ("decametres", _METRE * 10),
    16: ("hectometres", _METRE * 100),
    17: ("gigametres", _METRE * 1e9),
    18: ("astronomical units", _ASTRONOMICAL_UNIT),
    19: ("light years", 9_460_730_472_580_800.0 * _METRE),
    20: ("parsecs", _ASTRONOMICAL_UNIT * 648_000 / 3.141592653589793),
    21: ("US survey feet", _SURVEY_FOOT),
    22: ("US survey inches", _SURVEY_FOOT / 12),
    23: ("US survey yards", _SURVEY_FOOT * 3),
    24: ("US survey miles", _SURVEY_FOOT * 5280),
}
"""Code of $INSUNITS (DXF reference, header section) → name, millimetres."""


def unit_of(
    document: Drawing, path: str, given: str | None = None
) -> tuple[str, float, tuple[Diagnostic, ...]]:
    """Name of the drawing's unit, mm a unit, findings; raises Refused for unknown codes.

    given: short name of the unit that holds whatever the drawing says. The units of blocks do
    not matter: a CAD system puts them into the scale of the insert when it is made.
    """
    code = document.header.get("$INSUNITS", None)
    if given is not None:
        name, factor = UNITS[given]
        said, _ = _MILLIMETRES.get(code or 0, (name, factor))
        told = (OTHER_UNIT(path=path, place="header", said=said, given=name),)
        return name, factor, told if said != name else ()
    if code is None or code == 0:
        state = "missing" if code is None else "0"
        english = document.header.get("$MEASUREMENT", 1) == 0
        hint = ", although its measurement is English" if english else ""
        return "millimetres", 1.0, (NO_UNITS(path=path, place="header", state=state, hint=hint),)
    if code not in _MILLIMETRES:
        raise Refused(UNKNOWN_UNITS(path=path, place="header", code=code))
    return (*_MILLIMETRES[code], ())
