"""Why a run of MELFA-BASIC is over before its end."""

from __future__ import annotations


class Failed(Exception):
    """The controller stops with an error.

    number: as it shows it (lists of errors, BFP-A8871), None where the manuals give none.
    """

    def __init__(self, number: int | None, what: str) -> None:
        super().__init__(f"error {number}: {what}" if number else f"error: {what}")
        self.number = number


class Unknown(Exception):
    """What nothing at hand tells, or what is not simulated: the run ends instead of guessing."""


class Ended(Exception):
    """`End` of the program that runs."""


class Redirected(Exception):
    """An interrupt has the program go on elsewhere. nest: the run of rows. at: the row."""

    def __init__(self, nest: int, at: int) -> None:
        super().__init__(nest, at)
        self.nest, self.at = nest, at


def number_wanted(what: str) -> Failed:
    return Failed(4390, f"{what} is no number")


def out_of_range(what: str) -> Failed:
    return Failed(3110, f"{what} is out of range")


def open_point(what: str, option: str) -> Unknown:
    """What the manuals leave open, and an option of the run tells (see `Options`)."""
    return Unknown(f"{what}: the option `{option}` tells")
