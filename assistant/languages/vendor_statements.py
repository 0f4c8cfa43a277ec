"""Vendor statements: why they stay text, what their text is parsed as, what it does.

Reasons that no single vendor's words explain, for statements that have no equivalent in the neutral
program; the parsed nodes of vendor text, remembered from one pass to the next; and the effects of
that text (data read and written, calls, motion, jumps) from a table with a row for each kind of
node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.base.source_text import words_of
from assistant.program.expressions import Effect, EffectBuilder, Verbatim
from assistant.program.statements import Opaque, Reason
from assistant.program.vendor_statements import VendorText

SETTINGS_DIFFER: Final = Reason(
    "its settings differ with the way that leads here", "set them where the ways meet"
)
NO_EQUIVALENT: Final = Reason(
    "no statement of other languages says it", "say it in plain statements"
)
CONTROLLER_STATE: Final = Reason(
    "it reads or writes a state of the controller itself", "keep the state in a variable of its own"
)
DEPENDED_ON: Final = Reason(
    "something below depends on this setting and stays as its text",
    "see to that first",
    serves=True,
)
NOT_FIRST: Final = Reason(
    "it ends a called program from within a subroutine", "set a variable and return, end above"
)
ENDS_CYCLE: Final = Reason(
    "it ends the cycle of the whole program from within a subroutine",
    "set a variable and return, ask for it in the main program, end there",
)
INTERRUPTS: Final = Reason(
    "it belongs to an interrupt, which works beside the program",
    "write the interrupt in the other language, or ask for the signal where it matters",
)
TASKS: Final = Reason(
    "it controls programs that run beside this one",
    "let the cell's controller start them, or say it in the other language",
)
CAMERAS: Final = Reason(
    "it talks to a camera in the maker's own protocol",
    "read the camera over a line in the other language",
)
COMMUNICATION: Final = Reason(
    "it talks over a line or to a file", "write the communication in the other language"
)
COMPLIANCE: Final = Reason(
    "it makes the arm soft or asks for force, which each maker does in an own way",
    "use the other robot's soft or force control",
)
CONVEYORS: Final = Reason(
    "it follows a conveyor in the maker's own way", "use the other robot's conveyor tracking"
)
TUNING: Final = Reason(
    "it sets how the controller watches or tunes the arm",
    "leave it out, or set the other's own",
)
SERVO: Final = Reason("it switches motors or brakes", "leave that to the operator")


_SHOWN_CHARACTERS: Final = 60
"""Characters of a text that a finding shows."""
_MOST_REMEMBERED: Final = 1 << 14
"""Texts that are remembered."""


class ParsedTexts:
    """Parsed vendor texts: lifting, adapting, naming and building each need the same ones.

    unreadable: the rule for a text that is not of the language; it names `text` and `why`.
    """

    def __init__(self, unreadable: Rule) -> None:
        self._unreadable = unreadable
        self._known: dict[tuple[str, str], tuple[Any, ...]] = {}

    def known(self, kind: str, text: str) -> tuple[Any, ...] | None:
        """The nodes of a text that was read or remembered as of a kind."""
        return self._known.get((kind, text))

    def read(
        self, kind: str, text: str, parse: Callable[[str], tuple[Any, ...] | Diagnostic]
    ) -> tuple[Any, ...]:
        """The nodes of a text; raises Refused if it cannot be parsed."""
        known = self.known(kind, text)
        if known is not None:
            return known
        read = parse(text)
        if isinstance(read, Diagnostic):
            raise self.refused(text, read.message)
        self.remember(kind, text, read)
        return read

    def remember(self, kind: str, text: str, nodes: tuple[Any, ...]) -> str:
        """The text, which says these nodes."""
        # Emptied as a whole, which is simpler than dropping the oldest, and the texts at hand come
        # back soon.
        if len(self._known) >= _MOST_REMEMBERED:
            self._known.clear()
        self._known[kind, text] = nodes
        return text

    def refused(self, text: str, why: str) -> Refused:
        return Refused(self._unreadable(text=text[:_SHOWN_CHARACTERS], why=why))


def foreign_text_fields(kept: VendorText, language: str) -> dict[str, Any]:
    """Return the fields of a finding on the text of another language: `language`, `text`, `cure`.

    language: the title of the language that is written.
    """
    text = kept.text if len(kept.text) <= _SHOWN_CHARACTERS else kept.text[:_SHOWN_CHARACTERS] + "…"
    reason = kept.reason if isinstance(kept, Opaque | Verbatim) else None
    if reason is None:
        cure = f"write it in the pseudo-program or in {language}"
        return {"language": kept.language, "text": text, "cure": cure}
    return {"language": kept.language, "text": f"{text}; {reason.why}", "cure": reason.cure}


Fields = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NodeEffect:
    """Effect of a node, without the nodes in it.

    reads, writes, calls, declares: fields with texts, or with nodes of data, that are named there.
    words: fields with texts whose words may be names. untold: it may do anything.
    """

    reads: Fields = ()
    writes: Fields = ()
    calls: Fields = ()
    declares: Fields = ()
    words: Fields = ()
    moves: bool = False
    jumps: bool = False
    waits: bool = False
    untold: bool = False


class UnknownEffect(Exception):
    """The callee of a node is computed at run time: it may do anything."""


Take = Callable[[EffectBuilder, Any], None]
"""Puts into an effect what a node does; raises UnknownEffect."""


class Effects:
    """Effects of the nodes of one language.

    nodes: returns those in a node or in several. named: the data that a node is, or is a part of,
    None for other nodes. rows: effects by type of node; other nodes have no effect.
    """

    def __init__(
        self,
        nodes: Callable[[Any], Iterable[Any]],
        named: Callable[[Any], str | None],
        rows: Mapping[type, NodeEffect | Take],
    ) -> None:
        self._nodes, self._named = nodes, named
        self._takes = {
            k: self._take(r) if isinstance(r, NodeEffect) else r for k, r in rows.items()
        }

    def of(self, tree: Any) -> Effect | None:
        """Return the effect of a node or several, None if it is unknown."""
        done = EffectBuilder()
        try:
            for node in self._nodes(tree):
                take = self._takes.get(type(node))
                if take is not None:
                    take(done, node)
        except UnknownEffect:
            return None
        return done.effect()

    def names(self, *values: Any) -> Iterator[str]:
        """Yield the names in texts and of nodes of data."""
        for value in values:
            if isinstance(value, str):
                yield value
            elif isinstance(value, tuple):
                yield from self.names(*value)
            elif name := self._named(value):
                yield name

    def _take(self, row: NodeEffect) -> Take:
        def take(done: EffectBuilder, node: Any) -> None:
            if row.untold:
                raise UnknownEffect
            done.reads.update(*(self.names(getattr(node, field)) for field in row.reads))
            done.writes.update(*(self.names(getattr(node, field)) for field in row.writes))
            done.calls.update(*(self.names(getattr(node, field)) for field in row.calls))
            for field in row.declares:
                done.declare(*self.names(getattr(node, field)))
            for field in row.words:
                done.reads.update(words_of(getattr(node, field)))
            done.moves |= row.moves
            done.jumps |= row.jumps
            done.waits |= row.waits

        return take
