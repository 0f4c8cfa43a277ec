"""Programs that run together: the tasks or slots of a controller, and what is loaded in each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.source_text import SourceText
from assistant.languages import Language
from assistant.program.program import Program

NOT_RUN: Final = error(
    "VC201", "programs in {language} cannot be run here", "choose a program in {languages}"
)


@dataclass(frozen=True, slots=True)
class Group:
    """Files that are loaded together. name: of their task or slot.

    essential: whether the run goes on until it ends. beside: whether files that it calls are
    looked for in the folder of the first.
    """

    name: str
    files: tuple[str, ...]
    essential: bool = True
    beside: bool = True


@dataclass(frozen=True, slots=True)
class Part:
    """A task or slot with what is loaded in it.

    trees: of one language, the program first. names: of the programs, where they call each other.
    """

    name: str
    trees: tuple[Any, ...]
    names: tuple[str, ...] = ()
    essential: bool = True


@dataclass(frozen=True, slots=True)
class Programs:
    """What runs together: parts in one language, or a pseudo-program.

    title: as the user named it. language: None for the pseudo-program. text: of the pseudo-program,
    None where it comes from another source. findings: about what was read.
    """

    title: str
    language: Language[Any] | None = None
    parts: tuple[Part, ...] = ()
    program: Program | None = None
    text: SourceText | None = None
    findings: tuple[Diagnostic, ...] = ()

    def sources(self) -> list[SourceText]:
        """The texts that places are in."""
        trees = (tree for part in self.parts for tree in part.trees)
        found = [tree.source for tree in trees if tree.source is not None]
        return found if self.text is None else [self.text]

    def signals(self) -> frozenset[str] | None:
        """Names that the programs use for signals, and may use, in lower case; None for any."""
        if self.program is not None:
            return frozenset(name.lower() for name in self.program.signals)
        if self.language is None or self.language.family not in SIGNALS:
            return None
        return SIGNALS[self.language.family](self)


def groups(language: Language[Any], files: Sequence[str], folder: str | None) -> list[Group]:
    """The tasks or slots that files are loaded into; raises Refused where that is not clear.

    folder: that the files were found in, None where each was named.
    """
    return _grouping_of(language, GROUPS)(files, folder)


def _grouping_of(language: Language[Any], table: Mapping[str, Grouping]) -> Grouping:
    if language.family not in table:
        spoken = ", ".join(table)
        raise Refused(NOT_RUN(language=language.title, languages=spoken), exit_status=2)
    return table[language.family]


Grouping = Callable[[Sequence[str], str | None], list[Group]]


def _tasks(files: Sequence[str], folder: str | None) -> list[Group]:
    from assistant.virtual.rapid.tasks import rapid_tasks

    return rapid_tasks(files, folder)


def _slots(files: Sequence[str], folder: str | None) -> list[Group]:
    from assistant.virtual.melfa.loading import melfa_slots

    return melfa_slots(files, folder)


def _rapid_signals(programs: Programs) -> frozenset[str] | None:
    """All names that are used: what only an expression reads may be a signal as well."""
    from assistant.languages.rapid.tree import syntax
    from assistant.languages.rapid.tree.walk import nodes
    from assistant.virtual.rapid.loading import used_signals, works_signals_out

    if any(works_signals_out(part.trees) for part in programs.parts):
        return None
    files = tuple(tree.parts for part in programs.parts for tree in part.trees)
    used = {one.name.lower() for one in nodes(files) if isinstance(one, syntax.NameRef)}
    return frozenset(used.union(*(used_signals(part.trees)[1] for part in programs.parts)))


SIGNALS: Final[Mapping[str, Callable[[Programs], frozenset[str] | None]]] = {"RA": _rapid_signals}
"""By the family of a language whose signals have names."""
GROUPS: Final[Mapping[str, Grouping]] = {"RA": _tasks, "MB": _slots}
"""By the family of a language."""
