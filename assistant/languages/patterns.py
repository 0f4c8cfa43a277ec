r"""Rows of a language: a word with its arguments, and the record of the same meaning, both ways.

    Row("WaitUntil {condition} \MaxTime:={timeout?}", WaitUntil)
    Row("AccSet {acceleration}, 100", SetAcceleration, deceleration=Name("{acceleration}"))

A pattern is the word and its arguments, which may be patterns themselves, `Word(…)`; a backslash
begins an option. Braces enclose a slot: the field of the record with that value. A colon separates
the name from the slot's kind, if the kind is not the name, and from further details that a language
needs. `?` marks an optional slot, and `=` gives the value of a missing number. Fields that a
pattern does not express follow the pattern, and may name slots in turn; a field that is not given
has its default.

A language states the parts of its tree, a `Medium`, once for reading and once for writing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, fields
from typing import Any, Final, Generic, TypeVar

from assistant.base.data_classes import dataclass
from assistant.program.expressions import Apply, Name, Number
from assistant.program.rewriting import records, rewrite
from assistant.program.statements import Motion

N = TypeVar("N")


@dataclass(frozen=True, slots=True)
class Called(Generic[N]):
    """A word with its arguments.

    given: None for one that is left out. options: by name, None for a mere switch. leading: whether
    options stand before the other arguments.
    """

    word: str
    given: Sequence[N | None] = ()
    options: Mapping[str, N | None] = field(default_factory=dict)
    leading: bool = False


@dataclass(frozen=True, slots=True)
class Slot:
    """A place in a pattern. kind, of: see above. default: None for none."""

    name: str
    kind: str
    of: str = ""
    optional: bool = False
    default: Number | None = None

    @property
    def may_miss(self) -> bool:
        return self.optional or self.default is not None


@dataclass(frozen=True, slots=True)
class Pattern:
    """options: None for a mere switch, which must be there. leading: see `Called`.

    key, known: the word, and the options by name, in lower case.
    """

    word: str
    given: tuple[Slot | Pattern | Number, ...]
    options: Mapping[str, Slot | None]
    leading: bool = False
    key: str = field(init=False)
    known: Mapping[str, Slot | None] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "key", self.word.lower())
        known = {name.lower(): slot for name, slot in self.options.items()}
        object.__setattr__(self, "known", known)

    def has(self, options: Mapping[str, object]) -> bool:
        """True if the options, by lower-case name, fit the pattern, with or without a value."""
        for name, slot in self.known.items():
            # A mere switch has to be there; an option is given with a value if its slot wants one.
            if (slot is None and name not in options) or (
                name in options and (slot is None) != (options[name] is None)
            ):
                return False
        return options.keys() <= self.known.keys()


Read = Callable[[N, Slot], Any]
"""Returns the value of a node in a slot, None if the node does not have a value of that kind."""
Write = Callable[[Any, Slot], "N | None"]
"""Returns the node for a value, None if the value does not fit the slot."""


@dataclass(frozen=True, slots=True)
class Reading(Generic[N]):
    """Functions with which a language reads its rows.

    kinds: of slots; `value` is any expression. opened: returns the call that a node is. number:
    returns the literal that it is. A language gives those of these that its rows have as arguments.
    """

    kinds: Mapping[str, Read[N]]
    opened: Callable[[N], Called[N] | None] = lambda _: None
    number: Callable[[N], float | None] = lambda _: None

    def fields(self, pattern: Pattern, called: Called[N]) -> dict[str, Any] | None:
        """Return the values of a pattern's slots, None if the call does not match the pattern."""
        given, missing = called.given, pattern.given[len(called.given) :]
        if called.word.lower() != pattern.key or len(given) > len(pattern.given):
            return None
        options = {name.lower(): node for name, node in called.options.items()}
        if (options or pattern.known) and not pattern.has(options):
            return None
        # Only slots at the end may be left out of the arguments.
        if not all(isinstance(part, Slot) and part.may_miss for part in missing):
            return None
        found: dict[str, Any] = {}
        for part, node in zip(pattern.given, (*given, *[None] * len(missing)), strict=True):
            if not self._take(part, node, found):
                return None
        for name, slot in pattern.known.items():
            if slot is not None and not self._take(slot, options.get(name), found):
                return None
        return found

    def _take(self, part: Slot | Pattern | Number, node: N | None, found: dict[str, Any]) -> bool:
        """Try to match a node with a part of a pattern; on success put its values into `found`."""
        value: Any = None
        match part:
            case Slot(name, default=default) if node is None:
                value = default
                if value is None:
                    return part.optional
            case Slot(name, kind) if node is not None:
                value = self.kinds.get(kind, self.kinds["value"])(node, part)
            case Pattern() if node is not None:
                called = self.opened(node)
                inner = None if called is None else self.fields(part, called)
                found.update(inner or {})
                return inner is not None
            case Number(wanted) if node is not None:
                return self.number(node) == wanted
            case _:
                return False
        found[name] = value
        return value is not None


@dataclass(frozen=True, slots=True)
class Writing(Generic[N]):
    """Functions with which a language writes its rows. made: node of a call. number: of a literal.

    A language gives those of these that its rows have as arguments.
    """

    kinds: Mapping[str, Write[N]]
    made: Callable[[Called[N]], N | None] = lambda _: None
    number: Callable[[float], N | None] = lambda _: None

    def called(self, pattern: Pattern, said: Mapping[str, Any]) -> Called[N] | None:
        """The call with the values of its slots, None if one does not fit."""
        given = [self._part(part, said) for part in pattern.given]
        options: dict[str, N | None] = {}
        for name, slot in pattern.options.items():
            node = None if slot is None else self._part(slot, said)
            if node is not None or slot is None:
                options[name] = node
            elif not slot.optional:
                return None
        return None if None in given else Called(pattern.word, given, options, pattern.leading)

    def _part(self, part: Slot | Pattern | Number, said: Mapping[str, Any]) -> N | None:
        match part:
            case Slot(name, kind):
                value = said.get(name)
                write = self.kinds.get(kind, self.kinds["value"])
                return None if value is None else write(value, part)
            case Pattern():
                inner = self.called(part, said)
                return None if inner is None else self.made(inner)
            case Number(value):
                return self.number(value)


class Row:
    """A pattern of a language and the record that it stands for."""

    def __init__(self, text: str, record: type[Any], **fixed: object) -> None:
        self.pattern = pattern(text)
        self.record, self.fixed = record, fixed
        self.key: object = record
        self._defaults = {f.name: f.default for f in fields(record) if f.compare}
        named = {slot.name for slot in slots(self.pattern)}
        # Fields that the pattern does not express must have the value that reading gives them.
        self._unsaid = tuple(name for name in self._defaults if name not in named)
        self._fills = any(isinstance(part, Name) for x in fixed.values() for part in records(x))

    def said(self, found: Mapping[str, Any]) -> Any:
        """The record with what was found in the slots."""
        own = {name: value for name, value in found.items() if name in self._defaults}
        return self.record(**own, **self._filled(found))

    def slots(self, record: Any) -> dict[str, Any] | None:
        """Return the values of a record for the slots, None if the row cannot express it."""
        given = {name: getattr(record, name) for name in self._defaults}
        fixed = self._filled(given)
        for name in self._unsaid:
            if given[name] != fixed.get(name, self._defaults[name]):
                return None
        return given

    def _filled(self, found: Mapping[str, Any]) -> Mapping[str, Any]:
        def fill(x: Any) -> Any:
            return found.get(x.name[1:-1], x) if isinstance(x, Name) else x

        if not self._fills:
            return self.fixed
        return {name: rewrite(value, fill) for name, value in self.fixed.items()}


class FunctionRow(Row):
    """A function: its arguments fill the slots in their order."""

    def __init__(self, function: str, text: str) -> None:
        super().__init__(text, Apply, function=function)
        self.key = function
        self._names = [slot.name for slot in slots(self.pattern)]

    def said(self, found: Mapping[str, Any]) -> Any:
        return Apply(str(self.key), tuple(found[name] for name in self._names))

    def slots(self, record: Any) -> dict[str, Any] | None:
        if len(record.arguments) != len(self._names):
            return None
        return dict(zip(self._names, record.arguments, strict=True))


class MotionRow(Row):
    """A move, with the parts of its motion in slots of their names.

    A part that is missing has its default. What the move sets on its way stands elsewhere.
    """

    def __init__(self, text: str, record: type[Any], **fixed: object) -> None:
        super().__init__(text, record, **fixed)
        # The parts of the motion have slots of their own.
        self._unsaid = tuple(name for name in self._unsaid if name != "motion")
        named = {slot.name for slot in slots(self.pattern)}
        self._usual = [(x.name, x.default) for x in fields(Motion) if x.name not in named]

    def said(self, found: Mapping[str, Any]) -> Any:
        stated = {x.name: found[x.name] for x in fields(Motion) if found.get(x.name) is not None}
        return super().said({**found, "motion": Motion(**stated)})

    def slots(self, record: Any) -> dict[str, Any] | None:
        given = super().slots(record)
        if given is None or any(getattr(record.motion, name) != x for name, x in self._usual):
            return None
        return given | {x.name: getattr(record.motion, x.name) for x in fields(Motion)}


class Rows:
    """Rows in their order: the first that fits is the one.

    also: rows that are read as well, but never written. written: words, in lower case, and records:
    their types, of those that are.
    """

    def __init__(self, *rows: Row, also: Sequence[Row] = ()) -> None:
        self._by_word: dict[str, list[Row]] = {}
        self._by_key: dict[object, list[Row]] = {}
        for row in (*rows, *also):
            self._by_word.setdefault(row.pattern.word.lower(), []).append(row)
        for row in rows:
            self._by_key.setdefault(row.key, []).append(row)
        self.written = frozenset(row.pattern.word.lower() for row in rows)
        self.records = frozenset(row.record for row in rows)

    def __contains__(self, word: str) -> bool:
        """True if a row begins with a word, in lower case."""
        return word in self._by_word

    def read(self, called: Called[N], reading: Reading[N]) -> Any:
        """Return the record of a call, None if no row matches it."""
        for row in self._by_word.get(called.word.lower(), ()):
            found = reading.fields(row.pattern, called)
            if found is not None:
                return row.said(found)
        return None

    def write(self, record: Any, writing: Writing[N]) -> Called[N] | None:
        """The call that says a record, None if no row does."""
        key = record.function if isinstance(record, Apply) else type(record)
        for row in self._by_key.get(key, ()):
            said = row.slots(record)
            called = None if said is None else writing.called(row.pattern, said)
            if called is not None:
                return called
        return None


def slots(pattern: Pattern) -> Iterator[Slot]:
    """The slots of a pattern in the order of its text."""
    for part in (*pattern.given, *pattern.options.values()):
        if isinstance(part, Slot):
            yield part
        elif isinstance(part, Pattern):
            yield from slots(part)


# --------------------------------------------------------------------------------- their text


_TOKEN: Final = re.compile(
    r"""[\s,]*(?:
        \{(?P<slot>\w+)(?::(?P<kind>\w+)(?:\s(?P<of>[\w\s]+))?)?(?P<optional>\?)?
            (?:=(?P<default>[\d.]+))?\}
        | \\(?P<option>\w+)(?P<valued>:=)? | (?P<number>[\d.]+) | (?P<word>\w+)(?P<opens>\()?
        | (?P<closes>\))
    )""",
    re.VERBOSE,
)


def pattern(text: str) -> Pattern:
    """The pattern that a text says."""
    made = [*_parts(_TOKEN.finditer(text))]
    word = re.match(r"\w+", text)
    assert word is not None
    if len(made) == 1 and isinstance(made[0][1], Pattern):
        return made[0][1]
    return _pattern(word[0], made[1:])


def _pattern(word: str, parts: Sequence[tuple[str, Any]]) -> Pattern:
    given = tuple(part for option, part in parts if not option)
    options = {option: part for option, part in parts if option}
    return Pattern(word, given, options, leading=bool(parts and parts[0][0]))


def _parts(tokens: Iterator[re.Match[str]]) -> Iterator[tuple[str, Any]]:
    """Arguments up to the bracket that closes them, each with the name of its option."""
    option = ""
    # An inner pattern takes tokens of the same iterator up to its bracket.
    for token in tokens:
        if token["closes"]:
            return
        if token["option"]:
            if not token["valued"]:
                yield token["option"], None
            option = token["option"] if token["valued"] else ""
            continue
        if token["slot"]:
            slot, kind = token["slot"], token["kind"] or token["slot"]
            default = Number(_number(token["default"])) if token["default"] else None
            yield option, Slot(slot, kind, token["of"] or "", bool(token["optional"]), default)
        elif token["number"]:
            yield option, Number(_number(token["number"]))
        elif token["opens"]:
            yield option, _pattern(token["word"], [*_parts(tokens)])
        else:
            yield option, Pattern(token["word"], (), {})
        option = ""


def _number(text: str) -> float:
    return int(text) if text.isdigit() else float(text)
