"""Proofs, examined: translations with one fault each, and how many of them the proof finds.

    python -m benchmarks --only proofs [--programs 40] [--mutants 2]

The programs are drawn at random, as many in either direction. Each translation has to be proven
first; then each kind of fault is made in it at some places, and the proof runs again. Lines that no
run reaches do not count: there an end of the program goes unnoticed, too. What the proof does not
find is printed with both lines: it is one that no run can tell, or a gap of the proof.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Final

import assistant
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.compiler import Compiled
from assistant.compiler.arms import Arms
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving, prove_motion, written_pair
from benchmarks import drawn_cells

Made = Callable[[re.Match[str], Random, Sequence[str]], str | None]
"""What a line becomes, from what matches in it; None where there is nothing else to be."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A kind of fault. melfa, rapid: what it is made of in so many lines of either language."""

    name: str
    made: Made
    melfa: str
    rapid: str
    lines: int = 1


def _nothing(*_: object) -> str:
    return ""


def _other_number(match: re.Match[str], rng: Random, _: Sequence[str]) -> str:
    return _with(match, f"{float(_what(match)) + rng.choice((1, 2)):g}")


def _one_off(match: re.Match[str], rng: Random, _: Sequence[str]) -> str:
    return _with(match, str(int(_what(match)) + rng.choice((-1, 1))))


def _larger(match: re.Match[str], _: Random, __: Sequence[str]) -> str:
    return _with(match, f"{2 * float(_what(match)):g}")


def _both_larger(match: re.Match[str], _: Random, __: Sequence[str]) -> str:
    """Of the two distances of `Cnt` the smaller one counts, so that both have to grow."""
    return _with(match, ",".join(f"{2 * int(number)}" for number in _what(match).split(",")))


def _negated(match: re.Match[str], _: Random, __: Sequence[str]) -> str:
    return _with(match, "0" if _what(match) == "1" else "1")


def _other_word(match: re.Match[str], rng: Random, words: Sequence[str]) -> str | None:
    others = [word for word in dict.fromkeys(words) if word.lower() != _what(match).lower()]
    return _with(match, rng.choice(others)) if others else None


def _relation(match: re.Match[str], _: Random, __: Sequence[str]) -> str:
    others = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "=": "<>", "<>": "="}
    return _with(match, others[_what(match)])


def _joined(match: re.Match[str], _: Random, __: Sequence[str]) -> str:
    return _with(match, {"and": "Or", "or": "And", "xor": "Or"}[_what(match).lower()])


def _swapped(match: re.Match[str], _: Random, __: Sequence[str]) -> str | None:
    return None if match[1] == match[2] else f"{match[2]}\n{match[1]}"


def _what(match: re.Match[str]) -> str:
    """The group that matched."""
    return match[match.lastindex or 0]


def _with(match: re.Match[str], other: str) -> str:
    """The line with something else in the place of the group that matched."""
    group = match.lastindex or 0
    return match.string[: match.start(group)] + other + match.string[match.end(group) :]


FAULTS: Final = (
    Fault("a move dropped", _nothing,
          r"^Mvs|^Mov\b|^Mvr",
          r"^Move[LJC]"),
    Fault("an output dropped", _nothing,
          r"^M_Out",
          r"^SetDO|^SetGO|^PulseDO"),
    Fault("a wait dropped", _nothing,
          r"^Wait ",
          r"^WaitDI|^WaitUntil|^WaitDO"),
    Fault("a delay dropped", _nothing,
          r"^Dly",
          r"^WaitTime"),
    Fault("a call dropped", _nothing,
          r"^GoSub|^CallP",
          r"^(?!END|EXIT|ELSE|RETURN)[A-Za-z]\w*;$"),
    Fault("an interrupt dropped", _nothing,
          r"^Act \d=1$|^Def Act",
          r"^ISignalDI|^CONNECT|^IWatch"),
    Fault("two effects swapped", _swapped,
          r"^(M_Out\(\d+\)=[01]|Dly \S+|Wait .*|Mvs \w+)\n(M_Out\(\d+\)=[01]|Dly \S+|Wait .*)$",
          r"^(SetDO .*|WaitTime .*|WaitDI .*|WaitUntil .*|Move.*)\n(SetDO .*|Wait.*)$", 2),
    Fault("another value of an output", _negated,
          r"^M_Out\(\d+\)=([01])\b",
          r"^SetDO \w+,([01]);"),
    Fault("another state to wait for", _negated,
          r"^Wait M_In\(\d+\)=([01])",
          r"^WaitDI \w+,([01])"),
    Fault("another input", _other_word,
          r"M_In\((\d+)\)",
          r"^WaitDI (\w+),|IF (di\w+)="),
    Fault("another output", _other_word,
          r"^M_Out\((\d+)\)",
          r"^SetDO (do\w+),"),
    Fault("another target", _other_word,
          r"^(?:Mvs|Mov) (\w+)$",
          r"^Move[LJ] (\w+),"),
    Fault("another number", _other_number,
          r"^Dly (\d+(?:\.\d+)?)$",
          r"^WaitTime (\d+(?:\.\d+)?);"),
    Fault("one off", _one_off,
          r"^(?:For|While|If)(?!.*M_Timer).*\b(\d+)\b",  # a statement takes longer than 1 ms
          r"^(?:FOR|WHILE|IF).*\b(\d+)\b"),
    Fault("another relation", _relation,
          r"^(?:If|While)(?!.*M_Timer).*?(<=|>=|<>|<|>)",  # no program meets the very moment
          r"^(?:IF|WHILE)(?!.*ClkRead).*?(<=|>=|<>|<|>)"),
    Fault("another operator", _joined,
          r"^(?:If|While|Wait).*\b(And|Or|Xor)\b",
          r"^(?:IF|WHILE|WaitUntil).*\b(AND|OR|XOR)\b"),
    Fault("another speed", _larger,
          r"^Spd (\d+(?:\.\d+)?)$",
          r"^Move[LC].*,v(\d+),"),
    Fault("a wider corner", _both_larger,
          r"^Cnt 1,(\d+,\d+)",
          r",z(10|20|50),"),
    Fault("another tool", _other_word,
          r"^Tool (\w+)$",
          r",(t[A-Z]\w*)(?:\\|;)"),
    Fault("another pulse", _larger,
          r"^M_Out.* Dly (\d+(?:\.\d+)?)$",
          r"^PulseDO\\PLength:=(\d+(?:\.\d+)?)"),
    Fault("another value of data", _one_off,
          r"^M\w+=(\d+)$",
          r"^\w+:=(\d+);"),
    Fault("another step of a counter", _larger,
          r"^M\w+=M\w+\+(\d+)$",
          r"^\w+:=\w+\+(\d+);"),
    Fault("another time limit", _larger,
          r"M_Timer\(\d+\)<(\d+)",
          r"\\MaxTime:=(\d+)|ClkRead\(\w+\)<(\d+)"),
)  # fmt: skip
NUMBER: Final = re.compile(r"^\s*(?:\d+\s+)?")
DATA: Final = re.compile(r"^\w+(?:\([\d,]+\))?=\([-+\d]|^(?:CONST|PERS|VAR|LOCAL)\b|^['!]")


@dataclass
class Exam:
    """What was found. left: those that were not, each with both lines. unreached: in lines that no
    run reaches. unreadable: those that no reader takes, and no proof is needed for.
    """

    tried: Counter[str] = field(default_factory=Counter)
    found: Counter[str] = field(default_factory=Counter)
    left: list[str] = field(default_factory=list)
    unreached: int = 0
    unreadable: int = 0
    proven: int = 0
    seconds: list[float] = field(default_factory=list)


def report(programs: int, mutants: int) -> None:
    """Prints the rate of each fault, what was not found, and how long a proof takes."""
    exam = Exam()
    rng = Random("mutants")
    with TemporaryDirectory() as folder:
        for name, done in _translations(programs, Path(folder)):
            began = time.thread_time()
            if not _proves(done, done.files):
                print(f"{name}: not proven", flush=True)
                continue
            exam.seconds.append(time.thread_time() - began)
            exam.proven += 1
            for fault in FAULTS:
                for files, ending, line, other in _mutants(done, fault, mutants, rng):
                    try:
                        found = not _proves(done, files)
                    except Refused:
                        exam.unreadable += 1
                        continue
                    if not found and _proves(done, ending):
                        exam.unreached += 1
                        continue
                    exam.tried[fault.name] += 1
                    exam.found[fault.name] += found
                    if not found:
                        exam.left.append(f"{name}: {fault.name}: {line!r} -> {other!r}")
    print(f"{'fault':<34}{'made':>8}{'found':>8}{'%':>8}")
    for fault in FAULTS:
        _row(fault.name, exam.tried[fault.name], exam.found[fault.name])
    _row("all", exam.tried.total(), exam.found.total())
    slowest = max(exam.seconds, default=0.0)
    print(f"\n{exam.proven} programs; the longest proof took {slowest:.1f} s of the processor")
    print(f"not counted, as no run reaches their lines: {exam.unreached}")
    print(f"not counted, as no reader takes them: {exam.unreadable}")
    print(f"not found: {len(exam.left)}")
    for line in exam.left:
        print(f"  {line}")


def _row(name: str, tried: int, found: int) -> None:
    share = f"{100 * found / tried:.0f}" if tried else "-"
    print(f"{name:<34}{tried:>8,}{found:>8,}{share:>8}")


def _translations(count: int, folder: Path) -> Iterator[tuple[str, Compiled]]:
    """Translations of drawn programs, as many in either direction, and what they are called."""
    process = folder / "cell.process.toml"
    process.write_text(drawn_cells.process_file(), encoding="utf-8")
    directions: dict[drawn_cells.Language, tuple[str, Path | None]] = {
        "rapid": ("melfa-basic-6", process),
        "melfa-basic-5": ("rapid", None),
    }
    for language, (to, cell) in directions.items():
        for seed in range(1, count // len(directions) + 1):
            text = SourceText(drawn_cells.drawn(language, seed))
            loaded = load_text(text, process=cell, language=language)
            done = assistant.translate(loaded, to=to)
            if not done.ok:
                print(f"{language} {seed}: not translated", flush=True)
                continue
            yield f"{language} {seed}", done.compiled


def _mutants(
    done: Compiled, fault: Fault, most: int, rng: Random
) -> Iterator[tuple[dict[str, bytes], dict[str, bytes], str, str]]:
    """Files with one fault each, files that end there instead, the line, and what became of it."""
    ((name, data),) = done.files.items()
    lines = data.decode().split("\n")
    pattern = re.compile(fault.rapid if done.language == "rapid" else fault.melfa)
    plain = [NUMBER.sub("", line).rstrip("\r") for line in lines]
    starts = range(len(plain) + 1 - fault.lines)
    texts = {at: "\n".join(plain[at : at + fault.lines]) for at in starts}
    places = [at for at, text in texts.items() if not DATA.match(text) and pattern.search(text)]
    words = [_what(m) for at in places if (m := pattern.search(texts[at])) and m.lastindex]
    for at in sorted(rng.sample(places, min(most, len(places)))):
        match = pattern.search(texts[at])
        assert match is not None
        other = fault.made(match, rng, words)
        if other is None or other == texts[at]:
            continue
        behind = lines[at + fault.lines :]
        changed = [*lines[:at], *([other] if other else []), *behind]
        end = "EXIT;" if done.language == "rapid" else "Hlt"
        made = ("\n".join(one).encode() for one in (changed, [*lines[:at], end, *lines[at:]]))
        yield {name: next(made)}, {name: next(made)}, texts[at], other


def _proves(done: Compiled, files: Mapping[str, bytes]) -> bool:
    """True if the proof holds for these files. Raises Refused for files that cannot be read."""
    pair = written_pair(done.source, done.program, done.language, files)
    return prove_motion(pair, Arms(), Proving()).holds
