"""What a report says of the reasons that cost a translation most."""

from pathlib import Path

from assistant.compiler import translate
from assistant.report.translation import Translated, costs, report_markdown, report_record, summary

MODULE = """MODULE Cell
  PROC main()
    Rewind f;
    WaitTime 1;
    Rewind g;
    WaitTime 2;
    TPErase;
    SearchL\\Stop,d,p,q,v100,t;
  ENDPROC
ENDMODULE
"""


def translated(folder: Path, text: str = MODULE) -> Translated:
    file = folder / "Cell`s.mod"
    file.write_text(text)
    return Translated(str(file), translate(file, to="melfa-basic-6"))


def test_like_statements_have_one_reason_and_the_most_come_first(tmp_path: Path) -> None:
    one = translated(tmp_path)
    (first, second, *others) = costs(one.translation.rows)
    assert (first.level, first.count, first.place.line) == ("not", 2, 3)
    assert "Rewind f" in first.message
    assert first.cure
    assert (second.level, second.count, second.place.line) == ("not", 1, 8)
    assert all(cost.level == "partial" for cost in others)
    assert costs(one.translation.rows, most=1) == [first]


def test_a_record_tells_them_with_the_share_that_is_said(tmp_path: Path) -> None:
    answer = report_record(translated(tmp_path))
    assert answer["totals"]["not"] == 3
    assert answer["said_percent"] == 57.1  # of main, which is counted, and six statements
    assert [r["statements"] for r in answer["reasons"][:2]] == [2, 1]


def test_markdown_is_a_comment_that_no_program_can_leave(tmp_path: Path) -> None:
    told = report_markdown([translated(tmp_path)])
    assert "| 4 | " not in told.splitlines()[0]
    assert "Cell`s.mod ``" in told.splitlines()[2]
    assert "| 57.1 % |" in told.splitlines()[2]
    (row,) = (line for line in told.splitlines() if "Rewind" in line)
    assert row.startswith("| 2 | not | ``")


def test_a_program_that_is_whole_costs_nothing(tmp_path: Path) -> None:
    one = translated(tmp_path, "MODULE m\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    assert costs(one.translation.rows) == []
    assert report_record(one)["said_percent"] == 100
    assert "reason" not in report_markdown([one])


def test_changed_statements_are_counted_by_code(tmp_path: Path) -> None:
    shown = "".join(f'TPWrite "{word}";\n' for word in "abcdefghijkl")
    stops = "TPErase;\n" * 2
    one = translated(tmp_path, f"MODULE m\nPROC main()\n{shown}{stops}ENDPROC\nENDMODULE\n")
    rows = [row for row in one.translation.rows if row.level == "partial"]
    told = [line.split()[:6:5] for line in summary(one) if line.startswith("  ") and line[2] != " "]
    assert told == [["12", "MB211"], ["2", "RA311"]]
    assert len(rows) == 14


def test_no_code_of_many_reasons_vanishes(tmp_path: Path) -> None:
    words = ["Rewind f", *(f"SearchL\\Stop,d,p{n},q,v100,t" for n in range(15))]
    lines = "".join(f"{word};\n" for word in words)
    one = translated(tmp_path, f"MODULE m\nPROC main()\n{lines}ENDPROC\nENDMODULE\n")
    lost = {row.reasons[0].code for row in one.translation.rows if row.level == "not"}
    told = "\n".join(summary(one))
    assert all(code in told for code in lost)
    assert len(told.splitlines()) < 80
