"""What a language makes of types, in words of no vendor."""

import pytest

from assistant.languages.checks.values import Kind, Operators
from tests.tables import every_row

NUMBERS = frozenset({"small", "large"})
OPERATORS = Operators(
    always={"<": "truth"},
    made={
        ("+", "small", "small"): "small",
        ("+", "large", "large"): "large",
        ("*", "vector", "small"): "vector",
    },
    choices={"literal": NUMBERS},
    copied={"input": NUMBERS},
    ordered=NUMBERS,
)


@every_row(
    ("operator", "left", "right", "made"),
    [
        ("+", "small", "small", "small"),
        ("+", "small", "literal", "small"),
        ("+", "literal", "large", "large"),
        ("+", "literal", "literal", "literal"),
        ("*", "vector", "literal", "vector"),
        ("+", "small", "large", None),
        ("*", "small", "vector", None),
    ],
)
def test_an_operator_makes_what_all_choices_allow(operator, left, right, made):
    assert OPERATORS.joined(operator, Kind(left), Kind(right)) == (Kind(made) if made else None)


def test_arrays_are_not_joined():
    assert OPERATORS.joined("+", Kind("small", 1), Kind("small", 1)) is None


@every_row(
    ("given", "wanted", "fits"),
    [
        (Kind("small"), Kind("small"), True),
        (Kind("literal"), Kind("large"), True),
        (Kind("small"), Kind("large"), False),
        (Kind("input"), Kind("large"), True),
        (Kind("small"), Kind("input"), False),
        (Kind("small", 1), Kind("small"), False),
        (Kind("small", 2), Kind("small", 1), False),
        (Kind("small", 2), Kind("small", -1), True),
        (None, Kind("small"), True),
    ],
)
def test_a_value_fits_where_one_of_its_choices_is_wanted(given, wanted, fits):
    assert OPERATORS.fits(given, wanted) is fits


def test_what_is_handed_over_itself_is_not_read():
    assert not OPERATORS.fits(Kind("input"), Kind("large"), read=False)


@pytest.mark.parametrize(
    ("operator", "left", "right", "joins"),
    [
        ("<", "small", "literal", True),
        ("<", "small", "large", False),
        ("<", "vector", "vector", False),
        ("=", "vector", "vector", True),
        ("+", "vector", "vector", False),
    ],
)
def test_what_is_ordered_may_be_less(operator, left, right, joins):
    assert OPERATORS.join(operator, Kind(left), Kind(right)) is joins
