"""Changes of programs carried from a controller's text into ours, and both sides merged."""

import random

import pytest

from assistant.base.text_merge import in_layout, merged, says_the_same
from assistant.controllers.mitsubishi import programs

OWN = b"""\
MODULE m
  ! a comment
  CONST num a := 1.50;   ! one and a half

  CONST pos p := [ [0, -2],
                   [3, 4] ];
  PROC main()
    go a,  p;
  ENDPROC
ENDMODULE
"""


def plain(data):
    return data


@pytest.mark.parametrize(
    ("there", "expected"),
    [
        (OWN.replace(b"\n\n", b"\n").replace(b"  ", b" "), OWN),
        (OWN.replace(b"1.50", b"1.5").replace(b" := ", b":="), OWN),
        (OWN.replace(b" ! one and a half", b"! one and a half"), OWN),
        (
            OWN.replace(b"[ [0, -2],\n                   [3, 4] ]", b"[[0,7.25],[3,-4]]"),
            OWN.replace(b"0, -2", b"0, 7.25").replace(b"3, 4", b"3, -4"),
        ),
        (OWN.replace(b"go a,  p", b"stop"), OWN.replace(b"go a,  p", b"stop")),
        (
            OWN.replace(b"    go", b"    wait 1;\r\n    go"),
            OWN.replace(b"    go", b"    wait 1;\n    go"),
        ),
        (OWN.replace(b"  ! a comment\n", b""), OWN.replace(b"  ! a comment\n", b"")),
        (OWN.replace(b"\n", b"\r\n"), OWN),
    ],
)
def test_what_says_the_same_stays_as_it_was_written(there, expected):
    assert in_layout(OWN, there, plain) == expected


def test_comments_that_a_memory_does_not_keep_stay():
    there = (
        b"MODULE m\nCONST num a:=1.5;\nCONST pos p:=[[0,-2],\n[3,-4.5]];\n"
        b"PROC main()\ngo a,p;\nENDPROC\nENDMODULE\n"
    )
    expected = OWN.replace(b"[3, 4]", b"[3, -4.5]")
    assert in_layout(OWN, there, plain, "!") == expected
    other = OWN.replace(b"1.50;   ! one and a half", b"1.75;   ! more")
    both = merged(OWN, other, there, plain, "!")
    assert both == other.replace(b"[3, 4]", b"[3, -4.5]")
    assert in_layout(OWN, there, plain).count(b"!") < 2, "elsewhere a comment counts"


CR = b"10 MOV P2\r\n20 DLY 0.5  ' wait\r\n30 END\r\nP2=(+1.234,+2.00)\r\nP1=(3,+4)\r\n"


def test_values_that_a_controller_lists_by_name_keep_their_places_and_digits():
    there = programs.listed_form(CR).replace(b"+3.00", b"+3.25")
    assert there.index(b"P1=") < there.index(b"P2=")
    assert in_layout(CR, there, programs.listed_form) == CR.replace(b"(3,", b"(+3.25,")
    own = CR.replace(b"DLY 0.5", b"DLY 0.75")
    both = merged(CR, own, there, programs.listed_form)
    assert both == own.replace(b"(3,", b"(+3.25,")
    assert merged(CR, both, there, programs.listed_form) == both, "it is not brought home twice"


def test_both_sides_are_kept_and_one_place_is_nobodys():
    there = OWN.replace(b"[3, 4]", b"[3, 5]")
    ours = OWN.replace(b"1.50", b"1.75").replace(b"    go", b"    wait 1;\n    go")
    both = merged(OWN, ours, there, plain)
    assert both == ours.replace(b"[3, 4]", b"[3, 5]")
    assert says_the_same(merged(OWN, both, there, plain), both, plain)
    assert merged(OWN, OWN.replace(b"[3, 4]", b"[3, 6]"), there, plain) is None
    assert merged(OWN, OWN.replace(b"[3, 4]", b"[3, 5]"), there, plain) is not None
    gone = OWN.replace(b"    go a,  p;\n", b"")
    assert merged(OWN, gone, OWN.replace(b"go a", b"go b"), plain) is None


def test_merging_knows_no_sides():
    """What one changes and the other does not is what either order gives."""
    rng = random.Random(7)
    lines = [b"word%d := %d;" % (i, rng.randrange(9)) for i in range(30)]

    def changed(numbers):
        found = list(lines)
        for i in numbers:
            found[i] = rng.choice([b"", b"other%d;" % i, b"word%d := 99;\nmore;" % i])
        return b"\n".join(line for line in found if line) + b"\n"

    base = b"\n".join(lines) + b"\n"
    for _ in range(30):
        numbers = rng.sample(range(1, 29, 3), 6)
        one, other = changed(numbers[:3]), changed(numbers[3:])
        both = merged(base, one, other, plain)
        assert both is not None and both == merged(base, other, one, plain)
        assert merged(base, base, one, plain) == one == merged(base, one, base, plain)


def test_changes_between_hundreds_of_lines_that_are_alike():
    lines = [b"step%d;" % (i % 7) for i in range(300)]

    def with_lines(*added):
        found = list(lines)
        for place, line in reversed(added):
            found.insert(place, line)
        return b"\n".join(found) + b"\n"

    own, there = ((10, b"own1;"), (290, b"own2;")), ((100, b"there1;"), (200, b"there2;"))
    both = merged(with_lines(), with_lines(*own), with_lines(*there), plain)
    assert both == with_lines(*sorted((*own, *there)))


def test_thousands_of_lines_that_are_alike():
    lines = [b"P%d=(+1.00)" % i if i % 2 else b"END" for i in range(6000)]
    base = b"\n".join(lines) + b"\n"
    there = base.replace(b"P3=(+1.00)", b"P3=(+2.00)").replace(b"P5999=(+1", b"P5999=(+3")
    assert in_layout(base, there, plain) == there
    own = base.replace(b"P7=(+1.00)", b"P7=(+8.00)")
    assert merged(base, own, there, plain) == there.replace(b"P7=(+1.00)", b"P7=(+8.00)")
