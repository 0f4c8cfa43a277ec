"""Which files are taken for MELFA-BASIC, in which version, and in which encoding."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.source_text import SourceText
from tests.tables import every_row

FOUR, FIVE, SIX = (languages.get(f"melfa-basic-{n}") for n in (4, 5, 6))
PLACE = "P1=(+1.00,+2.00,+3.00,+180.00,+0.00,+180.00)(7,0)\r\n"


def name_of(file: str, text: str | bytes) -> str | None:
    data = text if isinstance(text, bytes) else text.encode()
    found = languages.of_file(file, data)
    return None if found is None else found.name


@every_row(
    ("file", "text", "expected"),
    [
        ("A.prg", "10 MOV P1\r\n20 END\r\n" + PLACE, "melfa-basic-4"),
        ("A.prg", "10 MOV P1\r\n20 M1=M_IN8(3)\r\n", "melfa-basic-5"),
        ("A.prg", "10 IF M1=1 THEN\r\n20 MOV P1\r\n30 ENDIF\r\n", "melfa-basic-5"),
        ("A.prg", "1 Mov P1\r\n2 End\r\n", "melfa-basic-5"),
        ("A.prg", "1 Function V Main()\r\n2 FEnd\r\n", "melfa-basic-6"),
        ("A.prg", "1 Def Work W1\r\n", "melfa-basic-6"),
        ("A.prg", "Count=1\nWhile 1\nMov PHome\nWait M_In8(100)<>0\nWEnd\n", "melfa-basic-5"),
        ("cell.txt", "mA=5\nmB=0\nM_Out(130)=0\nIf M_In(3)=1 Then Mov pHome\n", "melfa-basic-5"),
        ("Code", "10 OVRD 30\n20 MOV P1\n30 HOPEN 1\n", "melfa-basic-4"),
        ("A.mb5", "10 MOV P1\r\n20 END\r\n", "melfa-basic-5"),
        ("A.MB6", "10 MOV P1\r\n20 END\r\n", "melfa-basic-6"),
        ("list.pos", "DEF POS P1=(1.00,2.00,3.00,0.00,90.00)(6,0)\r\n", "melfa-basic-4"),
        ("P.prg", PLACE, "melfa-basic-4"),
        ("A.prg", "1 'nothing yet\r\n", "melfa-basic-5"),
        ("A.prg", "MODULE m\r\nPROC main()\r\nStop;\r\nENDPROC\r\nENDMODULE\r\n", "rapid"),
        ("notes.txt", "Dear reader,\nthis is a text.\nIf you like it, then say so.\n", None),
        ("table.txt", "x,y,z\n1,2,3\n4,5,6\n", None),
        ("script", "#!/bin/sh\nx=1\nif [ $x = 1 ]; then echo; fi\n", None),
        ("module.txt", "import os\nx = 1\ny = x + 1\n", None),
        ("A.prg", "", None),
    ],
)  # fmt: skip
def test_files_are_known_by_their_text(file: str, text: str, expected: str | None) -> None:
    assert name_of(file, text) == expected


@pytest.mark.parametrize(
    ("file", "level"), [("A.MB4", 4), ("A.mb5", 5), ("A.mb6", 6), ("A.prg", 4), ("A", 4)]
)
def test_files_of_the_controller_are_named_as_such(file: str, level: int) -> None:
    data = b"ROBPRG\x00\x01" + bytes(range(256))
    language = languages.of_file(file, data)
    assert language is not None
    assert language.name == f"melfa-basic-{level}"
    with pytest.raises(Unreadable) as refused:
        language.decode(data, file)
    (finding,) = refused.value.findings
    assert (finding.code, finding.path) == ("MB001", file)
    assert "text" in finding.cure


@every_row(
    ("comment", "encoding"),
    [
        ("ロボット", "cp932"),
        ("ﾛﾎﾞｯﾄ", "cp932"),
        ("Zähler für Öfen, Prüfgröße", "cp1252"),
        ("położenie części", "cp1250"),
        ("doğrusal hareket başı", "cp1254"),
        ("Zähler ロボット", "utf-8"),
        ("Zähler ロボット", "utf-8-sig"),
        ("plain", "ascii"),
    ],
)
@every_row("newline", ["\r\n", "\n", "\r"])
def test_bytes_come_back(comment: str, encoding: str, newline: str) -> None:
    text = newline.join(["1 '" + comment, "2 Mvs P1", "M1=3 '\"", ""])
    source = FIVE.decode(text.encode(encoding))
    assert (source.text, source.encoding, source.newline) == (text, encoding, newline)
    tree = FIVE.parse(source)
    assert not tree.findings
    assert len(tree.items) == 3
    assert FIVE.encode(tree) == text.encode(encoding)


@pytest.mark.parametrize(
    ("text", "encoding"),
    [("Mov", "ascii"), ("Zähler", "cp1252"), ("ロボット", "cp932"), ("Zähler ロボット", "utf-8")],
)
def test_new_text_goes_out_in_an_encoding_that_it_is_read_in(text: str, encoding: str) -> None:
    tree = FIVE.parse(f"1 '{text}\r\n")
    assert FIVE.encode(tree) == f"1 '{text}\r\n".encode(encoding)
    assert FIVE.decode(FIVE.encode(tree)).text == f"1 '{text}\r\n"


@pytest.mark.parametrize("encoding", ["cp1252", "cp1250", "cp1254"])
def test_a_character_that_the_encoding_of_the_file_lacks_is_refused(encoding: str) -> None:
    text = "1 'ok\r\n2 'Zähler ロボット\r\n"
    with pytest.raises(Refused) as refused:
        FIVE.encode(FIVE.parse(SourceText(text, None, encoding)))
    (finding,) = refused.value.findings
    assert (finding.code, finding.line, finding.column) == ("IN007", 2, 11)


def test_a_character_that_no_encoding_has_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        FIVE.encode(FIVE.parse("1 'ok\r\n2 'Zähler \ud800\r\n"))
    (finding,) = refused.value.findings
    assert (finding.code, finding.line, finding.column) == ("IN007", 2, 11)


def test_the_command_line_names_a_tokenised_file(tmp_path: Path) -> None:
    from assistant.cli import main

    file = tmp_path / "P1.MB5"
    file.write_bytes(b"ROBPRG" + bytes(range(200)))
    for command in ("check", "show"):
        with pytest.raises(SystemExit) as ended:
            main([command, str(file)])
        assert ended.value.code == 2
