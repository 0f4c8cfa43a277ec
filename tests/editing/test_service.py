"""What editors ask beside findings: words, names, cures, outline, layout, translations."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused, Span
from assistant.editing import service
from assistant.editing.answers import MARKS, SORTS
from assistant.editing.service import Place, Workspace
from assistant.editing.text_lines import Lines
from tests.editing.typing import kept
from tests.tables import every_row

SAMPLES = Path(__file__).parent.parent.parent / "samples"
EVERY = kept()
FEW = ("samples-palletising.mod", "samples-PALLET.prg", "samples-around.pseudo")
EACH = [pytest.param(name, marks=() if name in FEW else pytest.mark.slow) for name in EVERY]
"""All of them, by `make test` a few."""


def opened(name, text=None):
    return Workspace().open(f"/nowhere/{name}", EVERY[name] if text is None else text)


def at(document, word, nth=0):
    """The place in the middle of a word."""
    offset = -1
    for _ in range(nth + 1):
        offset = document.text.index(word, offset + 1)
    return document.lines.place(offset + 1)


def changed(document, changes):
    """The text with changes of its file made."""
    text = document.text
    for one in sorted(changes, key=lambda one: one.range.start, reverse=True):
        span = document.lines.span(one.range)
        text = text[: span.start] + one.text + text[span.end :]
    return text


@pytest.mark.parametrize("text", ["", "a\r\nb\n\rc", "ä🤖\n𝄞x", "one\r\n", "\n\n"])
def test_places_and_offsets_are_the_same_both_ways(text):
    lines = Lines(text)
    for offset in range(len(text) + 1):
        if text[offset - 1 : offset + 1] == "\r\n":
            continue  # between the two there is no place
        assert lines.offset(lines.place(offset)) == offset
    assert lines.offset(Place(99, 0)) == len(text)
    assert lines.offset(Place(0, 99)) == len(lines.line(0))
    assert lines.span(lines.range(Span(0, len(text)))) == Span(0, len(text))


@pytest.mark.parametrize("name", EACH)
def test_tokens_are_the_words_of_each_line(name):
    document = opened(name)
    tokens = service.tokens(document)
    assert len(tokens) > 20
    assert (tokens.length > 0).all() and (tokens.sort < len(SORTS)).all()
    assert (tokens.marks < 1 << len(MARKS)).all()
    order = tokens.line * 10_000 + tokens.column
    assert (
        order[1:] >= order[:-1] + tokens.length[:-1] * (tokens.line[1:] == tokens.line[:-1])
    ).all()
    said = [
        document.lines.line(line).encode("utf-16-le")[2 * start : 2 * (start + length)]
        for line, start, length in zip(tokens.line, tokens.column, tokens.length, strict=True)
    ]
    left = "".join(document.text.split())
    assert "".join("".join(one.decode("utf-16-le").split()) for one in said) == left


@pytest.mark.parametrize("name", EACH)
def test_names_are_declared_used_and_renamed(name):
    """Each declaration is the definition of its uses; a renamed program has the same findings."""
    document = opened(name)
    before = [one.diagnostic.code for one in service.settled(document)]
    for line, facts in enumerate(document.facts):
        for one in facts.declares[:1]:
            if one.kind not in ("target", "variable", "procedure", "label") or one.implied:
                continue
            if one.name.startswith("Report"):
                continue  # called by a name that is worked out
            place = Place(line, one.start + 1)
            places = service.references(document, place)
            definition = service.definition(document, place)
            assert definition in places
            assert all(
                service.definition(document, use.range.start) == definition for use in places
            )
            new = one.name[:2] + "Q7"
            try:
                changes = service.rename(document, place, new)
            except Refused:
                continue
            text = changed(document, changes[document.path])
            again = Workspace().open(document.path, text)
            assert [x.diagnostic.code for x in service.settled(again)] == before, one.name
            break


def test_a_local_name_hides_a_global_one():
    text = (
        "MODULE a\n  VAR num x;\n  PROC main()\n    x:=1;\n  ENDPROC\n"
        '  PROC p(num x)\n    TPWrite ""\\Num:=x;\n  ENDPROC\nENDMODULE\n'
    )
    document = opened("a.mod", text)
    assert len(service.references(document, Place(1, 10))) == 2
    assert len(service.references(document, Place(5, 14))) == 2
    assert service.renameable(document, Place(3, 4)) is not None
    assert service.renameable(document, Place(6, 6)) is None
    with pytest.raises(Refused, match="ED003"):
        service.rename(document, Place(6, 6), "y")


@every_row(
    ("name", "word", "new", "code"),
    [
        ("samples-palletising.mod", "pHome:=", "main", "ED002"),
        ("samples-palletising.mod", "pHome:=", "MoveL", "ED001"),
        ("samples-palletising.mod", "pHome:=", "p Home", "ED001"),
        ("samples-PALLET.prg", "PHome=", "MHome", "ED001"),
        ("samples-PALLET.prg", "PHome=", "PPick", "ED002"),
        ("samples-PALLET.prg", "*PICK", "*P Q", "ED001"),
        ("samples-around.pseudo", "one [", "move", "ED001"),
    ],
)
def test_a_name_that_cannot_be_is_refused(name, word, new, code):
    document = opened(name)
    with pytest.raises(Refused, match=code):
        service.rename(document, at(document, word), new)


def test_names_are_renamed_in_all_files_of_a_task(tmp_path):
    one, other = tmp_path / "one.mod", tmp_path / "other.mod"
    one.write_text("MODULE one\n  PROC main()\n    help;\n  ENDPROC\nENDMODULE\n")
    other.write_text("MODULE other\n  PROC help()\n    Stop;\n  ENDPROC\nENDMODULE\n")
    document = Workspace().open(str(one), one.read_text())
    assert service.definition(document, Place(2, 5)).path == str(other)
    changes = service.rename(document, Place(2, 5), "assist")
    assert {path: len(made) for path, made in changes.items()} == {str(one): 1, str(other): 1}
    assert service.completions(document, Place(2, 6))[0].label == "help"


def test_what_a_word_means_is_told():
    document = opened("samples-palletising.mod")
    assert "straight line" in service.hover(document, at(document, "MoveL")).text
    assert "380.00 mm, 0.00 mm, 420.00 mm" in service.hover(document, at(document, "pHome")).text
    document = opened("samples-PALLET.prg")
    assert "straight line" in service.hover(document, at(document, "Mvs")).text
    assert "320.00 mm, 0.00 mm, 400.00 mm" in service.hover(document, at(document, "PHome=")).text
    assert "status" not in service.hover(document, at(document, "M_In")).text
    document = opened("samples-around.pseudo")
    assert "planned" in service.hover(document, at(document, "travel")).text
    assert "-10.00 mm, -60.00 mm" in service.hover(document, at(document, "one [")).text
    assert service.hover(document, Place(0, 4)) is None


def test_a_target_has_the_joints_of_the_projects_robot(tmp_path):
    (tmp_path / "assistant.toml").write_text(
        '[programs.one]\nsource = "one.pseudo"\nrobot = "irb1200-7-0.7"\nlanguage = "rapid"\n'
    )
    file = tmp_path / "one.pseudo"
    text = "program one\n\ntarget p [450, 0, 500] [0, 0, 1, 0]\n\nprocedure main\nend\n"
    file.write_text(text)
    document = Workspace(tmp_path).open(str(file), text)
    said = service.hover(document, Place(2, 7)).text
    assert "irb1200-7-0.7" in said and "°" in said


def test_a_position_of_five_axes_is_read_as_one(tmp_path):
    table = '[programs.lean]\nsource = "lean.mb4"\nrobot = "rv-2aj"\n'
    (tmp_path / "assistant.toml").write_text(table)
    file = tmp_path / "lean.mb4"
    text = "10 MOV P1\n20 END\nP1=(270.00,110.00,230.00,20.00,150.00)(6,0)\n"
    file.write_text(text)
    document = Workspace(tmp_path).open(str(file), text)
    said = service.hover(document, Place(2, 1)).text.rsplit(": ", 1)[1]
    j1, j2, j3, j5, j6 = (float(one.removesuffix("°")) for one in said.split(", "))
    assert j1 == pytest.approx(22.17, abs=0.005)  # by the tangent of 110 / 270
    assert j2 + j3 + j5 == pytest.approx(150.0, abs=0.02)  # B
    assert j6 == pytest.approx(20.0 + j1 * 0.866025, abs=0.02)  # A, with the cosine of B


@every_row(
    ("name", "line", "wanted"),
    [
        ("samples-palletising.mod", "        Pick", "PickBox"),
        ("samples-palletising.mod", "        MoveL pH", "pHome"),
        ("samples-palletising.mod", "        MoveL pHome,v100,fine,tVacuum\\W", "WObj"),
        ("samples-palletising.mod", "        nPlaced:=pHome.tr", "trans"),
        ("samples-PALLET.prg", "39 Mo", "Mov"),
        ("samples-PALLET.prg", "39 Mov PHo", "PHome"),
        ("samples-PALLET.prg", "39 PTo.Z=PFirst.", "X"),
        ("samples-around.pseudo", "  tra", "travel"),
    ],
)
def test_words_are_completed(name, line, wanted):
    text = EVERY[name].splitlines()
    begins = "        MoveJ pH", "39 ", "  move a"
    number = next(n for n, one in enumerate(text) if one.startswith(begins))
    text[number] = line
    document = opened(name, "\n".join(text))
    found = service.completions(document, Place(number, len(line)))
    assert found[0].label == wanted
    assert changed(document, []) == document.text
    prefix = document.lines.span(found[0].range)
    assert wanted.lower().startswith(document.text[prefix.start : prefix.end].lower())


def test_nothing_is_completed_in_comments_and_texts():
    document = opened("samples-palletising.mod")
    assert service.completions(document, Place(1, 10)) == ()


CURED = [
    ("samples-palletising.mod", "WaitTime 0.3;", "WaitTime 0.3", "RA103"),
    ("samples-palletising.mod", "        PickBox;", "        PickBix;", None),
    ("samples-palletising.mod", "MoveL pPick", "MoveL pPik", None),
    ("samples-palletising.mod", "ENDPROC\n\n    PROC Pick", "ENDPROCC\n\n    PROC Pick", None),
    ("samples-PALLET.prg", "HOpen 1", "HOpn 1", None),
    ("samples-PALLET.prg", "GoSub *PICK", "GoSub *PIKC", None),
    ("samples-around.pseudo", "  move absolute", "  mvoe absolute", None),
    ("samples-around.pseudo", "procedure main", "procedre main", None),
]


@pytest.mark.parametrize(("name", "right", "wrong", "code"), CURED)
def test_a_cure_that_is_an_edit_is_offered(name, right, wrong, code):
    """What is offered first takes the finding away, by a look at the whole."""
    text = EVERY[name]
    assert right in text
    document = opened(name, text.replace(right, wrong, 1))
    known = {(one.diagnostic.code, one.diagnostic.message) for one in service.settled(opened(name))}
    found = [
        one
        for one in service.settled(document)
        if (one.diagnostic.code, one.diagnostic.message) not in known
    ]
    cured = [(one, fix) for one in found for fix in service.fixes(document, one) if fix.preferred]
    assert cured, [str(one.diagnostic) for one in found]
    one, fix = cured[0]
    assert fix.code == one.diagnostic.code == (code or fix.code)
    again = opened(name, changed(document, fix.changes[document.path]))
    left = {(one.diagnostic.code, one.diagnostic.message) for one in service.settled(again)}
    assert (one.diagnostic.code, one.diagnostic.message) not in left


def test_a_finding_is_ignored_by_a_comment():
    text = EVERY["samples-palletising.mod"].replace("fine,tVacuum;", "fine,tVacum;", 1)
    document = opened("samples-palletising.mod", text)
    (found,) = service.settled(document)
    ignoring = service.fixes(document, found)[-1]
    assert ignoring.title == f"Ignore {found.diagnostic.code} here" and not ignoring.preferred
    again = opened(document.path, changed(document, ignoring.changes[document.path]))
    assert service.settled(again) == ()


@pytest.mark.parametrize("name", EACH)
def test_outlines_stand_inside_each_other(name):
    document = opened(name)

    def inside(items, least, most):
        for one in items:
            assert least <= one.range.start <= one.selection.start
            assert one.selection.end <= one.range.end <= most
            inside(one.children, one.range.start, one.range.end)

    found = service.outline(document)
    inside(found, Place(0, 0), document.lines.place(len(document.text)))


def test_the_outline_has_routines_records_and_labels():
    found = service.outline(opened("rapid-records.mod"))
    kinds = {one.kind for one in found[0].children}
    assert {"record", "procedure", "variable"} <= kinds
    assert [one.name for one in service.outline(opened("samples-PALLET.prg"))][-5] == "*PICK"


@pytest.mark.parametrize("name", EACH)
def test_the_layout_is_that_of_fmt(name):
    document = opened(name)
    text = changed(document, service.formatted(document))
    assert service.formatted(Workspace().open(document.path, text)) == ()
    loose = "\n".join(f"  {line}  " if line.strip() else line for line in text.splitlines()) + "\n"
    if document.language.startswith("melfa"):
        return  # blanks at the end may be part of a comment there
    if "%%%" in text:
        return  # nor may they be in a header
    moved = Workspace().open(document.path, loose)
    assert changed(moved, service.formatted(moved)).splitlines() == text.splitlines()


def test_what_cannot_be_laid_out_is_refused():
    document = opened("samples-palletising.mod", EVERY["samples-palletising.mod"][:-20])
    with pytest.raises(Refused):
        service.formatted(document)


@pytest.mark.parametrize(
    ("name", "to"),
    [
        ("samples-palletising.mod", "pseudo"),
        ("samples-gluing.mod", "melfa-basic-5"),
        ("samples-PALLET.prg", "pseudo"),
        ("melfa_basic-pick_and_place.mb4", "rapid"),
    ],
)
def test_each_line_stands_beside_what_it_became(name, to):
    document = opened(name)
    done = service.translation(document, to)
    assert done.files
    (text,) = [text for path, text in done.files.items() if path == next(iter(done.files))]
    written = text.splitlines()
    gone = [pair for pair in done.pairs if pair.written]
    assert len(gone) > 5
    for pair in gone:
        assert all(written[line].strip() for line in pair.written)
        assert all(0 <= line < len(document.lines) for line in pair.source)


def test_an_unknown_language_is_refused_and_what_cannot_be_read_is_told():
    document = opened("samples-palletising.mod")
    with pytest.raises(Refused):
        service.translation(document, "karel")
    broken = opened("samples-palletising.mod", document.text.replace(";", "", 1))
    done = service.translation(broken, "pseudo")
    assert not done.files and done.findings
