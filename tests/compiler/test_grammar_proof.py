"""The proof parses what was emitted with lark: completely up to 20,000 lines, else in samples."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lark import Lark

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler import compile
from assistant.compiler.read_back_proof import NOT_IN_GRAMMAR, prove_read_back
from assistant.languages import lark_parsing
from assistant.languages.lark_parsing import (
    SAMPLED,
    WINDOW,
    Parsed,
    Spacing,
    between_samples,
)
from assistant.languages.rapid import Rapid

SAMPLES = Path(__file__).parent.parent.parent / "samples"


@pytest.mark.parametrize("language", ["rapid", "melfa-basic-4", "melfa-basic-5", "melfa-basic-6"])
def test_every_emitted_line_is_parsed(language: str) -> None:
    compiled = compile(SAMPLES / "positioning.csv", language=language)
    lines = sum(len(data.splitlines()) for data in compiled.files.values())
    assert compiled.proof.grammar == Parsed(lines, lines)
    assert next(compiled.proof_lines()).endswith(f"; grammar: {lines} lines parsed")


def test_the_lines_of_all_modules_are_counted() -> None:
    compiled = compile(SAMPLES / "positioning.csv", language="rapid", most_targets=10)
    assert len(compiled.files) > 2
    lines = sum(len(data.splitlines()) for data in compiled.files.values())
    assert compiled.proof.grammar == Parsed(lines, lines)


def test_a_text_that_the_grammar_refuses_is_not_written() -> None:
    class Narrow(Rapid):
        """RAPID without waits, as its grammar has it."""

        def by_lark(self) -> Lark:
            return Lark("start: (/(?!WaitTime)[^ \\n]+/)*\n%ignore /[ \\n]+/", parser="lalr")

    compiled = compile(SAMPLES / "positioning.csv", language="rapid")
    files = {"m.mod": b"MODULE m\nPROC main()\n  Stop;\n  WaitTime 1;\nENDPROC\nENDMODULE\n"}
    proof = prove_read_back(Narrow(), compiled.program, files)
    assert not proof.holds
    (found,) = proof.findings
    assert (found.code, found.path, found.line, found.column) == ("CO108", "m.mod", 4, 3)
    assert "`W` is not expected there" in found.message


# ---------------------------------------------------------------------------- long texts


def moves(count: int, then: str = "") -> str:
    body = "".join(f"    MoveL p{i % 7},v100,z10,tool0;\n" for i in range(count))
    return f"MODULE m\n  PROC main()\n{body}{then}  ENDPROC\nENDMODULE\n"


def positions(count: int, then: str = "") -> str:
    body = "".join(f"P{i}=(1.5,2,3,0,0,{i})(6,0)\n" for i in range(1, count + 1))
    return f"Mov P1\n{body}{then}"


def parsed(language: str, text: str, sampling: Any = "samples") -> Parsed:
    known = languages.get(language)
    tree = known.parse(SourceText(text, "long"))
    found = lark_parsing.parse(known, [tree], NOT_IN_GRAMMAR, sampling)
    assert found is not None
    return found


FORMS = [("rapid", moves), ("melfa-basic-5", positions)]
SHORT = 500


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Texts of more than SHORT lines are long."""
    monkeypatch.setattr(lark_parsing, "WHOLE", SHORT)


def is_parsed_in_samples(language: str, text: Any, most: int) -> None:
    assert parsed(language, text(most - text(0).count("\n"))) == Parsed(most, most)
    longer = text(most + 1 - text(0).count("\n"))
    found = parsed(language, longer)
    assert not found.refused
    assert 0 < found.lines < found.total == most + 1
    assert str(found) == f"{found.lines:,} of {most + 1:,} lines parsed"
    assert parsed(language, longer, "full") == Parsed(most + 1, most + 1)


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize(("language", "text"), FORMS)
def test_longer_texts_are_parsed_in_samples_or_completely(language: str, text: Any) -> None:
    is_parsed_in_samples(language, text, SHORT)


@pytest.mark.slow
@pytest.mark.parametrize(("language", "text"), FORMS)
def test_texts_of_20001_lines_are_parsed_in_samples_or_completely(language: str, text: Any) -> None:
    is_parsed_in_samples(language, text, 20_000)


@pytest.mark.usefixtures("short")
def test_many_files_are_parsed_completely_up_to_a_sum(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lark_parsing, "SAMPLED", SHORT // 5)
    known = languages.get("rapid")
    trees = [known.parse(SourceText(moves(SHORT // 2 - 4), f"{n}.mod")) for n in range(12)]
    first = lark_parsing.parse(known, trees[:2], NOT_IN_GRAMMAR, "samples")
    assert first == Parsed(SHORT, SHORT)
    found = lark_parsing.parse(known, trees, NOT_IN_GRAMMAR, "samples")
    assert found is not None
    assert found.total == 6 * SHORT
    assert 0 < found.lines < SHORT
    every = lark_parsing.parse(known, trees, NOT_IN_GRAMMAR, "full")
    assert every == Parsed(6 * SHORT, 6 * SHORT)


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("sampling", ["samples", "full"])
def test_what_is_refused_after_rows_that_were_left_out_has_its_line(sampling: str) -> None:
    (found,) = parsed("rapid", moves(2000, "    WaitTime 1 2;\n"), sampling).refused
    assert (found.line, found.column) == (2003, 16)
    assert "`2` is not expected there" in found.message
    (found,) = parsed("melfa-basic-5", positions(2000, "Dly 1 2\n"), sampling).refused
    assert (found.line, found.column) == (2002, 7)
    (found,) = parsed("rapid", moves(2000).replace("ENDMODULE\n", ""), sampling).refused
    assert "the text ends where more is expected" in found.message
    assert found.line == 2004


@pytest.mark.parametrize("sizes", [[8], [199, 201], [30_000], [1_000_000], [8] * 9000, [5000] * 99])
def test_samples_hold_the_ends_of_each_run_and_windows_between_them(sizes: list[int]) -> None:
    runs, at = [], 0
    for size in sizes:
        starts = at + 10 * np.arange(size)
        runs.append(np.stack([starts, starts + 9], axis=1))
        at += 10 * size + 5
    left_out = between_samples(runs, Spacing.of([len(run) for run in runs]))
    assert sum(sizes) - sum(rows for _, _, rows in left_out) <= 2 * SAMPLED + WINDOW + 2 * len(
        sizes
    )
    assert all(first[1] <= then[0] for first, then in pairwise(left_out))
    begins = {begin for begin, _, _ in left_out}
    assert all(end - begin == 10 * rows for begin, end, rows in left_out)
    assert not begins & {int(run[0, 0]) for run in runs}
    lasts = [int(run[-1, 0]) for run in runs]
    assert not any(begin <= last < end for begin, end, _ in left_out for last in lasts[:50])
    if sizes == [1_000_000]:
        assert len(left_out) > 15
