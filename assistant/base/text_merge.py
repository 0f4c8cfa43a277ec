"""Merge and difference of program texts: changes made on a controller, carried into the local text.

A controller returns a program in its own layout: steps in order, other blanks, numbers with two
decimals. The words of each line are compared in the form in which the controller compares programs,
so that a line that means the same stays as it was written locally.
"""

from __future__ import annotations

import difflib
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from difflib import SequenceMatcher
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.source_text import decode, ended_lines, line_end, lines_of, visible

StoredForm = Callable[[bytes], bytes]
"""The form in which a controller compares programs; see `Programs.stored`."""

_ENCODINGS: Final = ("utf-8", "latin-1")
"""Encodings to read programs in; latin-1 has a character for every byte, so none is refused."""
_WORD: Final = re.compile(
    r'"[^"\r\n]*"|[A-Za-z_]\w*|\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\S'
)
_NUMBER: Final = re.compile(r"[+-]?\.?\d")
_BEFORE_SIGNS: Final = frozenset("[(,=:")
"""Words behind which a sign is of the number that follows."""
_DIGITS: Final = 6
"""Decimals to which numbers of two texts must agree that were written by different programs."""

_MOST_PAIRS: Final = 2_000_000
"""Pairs of equal lines, one of each text, that are all compared; that takes about a second."""

_Key = tuple[str | float, ...]


@dataclass(frozen=True, slots=True)
class _Text:
    """Lines of a text with their ends, and the content of each."""

    lines: list[str]
    keys: list[_Key]
    encoding: str


def in_layout(own: bytes, other: bytes, form: StoredForm, mark: str = "") -> bytes:
    """Return the content of `other`, in the layout of `own` where the content of both is the same.

    mark: begins a comment where comments do not count, because one of the texts may have lost them;
    "" where they count.
    """
    mine, theirs = (
        _text(own, form, None, mark),
        _text(_in_order(own, other, form), form, None, mark),
    )
    return _bytes(_carried(mine, theirs, mark), mine.encoding)


def merged(base: bytes, own: bytes, other: bytes, form: StoredForm, mark: str = "") -> bytes | None:
    """`own` with the changes that lead from `base` to `other`, None where it changed there too."""
    ground, mine = _text(base, form, _DIGITS, mark), _text(own, form, _DIGITS, mark)
    theirs = _text(in_layout(base, other, form, mark), form, _DIGITS, mark)
    ours = _changes(ground.keys, mine.keys)
    lines, at = [], 0
    for change in _changes(ground.keys, theirs.keys):
        new = theirs.keys[change.begin : change.end]
        touched = [one for one in ours if one.touches(change)]
        if touched:
            if any(not one.of_same_lines(change) for one in touched) or any(
                mine.keys[one.begin : one.end] != new for one in touched
            ):
                return None
            continue  # the same change was made here
        # Local changes above shift the lines: the last one says by how much.
        moved = next((c.end - c.stop for c in reversed(ours) if c.stop <= change.first), 0)
        lines += mine.lines[at : change.first + moved] + theirs.lines[change.begin : change.end]
        at = change.stop + moved
    return _bytes([*lines, *mine.lines[at:]], mine.encoding)


def _in_order(own: bytes, other: bytes, form: StoredForm) -> bytes:
    """The other text with its values in the order of ours, if that is all one to the controller.

    A controller may list values by their names, wherever they stood.
    """
    mine, theirs = _text(own, form), _text(other, form)
    order = {head: i for i, head in enumerate(_heads(mine)) if head}
    slots = [i for i, head in enumerate(_heads(theirs)) if head in order]
    heads = _heads(theirs)
    moved = sorted(slots, key=lambda i: order[heads[i]])
    lines = list(theirs.lines)
    for slot, taken in zip(slots, moved, strict=True):
        lines[slot] = theirs.lines[taken]
    # A line without an end would be joined to the next one.
    if lines == theirs.lines or not all(map(_end, theirs.lines)):
        return other
    text = _bytes(lines, theirs.encoding)
    return text if form(text) == form(other) else other


def _heads(text: _Text) -> list[str]:
    """Return the name that each line assigns to, "" if that is not plain or appears twice."""
    heads = [
        str(key[0]) if len(key) > 1 and key[1] == "=" and isinstance(key[0], str) else ""
        for key in text.keys
    ]
    times = Counter(heads)
    return [head if times[head] == 1 else "" for head in heads]


def says_the_same(one: bytes, other: bytes, form: StoredForm, mark: str = "") -> bool:
    """True if two texts have the same content, numbers to DIGITS decimals."""
    return _text(one, form, _DIGITS, mark).keys == _text(other, form, _DIGITS, mark).keys


@dataclass(frozen=True, slots=True)
class _Change:
    """Lines first … stop of one text that are lines begin … end of another."""

    first: int
    stop: int
    begin: int
    end: int

    def touches(self, other: _Change) -> bool:
        if self.first == self.stop or other.first == other.stop:  # something is put in
            return self.first <= other.stop and other.first <= self.stop
        return self.first < other.stop and other.first < self.stop

    def of_same_lines(self, other: _Change) -> bool:
        return (self.first, self.stop) == (other.first, other.stop)


def _changes(old: Sequence[_Key], new: Sequence[_Key]) -> list[_Change]:
    """In order, line by line where as many lines are replaced."""
    found: list[_Change] = []
    for step, i1, i2, j1, j2 in _steps(old, new):
        if step != "equal" and i2 - i1 == j2 - j1:
            found += [_Change(i1 + k, i1 + k + 1, j1 + k, j1 + k + 1) for k in range(i2 - i1)]
        elif step != "equal":
            found.append(_Change(i1, i2, j1, j2))
    return found


def _steps(old: Sequence[_Key], new: Sequence[_Key]) -> Iterator[tuple[str, int, int, int, int]]:
    """Yield opcodes as `SequenceMatcher.get_opcodes`, but match only between the first difference
    and the last: its time grows with the square of lines that appear often.
    """
    pairs = zip(old, new, strict=False)
    first = next((i for i, (a, b) in enumerate(pairs) if a != b), min(len(old), len(new)))
    most = min(len(old), len(new)) - first
    last = next((i for i in range(most) if old[-1 - i] != new[-1 - i]), most)
    if first:
        yield "equal", 0, first, 0, first
    mine, theirs = old[first : len(old) - last], new[first : len(new) - last]
    count = Counter(theirs)
    # `autojunk` ignores lines that appear often, so that changes far apart seem to be one.
    inner = SequenceMatcher(
        None, mine, theirs, autojunk=sum(count[key] for key in mine) > _MOST_PAIRS
    )
    for step, i1, i2, j1, j2 in inner.get_opcodes():
        yield step, first + i1, first + i2, first + j1, first + j2
    if last:
        yield "equal", len(old) - last, len(old), len(new) - last, len(new)


def _carried(mine: _Text, theirs: _Text, mark: str) -> list[str]:
    """The lines of the other text, ours where they say the same, with our line ends."""
    spare = dict(zip(mine.keys, mine.lines, strict=True))
    end = next((e for line in mine.lines if (e := _end(line))), "\n")
    lines: list[str] = []
    for step, i1, i2, j1, j2 in _steps(mine.keys, theirs.keys):
        block = mine.lines[i1:i2]
        if step == "equal" or (step == "delete" and not any(mine.keys[i1:i2])):
            lines += block  # the controller may not keep empty lines
        elif step == "replace" and (
            text := _with_values("".join(block), theirs.lines[j1:j2], mark)
        ):
            # The controller may break the lines elsewhere: the block is compared as one text.
            lines += ended_lines(text)
        elif i2 - i1 == j2 - j1:
            pairs = zip(block, theirs.lines[j1:j2], strict=True)
            lines += [_with_values(own, [new], mark) or _taken(new, end) for own, new in pairs]
        else:
            taken = zip(theirs.keys[j1:j2], theirs.lines[j1:j2], strict=True)
            # A line that only moved keeps the local layout.
            lines += [spare.get(key) or _taken(line, end) for key, line in taken]
    return lines


def _with_values(own: str, other: Sequence[str], mark: str) -> str | None:
    """Our text with the numbers of the other one, None if more than numbers differs."""
    mine, theirs = list(_words(own, mark)), list(_words("".join(other), mark))
    if len(mine) != len(theirs):
        return None
    text, at = [], 0
    for (word, start), (new, _) in zip(mine, theirs, strict=True):
        if _line_form(word) != _line_form(new):
            if not (_NUMBER.match(word) and _NUMBER.match(new)):
                return None
            text += [own[at:start], new]
            at = start + len(word)
    return "".join([*text, own[at:]])


def _words(text: str, mark: str) -> Iterator[tuple[str, int]]:
    """The words, each with where it begins; numbers with their signs. mark: of comments."""
    # A sign at the very start is of a number, as after a bracket.
    before, behind, end = "[", 0, line_end(text)
    sign: int | None = None
    for found in _WORD.finditer(text):
        word, start = found[0], found.start()
        if start < behind:
            continue
        if word == mark:
            behind = text.find(end, start) + 1 or len(text)
            continue
        if sign is not None:
            if _NUMBER.match(word) and sign + 1 == start:
                word, start = text[sign] + word, sign
            else:
                yield text[sign], sign
            sign = None
        elif word in ("+", "-") and before in _BEFORE_SIGNS:
            sign, before = start, word
            continue
        yield word, start
        before = word
    if sign is not None:
        yield text[sign], sign


def _taken(line: str, end: str) -> str:
    return line[: len(line) - len(_end(line))] + end


def _end(line: str) -> str:
    return line[len(line.rstrip("\r\n")) :]


def _text(data: bytes, form: StoredForm, digits: int | None = None, mark: str = "") -> _Text:
    source = decode(data, None, _ENCODINGS)
    lines = ended_lines(source.text)
    known = {line: _word_key(line, source.encoding, form, digits, mark) for line in set(lines)}
    return _Text(lines, [known[line] for line in lines], source.encoding)


def _word_key(line: str, encoding: str, form: StoredForm, digits: int | None, mark: str) -> _Key:
    with suppress(Refused):  # a line alone may be no program
        line = form(line.encode(encoding)).decode(encoding, "replace")
    return tuple(_line_form(word, digits) for word, _ in _words(line, mark))


def _line_form(word: str, digits: int | None = None) -> str | float:
    if not _NUMBER.match(word):
        return word
    return float(word) if digits is None else round(float(word), digits)


def _bytes(lines: Sequence[str], encoding: str) -> bytes:
    return "".join(lines).encode(encoding)


_ABSENT_FILE: Final = "/dev/null"
"""Name of a missing program in a unified difference."""


def difference(before: bytes | None, after: bytes | None, one: str, other: str) -> str:
    """Return a unified diff of two versions of a program, "" if equal. one, other: labels."""
    left, right = _shown_lines(before or b""), _shown_lines(after or b"")
    origin = one if before is not None else _ABSENT_FILE
    target = other if after is not None else _ABSENT_FILE
    lines = difflib.unified_diff(left, right, origin, target, lineterm="")
    return "".join(f"{line}\n" for line in lines)


def _shown_lines(data: bytes) -> list[str]:
    """The lines, with no character in them that a terminal would obey."""
    lines = lines_of(decode(data, None, _ENCODINGS).text)
    return [visible(line) for line in lines if line]
