"""Programs for a cell that exists: its names, and what it has already, run beside its own modules.

What they do is told by the interpreters of `assistant.virtual`, which share nothing with what
gives the names.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import ezdxf
import pytest

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler import Compiled, compile, translate
from assistant.compiler.checker import check_files
from assistant.compiler.combine import combine_sources
from assistant.compiler.loader import Loaded
from assistant.languages.language_types import Frames
from assistant.program.geometry import Pose
from assistant.project import build, project_of
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Moved, Run
from assistant.virtual.melfa.options import Options
from assistant.virtual.proving.comparison import difference

PROCESS = """
[motion]
tool = "gun"
frame = "table"
[tools.gun]
tip = [0, 0, 120]
mass = 1
centre = [0, 0, 50]
{tool}
[frames.table]
position = [300, 0, 200]
{frame}
[signals.gun_on]
number = 8
[layers.GLUE]
speed = 33
blend = 0.7
on = {{gun_on = 1}}
off = {{gun_on = 0}}
[layers."Außen"]
speed = 77
"""
CELL = """MODULE Cell
PERS tooldata gun:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS wobjdata table:=[FALSE,TRUE,"",[[300,0,200],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PROC main()
{calls}
ENDPROC
ENDMODULE
"""
THERE = "on_controller = true"
START = Pose((400.0, 0.0, 500.0), (0.0, 1.0, 0.0, 0.0))


def drawn(folder: Path, name: str, at: float = 0.0, program: str = "", there: str = "") -> Path:
    """A drawing with two contours and a place, and its process file."""
    document = ezdxf.new()
    document.units = 4
    space = document.modelspace()
    space.add_line((at, 0), (at + 40, 0), dxfattribs={"layer": "GLUE"})
    space.add_lwpolyline([(at, 10), (at + 30, 10), (at + 30, 40)], dxfattribs={"layer": "Außen"})
    space.add_point((at, 50, 60))
    file = folder / f"{name}.dxf"
    document.saveas(file)
    text = PROCESS.format(tool=there, frame=there) + program
    file.with_suffix(".process.toml").write_text(text, encoding="utf-8")
    return file


def made(source: Path | Loaded, language: str = "rapid", **options: object) -> Compiled:
    found = compile(source, language=language, robot="irb1200-7-0.7", **options)  # type: ignore[arg-type]
    assert found.ok, [str(one) for one in found.findings]
    return found


def texts(*programs: Compiled) -> list[str]:
    return [data.decode("cp1252") for one in programs for data in one.files.values()]


def ran(*modules: str, entry: str = "main") -> Run:
    """A task of modules, from its main to the end."""
    language = languages.get("rapid")
    trees = [language.parse(text) for text in modules]
    assert not any(tree.findings for tree in trees)
    found = rapid.run(trees, entry=entry, start=START)
    assert (found.ended, found.message) == ("end", "")
    return found


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Run]:
    """Runs of two drawings, each as a separate program."""
    return {
        name: ran(*texts(made(drawn(tmp_path_factory.mktemp(name), name, at))))
        for name, at in (("left", 0.0), ("right", 50.0))
    }


def checked(folder: Path, *modules: str) -> list[str]:
    """Codes of what is found in modules of one task."""
    files = [folder / f"m{number}.mod" for number, _ in enumerate(modules)]
    for file, text in zip(files, modules, strict=True):
        file.write_text(text, encoding="ascii")
    return [one.code for one in check_files(files, robot="irb1200-7-0.7").findings]


def test_others_call_a_program_by_the_name_that_it_is_given(
    tmp_path: Path, alone: Mapping[str, Run]
) -> None:
    said = '[program]\nas = "{}"\nlocal = true\n'
    left = drawn(tmp_path, "left", 0.0, said.format("Glue_Left"), THERE)
    right = drawn(tmp_path, "right", 50.0, said.format("Glue_Right"), THERE)
    cell = CELL.format(calls="Glue_Left;\nGlue_Right;")
    modules = [cell, *texts(made(left), made(right))]
    assert ran(*modules).events == (*alone["left"].events, *alone["right"].events)
    assert checked(tmp_path, *modules) == []


def test_what_others_do_not_call_is_the_modules_own(tmp_path: Path) -> None:
    (text,) = texts(made(drawn(tmp_path, "left", 0.0, '[program]\nas = "Go"\nlocal = true\n')))
    declared = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    seen = [one for one in declared if one.startswith(("PERS", "CONST", "VAR", "PROC"))]
    assert seen == ["PROC Go()"]
    assert "LOCAL PERS tooldata gun" in text
    assert "LOCAL PROC Aussen()" in text


def test_without_a_main_others_call_the_layers(tmp_path: Path, alone: Mapping[str, Run]) -> None:
    prefixes = '[program]\nprefix = "{}_"\nmain = false\n'
    left = drawn(tmp_path, "left", 0.0, prefixes.format("left"), THERE)
    right = drawn(tmp_path, "right", 50.0, prefixes.format("right"), THERE)
    routines = ("outputs_off", "locations", "GLUE", "Aussen")
    calls = "\n".join(f"{side}_{name};" for side in ("left", "right") for name in routines)
    modules = [CELL.format(calls=calls), *texts(made(left), made(right))]
    assert ran(*modules).events == (*alone["left"].events, *alone["right"].events)
    assert checked(tmp_path, *modules) == []


def test_an_option_says_another_name_than_the_process_file(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left", 0.0, '[program]\nas = "Other"\n')
    alone = ran(*texts(made(drawn(tmp_path, "alone"))))
    assert ran(*texts(made(file, called="Go")), entry="Go").events == alone.events
    assert "PROC Go()" in texts(made(file, called="Go"))[0]
    assert "PROC main()" not in texts(made(file, called="Go"))[0]


def test_what_the_controller_has_is_named_and_not_written(tmp_path: Path) -> None:
    (text,) = texts(made(drawn(tmp_path, "left", there=THERE)))
    code = [line for line in text.splitlines() if "!" not in line]
    assert not any("tooldata" in line or "wobjdata" in line for line in code)
    assert any(r",gun\WObj:=table;" in line for line in code)
    tree = languages.get("rapid").parse(text)
    assert rapid.run([tree], start=START).ended != "end"  # a controller without them


def test_a_module_by_itself_is_checked_with_what_the_controller_has(tmp_path: Path) -> None:
    (text,) = texts(made(drawn(tmp_path, "left", there=THERE)))
    assert checked(tmp_path, text) == []
    far = text.replace("[[300,0,200]", "[[3000,0,200]")
    assert "RB102" in checked(tmp_path, far)


def test_units_of_a_long_program_see_what_it_declares(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left", 0.0, '[program]\nprefix = "left_"\n')
    document = ezdxf.readfile(file)
    zigzag = [(10 * n, 60 + 5 * (n % 2)) for n in range(12)]
    document.modelspace().add_lwpolyline(zigzag, dxfattribs={"layer": "GLUE"})
    document.save()
    found = compile(file, language="rapid", most_targets=10)
    assert found.ok and len(found.files) > 1
    assert not any("LOCAL" in text for text in texts(found))
    process = file.with_suffix(".process.toml")
    process.write_text(process.read_text("utf-8") + "local = true\n", "utf-8")
    refused = compile(file, language="rapid", most_targets=10)
    assert not refused.files
    assert [one.code for one in refused.findings if one.severity == "error"] == ["CL074"]


def test_several_drawings_are_routines_of_one_module(
    tmp_path: Path, alone: Mapping[str, Run]
) -> None:
    files = [drawn(tmp_path, name, at, there=THERE) for name, at in (("left", 0), ("right", 50))]
    (text,) = texts(made(combine_sources(files, "glue"), main=False))
    modules = [CELL.format(calls="right;\nleft;"), text]
    assert ran(*modules).events == (*alone["right"].events, *alone["left"].events)
    assert checked(tmp_path, *modules) == []


def test_several_drawings_are_one_program(tmp_path: Path, alone: Mapping[str, Run]) -> None:
    process = '[program]\nas = "{}"\nlocal = true\n'
    files = [
        drawn(tmp_path, "left", 0, process.format("Glue_Left")),
        drawn(tmp_path, "right", 50, process.format("Glue_Right") + "main = true\n"),
    ]
    (text,) = texts(made(combine_sources(files, "glue")))
    assert ran(text).events == (*alone["left"].events, *alone["right"].events)
    assert text.count("PERS tooldata gun") == 1  # which both drawings have in common
    assert "LOCAL PROC Glue_Left()" in text


def test_one_of_them_without_a_routine_of_its_own(tmp_path: Path, alone: Mapping[str, Run]) -> None:
    files = [
        drawn(tmp_path, "left", 0, '[program]\nprefix = "l_"\nmain = false\n'),
        drawn(tmp_path, "right", 50),
    ]
    (text,) = texts(made(combine_sources(files, "glue")))
    assert ran(text).events == (*alone["left"].events, *alone["right"].events)
    assert "PROC l_Aussen()" in text and "PROC left()" not in text


def test_drawings_that_do_not_go_together_are_refused_once(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    left, same = drawn(tmp_path, "left"), drawn(tmp_path / "other", "left")
    right = drawn(tmp_path, "right")
    process = right.with_suffix(".process.toml")
    process.write_text(process.read_text("utf-8").replace("0, 120]", "0, 121]"), "utf-8")
    module = tmp_path / "cell.mod"
    module.write_text("MODULE cell\nPROC main()\nENDPROC\nENDMODULE\n", encoding="ascii")
    for files, code in (([left, same], "CL072"), ([left, right], "CL071"), ([module], "CL070")):
        with pytest.raises(Refused) as refused:
            combine_sources(files, "glue")
        assert [one.code for one in refused.value.findings] == [code]


def test_no_drawing_takes_the_place_of_what_runs_all_of_them(tmp_path: Path) -> None:
    files = [drawn(tmp_path, "left"), drawn(tmp_path, "Main", 50)]
    with pytest.raises(Refused) as refused:
        combine_sources(files, "glue")
    assert [one.code for one in refused.value.findings] == ["CL075"]
    files[1] = drawn(tmp_path, "Main", 50, '[program]\nas = "right"\n')
    (text,) = texts(made(combine_sources(files, "glue")))
    assert text.index("PROC main()") < text.index("PROC right()")


COUNTED = "on_controller = true\nnumber = 1"
MELFA = ("melfa-basic-5", "melfa-basic-6")


def called(language: str, *programs: str, options: Options | None = None) -> Run:
    """Programs of MELFA-BASIC that one calls after the other."""
    spoken = languages.get(language)
    names = [f"P{number}" for number, _ in enumerate(programs)]
    main = "\n".join(f'CallP "{name}"' for name in names) + "\nEnd\n"
    trees = [spoken.parse(text) for text in (main, *programs)]
    found = melfa.run(trees, names=["MAIN", *names], start=START, options=options)
    assert (found.ended, found.message) == ("end", "")
    return found


@pytest.mark.parametrize("language", MELFA)
def test_tools_and_frames_are_called_by_the_numbers_of_a_controller(
    tmp_path: Path, language: str
) -> None:
    alone, there = [], []
    for name, at in (("left", 0.0), ("right", 50.0)):
        (tmp_path / name).mkdir()
        robot = "rv-4frl"
        for found, more in ((alone, ""), (there, COUNTED)):
            file = drawn(tmp_path / name, f"{name}{len(found)}", at, there=more)
            compiled = compile(file, language=language, robot=robot)
            assert compiled.ok, [str(one) for one in compiled.findings]
            found += texts(compiled)
    code = "\n".join(line for line in there[0].splitlines() if "'" not in line)
    assert "Tool 1" in code and "Base 1" in code and "MEXTL" not in code and "CORD" not in code
    kept = Options(
        tools={1: (0, 0, 120, 0, 0, 0)}, bases={1: (300, 0, 200, 0, 0, 0)}, bases_are="seen"
    )
    first, second = called(language, *alone), called(language, *there, options=kept)
    assert len([one for one in first.events if isinstance(one, Moved)]) > 10
    assert difference(first, second) is None


def test_the_file_that_is_called_has_the_name_that_it_is_given(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left", there=COUNTED)
    found = compile(file, language="melfa-basic-5", robot="rv-4frl", called="Glue_Left")
    assert list(found.files) == ["GLUELEFT.prg"]
    assert "CO323" in [one.code for one in found.findings]
    long = compile(file, language="melfa-basic-5", robot="rv-4frl", called="TheGlueOfTheLeft")
    assert not long.files and "CO322" in [one.code for one in long.findings]


def test_a_program_by_itself_is_checked_with_the_tools_of_its_numbers(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left", there=COUNTED)
    (text,) = texts(compile(file, language="melfa-basic-5", robot="rv-4frl"))
    for name, said, codes in (("a", text, False), ("b", text.replace("+300.0", "+3000.0"), True)):
        program = tmp_path / f"{name}.prg"
        program.write_text(said, encoding="cp1252")
        found = check_files([program], robot="rv-4frl").findings
        assert any(one.code == "RB102" for one in found) is codes


@pytest.mark.parametrize(
    ("language", "there", "frames"),
    [
        ("melfa-basic-4", COUNTED, "base"),
        ("melfa-basic-5", THERE, "base"),
        ("melfa-basic-5", COUNTED, "product"),
        ("melfa-basic-5", COUNTED.replace("1", "9"), "base"),
    ],
)
def test_what_cannot_be_called_by_a_number_is_refused(
    tmp_path: Path, language: str, there: str, frames: Frames
) -> None:
    found = compile(drawn(tmp_path, "left", there=there), language=language, frames=frames)
    assert not found.files
    errors = [one.code for one in found.findings if one.severity == "error"]
    assert set(errors) == {"CO329"}


def test_every_name_is_checked_before_anything_is_written(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left")
    for options, code in (
        ({"called": "glue"}, "CO321"),
        ({"called": "GUN"}, "CO321"),
        ({"called": "a-b"}, "CO320"),
        ({"called": "Go", "main": False}, "CO326"),
    ):
        with pytest.raises(Refused) as refused:
            compile(file, language="rapid", **options)  # type: ignore[arg-type]
        assert [one.code for one in refused.value.findings] == [code]
    found = compile(file, language="rapid", called="default")  # a word of the language
    assert not found.files
    assert "CO322" in [one.code for one in found.findings]


def test_a_name_that_the_language_has_not_is_no_name_of_the_controller(tmp_path: Path) -> None:
    file = drawn(tmp_path, "left", there=THERE)
    process = file.with_suffix(".process.toml")
    process.write_text(process.read_text("utf-8").replace("gun", "Default"), "utf-8")
    found = compile(file, language="rapid")
    assert not found.files
    assert [one.code for one in found.findings if one.severity == "error"] == ["CO329"]


def test_a_program_that_moves_by_itself_keeps_its_main(tmp_path: Path) -> None:
    file = tmp_path / "moves.pseudo"
    file.write_text(
        "program moves\n\nprocedure main\n  wait 1 s\nend\n",
        encoding="utf-8",
    )
    with pytest.raises(Refused) as refused:
        compile(file, language="rapid", main=False)
    assert [one.code for one in refused.value.findings] == ["CO324"]


@pytest.mark.slow
def test_a_project_says_what_its_programs_are_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, at in (("left", 0.0), ("right", 50.0)):
        drawn(tmp_path, name, at, there=THERE)
    (tmp_path / "assistant.toml").write_text(
        '[controllers.cell]\naddress = "virtual:irc5"\nrobot = "irb1200-7-0.7"\n'
        '[programs.Glue]\nsource = "left.dxf"\nalso = ["right.dxf"]\nmain = false\n'
        '[programs.One]\nsource = "right.dxf"\nas = "Glue_Right"\n'
        '[targets.cell]\nprograms = ["Glue", "One"]\n',
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    assert [str(one.state) for one in build(project_of()).programs] == ["built", "built"]
    folder = tmp_path / "build" / "cell"
    glue, one = ((folder / name).read_text("ascii") for name in ("Glue.mod", "right.mod"))
    assert "PROC left()" in glue and "PROC right()" in glue and "PROC main()" not in glue
    assert "PROC Glue_Right()" in one and "PROC main()" not in one
    assert [str(one.state) for one in build(project_of()).programs] == ["unchanged", "unchanged"]
    drawn(tmp_path, "right", 60.0, there=THERE)
    assert [str(one.state) for one in build(project_of()).programs] == ["built", "built"]


def test_a_translated_program_keeps_its_names_and_leaves_what_the_controller_has(
    tmp_path: Path,
) -> None:
    module = tmp_path / "cell.mod"
    move = "MoveJ p1,v100,fine,gun;"
    target = "CONST robtarget p1:=[[350,20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    tool = "PERS tooldata gun:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];"
    module.write_text(
        f"MODULE cell\n{tool}\n{target}\nPROC main()\n{move}\nENDPROC\nENDMODULE\n",
        encoding="ascii",
    )
    process = tmp_path / "cell.process.toml"
    process.write_text(
        f'[program]\nas = "Go"\n[tools.gun]\ntip = [0, 0, 120]\n{COUNTED}\n', encoding="utf-8"
    )
    found = translate(module, to="melfa-basic-5", robot="rv-4frl", process=process)
    assert list(found.files) == ["CELL.prg"]
    (data,) = found.files.values()
    assert b" Tool 1" in data
    assert "CO009" in [one.code for one in found.whole]
