"""Completion, hover texts and semantic tokens of a document.

Completions are the words that may be at a position: declared names, instructions, keywords, values.
A hover text describes an instruction, a declaration, or a target with its pose (mm, degrees).
Tokens are the words of the text with their sorts, in columns.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from assistant.base.diagnostics import Refused
from assistant.base.rotations import to_euler
from assistant.editing.answers import SORTS, Completion, CompletionKind, Hover, Tokens
from assistant.editing.symbols import Named, editable, named, range_of, word_at
from assistant.editing.text_lines import Place, Range
from assistant.editing.workspace import Document
from assistant.program.editor_support import Declaration, Editable, KnownWord, LineFacts, Word

if TYPE_CHECKING:
    from assistant.program.geometry import Target
    from assistant.robots import Robot


_MOST_COMPLETIONS: Final = 500
"""Largest number of completions in one answer."""
_COMPLETION_KINDS: Final = {
    "procedure": "procedure", "function": "function", "interrupt": "procedure", "record": "type",
    "type": "type", "constant": "variable", "variable": "variable", "target": "target",
    "parameter": "parameter", "label": "label", "step": "label",
}  # fmt: skip
_LATER_RANK: Final = 1000
"""Added to the rank of words that do not begin with the typed letters."""
_STARTING: Final = ("instruction", "procedure", "keyword", "variable")
_VALUES: Final = ("target", "variable", "parameter", "function", "label")


def completions(document: Document, place: Place) -> tuple[Completion, ...]:
    """See `service.completions`."""
    speaks = editable(document)
    if speaks is None or place.line >= len(document.facts) or place.line < 0:
        return ()
    lines = document.lines
    column = lines.offset(place) - lines.starts[place.line]
    said = document.facts[place.line].words
    inside = next((word for word in said if word.start < column <= word.end), None)
    if inside is not None and inside.kind in ("comment", "string", "number"):
        return ()
    words = [word for word in said if word.end < column or word is inside]
    begun = inside if inside is not None and inside.kind != "operator" else None
    before = [word for word in words if word is not begun]
    start = column if begun is None else begun.start
    range = range_of(lines, place.line, start, column)
    prefix = lines.line(place.line)[start:column]
    offered = _offered(document, speaks, place.line, before)
    return tuple(_fitting(speaks, offered, prefix, range))


_Offer = tuple[str, CompletionKind, str, str, int]
"""Label, kind, detail, more, and rank."""


def _offered(
    document: Document, speaks: Editable, line: int, before: list[Word]
) -> Iterator[_Offer]:
    last = before[-1].text if before else ""
    if last == "." and len(before) > 1:
        detail = _detail(document, speaks, line, before[-2].text)
        for rank, (name, type) in enumerate(speaks.members(detail).items()):
            yield name, "property", type, "", rank
        return
    if last == "\\":
        called = next((word for word in before if word.kind == "name"), None)
        options = speaks.options(called.text) if called else {}
        for rank, (name, type) in enumerate(options.items()):
            yield name, "property", type, "", rank
        return
    begins = not any(word.kind != "number" for word in before)
    first = _STARTING if begins else _VALUES
    for one in _declared(document, line):
        kind = cast(CompletionKind, _COMPLETION_KINDS.get(one.kind, "variable"))
        own = one.scope == "routine"
        yield one.name, kind, one.detail, "", (0 if kind in first else 2) - own
    for known in speaks.known().values():
        kind = cast(CompletionKind, known.sort)
        yield known.name, kind, known.detail, known.about, _rank(kind, first)


def _rank(kind: str, first: tuple[str, ...]) -> int:
    """Words of the language behind what is declared; those that begin a statement first."""
    return 3 + first.index(kind) if kind in first else 9


def _declared(document: Document, line: int) -> Iterator[Declaration]:
    """Yield the declarations visible in a line: of its routine, of its file, and shared ones of
    other files.
    """
    routine = document.made_of.routine_at(line)
    for other in document.workspace.task(document):
        for at, facts in enumerate(other.facts):
            for one in facts.declares:
                if one.kind in ("module", "program"):
                    continue
                home = None if not facts.declares else other.made_of.routine_at(at)
                inner = home is not None and (at > home.head or one.scope == "routine")
                if other is not document and (inner or one.scope != "task"):
                    continue
                if inner and not one.implied and home is not routine:
                    continue
                yield one


def _detail(document: Document, speaks: Editable, line: int, name: str) -> str:
    key = speaks.folded(name)
    for one in _declared(document, line):
        if speaks.folded(one.name) == key:
            return one.detail
    return ""


def _fitting(
    speaks: Editable, offered: Iterator[_Offer], prefix: str, range: Range
) -> Iterator[Completion]:
    wanted = speaks.folded(prefix)
    found: dict[str, tuple[int, _Offer]] = {}
    for offer in offered:
        key = speaks.folded(offer[0])
        if not _fits(key, wanted):
            continue
        rank = offer[4] + (0 if key.startswith(wanted) else _LATER_RANK)
        if key not in found or rank < found[key][0]:
            found[key] = rank, offer
    ranked = sorted(found.values(), key=lambda one: (one[0], one[1][0].lower()))
    for rank, (name, kind, detail, about, _) in ranked[:_MOST_COMPLETIONS]:
        yield Completion(name, kind, name, range, detail, about, rank)


def _fits(key: str, wanted: str) -> bool:
    """True if the letters of `wanted` occur in `key` in their order, beginning with the first
    one.
    """
    if not wanted:
        return True
    if not key or key[0] != wanted[0]:
        return False
    letters = iter(key)
    return all(letter in letters for letter in wanted)


_MOST_COMMENT: Final = 5
"""Lines of a comment above a declaration that are shown."""


def hover(document: Document, place: Place) -> Hover | None:
    """See `service.hover`."""
    speaks = editable(document)
    at = word_at(document, place)
    if speaks is None or at is None:
        return None
    line, word = at
    found = named(document, place)
    if found is not None and found.declared is not None:
        text = "\n\n".join(_of_declared(document, found))
    else:
        known = speaks.known().get(speaks.folded(word.text)) or speaks.known().get(
            _with_next(document, line, word.start)
        )
        if known is None or (word.kind not in ("name", "keyword")):
            return None
        if not known.detail and not known.about:
            return None
        text = "\n\n".join(
            part for part in (_code(known.detail or known.name), known.about) if part
        )
    return Hover(text, range_of(document.lines, line, word.start, word.end))


def _with_next(document: Document, line: int, start: int) -> str:
    """Return a word and the one after it: `def pos`."""
    words = [word for word in document.facts[line].words if word.start >= start][:2]
    return " ".join(word.text.lower() for word in words)


def _of_declared(document: Document, found: Named) -> Iterator[str]:
    assert found.declared is not None
    home = found.document
    lines = home.lines
    said = lines.line(found.at).strip()
    yield _code(said)
    comment = list(_comment_above(home, found.at))
    if comment:
        yield _escaped_markdown("\n".join(comment))
    if home is not document:
        yield _escaped_markdown(f"in {home.path}")
    if found.declared.kind == "target":
        yield from _of_target(home, found.declared.name)


def _comment_above(document: Document, line: int) -> Iterator[str]:
    above = line - 1
    while above >= 0 and line - above <= _MOST_COMMENT:
        words = document.facts[above].words
        if len(words) != 1 or words[0].kind != "comment":
            break
        above -= 1
    speaks = document.spoken
    mark = "" if speaks is None else speaks.mark
    for at in range(above + 1, line):
        yield document.facts[at].words[0].text.removeprefix(mark).strip()


def _of_target(document: Document, name: str) -> Iterator[str]:
    """Its pose in mm and degrees, and the joints of the project's robot."""
    speaks = document.spoken
    assert speaks is not None and speaks.editable is not None
    key = speaks.editable.folded(name)
    try:
        source = document.declared(frozenset({key})).source(document.path)
        program = speaks.program(source, (), _project_robot(document))
    except Refused:
        return
    for known, target in program.targets.items():
        if known.lower() == key.lower():
            yield from _of_pose(document, target)
            return
    for known, joints in program.joint_targets.items():
        if known.lower() == key.lower():
            yield "joints: " + _numbers(joints.joints, "°")
            return


def _of_pose(document: Document, target: Target) -> Iterator[str]:
    x, y, z = target.pose.position
    euler = to_euler(np.array([target.pose.quaternion]))[0]
    yield (
        f"position: {_numbers((x, y, z), ' mm')}  \n"
        f"turned: {_numbers(euler[::-1], '°')} about x, y, z in turn (Euler ZYX)"
    )
    robot = _project_robot(document)
    if robot is None:
        return
    columns = np.array([_columns(target)])
    joints = robot.joints_of([target.pose.position], [target.pose.quaternion], columns)[0]
    if np.isnan(joints).any():
        yield f"{robot.name}: not within reach of the bare flange, in the robot's base"
    else:
        yield f"{robot.name}, bare flange, in the robot's base: {_numbers(joints, '°')}"


def _columns(target: Target) -> list[int]:
    from assistant.program.motion import configuration_row

    return list(configuration_row(target.configuration))


def _project_robot(document: Document) -> Robot | None:
    return document.workspace.robot(document)


def _numbers(values: object, unit: str) -> str:
    return ", ".join(f"{value:.2f}{unit}" for value in np.asarray(values, dtype=float).ravel())


def _code(text: str) -> str:
    fence = "`" * 3
    while fence in text:
        fence += "`"
    return f"{fence}\n{text}\n{fence}"


def _escaped_markdown(text: str) -> str:
    """Escape a plain text for Markdown."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]()#+-.!|<>&" else c for c in text)


_SORT: Final = {name: number for number, name in enumerate(SORTS)}
_PLAIN_SORTS: Final = {
    kind: _SORT[kind]
    for kind in ("comment", "keyword", "number", "string", "operator", "label", "property")
}
_DECLARED_SORTS: Final[Mapping[str, str]] = {
    "procedure": "procedure", "function": "function", "interrupt": "procedure", "record": "type",
    "type": "type", "constant": "variable", "variable": "variable", "target": "target",
    "parameter": "parameter", "label": "label", "step": "label", "module": "type",
    "program": "type",
}  # fmt: skip
_DECLARATION, READONLY, _PREDEFINED = 1, 2, 4
_LineTokens = tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...], tuple[int, ...]]


def tokens(document: Document, first: int, last: int | None) -> Tokens:
    """See `service.tokens`."""
    speaks = document.spoken
    editable = None if speaks is None else speaks.editable
    if editable is None:
        return Tokens(*(np.zeros(0, dtype=np.int32) for _ in range(5)))
    declared: dict[str, int] = {}
    for other in document.workspace.task(document):
        for facts in other.facts:
            for one in facts.declares:
                if not one.implied or one.kind == "label":
                    declared.setdefault(editable.folded(one.name), _packed_sort(one))
    lines = document.lines
    rows: list[tuple[int, int, int, int, int]] = []
    known, narrow = editable.known(), document.text.isascii()
    for number, facts in enumerate(
        document.facts[first : None if last is None else last + 1], first
    ):
        text = "" if narrow else lines.line(number)
        ascii_line = narrow or text.isascii()
        for start, end, sort, marks in _line_tokens(editable, facts, declared, known):
            if not ascii_line:
                start, end = _utf16_column(text, start), _utf16_column(text, end)
            rows.append((number, start, end - start, sort, marks))
    table = np.array(rows, dtype=np.int32).reshape(-1, 5)
    return Tokens(*(np.ascontiguousarray(column) for column in table.T))


@lru_cache(maxsize=1 << 12)
def _utf16_column(text: str, column: int) -> int:
    return len(text[:column].encode("utf-16-le")) // 2


def _packed_sort(one: Declaration) -> int:
    readonly = READONLY if one.fixed or one.kind == "constant" else 0
    return _SORT[_DECLARED_SORTS[one.kind]] << 3 | readonly


def _line_tokens(
    editable: Editable,
    facts: LineFacts,
    declared: Mapping[str, int],
    known: Mapping[str, KnownWord],
) -> list[tuple[int, int, int, int]]:
    here = {one.start: one for one in facts.declares}
    found = []
    for kind, start, end, text in facts.words:
        own = here.get(start)
        if own is not None:
            packed = _packed_sort(own) | _DECLARATION
        elif kind != "name":
            packed = _PLAIN_SORTS[kind] << 3
        else:
            key = editable.folded(text)
            packed = declared.get(key, -1)
            if packed < 0:
                packed = _of_known(known.get(key))
        found.append((start, end, packed >> 3, packed & 7))
    return found


def _of_known(known: KnownWord | None) -> int:
    if known is None:
        return _SORT["variable"] << 3
    return _SORT[known.sort] << 3 | _PREDEFINED
