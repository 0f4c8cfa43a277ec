"""First values of arrays that do not fit: `check` and `translate` name the same numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import check
from assistant.compiler import translate

PLACE = "[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


@pytest.mark.parametrize(
    ("size", "values", "given", "wanted"),
    [
        ("3", "[1,2]", 2, 3),
        ("3", "[1,2,3,4]", 4, 3),
        ("2,2", "[[1,2],[3]]", 1, 2),
        ("3,2", "[[1,2],[3,4]]", 2, 3),
    ],
)
def test_the_report_names_the_fault_of_check(
    size: str, values: str, given: int, wanted: int, tmp_path: Path
) -> None:
    first = ",".join("1" for _ in size.split(","))
    source = tmp_path / "row.mod"
    source.write_text(
        f"MODULE row\nVAR num list{{{size}}}:={values};\nCONST robtarget near:={PLACE};\n"
        f"PROC main()\nMoveL Offs(near,0,0,list{{{first}}}),v100,fine,tool0;\nENDPROC\nENDMODULE\n",
        "ascii",
    )
    (told,) = (f for f in check(source).findings if f.code == "RA424")
    assert told.message == f"{given} elements are written for an array of {wanted}"
    done = translate(source, to="melfa-basic-6")
    (row,) = (row for row in done.rows if row.level == "not")
    assert row.text.startswith("VAR num list")
    assert any(f"{given} elements written for an array of {wanted}" in f.message
               for f in row.reasons)  # fmt: skip
