"""Findings while one types: those of the whole program, at once, and none that flickers."""

from __future__ import annotations

import random
import re

import pytest

from assistant.base.diagnostics import has_errors
from assistant.base.source_text import SourceText
from assistant.compiler.checker import check_text
from assistant.editing import service
from assistant.editing.live_findings import SMALL
from assistant.editing.service import Change, Place, Range, Workspace
from assistant.findings.severities import apply_severities
from tests.editing.typing import kept, lines_that_close, lines_to_damage, made, typed

MODULE = """MODULE Small
    CONST robtarget pHome:=[[380,0,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num nUnused;

    PROC main()
        MoveJ pHome,v100,fine,tool0;
        helper 1;
    ENDPROC

    PROC helper(num n)
        TPWrite "x"\\Num:=n;
    ENDPROC
ENDMODULE
"""


def told(found):
    return [(one.diagnostic.code, one.range, one.diagnostic.message) for one in found]


def on_others(found, line):
    """Findings that begin on other lines than one."""
    return sorted(one for one in told(found) if one[1].start.line != line)


def with_line(workspace, document, number, text):
    """The document with another text of a line."""
    there = document.lines.line(number)
    whole = Range(Place(number, 0), Place(number, len(there.encode("utf-16-le")) // 2))
    change = Change(whole, text)
    return workspace.change(document.path, [change], document.version + 1)


def retyped(workspace, document, number):
    """Each state of a line that is typed anew, with what is found then, in a text of others."""
    for state in typed(document.lines.line(number)):
        document = with_line(workspace, document, number, state)
        yield document, service.findings(document)


def is_damaged(found, line):
    return any(one.range.start.line == line and has_errors([one.diagnostic]) for one in found)


def is_unreadable(document):
    return bool(document.spoken.syntax(document.source))


@pytest.mark.parametrize("name", ["code450.mod"])
def test_no_finding_flickers_on_sound_lines(name):
    check_no_flicker(name, made()[name], lambda text, mark: lines_to_damage(text, mark)[:1])


@pytest.mark.parametrize("name", ["code450.mod", "code450.mb5", "code450.mb6"])
def test_a_block_that_nothing_closes_ends_where_it_did(name):
    closing = check_no_flicker(name, made()[name], lambda text, _: lines_that_close(text)[:1])
    assert closing >= 3


def check_no_flicker(name, text, chosen):
    """How often a damaged state was looked at; other lines have what they had when all was sound.

    chosen: lines to damage, of a text and what begins a comment in it.

    What a line says on the way may be sound, and mean something for others: `GoSub *A`, which
    becomes `GoSub *AB`.
    """
    workspace = Workspace()
    document = workspace.open(f"/nowhere/{name}", text)
    before = service.settled(document)
    damaged = 0
    for number in chosen(text, document.spoken.mark):
        others = on_others(before, number)
        for state, found in retyped(workspace, document, number):
            document = state
            if not is_unreadable(document):
                others = on_others(found, number)
                continue
            damaged += 1
            assert is_damaged(found, number), (name, number, state.lines.line(number))
            assert on_others(found, number) == others, (name, number, state.lines.line(number))
        assert told(found) == told(before)
    return damaged


@pytest.mark.slow
def test_no_finding_flickers_in_any_file(tell):
    texts = {**kept(), **made()}
    damaged = 0
    for name, text in texts.items():
        damaged += check_no_flicker(
            name, text, lambda text, mark: [*lines_to_damage(text, mark), *lines_that_close(text)]
        )
    lines = sum(len(text.splitlines()) for text in texts.values())
    tell(f"{len(texts)} files, {lines:,} lines: {damaged:,} damaged states, no finding flickered")
    assert len(texts) >= 20 and damaged > 200


@pytest.mark.slow
def test_what_is_found_at_once_is_what_is_found_in_the_whole(tell):
    """Lines are taken out and put elsewhere; the quick look agrees with the whole, but for rules
    that ask about the whole program, at lines that did not change."""
    draws, same, states = random.Random(23), 0, 0
    for name, text in made().items():
        workspace = Workspace()
        document = workspace.open(f"/nowhere/{name}", text)
        service.settled(document)
        for number in lines_to_damage(text, document.spoken.mark):
            other = draws.randrange(5, len(document.lines) - 5)
            document = with_line(workspace, document, number, document.lines.line(other))
            here = [one for one in told(service.findings(document)) if one[1].start.line == number]
            whole = Workspace().open(document.path, document.text)
            there = [one for one in told(service.settled(whole)) if one[1].start.line == number]
            states += 1
            same += here == there
            service.settled(document)
    tell(f"{same} of {states} changed lines have at once the findings that the whole gives them")
    assert same >= states * 0.9


@pytest.mark.parametrize("comment", ["", "ignore-file RA204", "ignore RA204"])
def test_what_a_comment_ignores_is_not_told_of_a_line_that_is_typed(comment):
    lines = made()["code450.mod"].splitlines()
    number = next(n for n, line in enumerate(lines) if n > SMALL and re.search(r",v\d+,", line))
    at = 1 if "file" in comment else number
    lines.insert(at, f"    ! assistant: {comment}" if comment else "")
    workspace = Workspace()
    document = workspace.open("/nowhere/ignoring.mod", "\r\n".join(lines))
    service.settled(document)
    changed = re.sub(r",v\d+,", ",v99,", document.lines.line(number + 1))
    document = with_line(workspace, document, number + 1, changed)
    codes = [
        one.diagnostic.code
        for one in service.findings(document)
        if one.range.start.line == number + 1 and "v99" in one.diagnostic.message
    ]
    assert codes == ([] if comment else ["RA204"])


@pytest.mark.parametrize("name", ["samples-palletising.mod", "samples-PALLET.prg"])
def test_the_whole_is_what_check_finds(name):
    text = kept()[name].replace("PickBox;", "PickBx;").replace("GoSub *PICK", "GoSub *PIK")
    document = Workspace().open(f"/nowhere/{name}", text)
    found = service.settled(document)
    source = SourceText(text, document.path, "utf-8", "\n")
    checked = check_text(source, language=document.language)
    expected = apply_severities(checked.findings, checked.texts).left
    assert found and {one.diagnostic.code for one in found} == {one.code for one in expected}


def test_a_declaration_that_goes_is_told_where_it_was_used():
    workspace = Workspace()
    document = workspace.open("/nowhere/Small.mod", MODULE)
    service.settled(document)
    document = with_line(workspace, document, 1, "")
    found = service.findings(document)
    assert any("pHome" in one.diagnostic.message and one.range.start.line == 5 for one in found)
    assert not found[0].settled
    assert all(one.settled for one in service.settled(document))


def test_a_damaged_line_leaves_other_changes_to_be_looked_at():
    workspace = Workspace()
    document = workspace.open("/nowhere/Small.mod", MODULE)
    service.settled(document)
    document = with_line(workspace, document, 10, '        TPWrite "x"\\Num:=')
    assert is_damaged(service.findings(document), 10)
    document = with_line(workspace, document, 5, "        MoveJ pHom,v100,fine,tool0;")
    found = service.findings(document)
    assert any("pHom" in one.diagnostic.message for one in found)
    assert is_damaged(found, 10)
    assert told(service.settled(document)) == told(found)


def test_a_file_that_is_damaged_from_the_start_has_its_findings():
    text = MODULE.replace("ENDPROC", "ENDPRC", 1)
    document = Workspace().open("/nowhere/Small.mod", text)
    assert any(has_errors([one.diagnostic]) for one in service.findings(document))


def test_what_is_no_program_has_no_findings():
    document = Workspace().open("/nowhere/notes.txt", "\x00\x01 nothing")
    assert document.language == "" and service.settled(document) == ()
    assert len(service.tokens(document)) == 0 and service.outline(document) == ()


def test_a_task_is_looked_at_with_what_is_open(tmp_path):
    one, other = tmp_path / "one.mod", tmp_path / "other.mod"
    one.write_text("MODULE one\n    PROC main()\n        help;\n    ENDPROC\nENDMODULE\n")
    other.write_text("MODULE other\n    PROC help()\n        Stop;\n    ENDPROC\nENDMODULE\n")
    workspace = Workspace()
    document = workspace.open(str(one), one.read_text())
    assert service.settled(document) == ()
    beside = workspace.open(str(other), other.read_text())
    beside = workspace.change(beside.path, beside.text.replace("help", "halp"), 1)
    assert [one.diagnostic.code for one in service.settled(document)] == ["RA402"]
    workspace.close(beside.path)
    assert service.settled(document) == ()


def test_a_backup_keeps_a_task_in_two_folders(tmp_path):
    for folder in ("PROGMOD", "SYSMOD", "HOME"):
        (tmp_path / "RAPID" / "TASK1" / folder).mkdir(parents=True)
    one = tmp_path / "RAPID" / "TASK1" / "PROGMOD" / "one.mod"
    other = tmp_path / "RAPID" / "TASK1" / "SYSMOD" / "other.sys"
    one.write_text("MODULE one\n    PROC main()\n        help;\n    ENDPROC\nENDMODULE\n")
    other.write_text(
        "MODULE other(SYSMODULE)\n    PROC help()\n        Stop;\n    ENDPROC\nENDMODULE\n"
    )
    document = Workspace().open(str(one), one.read_text())
    assert service.definition(document, Place(2, 9)).path == str(other)
    assert service.settled(document) == ()
