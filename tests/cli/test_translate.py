"""`translate`: reports for people and programs, exit statuses, nothing half done."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest

from assistant.base.source_text import SourceText
from assistant.cli import main
from assistant.languages.melfa_basic import MelfaBasic
from assistant.languages.melfa_basic.tree.syntax import File
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.view.cases import data_of

SAMPLES = Path(__file__).parents[2] / "samples"
PALLET = SAMPLES / "melfa" / "PALLET.prg"
CELL = SAMPLES / "melfa" / "cell.process.toml"
TO_RAPID = ("--to", "rapid", "-r", "irb1200-7-0.7", "--from-robot", "rv-4frl", "-p", CELL)

Capture = pytest.CaptureFixture[str]
FILE_MODULE = """MODULE files
  VAR iodev ioFile;
  PROC main()
    WaitTime 1;
    Open "HOME:/a.txt",ioFile\\Read;
    Rewind ioFile;
    SetDO doDone,1;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def exchange(tmp_path: Path) -> Path:
    """A module that rewinds a file, in line 6, which no other language can."""
    file = tmp_path / "in" / "files.mod"
    file.parent.mkdir()
    file.write_text(FILE_MODULE)
    return file


def test_a_program_that_can_be_said_is_written(tmp_path: Path, capsys: Capture) -> None:
    status, out, _ = run(capsys, "translate", PALLET, *TO_RAPID, "-o", tmp_path, "--all")
    assert status == 0
    lines = out.splitlines()
    assert f"{PALLET}:13: partial: 13 Mov PHome -> PALLET.mod:23" in lines
    assert f"{PALLET}:12: supported: 12 Cnt 0" in lines
    assert any(line.startswith("    CO509 ") for line in lines)
    assert lines[-1] == f"wrote {tmp_path / 'PALLET.mod'}"
    module = (tmp_path / "PALLET.mod").read_text()
    assert "MoveJ PHome" in module.splitlines()[22]
    assert module.count("load of tool PGripper") == 1


def test_what_cannot_be_said_is_a_stop_in_a_draft(
    tmp_path: Path, exchange: Path, capsys: Capture
) -> None:
    """And a draft is no success; nothing is written if none is wanted."""
    to = ("translate", exchange, "--to", "melfa-basic-5", "-o", tmp_path / "out")
    status, out, _ = run(capsys, *to, "--no-draft")
    assert status == 1
    lines = out.splitlines()
    assert f"    {exchange}:6: Rewind ioFile" in lines
    assert lines[0].endswith("; nothing is written: MB209 in `main`")
    assert [file.name for file in (tmp_path / "out").glob("[!.]*")] == ["cell.toml"]
    status, out, _ = run(capsys, *to)
    assert status == 1
    assert "a draft, which lacks 1 value and stops at 1 statement\n" in out
    (file,) = (tmp_path / "out").glob("*.prg")
    assert file.read_text().startswith("1 ' DRAFT")


def test_a_summary_has_reasons_first_places_and_how_many_more(
    tmp_path: Path, capsys: Capture
) -> None:
    module = tmp_path / "many.mod"
    asks = [f"  PulseDO\\PLength:=0.5,do{n};\n  Rewind io;" for n in range(7)]
    text = ["MODULE many", "VAR iodev io;", "PROC main()", *asks, "ENDPROC", "ENDMODULE", ""]
    module.write_text("\n".join(text))
    _, out, _ = run(capsys, "translate", module, "--to", "melfa-basic-6", "-o", tmp_path / "o")
    lines = out.splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("  7 not translated: "))
    assert lines[0].startswith(f"{module}: ")
    assert "% translated: 9 of 16 statements" in lines[0]
    assert lines[first + 1].startswith(f"    {module}:5: Rewind io -> MANY.prg:")
    assert lines[first + 6] == "    and 2 more"
    assert not any(line.startswith(f"{module}:3:") for line in lines)


def test_the_answer_in_json_and_findings_at_their_lines(
    tmp_path: Path, exchange: Path, capsys: Capture
) -> None:
    made = tmp_path / "out"
    given = ("translate", exchange, "--to", "melfa-basic-6", "-o", made, "--format")
    status, out, _ = run(capsys, *given, "json")
    answer = json.loads(out)
    cell = str(made / "cell.toml")
    assert (status, answer["ok"]) == (1, False)
    assert answer["written"] == [str(made / "FILES.prg"), cell]
    assert answer["next"][0].endswith(f" --format json --cell {cell}")
    (program,) = answer["programs"]
    (lack,) = program["wanting"]
    assert (lack["name"], lack["kind"], lack["uses"]) == (
        "doDone",
        "digital output",
        ["files.mod:7"],
    )
    assert (program["cell"], program["draft"]) == (cell, True)
    rewind = next(s for s in program["statements"] if s["line"] == 6)
    assert (rewind["level"], rewind["text"]) == ("not", "Rewind ioFile")
    assert rewind["reasons"][0]["code"] == "MB209"
    counts = [s["level"] for s in program["statements"]]
    assert {k: v for k, v in program["totals"].items() if v} == {
        level: counts.count(level) for level in set(counts)
    }
    for form, place in (("sarif", '"startLine": 6'), ("github", "line=6")):
        status, out, _ = run(capsys, *given, form)
        assert (status, place in out) == (1, True), form


def test_reports_are_written_as_their_suffix_says(
    tmp_path: Path, exchange: Path, capsys: Capture
) -> None:
    for name in ("r.html", "r.json", "r.txt"):
        given = ("translate", exchange, "--to", "melfa-basic-6", "-o", tmp_path / "out")
        assert run(capsys, *given, "--report", tmp_path / name)[0] == 1
    html = (tmp_path / "r.html").read_text()
    beside = data_of(html)["beside"]
    assert "Rewind ioFile" in beside["texts"][0]["lines"][5]
    assert beside["reasons"]["6"].startswith("MB209")
    assert "SetDO doDone,1" in html
    (data,) = json.loads((tmp_path / "r.json").read_text())
    assert data["statements"][0]["line"] == 2
    assert ":6: not: Rewind ioFile" in (tmp_path / "r.txt").read_text()


def test_a_page_holds_texts_as_texts(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "m.mod"
    source.write_text('MODULE m\nPROC main()\nOpen "<script>",f;\nENDPROC\nENDMODULE\n')
    report = tmp_path / "r.html"
    given = ("translate", source, "--to", "melfa-basic-6", "-o", tmp_path / "out")
    run(capsys, *given, "--report", report)
    page = report.read_text()
    assert 'Open "<script>"' in data_of(page)["beside"]["texts"][0]["lines"][2]
    assert page.count("<script>") == 2  # the library that draws, and what uses it


def test_names_are_written_as_a_table(tmp_path: Path, capsys: Capture) -> None:
    module, table = tmp_path / "n.mod", tmp_path / "names.csv"
    module.write_text(
        """MODULE n
  RECORD box
    num width;
  ENDRECORD
  VAR box one;
  VAR num nParts:=1;
  VAR num nUnused:=2;
  PROC main()
    VAR num nParts:=4;
    one.width:=nParts;
    place_part one.width;
  ENDPROC
  PROC place_part(num nHow)
    again:
    nParts:=nParts+nHow;
    IF nParts<9 GOTO again;
  ENDPROC
ENDMODULE
"""
    )
    rows = {}
    for level in ("4", "6"):
        to = f"melfa-basic-{level}"
        run(capsys, "translate", module, "--to", to, "-o", tmp_path / level, "--names", table)
        (file,) = (tmp_path / level).glob("[!.]*")
        with table.open() as lines:
            for row in csv.DictReader(lines):
                assert not row["new"] or row["new"] in file.read_text()
                rows[level, row["kind"], row["routine"], row["old"]] = row["new"], row["line"]
    assert rows["6", "procedure", "", "place_part"] == ("place_part", "13")
    assert rows["4", "procedure", "", "place_part"] == ("PLACPART", "13")
    assert rows["6", "parameter", "place_part", "nHow"] == ("MnHow", "")
    assert rows["4", "parameter", "place_part", "nHow"] == ("MNHOW", "")
    assert rows["6", "variable", "", "nParts"] == ("MnParts", "6")
    assert rows["6", "variable", "main", "nParts"] == ("MnParts2", "9")
    assert rows["6", "data", "", "one"] == ("Mone_width", "5")
    assert rows["6", "label", "place_part", "again"] == ("again", "")
    assert rows["6", "procedure", "", "main"] == ("Main", "8")


def test_standard_input(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(PALLET.read_bytes())))
    status, out, _ = run(capsys, "translate", "-", *TO_RAPID, "-o", tmp_path, "--all")
    assert status == 0
    assert "standard input:12: supported: 12 Cnt 0" in out


def test_files_of_one_name_in_two_folders_have_a_folder_each(
    tmp_path: Path, capsys: Capture
) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "PALLET.prg").write_bytes(PALLET.read_bytes())
    out = tmp_path / "out"
    status, said, err = run(capsys, "translate", tmp_path, *TO_RAPID, "-o", out)
    assert status == 0
    assert "2 programs, 2 of them complete\n" in said
    assert "CL001" in err
    assert (out / "a_PALLET" / "PALLET.mod").read_bytes()
    assert (out / "b_PALLET" / "PALLET.mod").read_bytes()


FINE = "1 Tool P_NTool\n2 Base P_NBase\n3 Mvs P1\n4 End\nP1=(400,0,300,180,0,180)(7,0)\n"
BAD = {
    "a syntax error": ("1 Mvs Mvs\n", 1),
    "no program": ("nothing at all", 2),
    "a value that nobody states": ('1 Open "COM1:" As #1\n2 End\n', 1),
}


def test_each_program_answers_for_itself(tmp_path: Path, capsys: Capture) -> None:
    def check(kind: str, order: int) -> None:
        folder = tmp_path / f"{kind}{order}"
        folder.mkdir()
        text, worst = BAD[kind]
        (folder / "GOOD.prg").write_text(FINE)
        bad = folder / ("BAD.txt" if worst == 2 else "BAD.prg")
        bad.write_text(text)
        both = [folder / "GOOD.prg", bad][::order]
        given = ("translate", *both, "--to", "rapid", "--no-draft", "-o", folder / "out")
        status, _, err = run(capsys, *given)
        assert status == worst
        assert "BAD" in err or kind == "a value that nobody states"
        assert [path.name for path in (folder / "out").glob("*.mod")] == ["GOOD.mod"]

    each([(kind, order) for kind in BAD for order in (1, -1)], check)


INSIDE = {
    "translate": ("--to", "rapid", "-o", "OUT"),
    "check": (),
    "fmt": (),
    "compile": ("-l", "rapid", "-o", "OUT"),
}


def test_what_fails_inside_is_the_finding_of_one_program(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    parse = MelfaBasic.parse

    def parsed(self: MelfaBasic, source: SourceText) -> File:
        if isinstance(source, SourceText) and "FAULT" in (source.path or ""):
            raise KeyError("inside")
        return parse(self, source)

    monkeypatch.setattr(MelfaBasic, "parse", parsed)
    monkeypatch.delenv("ROBOT_ASSISTANT_TRACEBACK", raising=False)

    def check(command: str) -> None:
        out = tmp_path / command
        names = [tmp_path / f"{name}.prg" for name in ("FIRST", "FAULT", "LAST")]
        for name in names:
            name.write_text(FINE)
        options = [str(out) if word == "OUT" else word for word in INSIDE[command]]
        with pytest.raises(SystemExit) as ended:
            main([command, *map(str, names), "--from", "melfa-basic-5", *options])
        said, err = capsys.readouterr()
        assert ended.value.code == 2
        assert err.count("CL900 error") == 1
        assert "FAULT.prg" in err
        if "-o" in options:
            written = sorted(path.name for path in out.glob("*.mod"))
            assert written == ["FIRST.mod", "LAST.mod"]
        else:
            assert "3 checked" in said or "2 files" in said

    each(INSIDE, check)


def test_parts_that_a_program_loads_are_translated_with_it(tmp_path: Path, capsys: Capture) -> None:
    rows = "".join(f"{300 + i},0,300,0,1,0,0\n" for i in range(30))
    source = tmp_path / "seam.csv"
    source.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n" + rows)
    made = tmp_path / "made"
    run(capsys, "compile", source, "-l", "rapid", "--most-targets", "10", "-o", made)
    files = sorted(made.glob("*.mod"))
    assert len(files) == 4
    out = tmp_path / "out"
    status, said, err = run(capsys, "translate", *files, "--to", "melfa-basic-5", "-o", out)
    assert (status, said.count("proven:")) == (0, 1)
    assert len(list(out.glob("[!.]*"))) == 4
    status, _, err = run(capsys, "translate", files[1], "--to", "melfa-basic-5", "-o", out)
    assert status == 1
    assert "CO008" in err and "CO102" not in err


WRONG = (
    ["nowhere.mod", "--to", "rapid"],
    [str(PALLET), "--to", "karel"],
    [str(PALLET), "--to", "rapid", "-r", "r2d2"],
    [str(SAMPLES / "plate.dxf"), "--to", "rapid"],
    [str(PALLET)],
    [str(PALLET), "--to", "rapid", "-p", "nowhere.toml"],
)


def test_wrong_usage_is_2(tmp_path: Path, capsys: Capture) -> None:
    output = tmp_path / "out"

    def check(given: list[str]) -> None:
        status, _, err = run(capsys, "translate", *given, "-o", output)
        assert status == 2
        assert err
        assert not output.exists()

    each(WRONG, check)


def test_a_program_is_not_written_over(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "PALLET.prg"
    source.write_bytes(PALLET.read_bytes())
    for command in (("translate", source, "--to"), ("compile", source, "-l")):
        status, _, err = run(capsys, *command, "melfa-basic-6", "-o", tmp_path)
        assert status == 2 and "CL007" in err
    status, _, err = run(capsys, "translate", source, *TO_RAPID, "-o", tmp_path, "--report", source)
    assert status == 2 and "CL007" in err
    assert source.read_bytes() == PALLET.read_bytes()
    assert list(tmp_path.iterdir()) == [source]


def test_nothing_on_standard_input_is_no_program(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"")))
    status, _, err = run(
        capsys, "translate", "-", "--from", "rapid", "--to", "melfa-basic-5", "-o", tmp_path
    )
    assert status == 2 and "IN005" in err
    assert list(tmp_path.iterdir()) == []


PART = """1 Tool P_NTool
2 Base P_NBase
3 Spd 100
4 If M_In(3)=1 Then GoTo *LEFT
5 Wait M_In(4)=1
6 Mov P1
7 *LEFT
8 M_Out(9)=1
9 End
P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
"""


def test_a_proof_by_motion(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "PART.prg"
    source.write_text(PART)
    given = ("translate", source, *TO_RAPID[:-2], "-o", tmp_path / "out", "--prove", "--seed", "2")
    status, out, _ = run(capsys, *given)
    assert status == 0
    assert f"{source}: text read back: proven: " in out
    assert f"{source}: motion compared: branches taken: 2 of 2 in PART.prg" in out
    assert "5 runs, 4 visits, 5 signal changes and 5 waits for inputs" in out
    assert "0.0000 degrees: proven; not compared: speeds of joint moves" in out
    assert (tmp_path / "out" / "PART.mod").is_file()
    status, out, _ = run(capsys, *given, "--format", "json")
    (program,) = json.loads(out)["programs"]
    assert (status, program["motion"]["holds"], program["motion"]["visits"]) == (0, True, 4)
    assert program["motion"]["branches"][1] == {"program": "PART.mod", "taken": 2, "of": 2}


def test_nothing_is_written_without_the_proof_that_was_asked_for(
    tmp_path: Path, capsys: Capture
) -> None:
    program = tmp_path / "PART.prg"
    program.write_text(
        "1 Spd 100\n2 Mvs P1\n3 M1=M_Mode\n4 Dly M1\n5 End\n"
        "P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)\n"
    )
    given = ("translate", program, "--to", "melfa-basic-6", "-o", tmp_path / "out")
    assert run(capsys, *given, "--from", "melfa-basic-5")[0] == 0
    (tmp_path / "out" / "PART.prg").unlink()
    status, out, err = run(capsys, *given, "--from", "melfa-basic-5", "--prove")
    assert status == 1
    assert f"{program}: motion compared: not proven\n" in out
    assert "CO111 error" in err and "M_Mode" in err.replace("M_MODE", "M_Mode")
    assert list((tmp_path / "out").glob("[!.]*")) == []


def test_a_script_without_a_proof_and_programs_to_standard_output_are_refused(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, err = run(capsys, "translate", PALLET, *TO_RAPID, "--signals", tmp_path / "s.toml")
    assert status == 2
    assert "CL020" in err
    status, out, err = run(capsys, "translate", PALLET, *TO_RAPID, "-o", "-")
    assert (status, out) == (2, "")
    assert "CL014" in err
    assert list(tmp_path.iterdir()) == []


def test_rows_of_several_modules_name_their_file(tmp_path: Path, capsys: Capture) -> None:
    for name, odd in (("one", "IPathPos"), ("two", "OddOne")):
        call = "    ptwo;\n" if name == "one" else ""
        text = f"MODULE {name}\n  PROC p{name}()\n    {odd};\n{call}  ENDPROC\nENDMODULE\n"
        (tmp_path / f"{name}.mod").write_text(text)
    (tmp_path / "all.pgf").write_text(
        '<?xml version="1.0"?><Program><Module>one.mod</Module><Module>two.mod</Module></Program>'
    )
    given = (tmp_path / "all.pgf", "--to", "melfa-basic-5", "--entry", "pone")
    for kind in ("md", "txt"):
        report = tmp_path / f"report.{kind}"
        _, said, _ = run(capsys, "translate", *given, "-o", tmp_path / "out", "--report", report)
        for name in ("one", "two"):
            assert f"{name}.mod:3" in report.read_text("utf-8"), kind
            assert f"{name}.mod:3" in said


def test_a_report_says_why_a_program_is_not_in_it(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "in").mkdir()
    broken = tmp_path / "in" / "broken.mod"
    broken.write_text("MODULE broken\n  PROC main()\n    reg1 = 5;\n  ENDPROC\nENDMODULE\n")
    mainless = tmp_path / "in" / "part.mod"
    mainless.write_text("MODULE part\n  PROC glue()\n    WaitTime 1;\n  ENDPROC\nENDMODULE\n")
    for kind in ("md", "json", "txt"):
        report = tmp_path / f"report.{kind}"
        given = (broken, mainless, "--to", "melfa-basic-5", "-o", tmp_path / "out")
        status, _, _ = run(capsys, "translate", *given, "--report", report)
        told = report.read_text("utf-8")
        assert status == 1
        assert "RA101" in told and "broken.mod" in told and "MB245" in told, kind
    records = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert [one["ok"] for one in records] == [False, False]
    assert records[1]["source"] == str(broken)


REACHED = """MODULE reached
  VAR num n;
  PROC main()
    WaitDI diGo,1;
    {}
    SetDO doDone,1;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(
    ("statement", "script", "said"),
    [
        ("IF DInput(diPart)=1 n:=1;", "", "proven by motion along 2 of 2 branches"),
        (
            "IF DInput(diPart)=1 n:=1;",
            '[[set]]\ninput = "diGo"\nvalue = 1\n',
            "proven by motion along 1 of 2 branches alone, 50 %",
        ),
        ("n:=1;", "", "proven by motion"),
        (
            "SetDO doDone,1;\n    WaitDI diPart,1;\n    IF n=1 n:=2;",
            '[[set]]\ninput = "diGo"\nvalue = 1\n',
            "along 0 of 2 branches alone, 0 %, and not past the wait at reached.mod:6",
        ),
    ],
)
def test_the_first_line_says_how_far_a_proof_reached(
    tmp_path: Path, capsys: Capture, statement: str, script: str, said: str
) -> None:
    (tmp_path / "reached.mod").write_text(REACHED.format(statement))
    numbers = {"diGo": ("input", 8), "diPart": ("input", 9), "doDone": ("output", 10)}
    text = "".join(
        f'[signals.{name}]\nkind = "digital"\ndirection = "{way}"\nnumber = {number}\n'
        for name, (way, number) in numbers.items()
    )
    (tmp_path / "cell.toml").write_text(text)
    (tmp_path / "script.toml").write_text(script)
    more = ("--signals", tmp_path / "script.toml") if script else ()
    to = ("--to", "melfa-basic-6", "-o", tmp_path / "out", "--prove", *more)
    _, out, _ = run(capsys, "translate", tmp_path / "reached.mod", *to)
    assert out.splitlines()[0].endswith(said), out


def part(name: str) -> str:
    return f"MODULE {name}\nPROC run_{name}()\nSetDO x,1;\nENDPROC\nENDMODULE\n"


def test_json_has_every_command_that_goes_on(tmp_path: Path, capsys: Capture) -> None:
    for name in ("a", "b"):
        (tmp_path / f"{name}.mod").write_text(part(name))
    cell = tmp_path / "cell.toml"
    cell.write_text('[signals.x]\nkind = "digital"\ndirection = "output"\nnumber = 9\n')
    given = ("translate", tmp_path / "a.mod", tmp_path / "b.mod", "--to", "melfa-basic-6")
    _, said, _ = run(capsys, *given, "--cell", cell)
    _, out, _ = run(capsys, *given, "--cell", cell, "--format", "json")
    shown = [line.removeprefix("then: ") for line in said.splitlines() if line.startswith("then: ")]
    assert len(shown) == 2 and "--entry run_b" in shown[1]
    assert [one.replace(" --format json", "") for one in json.loads(out)["next"]] == shown


@pytest.mark.parametrize("others", [(), ("b.mod",)])
def test_the_command_that_goes_on_from_standard_input_is_fed_a_file(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch, others: tuple[str, ...]
) -> None:
    (tmp_path / "b.mod").write_text(part("b"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(part("a").encode())))
    _, said, _ = run(capsys, "translate", "-", *others, "--to", "melfa-basic-6")
    (line,) = (line for line in said.splitlines() if line.startswith("then: "))
    assert line.startswith("then: robot-assistant translate - ") and line.endswith(" < FILE")
