"""Names that are near: by their beginning, else by their spelling, never all there are."""

import pytest

from assistant import languages, robots
from assistant.base.diagnostics import Refused
from assistant.base.near_names import near_names
from assistant.compiler.arms import known_robot
from assistant.compiler.loader import language_of


@pytest.mark.parametrize(
    ("given", "near"),
    [
        ("irb4600", ("irb4600-20-2.50", "irb4600-40-2.55", "irb4600-60-2.05")),
        ("IRB 1200", ("irb1200-5-0.9", "irb1200-7-0.7")),
        ("IRB1200-7/0.7", ("irb1200-7-0.7",)),
        ("kuka", ()),
        ("", ()),
        ("-", ()),
    ],
)
def test_robots_that_somebody_may_have_meant(given, near):
    assert near_names(given, robots.names()) == near


@pytest.mark.parametrize("name", ["RAPID", "Rapid", "Melfa-Basic-5"])
def test_languages_are_known_in_any_case(name):
    assert language_of(name) is languages.get(name.lower())


def test_robots_are_known_in_any_case():
    assert known_robot("IRB1200-7-0.7") is known_robot("irb1200-7-0.7")


@pytest.mark.parametrize(
    ("ask", "cure"),
    [
        (lambda: language_of("rapd"), "did you mean rapid?"),
        (lambda: language_of("karel"), "choose one of rapid, melfa-basic-4"),
        (lambda: known_robot("irb1200"), "did you mean irb1200-5-0.9 or irb1200-7-0.7?"),
        (lambda: known_robot("kuka"), "choose one of irb120-3-0.58"),
    ],
)
def test_a_wrong_name_is_answered_with_those_that_are_near(ask, cure):
    with pytest.raises(Refused) as caught:
        ask()
    (finding,) = caught.value.findings
    assert finding.cure.startswith(cure)
