"""Where findings about a move are: the file and line of the move, of several files as well."""

from pathlib import Path

from assistant.compiler import compile, translate
from assistant.compiler.checker import check_files
from assistant.compiler.loader import load

FIRST = """MODULE First
  PROC main()
    MoveJ [[400,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
    other;
  ENDPROC
ENDMODULE
"""
OTHER = (
    FIRST.replace("First", "Other")
    .replace("main", "other")
    .replace("    other;", "    Stop;")
    .replace("[400,0,500]", "[9000,0,50]")
)
"""Its statements have the places in their file that those of the first one have."""
LIST = "<Program><Module>First.mod</Module><Module>Other.mod</Module></Program>"


def cell(folder: Path) -> Path:
    for name, text in (("First.mod", FIRST), ("Other.mod", OTHER), ("Cell.pgf", LIST)):
        (folder / name).write_text(text)
    return folder / "Cell.pgf"


def test_a_move_that_is_out_of_reach_is_told_in_the_file_of_the_move(tmp_path: Path) -> None:
    checked = check_files([str(cell(tmp_path))], robot="irb1200-7-0.7")
    (found,) = (f for f in checked.findings if f.code == "RB102")
    assert (Path(found.path or "").name, found.line) == ("Other.mod", 3)
    assert found.place == "move 1 of other"


def test_so_it_is_in_a_translation(tmp_path: Path) -> None:
    done = translate(
        cell(tmp_path), to="melfa-basic-6", from_robot="irb1200-7-0.7", robot="rv-4frl"
    )
    (found,) = (f for f in done.whole if f.code == "RB102")
    assert (Path(found.path or "").name, found.line) == ("Other.mod", 3)


def test_an_arc_counts_as_two_targets(tmp_path: Path) -> None:
    pose = "[[{},0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    near, via, far = (pose.format(x) for x in (400, 420, 9000))
    file = tmp_path / "Arc.mod"
    file.write_text(
        f"MODULE Arc\nPROC main()\nMoveL {near},v100,fine,tool0;\n"
        f"MoveC {via},{near},v100,fine,tool0;\nMoveL {far},v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    )
    found = check_files([str(file)], robot="irb1200-7-0.7").findings
    assert [f.line for f in found if f.code == "RB102"] == [5]


def test_what_a_pseudo_program_lacks_is_told_at_its_line(tmp_path: Path) -> None:
    file = tmp_path / "cell.pseudo"
    file.write_text("program cell\n\nprocedure main\n  wait pause s\nend\n")
    found = compile(load(str(file)), language="melfa-basic-5").findings
    assert [f.line for f in found if f.code == "MB229"] == [4]
