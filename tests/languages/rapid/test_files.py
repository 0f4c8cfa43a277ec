"""Bytes of files: encodings, line ends, program lists, and what is no text."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import compiler, languages
from assistant.base.diagnostics import Refused
from assistant.languages.rapid.reading.files import listed, newline_of
from tests.examples import drawn
from tests.tables import every_row

RAPID = languages.get("rapid")
MODULE = (
    'MODULE m\n  ! Größe\n  CONST string a:="ä";\n  PROC main()\n    Stop;\n  ENDPROC\nENDMODULE\n'
)
ENCODINGS = ("utf-8-sig", "utf-8", "cp1252", "latin-1", "utf-16-le", "utf-16-be")


@every_row("newline", ["\n", "\r\n", "\r"])
@every_row("encoding", ENCODINGS)
def test_every_encoding_and_line_end_comes_back(encoding: str, newline: str) -> None:
    mark = "\ufeff" if encoding.startswith("utf-16") else ""
    data = (mark + MODULE.replace("\n", newline)).encode(encoding)
    source = RAPID.decode(data)
    tree = RAPID.parse(source)
    assert not [f for f in tree.findings if f.severity == "error"]
    assert [f.code for f in tree.findings] == (["RA106"] if mark else [])
    assert RAPID.encode(tree) == data
    assert source.newline == newline
    assert [module.name for module in tree.modules] == ["m"]
    assert tree == RAPID.parse(MODULE)
    assert RAPID.recognises(data)


@settings(max_examples=drawn(60), deadline=None)
@given(
    st.lists(st.sampled_from([*MODULE.split("\n"), "a:=1", "é", "! “”", "", "\0", "#"])),
    st.sampled_from(["\n", "\r\n", "\r", "\n\r", "\r\r\n"]),
    st.sampled_from(ENCODINGS[:2]),
)
def test_any_lines_come_back_as_the_same_bytes(
    lines: list[str], newline: str, encoding: str
) -> None:
    data = newline.join(lines).encode(encoding)
    assert RAPID.encode(RAPID.parse(RAPID.decode(data))) == data


def test_lines_of_old_macintosh_files_are_counted() -> None:
    text = "MODULE m\rPROC p()\ra = 1;\rENDPROC\rENDMODULE\r"
    (finding,) = RAPID.parse(text).findings
    assert (finding.line, finding.column, finding.excerpt) == (3, 3, "a = 1;")


def test_doubled_carriage_returns_are_told() -> None:
    findings = RAPID.parse(MODULE.replace("\n", "\r\r\n")).findings
    assert [f.code for f in findings] == ["RA107"]


def test_an_encrypted_module_is_named_as_such(tmp_path: Path) -> None:
    data = bytes([0xF0, *random.Random(1).choices(range(256), k=3000)])
    assert RAPID.recognises(data)
    tree = RAPID.parse(RAPID.decode(data))
    (finding,) = tree.findings
    assert finding.code == "RA105"
    assert "encrypted" in finding.message
    assert RAPID.encode(tree) == data
    file = tmp_path / "locked.sys"
    file.write_bytes(data)
    with pytest.raises(Refused, match="encrypted"):
        compiler.load(file)


def test_wide_text_without_a_mark_is_told() -> None:
    (finding,) = RAPID.parse(RAPID.decode("MODULE m\nENDMODULE\n".encode("utf-16-le"))).findings
    assert "every other byte" in finding.message


def test_a_lone_zero_byte_has_its_place() -> None:
    (finding,) = RAPID.parse(MODULE.replace("Stop;", "Stop\0;")).findings
    assert (finding.line, finding.column) == (5, 9)
    assert "U+0000" in finding.message


LIST = (
    '<?xml version="1.0" encoding="ISO-8859-1" ?>\r\n<Program>\r\n'
    "\t<Module>one.mod</Module>\r\n\t<Module>a&amp;b.mod</Module>\r\n</Program>\r\n"
)


def test_a_program_list_gives_its_modules(tmp_path: Path) -> None:
    data = LIST.encode("latin-1")
    assert RAPID.recognises(data)
    assert RAPID.recognises(b"\xef\xbb\xbf" + data)
    tree = RAPID.parse(RAPID.decode(data))
    assert not tree.findings
    assert RAPID.called_files(tree) == listed(LIST) == ("one.mod", "a&b.mod")
    assert RAPID.encode(tree) == data
    assert RAPID.format(tree) == LIST
    (tmp_path / "cell.pgf").write_bytes(data)
    (tmp_path / "one.mod").write_text("MODULE one\nPROC main()\nrest;\nENDPROC\nENDMODULE\n")
    (tmp_path / "a&b.mod").write_text("MODULE b\nPROC rest()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    program = compiler.load(tmp_path / "cell.pgf").program
    assert {procedure.name for procedure in program.procedures} >= {"main", "rest"}


def test_other_xml_is_no_program_list() -> None:
    (finding,) = RAPID.parse("<?xml version='1.0'?>\n<Robot/>\n").findings
    assert finding.code == "RA105"
    assert not RAPID.recognises(b"<?xml version='1.0'?>\n<Robot/>\n")


@pytest.mark.parametrize(
    ("text", "newline"), [("", "\r\n"), ("a\nb", "\n"), ("a\r\nb\n", "\r\n"), ("a\rb", "\r")]
)
def test_new_lines_end_as_the_others(text: str, newline: str) -> None:
    assert newline_of(text) == newline


def test_a_damaged_file_is_not_compiled(tmp_path: Path) -> None:
    file = tmp_path / "m.mod"
    file.write_text(MODULE.replace("Stop;", "a = 1;\n    b == 2;"), encoding="utf-8")
    with pytest.raises(Refused) as refused:
        compiler.load(file)
    assert [f.line for f in refused.value.findings] == [5, 6]


@pytest.mark.parametrize(
    "text",
    ["PROC a()\n  Stop;\nENDPROC\n\nVAR num b;\n", "MoveL p1,v100,fine,tool0;\nStop;\n"],
)
def test_a_fragment_wants_only_its_module(text: str) -> None:
    (finding,) = RAPID.parse(text).findings
    assert "MODULE" in finding.cure
    assert len(RAPID.parse(text + "a = 1;\n").findings) == 2


def test_comments_in_east_asian_encodings_are_no_sign_of_an_encrypted_file() -> None:
    comment = "焊接程序：取料点与放料点".encode("gbk")
    data = b"MODULE m\n" + b"! " + comment + b"\nENDMODULE\n"
    source = RAPID.decode(data)
    tree = RAPID.parse(source)
    assert not tree.findings
    assert RAPID.encode(tree) == data


def test_a_program_of_another_vendor_is_not_taken_for_an_encrypted_module() -> None:
    comment = "自動化プログラム".encode("cp932")
    data = b"1 ' " + comment + b"\n2 MOV P1\n3 END\n"
    found = languages.of_file("1.prg", data)
    assert found is not None
    assert found.name.startswith("melfa-basic")


def test_prose_around_a_module_keeps_its_bytes() -> None:
    data = b"See the module below, with %%% in it.\nMODULE m\nENDMODULE\n%%% end %%%\n"
    tree = RAPID.parse(RAPID.decode(data))
    assert tree.findings
    assert RAPID.encode(tree) == data


@pytest.mark.parametrize(
    "text",
    [
        "MODULE a ! note\n(SYSMODULE)\nENDMODULE\n",
        "MODULE a\nPROC p()\nERROR ! note\n(ERR_DIVZERO)\nRETRY;\nENDPROC\nENDMODULE\n",
    ],
)
def test_a_comment_may_stand_before_a_parenthesis(text: str) -> None:
    tree = RAPID.parse(text)
    assert not tree.findings
    assert RAPID.render(tree) == text
