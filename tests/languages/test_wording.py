"""What one finding tells of many things."""

import numpy as np

from assistant.languages.checks.registry import SHOWN_NAMES, Listing


def test_nothing_stands_nowhere():
    assert Listing().first is None


def test_one_thing_is_named():
    found = Listing()
    found.add("line 3", "a")
    assert found.first == ("line 3", 0)
    assert found.words == {"names": "`a`", "them": "it"}


def test_rows_are_counted_and_the_first_of_all_are_named():
    found = Listing()
    found.add("line 3", "a")
    found.add_rows("table", np.arange(10, 1010), lambda row: f"p{row}")
    names = ["`a`", *(f"`p{row}`" for row in range(10, 9 + SHOWN_NAMES))]
    assert found.first == ("line 3", 0)
    assert found.words == {
        "names": ", ".join(names) + f" and {1001 - SHOWN_NAMES} more",
        "them": "them",
    }


def test_the_first_row_that_counts_is_where_a_finding_stands():
    found = Listing()
    found.add_rows("used", np.empty(0, np.intp), lambda row: f"p{row}")
    found.add_rows("table", np.array([4, 7]), lambda row: f"p{row}")
    assert found.first == ("table", 4)
    assert found.words["names"] == "`p4`, `p7`"
