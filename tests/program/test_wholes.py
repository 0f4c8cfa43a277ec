"""Numbers that are whole, or never below 0, whatever way a program takes."""

from __future__ import annotations

from assistant.program import expressions as e
from assistant.program import pseudo
from assistant.program.analysis.integer_inference import NumberFacts, without_needless_rounding
from assistant.program.program import Program
from tests.tables import every_row

HEAD = """\
program cell

signal level analog input 6000
signal part group input 8 bits 4

variable a number = 0
variable b number = 2
variable unset number
variable i integer
persistent kept number = 1

"""
SHIFT = """

procedure shift(given number, changed inout number)
end
"""


def program(*lines: str) -> Program:
    body = "".join(f"  {line}\n" for line in lines)
    return pseudo.parse(HEAD + f"procedure main\n{body}end\n{SHIFT}")


def known(made: Program, name: str) -> tuple[bool, bool]:
    found = NumberFacts(made).of(e.Name(name), made.procedures[0])
    return found.whole, found.positive


@every_row(
    ("lines", "name", "wanted"),
    [
        (["a = b + part"], "a", (True, True)),
        (["a = b - 1"], "a", (True, False)),
        (["a = b / 2"], "a", (False, True)),
        (["a = level"], "a", (False, False)),
        (["a = kept"], "a", (False, False)),
        (["a = unset"], "a", (False, False)),
        (["i = unset"], "i", (True, False)),
        (["a = round(unset)"], "a", (True, False)),
        (["a = unset div 2"], "a", (True, False)),
        (["a = abs(unset)"], "a", (False, True)),
        (["b = a", "a = b + 1"], "b", (True, True)),
        (["b = a", "a = b + 0.5"], "b", (False, True)),
        (["for k from 1 to 4", "  a = k", "end"], "a", (True, True)),
        (["for k from 0 to 1 step 0.5", "  a = k", "end"], "a", (False, True)),
        (["b = 0.5", "for k from 0 to 1 step b", "  a = k", "end"], "a", (False, True)),
        (["for k from 3 to 1 step -1", "  a = k", "end"], "a", (True, False)),
        (["call shift(a, b)"], "a", (True, True)),
        (["call shift(a, b)"], "b", (False, False)),
        (["opaque rapid | b:=b/2;"], "b", (False, False)),
    ],
)
def test_what_is_known_of_a_variable(
    lines: list[str], name: str, wanted: tuple[bool, bool]
) -> None:
    assert known(program(*lines), name) == wanted


def test_only_rounding_that_changes_nothing_is_left_out() -> None:
    made = without_needless_rounding(program("a = round(b)", "a = round(level) + round(part)"))
    assert made == program("a = b", "a = round(level) + part")
