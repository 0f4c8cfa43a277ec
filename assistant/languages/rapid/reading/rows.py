r"""Long runs of alike lines read into columns: declared robtargets and plain moves.

    CONST robtarget p1:=[[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    MoveL p1,v100,z10,tool0\WObj:=table;
    MoveL [[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;

A regular expression bounds a run and its words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from assistant.base.columns import Slots
from assistant.languages.rapid.tables.words import LONGEST_NAME, RESERVED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import (
    CIRCULAR,
    FEWEST_IN_RUN,
    JOINT,
    LINEAR,
    TARGET_GROUPS,
    TARGET_PARTS,
    MotionNames,
    MoveRun,
    TargetRun,
)
from assistant.languages.runs.columns import Names, Store
from assistant.languages.runs.row_text import MOST, Found, Marks, entries, line_spans, stretches
from assistant.languages.runs.row_text import NameWords as Spelling

_B = r"[ \t]"
_NAME = r"[A-Za-z][A-Za-z0-9_]*+"
_SLOT = rf"{_B}*+[-+0-9.eE]++{_B}*+"
_EOL = rf";{_B}*+(?:\r?\n|\Z)"


def _slots(count: int) -> str:
    return r"\[" + ",".join([_SLOT] * count) + r"\]"


_WIDE = r"\[\[[-+0-9.eE,\[\]]++"
"""A value without blanks; that its brackets and commas stand right is seen in the columns."""
_SPACED = r"\[" + ",".join(_slots(stop - start) for start, stop in TARGET_PARTS) + r"\]"
_DECLARED = rf"{_B}++{_NAME}{_B}*+:={_B}*+(?:{_WIDE}{_EOL}|{_SPACED}{_EOL})"
_TARGET_HEAD = rf"(?P<head>(?:LOCAL{_B}++)?+CONST{_B}++robtarget)"
_SETTINGS = rf"{_B}*+,{_B}*+".join([_NAME] * 3)
_FRAME = rf"(?:{_B}*+,?+{_B}*+\\WObj{_B}*+:={_B}*+{_NAME})?+{_B}*+{_EOL}"
_TAIL = rf"{_B}*+,{_B}*+{_SETTINGS}{_FRAME}"
_MOVE = rf"{_B}*+Move(?:[JL]{_B}++{_NAME}|C{_B}++{_NAME}{_B}*+,{_B}*+{_NAME}){_TAIL}"
_INLINE = rf"{_B}*+Move[JL]{_B}*+(?:{_WIDE}(?<=\],){_SETTINGS}{_FRAME}|{_SPACED}{_TAIL})"
_REST = f"{{{FEWEST_IN_RUN - 1},{MOST - 1}}}+"
_ALL = f"{{{FEWEST_IN_RUN},{MOST}}}+"

_RUNS: Final = re.compile(
    rf"^(?:{_B}*+{_TARGET_HEAD}{_DECLARED}(?:{_B}*+(?P=head){_DECLARED}){_REST}"
    rf"|(?P<moves>(?:{_MOVE}){_ALL})|(?P<inline>(?:{_INLINE}){_ALL}))",
    re.MULTILINE,
)
_BLANKS: Final = b" \t\r\n"
_NAME_SPELLING: Final = Spelling(LONGEST_NAME, RESERVED)
_MOVE_KINDS: Final = np.zeros(256, dtype=np.uint8)
_MOVE_KINDS[ord("C")], _MOVE_KINDS[ord("J")], _MOVE_KINDS[ord("L")] = CIRCULAR, JOINT, LINEAR


RunNode: TypeAlias = s.TargetRunNode | s.MoveRunNode
Runs: TypeAlias = Sequence[Found[RunNode]]


def find_runs(text: str) -> Iterator[Found[RunNode]]:
    """The runs of a text, in order; rows that are not exactly plain are left out."""
    store = Store(text.count(";"), TARGET_PARTS[-1][1])
    for match in _RUNS.finditer(text):
        head, inline = match["head"], match["inline"] is not None
        read: Callable[[bytes], RunNode] = partial(_move_run, store, inline)
        if head is not None:
            read = partial(_target_run, store, head)
        yield from stretches(text, *match.span(), FEWEST_IN_RUN, store, read)


# Rows without blanks, one behind the other


def _target_run(store: Store, head: str, data: bytes) -> s.TargetRunNode:
    """head: what stands before each name."""
    text = Slots(data.translate(None, _BLANKS))
    marks = Marks(text, b"=,", b";")
    values = store.take(len(marks.rows))
    equals = marks.offsets[marks.first]
    TARGET_GROUPS.read(text, marks, 1, equals + 1, b";", values)
    starts = marks.rows + len(re.sub(r"\s", "", head))
    scope = "LOCAL" if head.startswith("LOCAL") else ""
    names = _NAME_SPELLING.names(text, starts, equals - len(":"))
    return s.TargetRunNode(scope, TargetRun(names, values), rows=line_spans(data, b";", ended=True))


def _move_run(store: Store, inline: bool, data: bytes) -> s.MoveRunNode:
    text = Slots(data.translate(None, _BLANKS))
    marks = Marks(text, b",", b";")
    kinds = _MOVE_KINDS[text.bytes[marks.rows + len("Move")]]
    names = vias = Names.none(len(kinds))
    begins, values = marks.rows + len("MoveL"), None
    if inline:
        values = store.take(len(kinds))
        ends = TARGET_GROUPS.read(text, marks, 0, begins, b",", values)
    else:
        circular = kinds == CIRCULAR
        first, ends = marks.offsets[marks.first], marks.offsets[marks.first + circular]
        if circular.any():
            at = np.flatnonzero(circular)
            vias = _NAME_SPELLING.names(text, begins[at], first[at]).spread(at, len(kinds))
            begins = np.where(circular, first + 1, begins)
        names = _NAME_SPELLING.names(text, begins, ends)
    motions = entries(text, ends + 1, marks.stops, 4 * LONGEST_NAME + 24, _motion_names)
    run = MoveRun(kinds, names, vias, motions, values)
    return s.MoveRunNode(run, rows=line_spans(data, b";", ended=False))


def _motion_names(tail: bytes) -> MotionNames:
    speed, zone, tool, *frame = re.findall(r"[A-Za-z]\w*", tail.decode("ascii"))
    names = (speed, zone, tool, *frame[1:])
    if any(len(name) > LONGEST_NAME or name.lower() in RESERVED for name in names):
        raise ValueError("a word is no name")
    return MotionNames(speed, zone, tool, frame[1] if frame else "")
