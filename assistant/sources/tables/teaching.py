"""A target more in a file of taught targets, or one taught anew; nothing else of it changes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.base.diagnostics import Refused, Span, error
from assistant.base.source_text import SourceText
from assistant.base.toml_text import key_spans, parse_toml, value_spans
from assistant.program.program import identifier
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import read_toml
from assistant.sources.reading import Reading
from assistant.sources.tables.taught import ORIENTATIONS, read_taught

NO_NAME: Final = error(
    "TB507",
    "`{name}` cannot name a target",
    "write {known}, or another name of letters and digits with `_` between them, a letter first",
)
TARGETS_IN_BRACKETS: Final = error(
    "TB508",
    "the targets stand in brackets, where none can be added",
    "write [[targets]] above each of them",
)
TARGET_EXISTS: Final = error(
    "TB509", "there is a target `{name}` already", "choose another name, or ask to teach it anew"
)
OTHER_ROBOT: Final = error(
    "TB510",
    "the targets were taught on `{there}`, and this one is of `{given}`",
    "name another file: joints and branches of one arm mean nothing to another one",
)
EXTERNAL_AXES: Final = error(
    "TB511",
    "`{name}` has external axes, and the controller tells no position of them",
    "give it another name, or take `external` out",
)
NO_ROBOT: Final = error(
    "TB512",
    "joints mean a place of one arm, and the file names none",
    'write robot = "{robot}" as its first line',
)

POSE_KEYS: Final = ("position", "quaternion", "configuration")
JOINT_KEYS: Final = ("joints",)


@dataclass(frozen=True, slots=True)
class TaughtTarget:
    """A target as a file of targets says it.

    values: TOML by key, of POSE or of JOINTS, in their order. more: tool and frame, which only
    a new target gets. robot: that it was taught on, None if nobody knows.
    """

    name: str
    values: Mapping[str, str]
    more: Mapping[str, str]
    robot: str | None = None


def new_file_text(robot: str | None) -> str:
    """The text of a file before its first target."""
    return "" if robot is None else f"robot = {json.dumps(robot)}\n"


def with_target(
    source: SourceText,
    stem: str,
    target: TaughtTarget,
    process: Process = NO_PROCESS,
    *,
    again: bool = False,
) -> tuple[SourceText, Reading]:
    """The text with the target, and what it reads as. again: one of its name is taught anew.

    Raises Refused and Unreadable; what the text says of all else stays to the letter.
    """
    if (known := identifier(target.name)) != target.name:
        raise Refused(NO_NAME(path=source.path, name=target.name, known=known))
    content = read_toml(source).content
    there = content.get("robot", process.robot)
    if target.robot is not None and there not in (None, target.robot):
        raise Refused(OTHER_ROBOT(path=source.path, there=there, given=target.robot))
    if "joints" in target.values and there is None:
        named = target.robot or "NAME"
        raise Refused(NO_ROBOT(path=source.path, robot=named))
    entries = content.get("targets", [])
    number = _entry_number(entries, target.name)
    if number is None:
        text = _with_added_target(source, target)
    elif again:
        text = _Reteaching(source, number, entries[number], target).text()
    else:
        span = key_spans(source.text).get(("targets", str(number)), Span(0, 0))
        raise Refused(source.finding(TARGET_EXISTS, span, name=target.name))
    changed = replace(source, text=text)
    return changed, read_taught(changed, stem, process)


def _entry_number(entries: Any, name: str) -> int | None:
    """Number of the target of a name, compared without case."""
    if not isinstance(entries, list):
        return None
    named = (e.get("name") if isinstance(e, dict) else None for e in entries)
    same = (i for i, n in enumerate(named) if isinstance(n, str) and n.lower() == name.lower())
    return next(same, None)


def _is_in_brackets(source: SourceText) -> bool:
    span = key_spans(source.text).get(("targets",))
    return span is not None and not source.text[: span.start].rstrip(" \t").endswith("[[")


def _with_added_target(source: SourceText, target: TaughtTarget) -> str:
    if _is_in_brackets(source):
        raise Refused(
            source.finding(
                TARGETS_IN_BRACKETS, key_spans(source.text)[("targets",)], name=target.name
            )
        )
    end, text = source.newline, source.text
    before = "" if not text else end if text.endswith(end) else end + end
    lines = ["[[targets]]", f'name = "{target.name}"']
    lines += [f"{key} = {value}" for key, value in (*target.values.items(), *target.more.items())]
    return text + before + "".join(line + end for line in lines)


class _Reteaching:
    """Changes the place of one entry and leaves what else it says: its speed, its comments."""

    def __init__(
        self, source: SourceText, number: int, entry: Mapping[str, Any], target: TaughtTarget
    ) -> None:
        self.source, self.entry, self.target = source, entry, target
        self.path = ("targets", str(number))
        self.keys, self.values = key_spans(source.text), value_spans(source.text)

    def text(self) -> str:
        name = self.target.name
        if _is_in_brackets(self.source):
            raise Refused(self.source.finding(TARGETS_IN_BRACKETS, self.keys[self.path], name=name))
        if "external" in self.entry:
            span = self.keys[*self.path, "external"]
            raise Refused(self.source.finding(EXTERNAL_AXES, span, name=name))
        # In its place among the others: a new value behind an old one of the same meaning.
        olds = {key for key in (*POSE_KEYS, *ORIENTATIONS, *JOINT_KEYS) if key in self.entry}
        rest = dict(self.target.values)
        edits: list[tuple[Span, str]] = []
        at = self._line(Span(self.keys[*self.path, "name"].start, self._end("name"))).end
        for key in sorted(olds, key=lambda one: self.keys[*self.path, one].start):
            pair = Span(self.keys[*self.path, key].start, self._end(key))
            line = self._line(pair)
            taken = self._successor(key, rest)
            if taken is None:
                edits.append((line, ""))
                continue
            # A comment behind the value tells of it, and may be wrong for another kind of value.
            kept = pair if taken == key else Span(pair.start, self._without_end(line))
            edits.append((kept, f"{taken} = {rest.pop(taken)}"))
            at = line.end
        if rest:
            newline = self.source.newline
            lines = "".join(f"{key} = {value}{newline}" for key, value in rest.items())
            edits.append((Span(at, at), lines if self._ends(at) else newline + lines))
        text = self.source.text
        for span, new in sorted(edits, key=lambda edit: edit[0].start, reverse=True):
            text = text[: span.start] + new + text[span.end :]
        return text

    def _end(self, key: str) -> int:
        return self.values[*self.path, key].end

    def _ends(self, at: int) -> bool:
        return self.source.text[:at].endswith("\n")

    def _without_end(self, line: Span) -> int:
        text = self.source.text[line.start : line.end]
        return line.start + len(text.rstrip("\r\n"))

    def _successor(self, key: str, rest: Mapping[str, str]) -> str | None:
        """What takes the place of a key: the same, or what says the same in other words."""
        if key in rest:
            return key
        if key in ORIENTATIONS and "quaternion" in rest and "quaternion" not in self.entry:
            return "quaternion"
        places = ("position", "joints")
        return next((p for p in places if key in places and p in rest), None)

    def _line(self, pair: Span) -> Span:
        """The whole lines of a pair, with a comment behind it."""
        text = self.source.text
        start = text.rfind("\n", 0, pair.start) + 1
        end = text.find("\n", pair.end)
        return Span(start, len(text) if end < 0 else end + 1)


def is_otherwise_equal(before: str, after: str, name: str) -> bool:
    """Whether a text says of all but one target what another one says."""
    return _without_target(before, name) == _without_target(after, name)


def _without_target(text: str, name: str) -> str:
    content = parse_toml(text)
    entries = content.get("targets", [])
    number = _entry_number(entries, name)
    kept = [entry for i, entry in enumerate(entries) if i != number]
    return repr({**content, "targets": kept})  # by text: numbers that are none equal no others
