"""Robot programs and pseudo-programs: read, printed, checked, laid out, lifted."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache, partial
from typing import Any, Final

from assistant import checks, languages
from assistant.base.diagnostics import has_errors
from assistant.base.source_text import SourceText
from assistant.compiler.checker import check_text
from assistant.compiler.formatter import NOT_THE_SAME, format_text
from assistant.compiler.loader import parse_pseudo
from assistant.languages import Language
from assistant.program import pseudo
from assistant.program.comparison import Tolerance, compare
from assistant.program.program import Program
from assistant.resources import read_grammar
from tests.fuzz.target import ROOT, Target, files_of, one_in, promise, refusing, sound

NAME: Final = "input"
CLOSE: Final = Tolerance(angle=1e-9)
"""Quaternions that are read are made unit ones."""


def vendor(name: str, data: bytes) -> None:
    """One text of a vendor language, through all that is done with it short of another language."""
    language = languages.get(name)
    promise(isinstance(language.recognises(data), bool), "recognises says neither yes nor no")
    with refusing():
        source = language.decode(data, NAME + language.suffixes[0])
        tree = language.parse(source)
        promise(language.render(tree) == source.text, "the text does not come back")
        promise(language.encode(tree) == data, "the bytes do not come back")
        placed(tree.findings, source)
        list(language.parts(tree))
        sound(language.check([tree]))
        if not has_errors(tree.findings):
            laid_out(language, source, tree)
        with refusing():
            program = language.lift(tree)
            if has_errors(tree.findings):
                return
            promise(language.lower(program) is tree, "lowered unchanged, it is another tree")
            sound(checks.check(program))
            if one_in(4, data):
                list(language.said(source.text))
                said(program)
                sound(check_text(source, language=name, robot="rv-2aj").findings)


def laid_out(language: Language[Any], source: SourceText, tree: Any) -> None:
    done = format_text(source, language)
    codes = [finding.code for finding in done.findings]
    promise(NOT_THE_SAME.code not in codes, "laid out anew, it is not the same program")
    sound(done.findings)
    if done.changed:
        again = format_text(SourceText(done.text, source.path, source.encoding), language)
        promise(not again.changed, "laid out twice, it changes twice")


def placed(findings: tuple[Any, ...], source: SourceText) -> None:
    sound(findings)
    for finding in findings:
        if finding.line is not None and finding.excerpt is not None:
            shown = source.line_text(finding.line)
            promise(shown == finding.excerpt, f"{finding.code} shows another line")


def said(program: Program) -> None:
    """A program that was lifted can be printed as pseudo text, which says the same."""
    printed = pseudo.print_program(program)
    again = parse_pseudo(SourceText(printed.text))
    difference = compare(program, again, CLOSE)
    promise(difference.same, "printed as pseudo text, it is another program", difference)


def pseudo_text(data: bytes) -> None:
    with refusing():
        source = SourceText(data.decode("utf-8", "replace"), NAME + pseudo.SUFFIX)
        sound(check_text(source).findings)
        program = parse_pseudo(source, None)
        printed = pseudo.print_program(program)
        again = parse_pseudo(SourceText(printed.text))
        promise(pseudo.print_program(again).text == printed.text, "printed twice, it differs")
        promise(compare(program, again, CLOSE).same, "printed, it is another program")


# ------------------------------------------------------------------------------ words of them


@cache
def of_grammar(name: str) -> tuple[str, ...]:
    """Words and marks that a grammar names."""
    found = re.findall(r'"([^"\n]+)"|\b([A-Za-z]\w+)', read_grammar(name))
    return tuple(dict.fromkeys(text or word for text, word in found))


@cache
def of_tables(*patterns: str) -> tuple[str, ...]:
    """Words of the tables of a language."""
    files = sorted(path for pattern in patterns for path in ROOT.glob(pattern))
    texts = (path.read_text("utf-8") for path in files)
    return tuple(dict.fromkeys(w for text in texts for w in re.findall(r"[A-Za-z_]\w+", text)))


def _lines(name: str) -> tuple[str, ...]:
    """Whole lines of a fixture, which stand for words as well."""
    return tuple(f"\n{line}\n" for line in (ROOT / name).read_text("utf-8").splitlines() if line)


def _words(grammar: str, *tables: str) -> Callable[[], tuple[str, ...]]:
    return lambda: of_grammar(grammar) + of_tables(*tables)


def _language(name: str, folder: str) -> Target:
    data = folder.replace("-", "_")
    seeds = files_of(f"tests/fuzz/seeds/{folder}/*", f"tests/languages/{data}/data/*", most=900)
    words = _words(f"{data}.lark", f"assistant/languages/{data}/tables/**/*.txt")
    return Target(name, partial(vendor, name), seeds, words, most=1200, tried=20)


TARGETS: Final = (
    _language("rapid", "rapid"),
    *(_language(f"melfa-basic-{number}", "melfa-basic") for number in (4, 5, 6)),
    Target(
        "pseudo",
        pseudo_text,
        files_of("tests/fuzz/seeds/pseudo/*"),
        lambda: (*of_grammar("pseudo.lark"), *_lines("tests/program/fixtures/lines.txt")),
        most=1200,
        tried=20,
    ),
)
