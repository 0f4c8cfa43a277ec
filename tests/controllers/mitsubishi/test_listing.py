"""The one form in which two listings of a MELFA-BASIC program are compared."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.controllers.mitsubishi.link import parse_answer
from assistant.controllers.mitsubishi.programs import listed_form
from assistant.controllers.mitsubishi.session import LOOK_IT_UP, cr_error

PROGRAM = (
    b'10 MOV P1\r\n20 \'Comment  stays\r\n30 PRINT #1,"a  b;c"\r\n'
    b"P1=(+1.00,-2.50,+0.00,+0.00,+0.00,+0.00)(7,0)\r\n"
    b"P10=(+1.00,+2.00,+3.00,+0.00,+0.00,+0.00)(6,15728640)\r\n"
)


@pytest.mark.parametrize(
    "other",
    [
        PROGRAM.replace(b"\r\n", b"\n"),
        PROGRAM.replace(b"MOV P1", b"Mov   P1"),
        PROGRAM.replace(b"10 MOV", b"0010  mov"),
        PROGRAM.replace(b"-2.50,+0.00", b" -2.5, -0.001"),
        PROGRAM + b"\r\n\r\n",
        b"10 END\r\n" + PROGRAM,
        b"".join(reversed(PROGRAM.splitlines(keepends=True))),
    ],
)
def test_spellings_of_the_same_program(other):
    assert listed_form(other) == listed_form(PROGRAM)


@pytest.mark.parametrize(
    "other",
    [
        PROGRAM.replace(b"MOV P1", b"MVS P1"),
        PROGRAM.replace(b"MOV P1", b"MOV P10"),
        PROGRAM.replace(b"Comment  stays", b"Comment stays"),
        PROGRAM.replace(b'"a  b;c"', b'"a b;c"'),
        PROGRAM.replace(b"-2.50", b"+2.50"),
        PROGRAM.replace(b"-2.50", b"-2.51"),
        PROGRAM.replace(b"(7,0)", b"(6,0)"),
        PROGRAM.replace(b"20 'Comment  stays\r\n", b""),
        PROGRAM.replace(b"P10=", b"P11="),
        PROGRAM + b"40 ACT 1=1\r\n",
    ],
)
def test_differences_that_matter(other):
    assert listed_form(other) != listed_form(PROGRAM)


def test_a_blank_that_means_something_is_kept():
    assert listed_form(b"10 ACT 1=1") != listed_form(b"10 ACT1=1")


@given(st.binary(max_size=300))
def test_listing_any_bytes_settles(data):
    assert listed_form(listed_form(data)) == listed_form(data)


@given(st.lists(st.floats(-99999, 99999), min_size=6, max_size=6))
def test_two_decimals_are_what_counts(values):
    printed = ",".join(f"{v:+.2f}" for v in values)
    long = ",".join(f"{float(f'{v:.2f}'):.4f}" for v in values)
    left, right = f"P1=({printed})(7,0)\r\n", f"p1 = ( {long} ) ( 7, 0 )\n"
    assert listed_form(left.encode()) == listed_form(right.encode())


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        ("QoK", ("", None, (), False)),
        ("Qok4140;2", ("4140;2", None, (), True)),
        ("QeR4220;3;17", ("4220;3;17", 4220, (3, 17), False)),
        ("Qer6010", ("6010", 6010, (), True)),
        ("qok1", ("1", None, (), True)),
        ("QoKQoK", ("QoK", None, (), False)),
    ],
)
def test_answers(raw, expected):
    answer = parse_answer(raw)
    assert answer is not None
    assert (answer.text, answer.number, answer.places, answer.alarmed) == expected


@pytest.mark.parametrize("raw", ["", "Q", "220 FTP ready", "QeR", "QeRxx", "QeR42", " QoK"])
def test_what_is_no_answer(raw):
    assert parse_answer(raw) is None


def test_error_numbers_have_a_text_and_a_cure():
    assert "syntax" in cr_error(4220).text and cr_error(4220).level == "L"
    assert cr_error(50).level == "H"
    assert cr_error(7499).text and cr_error(7499).cure == LOOK_IT_UP
    for number in range(10000):
        assert cr_error(number).text and cr_error(number).cure
