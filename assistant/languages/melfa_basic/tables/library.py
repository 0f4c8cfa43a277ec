"""Functions of MELFA-BASIC that the pseudo-program lacks, in terms of those that it has.

They stand in `library.txt`, as text of the pseudo-program. What they get that their manuals do not
tell the result of, such as a text without a number in it, ends the program.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program.program import Procedure
from assistant.program.rewriting import records, rewrite

LIBRARY_FUNCTIONS: Final[Mapping[str, Mapping[int, str]]] = {
    "SGN": {1: "sign_of"},
    "LEFT": {2: "left_part"},
    "RIGHT": {2: "right_part"},
    "STRPOS": {2: "place_in"},
    "STRUPR": {1: "upper_letters"},
    "STRLWR": {1: "lower_letters"},
    "CKSUM": {3: "sum_of_codes"},
    "HEX": {1: "hex_digits", 2: "last_hex_digits"},
    "BIN": {1: "binary_digits"},
    "VAL": {1: "number_in"},
    "ZONE2": {4: "in_capsule"},
}
"""Functions of MELFA-BASIC, by how many arguments they have, and the procedures that say them."""


@cache
def library() -> Mapping[str, Procedure]:
    """All of them by their names, without places in a text."""
    from assistant.program.pseudo.parser import parse

    tables = files("assistant.languages.melfa_basic.tables")
    text = tables.joinpath("library.txt").read_text("utf-8")

    def unplaced(node: Any) -> Any:
        return replace(node, span=None) if getattr(node, "span", None) else node

    procedures = rewrite(parse(text).procedures, unplaced, ())
    return {one.name: one for one in procedures}


def library_calls(procedure: Procedure) -> set[str]:
    """The names of the others that one calls."""
    made = (one.function for one in records(procedure.body) if isinstance(one, e.Apply))
    return {name for name in made if name in library()}
