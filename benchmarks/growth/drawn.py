"""Constructs that the grammars have: all that repeats or nests, each kind of statement n times, and
each of them n times with a word too few or too many.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Final

from benchmarks.growth.construct import Construct, Text
from benchmarks.growth.derivations import Derivations, Pumped, Terminals

_SAMPLES: Final[Mapping[str, str]] = {
    "NAME": "x", "NUMBER": "1", "INTEGER": "1", "SIGNED": "1", "STRING": '"a"', "LABEL": "*L",
    "STEP": "1", "HEX": "&H1", "BINARY": "&B1", "FN_NAME": "FNx", "SUFFIX": "!", "EMPTY": "()",
    "POSITION": "(1,2)", "COMMENT": "' a", "REM": "Rem a", "TABLE": "[1,[1]]", "NOTE": "! a\n",
    "HEADER": "%%%\nVERSION:1\n%%%\n", "MOTION": "Mov", "COMMAND": "Dly", "SIGN": "-",
    "TIMES": "*", "SHIFT": "<<", "COMPARISON": "<", "QUOTED_NAME": "`a b`", "WORD": "rapid",
    "RAW": "| a", "DIGEST": "0" * 64, "OPEN": "[,]", "TRUTH": "true", "WHOLE": "div",
    "WITHOUT_ENTRY": "without entry",
}  # fmt: skip
"""What stands for a terminal that is a regular expression."""
MOST_SHOWN: Final = 40
"""Characters of a text that its name tells."""
_CHOICE: Final = re.compile(r"\(?([#a-z]+(?: [a-z]+)?)[|)]")


@dataclass(frozen=True, slots=True)
class Spoken:
    """A language whose constructs are drawn. around: a whole text of a piece of n lines."""

    name: str
    file: str
    suffix: str
    starts: tuple[str, ...]
    around: Callable[[str, str], str]
    unsaid: frozenset[str] = frozenset()

    @property
    def derivations(self) -> Derivations:
        return _derivations(self)

    def written(self, words: Sequence[str]) -> str:
        patterns = self.derivations.patterns
        return _laid_out([_sample(one, patterns.get(one, "")) for one in words])


@cache
def _derivations(spoken: Spoken) -> Derivations:
    return Derivations(spoken.file, spoken.starts, spoken.unsaid)


def _sample(name: str, pattern: str) -> str:
    if name in _SAMPLES:
        return _SAMPLES[name]
    if found := _CHOICE.match(pattern):
        return found[1]
    return pattern.removesuffix(r"\b")


def _laid_out(words: Sequence[str]) -> str:
    """Words with blanks between them, a line end behind each `;`."""
    return " ".join(words).replace("; ", ";\n").replace("\n ", "\n")


def _module(start: str, text: str) -> str:
    if start == "start":
        return text
    return f"MODULE m\nPROC main()\n{text}\nENDPROC\nENDMODULE\n"


def _steps(start: str, text: str) -> str:
    if start == "data":
        return "1 End\n" + text
    return "".join(f"{k} {line}\n" for k, line in enumerate(text.split("\n"), 1))


def _program(start: str, text: str) -> str:
    if start == "declaration":
        return f"program p\n{text}\nprocedure main\nend\n"
    return f"program p\nvariable x number\nprocedure main\n{text}\nend\n"


SPOKEN: Final = (
    Spoken(
        "RAPID", "rapid.lark", ".mod", ("start", "statements"), _module,
        frozenset({"TARGETS", "MOVES"}),
    ),
    Spoken("MELFA-BASIC", "melfa_basic.lark", ".prg", ("line", "data"), _steps),
    Spoken(
        "pseudo", "pseudo.lark", ".pseudo", ("declaration", "statement"), _program
    ),
)  # fmt: skip


def drawn(languages: Sequence[Spoken] = SPOKEN) -> Iterator[Construct]:
    """All of them, each text once."""
    met: set[tuple[str, str]] = set()
    for spoken in languages:
        for start in spoken.starts:
            for name, words, text in _grown(spoken, start):
                if (spoken.suffix, text(2)) not in met:
                    met.add((spoken.suffix, text(2)))
                    shown = f"{spoken.name}: {name}: `{spoken.written(words)[:MOST_SHOWN]}`"
                    yield Construct(shown.replace("\n", " "), spoken.suffix, text)


def _grown(spoken: Spoken, start: str) -> Iterator[tuple[str, Terminals, Text]]:
    """What grows in the texts of a start rule, in words and as it is said."""
    for pumped in spoken.derivations.pumped(start):
        words = (*pumped.each.left, *pumped.seed, *pumped.each.right)
        yield f"{pumped.of} in each other", words, partial(_pumped, spoken, start, pumped)
    if start == "start":
        return  # whole modules, whose statements are those of another start rule
    for of, words in spoken.derivations.kinds(start):
        yield of, words, partial(_lines, spoken, start, words)
        for wrong, damaged in _damaged(words):
            yield f"{of} {wrong}", damaged, partial(_lines, spoken, start, damaged)


def _damaged(words: Terminals) -> Iterator[tuple[str, Terminals]]:
    """With a word too few or too many; the middle one."""
    at = len(words) // 2
    if len(words) > 1:
        yield "without a word", words[:at] + words[at + 1 :]
    yield "a word twice", words[: at + 1] + words[at:]


def _pumped(spoken: Spoken, start: str, pumped: Pumped, n: int) -> str:
    return spoken.around(start, spoken.written(pumped.words(n)))


def _lines(spoken: Spoken, start: str, words: Terminals, n: int) -> str:
    return spoken.around(start, "\n".join([spoken.written(words)] * n))
