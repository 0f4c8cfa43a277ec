"""What the text form looks like, and how freely it may be written by hand."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from assistant.base.diagnostics import Refused
from assistant.program.expressions import Binary, Expression, Name, Number, Text, Unary
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.program import Declaration, Procedure, Program, walk
from assistant.program.pseudo import SUFFIX, parse, print_program, read
from assistant.program.statements import (
    Assign,
    Comment,
    Message,
    Opaque,
    Return,
    Statement,
    Wait,
    While,
)
from tests.strategies import HOSTILE_TEXTS
from tests.tables import every_row

FIXTURES = FilePath(__file__).parent / "fixtures"
LINES = [
    line for line in (FIXTURES / "lines.txt").read_text(encoding="utf-8").splitlines()[1:] if line
]


def in_main(*lines: str) -> str:
    return "\n".join(
        ["program p", "", "procedure main", *(f"  {line}" for line in lines), "end", ""]
    )


def printed_body(text: str) -> list[str]:
    """The lines of the only procedure, as they are printed."""
    return [line[2:] for line in print_program(parse(text)).text.splitlines()[3:-1]]


def body(*lines: str) -> tuple[Statement, ...]:
    return parse(in_main(*lines)).procedures[0].body


def test_a_whole_program_reads_and_prints_the_same() -> None:
    text = (FIXTURES / f"plate{SUFFIX}").read_text(encoding="utf-8")
    assert print_program(parse(text)).text == text


def test_a_file_is_read_with_its_encoding(tmp_path: FilePath) -> None:
    text = (FIXTURES / "plate.pseudo").read_text(encoding="utf-8")
    file = tmp_path / "plate.pseudo"
    file.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert read(file) == parse(text)


@every_row("line", LINES)
def test_a_line_prints_as_it_was_read(line: str) -> None:
    assert printed_body(in_main(line)) == [line]


@every_row(
    ("written", "printed"),
    [
        ("  wait   1   s", "wait 1 s"),
        ("wait .5 s", None),
        ("wait 1 s # why", "# why\n  wait 1 s"),
        ("x = (((a)))", "x = a"),
        ("x = - 5", "x = -5"),
        ("x = (a * b) + c", "x = a * b + c"),
        ("call f()", "call f"),
        ("opaque rapid |x := 1;", "opaque rapid | x := 1;"),
        ('opaque rapid "x := 1;"', "opaque rapid | x := 1;"),
        ("#comment", "# comment"),
        ('#"not ended', '# "not ended'),
        ("`plain` = 1", "plain = 1"),
        ("move linear p speed 5mm/s blend 1mm", "move linear p speed 5 mm/s blend 1 mm"),
        ("stop  ", "stop"),
        ("for i from 1 to 3 step 1\n  end", "for i from 1 to 3\n  end"),
        ("for i from 1  towards  n\n  end", "for i from 1 towards n\n  end"),
        ("if a\n  else\n  end", "if a\n  end"),
    ],
)  # fmt: skip
def test_what_is_written_by_hand_prints_one_way(written: str, printed: str | None) -> None:
    if printed is None:
        with pytest.raises(Refused):
            parse(in_main(written))
        return
    assert print_program(parse(in_main(written))).text == in_main(printed)


# ------------------------------------------------------------------------------ expressions


A, B, C = Name("a"), Name("b"), Name("c")


@every_row(
    ("text", "meant"),
    [
        ("a - b - c", Binary("-", Binary("-", A, B), C)),
        ("a ^ b ^ c", Binary("^", A, Binary("^", B, C))),
        ("-a ^ b", Unary("-", Binary("^", A, B))),
        ("-a * b", Binary("*", Unary("-", A), B)),
        ("a + b * c", Binary("+", A, Binary("*", B, C))),
        ("not a = b", Unary("not", Binary("=", A, B))),
        ("a or b and c", Binary("or", A, Binary("and", B, C))),
        ("a xor b and c", Binary("xor", A, Binary("and", B, C))),
        ("a or b xor c", Binary("or", A, Binary("xor", B, C))),
        ("a < b and b < c", Binary("and", Binary("<", A, B), Binary("<", B, C))),
        ("a @ b @ c", Binary("@", Binary("@", A, B), C)),
        ("-5", Number(-5)),
        ("-(5)", Unary("-", Number(5))),
    ],
)
def test_operators_bind_as_stated(text: str, meant: Expression) -> None:
    assert body(f"return {text}") == (Return(meant),)


def test_a_number_keeps_its_type() -> None:
    (one, two) = body("return 1", "return 1.0")
    assert isinstance(one, Return) and isinstance(two, Return)
    assert isinstance(one.value, Number) and isinstance(one.value.value, int)
    assert isinstance(two.value, Number) and isinstance(two.value.value, float)


# --------------------------------------------------------------------------------- comments


def test_comments_stay_where_the_program_has_a_place_for_them() -> None:
    text = (
        "# head\nprogram p\n\nprocedure main\n  # one\n  if a\n    # two\n  end\n  # three\nend\n"
    )
    assert print_program(parse(text)).text == text


def test_no_comment_is_lost() -> None:
    text = """\
    # 0
    program p # 1
    # 2
    tool g # 3
    # 4
    procedure main # 5
      # 6
      variable i integer # 7
      switch i # 8
      # 9
      case 1 # 10
        follow seam # 11
          # 12
          linear [0, 0, 0] [1, 0, 0, 0] speed 1 mm/s blend fine # 13
        end # 14
      else # 15
        opaque rapid # 16
          | a # this is RAPID
          # 17
          "b" # 18
        end # 19
      end # 20
    end # 21
    # 22
    """
    program = parse(text)
    inner = [s.text for p in program.procedures for s in walk(p.body) if isinstance(s, Comment)]
    assert sorted([*program.comments, *inner], key=int) == [str(n) for n in range(23)]
    assert program.comments == ("0", "1", "2", "3", "21", "22")
    assert print_program(parse(print_program(program).text)) == print_program(program)


def test_a_mark_of_comment_inside_a_text_or_a_name_is_no_comment() -> None:
    program = parse(in_main('message "# a", `#b` # c'))
    assert program.procedures[0].body == (
        Comment("c"),
        Message((Text("# a"), Name("#b"))),
    )


# ---------------------------------------------------------------------------- hostile texts


@every_row("text", HOSTILE_TEXTS)
def test_hostile_texts_come_back_and_never_leave_their_line(text: str) -> None:
    program = Program(
        "p",
        (
            Procedure(
                "main",
                (
                    Comment(text),
                    Message((Text(text),)),
                    Opaque("rapid", text),
                    Assign(Name(text), Name("x")),
                    While(Name("x"), (Opaque("rapid", text), Comment(text))),
                ),
            ),
        ),
        comments=(text, text),
        robot=text,
        declarations=(Declaration(text, text),),
    )
    printed = print_program(program).text
    assert parse(printed.encode().decode()) == program
    lines = len(text.split("\n"))
    opaque = 1 if lines == 1 else lines + 2
    assert len(printed.splitlines()) == 13 + 3 * opaque


# -------------------------------------------------------------------------- order and depth


def test_equal_programs_print_equally() -> None:
    turned = [(f"p{i}", Target(Pose((float(i), 0.0, 0.0)))) for i in (10, 2, 1)]
    one = Program("p", targets=dict(turned))
    other = Program("p", targets=dict(reversed(turned)))
    assert one == other
    text = print_program(one).text
    assert text == print_program(other).text
    assert [line.split()[1] for line in text.splitlines()[2:]] == ["p1", "p2", "p10"]


def test_a_short_list_of_external_axes_means_that_the_others_are_unused() -> None:
    program = parse("program p\njoints j [1, 2] external [5]\n")
    nan = float("nan")
    assert program.joint_targets["j"] == JointTarget((1.0, 2.0), (5.0, nan, nan, nan, nan, nan))


@pytest.mark.parametrize("levels", [90, 95, 300, 3000])
def test_what_is_printed_can_be_read_however_deep_it_is(levels: int) -> None:
    chain: Expression = Name("a")
    for _ in range(levels - 1):
        chain = Binary("+", chain, Name("a"))
    deep: Statement = Wait(Number(1))
    for _ in range(levels - 1):
        deep = While(Name("a"), (deep,))
    for statement in (Return(chain), deep):
        program = Program("p", (Procedure("main", (statement,)),))
        try:
            text = print_program(program).text
        except Refused as refused:
            assert refused.findings[0].code == "PS105"
            assert levels > 50
        else:
            assert parse(text) == program


def test_blocks_nest_as_deep_as_is_said() -> None:
    deep: Statement = Wait(Number(1))
    for _ in range(50):
        deep = While(Name("a"), (deep,))
    program = Program("p", (Procedure("main", (deep,)),))
    assert parse(print_program(program).text) == program
    deeper = Program("p", (Procedure("main", (While(Name("a"), (deep,)),)),))
    with pytest.raises(Refused, match="block is nested too deeply"):
        print_program(deeper)
