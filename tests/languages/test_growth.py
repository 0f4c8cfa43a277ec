"""Programs that once took time with the square of their length: now the work grows as they do.

Work is counted in calls of functions, which are the same at each run.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from assistant import languages, translate
from assistant.compiler.checker import check_files
from assistant.program.program import TakenNames, identifier
from benchmarks.growth.flows import flows
from benchmarks.growth.measuring import calls

MOST = 1.2
"""The exponent of growth that is allowed."""
KNOWN = {one.name: one for one in flows()}


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("construct", "few"),
    [
        ("RAPID: semicolons on a line", 100),
        ("RAPID: semicolons and commas on a line", 20),
        ("RAPID: routines of one name", 60),
        ("MELFA-BASIC: subroutines in a ring", 30),
        ("MELFA-BASIC: subroutines in a ring, with jumps", 20),
        ("MELFA-BASIC: For in each other", 100),
        ("MELFA-BASIC: an interrupt and subroutines", 20),
    ],
)
def test_four_times_the_program_is_at_most_about_four_times_the_work(
    construct: str, few: int, tmp_path: Path
) -> None:
    one = KNOWN[construct]

    def work(n: int) -> float:
        file = tmp_path / f"a{n}{one.suffix}"
        file.write_text(one.text(n), "ascii")
        return calls(lambda: check_files([file]))

    work(1)  # loads what checking needs
    base = work(1)
    assert math.log((work(4 * few) - base) / (work(few) - base), 4) <= MOST


@pytest.mark.one_in(2)
@pytest.mark.parametrize("construct", ["MELFA-BASIC: moves", "MELFA-BASIC: settings"])
def test_as_much_more_work_as_there_is_to_translate(construct: str, tmp_path: Path) -> None:
    def work(n: int) -> float:
        file = tmp_path / f"a{n}.prg"
        file.write_text(KNOWN[construct].text(n), "ascii")
        return calls(lambda: translate(file, to="rapid", language="melfa-basic-6", draft=True))

    work(1)
    base = work(1)
    assert math.log((work(160) - base) / (work(40) - base), 4) <= MOST


def test_many_words_that_do_not_fit_are_mended_at_once() -> None:
    """As many as a file may have errors once were all that was read of it."""
    text = "MODULE m\nPROC main()\n{}\nENDPROC\nPROC b()\nENDPROC\nENDMODULE\n"
    tree = languages.get("rapid").parse(text.format(";" * 5000))
    assert [finding.code for finding in tree.findings] == ["RA101"]
    assert "PROC b" in str(languages.get("rapid").render(tree))


def test_names_are_chosen_without_looking_at_all_that_are_taken() -> None:
    def chosen(number: int) -> list[str]:
        taken = TakenNames(["A"])
        for _ in range(number):
            taken.add(identifier("a", taken))
        return sorted(taken)

    few, many = calls(lambda: chosen(100)), calls(lambda: chosen(400))
    assert math.log(many / few, 4) <= MOST
    assert chosen(3) == ["A", "a_2", "a_3", "a_4"]
    assert identifier("a", {"A", "a_2"}) == "a_3"
