"""Persistent data: shared by its name, kept from run to run, and written back into its module."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Said
from assistant.virtual.rapid import run
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.value_text import saved

TEXT = r'''MODULE Cell
    ! count of what was made
    PERS num  made := 1 ;  ! kept
    PERS num same:=0x10;
    PERS pos place:=[ 1, 2 ,3 ];
    LOCAL PERS string note:="a ""b""";
    TASK PERS num row{2}:=[1,2];
    PERS num bare;
    PERS num other_bare;
    PERS dnum fine_:=0.1;
    VAR num gone:=1;

    PROC main()
        made := made + 0.1;
        place.y := -2.5E10;
        note := "c\5C" + "\07";
        row{2} := 7;
        bare := 3;
        fine_ := fine_ + 0.2;
        Incr gone;
        TPWrite ""\Num:=made;
        TPWrite ""\Num:=gone;
    ENDPROC
ENDMODULE
'''


def parsed(text: str) -> s.File:
    file = languages.get("rapid").parse(text)
    assert file.findings == ()
    return file


def said(files: list[s.File], controller: Controller) -> list[str]:
    found = run(files, controller=controller)
    assert (found.ended, found.message) == ("end", "")
    return [event.text for event in found.events if isinstance(event, Said)]


def test_values_are_written_back_and_all_else_stays() -> None:
    file, controller = parsed(TEXT), Controller()
    said([file], controller)
    expected = TEXT
    for old, new in (
        ("made := 1 ;", "made := 1.1 ;"),
        ("[ 1, 2 ,3 ]", "[1,-2.5E10,3]"),
        ('"a ""b"""', r'"c\\\07"'),
        ("row{2}:=[1,2]", "row{2}:=[1,7]"),
        ("PERS num bare;", "PERS num bare := 3;"),
        ("dnum fine_:=0.1", "dnum fine_:=0.30000000000000004"),
    ):
        assert expected.count(old) == 1
        expected = expected.replace(old, new)
    assert saved(controller, file) == expected


def test_what_was_written_back_runs_on_as_the_data_itself() -> None:
    first, controller = parsed(TEXT), Controller()
    assert said([first], controller) == ["1.1", "2"]
    again = Controller()
    second = parsed(saved(controller, first))
    assert said([second], again) == said([first], controller) == ["1.2", "2"]
    assert saved(again, second).replace(" := 1.2 ;", "") == (
        saved(controller, first).replace(" := 1.2 ;", "")
    )


def test_a_persistent_of_several_modules_is_one() -> None:
    main = "MODULE A\nPERS num shared;\nPROC main()\nshared:=shared+1;\nsub;\nENDPROC\nENDMODULE\n"
    said_ = 'PROC sub()\nTPWrite ""\\Num:=shared;\nENDPROC'
    other = f"MODULE B\nPERS num shared := 4;\n{said_}\nENDMODULE\n"
    files, controller = [parsed(main), parsed(other)], Controller()
    assert said(files, controller) == ["5"]
    assert saved(controller, files[0]) == main.replace("shared;", "shared := 5;", 1)
    assert saved(controller, files[1]) == other.replace(":= 4", ":= 5")


def test_a_file_that_did_not_run_has_no_values() -> None:
    with pytest.raises(ValueError, match="not run"):
        saved(Controller(), parsed(TEXT))
