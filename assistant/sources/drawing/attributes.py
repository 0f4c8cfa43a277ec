"""Attributes of inserts: which tags mean what, and the values of a location.

| meaning      | default tags    | value                                                      |
|--------------|-----------------|------------------------------------------------------------|
| name         | NAME            | name of the location; without it the block's and a number   |
| order        | ORDER SEQUENCE  | number; locations are visited in its order                  |
| x_rotation   | RX A            | degrees about x                                             |
| y_rotation   | RY B            | degrees about y                                             |
| z_rotation   | RZ C            | degrees about z                                             |
| convention   | EULER           | ZYX (default): R = Rz·Ry·Rx, or XYZ: R = Rx·Ry·Rz           |
| q1 q2 q3 q4  | Q1 Q2 Q3 Q4     | unit quaternion, scalar first, instead of the angles        |
| speed        | SPEED           | mm/s along the path                                         |
| blend        | BLEND ZONE      | mm of corner rounding, or `fine`                            |
| tool         | TOOL            | a tool of the process file, or tool0                        |
| frame        | FRAME WOBJ      | a frame of the process file, or base                        |
| motion       | MOTION MOVE     | joint or linear                                             |

ZYX is what MELFA's A B C and RAPID's OrientZYX mean. Tags are compared without case; the table
`tags` of a process file replaces the default tags of a meaning by one. A blank value counts as
missing. Speeds and blends are in mm whatever the drawing's unit is.

A block is a location if one of its attributes has any of these tags. If it has only a name, an
order or a convention, and other attributes besides (as a title block has), it is not, and a
finding says so.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.program.motion import FINE, Blend
from assistant.sources.drawing.findings import (
    COMMA,
    NOT_A_NUMBER,
    NOT_FINITE,
    OUT_OF_RANGE,
    TWICE,
    UNKNOWN_MEANING,
    UNKNOWN_NAME,
    UNKNOWN_WORD,
    shown,
)

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.insert import Insert


W = TypeVar("W")


@dataclass(frozen=True, slots=True)
class TagMeaning:
    """tags: the default ones. decides: makes a block a location whatever else it carries."""

    tags: tuple[str, ...]
    decides: bool = True


TAG_MEANINGS: Final[Mapping[str, TagMeaning]] = {
    "name": TagMeaning(("NAME",), decides=False),
    "order": TagMeaning(("ORDER", "SEQUENCE"), decides=False),
    "x_rotation": TagMeaning(("RX", "A")),
    "y_rotation": TagMeaning(("RY", "B")),
    "z_rotation": TagMeaning(("RZ", "C")),
    "convention": TagMeaning(("EULER",), decides=False),
    "q1": TagMeaning(("Q1",)),
    "q2": TagMeaning(("Q2",)),
    "q3": TagMeaning(("Q3",)),
    "q4": TagMeaning(("Q4",)),
    "speed": TagMeaning(("SPEED",)),
    "blend": TagMeaning(("BLEND", "ZONE")),
    "tool": TagMeaning(("TOOL",)),
    "frame": TagMeaning(("FRAME", "WOBJ")),
    "motion": TagMeaning(("MOTION", "MOVE")),
}

ANGLES: Final = ("x_rotation", "y_rotation", "z_rotation")
QUATERNION: Final = ("q1", "q2", "q3", "q4")

_MOTION_WORDS: Final[Mapping[str, Literal["joint", "linear", "travel"]]] = {
    "joint": "joint",
    "movej": "joint",
    "mov": "joint",
    "ptp": "joint",
    "linear": "linear",
    "movel": "linear",
    "mvs": "linear",
    "lin": "linear",
    "travel": "travel",
}
"""Words for the type of motion, also those of the vendors' languages."""

_CONVENTIONS: Final[Mapping[str, Literal["ZYX", "XYZ"]]] = {"zyx": "ZYX", "xyz": "XYZ"}

_PLAIN_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NUMBER_WITH_COMMA: Final = re.compile(r"[+-]?\d*,\d+", re.ASCII)


@dataclass(frozen=True, slots=True)
class Tags:
    """Which meaning a tag has; made from the defaults and the process file's `tags`."""

    meanings: Mapping[str, str]
    """Tag in upper case → meaning."""

    @staticmethod
    def of(changed: Mapping[str, str], path: str) -> Tags:
        """Raises Refused for a meaning that there is not."""
        unknown = [m for m in changed if m not in TAG_MEANINGS]
        if unknown:
            known = ", ".join(TAG_MEANINGS)
            raise Refused(
                *(UNKNOWN_MEANING(path=path, meaning=shown(m), known=known) for m in unknown)
            )
        table = {
            tag: meaning
            for meaning, default in TAG_MEANINGS.items()
            if meaning not in changed
            for tag in default.tags
        }
        return Tags(table | {tag.strip().upper(): meaning for meaning, tag in changed.items()})

    def meaning(self, tag: str) -> str | None:
        return self.meanings.get(tag.strip().upper())

    def tag(self, meaning: str) -> str:
        """The tag to name in a finding about a value that is missing."""
        return next(tag for tag, m in self.meanings.items() if m == meaning)

    def make_location(self, tags: Iterable[str]) -> bool:
        """True if a block with these tags is a location (see above)."""
        given = [tag.strip() for tag in tags]
        found = [self.meaning(tag) for tag in given]
        known = [m for m in found if m is not None]
        # A single letter is what a symbol shows, such as that of a datum; angles come by three.
        if len(given) == 1 and len(given[0]) == 1 and known and known[0] in ANGLES:
            return False
        # Tags that do not decide need all others to be known: a title block has a NAME, too.
        return any(TAG_MEANINGS[m].decides for m in known) or bool(known and None not in found)


def texts_of(insert: Insert, document: Drawing) -> list[tuple[str, str]]:
    """Tag and text of each attribute of an insert, and of the constant ones of its block."""
    found = [
        (a.dxf.tag, a.plain_mtext() if a.has_embedded_mtext_entity else a.dxf.text)
        for a in insert.attribs
        if a.is_alive  # one that repair has dropped is a finding already
    ]
    # Constant attributes are stored in the block, not with its inserts.
    block = document.blocks.get(insert.dxf.name)
    if block is not None:
        there = {tag.strip().upper() for tag, _ in found}
        found += [
            (d.dxf.tag, d.dxf.text)
            for d in block.attdefs()
            if d.is_const and d.dxf.tag.strip().upper() not in there
        ]
    return found


@dataclass(slots=True)
class LocationValues:
    """The values of one location, by meaning; what is wrong with them goes into `findings`."""

    tags: Tags
    path: str
    place: str
    texts: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Meaning → tag and text, without blank ones."""
    unused: list[str] = field(default_factory=list)
    findings: list[Diagnostic] = field(default_factory=list)

    def take(self, texts: Iterable[tuple[str, str]]) -> None:
        """Sorts attributes by meaning."""
        for tag, text in texts:
            meaning = self.tags.meaning(tag)
            if meaning is None:
                self.unused.append(tag)
            elif text.strip():
                if meaning in self.texts:
                    self.say(TWICE, tag)
                self.texts[meaning] = tag, text.strip()

    def say(self, rule: Rule, tag: str = "", **fields: Any) -> None:
        place = f"{self.place} {shown(tag)}".strip()
        self.findings.append(rule(path=self.path, place=place, tag=shown(tag), **fields))

    def text(self, meaning: str) -> str:
        return self.texts.get(meaning, ("", ""))[1]

    def number(self, meaning: str) -> float | None:
        """A finite number; None, with a finding, for anything else, and for nothing."""
        if meaning not in self.texts:
            return None
        tag, text = self.texts[meaning]
        given = shown(text)
        if _NUMBER_WITH_COMMA.fullmatch(text):
            self.say(COMMA, tag, given=given, cure=given.replace(",", "."))
        elif _PLAIN_NUMBER.fullmatch(text):
            value = float(text)
            if math.isfinite(value):
                return value
            self.say(NOT_FINITE, tag, given=given)
        elif text.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            self.say(NOT_FINITE, tag, given=given)
        else:
            self.say(NOT_A_NUMBER, tag, given=given)
        return None

    def numbers(self, meanings: Iterable[str]) -> list[float] | None:
        """All of them, or None if one is missing or no number."""
        values = [self.number(m) for m in meanings]
        known = [v for v in values if v is not None]
        return known if len(known) == len(values) else None

    def speed(self) -> float | None:
        """mm/s."""
        value = self.number("speed")
        if value is None or value > 0:
            return value
        self._out_of_range("speed", "more than 0")
        return None

    def blend(self) -> Blend | None:
        """By its radius in mm; one of 0 is a stop."""
        if self.text("blend").lower() == "fine":
            return FINE
        value = self.number("blend")
        if value is None or value > 0:
            return None if value is None else Blend(value)
        if value < 0:
            self._out_of_range("blend", "0 or more")
        return FINE

    def kind(self) -> Literal["joint", "linear", "travel"] | None:
        return self._word("motion", _MOTION_WORDS)

    def convention(self) -> Literal["ZYX", "XYZ"]:
        return self._word("convention", _CONVENTIONS) or "ZYX"

    def name_of(self, meaning: str, known: Mapping[str, object]) -> str | None:
        """A declared name, spelled as it is declared."""
        if meaning not in self.texts:
            return None
        tag, text = self.texts[meaning]
        for name in known:
            if name.lower() == text.lower():
                return name
        self.say(UNKNOWN_NAME, tag, what=meaning, given=shown(text), known=", ".join(known))
        return None

    def _word(self, meaning: str, known: Mapping[str, W]) -> W | None:
        if meaning not in self.texts:
            return None
        tag, text = self.texts[meaning]
        if text.lower() not in known:
            self.say(UNKNOWN_WORD, tag, given=shown(text), known=", ".join(known))
        return known.get(text.lower())

    def _out_of_range(self, meaning: str, wanted: str) -> None:
        tag, text = self.texts[meaning]
        self.say(OUT_OF_RANGE, tag, given=shown(text), range=wanted)
