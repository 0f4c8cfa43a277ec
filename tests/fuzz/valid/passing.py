"""What every valid program goes through, stage by stage, and what it promises there."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from random import Random
from typing import Any, Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, Severity, has_errors
from assistant.base.source_text import SourceText
from assistant.compiler import Compiled, compile, translate
from assistant.compiler.checker import check_text
from assistant.compiler.loader import parse_pseudo
from assistant.languages import Language
from assistant.program.program import Program
from tests.fuzz.programs import NAME, laid_out, placed, said
from tests.fuzz.target import file, promise, sound

OURS: Final = ("CO101", "CO102")
"""What was written is not read back, or says something else: nobody but us is to blame."""
ARMS: Final = {"rapid": "irb1200-7-0.7", "melfa-basic-4": "rv-2aj", "melfa-basic-5": "rv-4frl"}


@dataclass(frozen=True, slots=True)
class Stage:
    """run: of a text in a language, with chance. often: how many of the programs it is for."""

    name: str
    run: Callable[[str, str, Random], None]
    often: float = 1.0


@contextmanager
def allowing() -> Iterator[None]:
    """What is refused inside is well, as long as it is told why."""
    try:
        yield
    except Refused as refused:
        promise(bool(refused.findings), "refused without a finding")
        sound(one.within(NAME) for one in refused.findings)


def read(name: str, text: str, rng: Random) -> None:
    """Without a syntax error, and back byte for byte; laid out, it is the same program."""
    language, source = languages.get(name), source_of(name, text)
    tree = language.parse(source)
    promise(not tree.findings, f"{name}: not read", list(tree.findings)[:1])
    promise(language.render(tree) == text, f"{name}: the text does not come back")
    laid_out(language, source, tree)
    list(language.said(text))
    list(language.parts(tree))


DRAWN_TOO_LONG = ("MB107",)
"""A step of more bytes than a controller takes: the draw looks at no lengths."""


def check(name: str, text: str, rng: Random) -> None:
    """No rule finds an error in it, and every finding has its place."""
    source = source_of(name, text)
    findings = check_text(source, language=name).findings
    placed(tuple(findings), source)
    for one in findings:
        right = one.severity is not Severity.ERROR or one.code in DRAWN_TOO_LONG
        promise(right, f"{name}: {one.code} of a valid program: {plain(one)}", one)


def lift(name: str, text: str, rng: Random) -> None:
    """As pseudo text it says the same; lowered, it is the text that it was."""
    language = languages.get(name)
    program = language.lift(language.parse(source_of(name, text)))
    said(program)
    with allowing():
        promise(language.render(language.lower(program)) == text, f"{name}: not its own text again")


def cross(name: str, text: str, rng: Random) -> None:
    """Written in another language, which reads it without a finding."""
    others = [one for one in languages.names() if one != name]
    to = rng.choice(others)
    options: dict[str, Any] = {
        "to": to,
        "language": name,
        "frames": rng.choice(("base", "base", "product")),
        "draft": rng.random() < 0.5,
    }
    if rng.random() < 0.1:
        options |= {"robot": ARMS.get(to), "from_robot": ARMS.get(name)}
    language = languages.get(name)
    path = file("input" + language.suffixes[0], text.encode(language.encodings[0]))
    with allowing():
        made = translate(path, **options)
        sound(one.within(NAME) for one in made.findings)
        sound(one.within(NAME) for row in made.rows for one in row.reasons)
        proven(made.compiled, f"{name} to {to}")
        if made.written is not made.compiled:
            proven(made.written, f"draft of {name} to {to}", known=has_errors(made.compiled.found))
        written(languages.get(to), made.files, f"{name} to {to}")
        if rng.random() < 0.15:
            again = translate(path, **options)
            promise(again.files == made.files, f"{to}: translated again, it is another text")
            told = [str(f) for f in made.findings], [str(f) for f in again.findings]
            promise(told[0] == told[1], f"{to}: translated again, other findings")


def anew(name: str, text: str, rng: Random) -> None:
    """Written in its own language as if it came from elsewhere, as a pseudo-program does."""
    language = languages.get(name)
    program = language.lift(language.parse(source_of(name, text)))
    into(replace(program, origin=None), name, rng, f"{name} anew")


def pseudo_read(name: str, text: str, rng: Random) -> None:
    program = of_pseudo(text)
    sound(check_text(SourceText(text, "input.pseudo")).findings)
    said(program)


def pseudo_cross(name: str, text: str, rng: Random) -> None:
    to = rng.choice(languages.names())
    into(of_pseudo(text), to, rng, f"pseudo to {to}")


STAGES: Final[Mapping[str, tuple[Stage, ...]]] = {
    **dict.fromkeys(
        ("rapid", "melfa-basic-4", "melfa-basic-5", "melfa-basic-6"),
        (
            Stage("read", read),
            Stage("check", check, 0.5),
            Stage("lift", lift),
            Stage("cross", cross),
            Stage("anew", anew, 0.3),
        ),
    ),
    "pseudo": (Stage("read", pseudo_read), Stage("cross", pseudo_cross)),
}


# ------------------------------------------------------------------------------ what they share


def source_of(name: str, text: str) -> SourceText:
    language = languages.get(name)
    return SourceText(text, NAME + language.suffixes[0], language.encodings[0])


def of_pseudo(text: str) -> Program:
    try:
        return parse_pseudo(SourceText(text, "input.pseudo"))
    except Refused as refused:
        promise(False, f"pseudo: not read: {plain(refused.findings[0])}", refused.findings[:1])
        raise


def into(program: Program, to: str, rng: Random, what: str) -> None:
    with allowing():
        made = compile(program, language=to, frames=rng.choice(("base", "product")))
        sound(one.within(NAME) for one in made.findings)
        proven(made, what)
        written(languages.get(to), made.files, what)


def proven(made: Compiled, what: str, *, known: bool = False) -> None:
    """What was written says what it was made of, unless an error tells why not."""
    told = made.ok or known or has_errors(made.found)
    promise(told, f"{what}: no files and no error", made.findings[:2])
    for one in made.found:
        promise(one.code not in OURS, f"{what}: {one.code} of the proof: {plain(one)}", one)


def written(language: Language[Any], files: Mapping[str, bytes], what: str) -> None:
    """What was written is read back, and its own rules find no error."""
    trees = []
    for name, data in files.items():
        tree = language.parse(language.decode(data, name))
        promise(not tree.findings, f"{what}: not read by its own reader", list(tree.findings)[:1])
        promise(language.encode(tree) == data, f"{what}: other bytes when read")
        trees.append(tree)
    found = language.check(trees) if trees else ()
    for one in found:
        right = one.severity is not Severity.ERROR or one.code in DRAWN_TOO_LONG
        promise(right, f"{what}: {one.code} of what was written: {plain(one)}", one)


def plain(finding: Diagnostic) -> str:
    """What a finding says, without what differs from one program to the next."""
    return re.sub(r"`[^`]*`|\d+", "…", finding.message)
