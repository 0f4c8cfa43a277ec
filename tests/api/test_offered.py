"""What Python offers on top, and what of it people see: text, pages of notebooks, written files."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from lxml import html

import assistant
from assistant.base.diagnostics import Refused, error
from tests.cli.test_check import BROKEN, CLEAN, ODD, write

SAMPLES = Path(__file__).parents[2] / "samples"
PLATE = SAMPLES / "plate.dxf"
IRB = "irb1200-7-0.7"
NASTY = "</pre><script>alert(1)</script><b a='\x1b[31m\u202e"


def test_everything_is_on_top_and_listed():
    wanted = {"load", "compile", "translate", "check", "simulate", "deploy", "from_poses"}
    wanted |= {"from_joints", "plan", "read_scene", "connect", "robots", "languages", "Refused"}
    wanted |= {"Pose", "Tool", "Load", "Frame", "Proving", "compare", "pose", "on"}
    names = [name for name in dir(assistant) if not name.startswith("_")]
    assert set(names) == wanted == set(assistant.__all__) - {"__version__"}
    for name in names:
        assert getattr(assistant, name).__doc__, name


def test_it_is_loaded_when_it_is_used():
    code = "import assistant, sys; dir(assistant); print([m for m in sys.modules if 'numpy' == m])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
def test_types_reach_who_uses_us(tmp_path):
    (tmp_path / "use.py").write_text(
        "import assistant\n"
        "reveal_type(assistant.compile('a.dxf', language='rapid').write('out'))\n"
        "reveal_type(assistant.check('a.mod').findings[0].cure)\n"
        "reveal_type(assistant.from_joints([[0.0]], unit='rad'))\n"
        "reveal_type(assistant.simulate('a.dxf').seconds)\n",
        encoding="utf-8",
    )
    mypy = pytest.importorskip("mypy.api")
    out, _, status = mypy.run(
        ["--no-incremental", "--follow-imports=silent", str(tmp_path / "use.py")]
    )
    assert status == 0, out
    said = re.findall(r'type is "([^"]*)"', out)
    assert said[1:] == ["str", "assistant.program.program.Program", "float"] and "Path" in said[0]


def test_what_python_prints_is_short():
    loaded = assistant.load(PLATE)
    compiled = assistant.compile(loaded, language="rapid", robot=IRB)
    count = sum(1 for _ in compiled.source.statements())
    assert re.fullmatch(
        r"<Program plate: 10 procedures, \d+ statements, \d+ targets>", repr(loaded.program)
    )
    assert count <= int(re.search(r"(\d+) statements", repr(loaded.program))[1])
    assert re.fullmatch(r"<Compiled plate in rapid: proven, plate.mod, 9 findings>", repr(compiled))
    poses = assistant.from_poses([[300, 0, i, 1, 0, 0, 0] for i in range(500)], unit="mm")
    assert re.fullmatch(
        r"<Program \w+: 2 procedures, 502 statements, 500 targets>",
        repr(poses),
    )
    done = assistant.simulate(loaded, robot=IRB)
    assert repr(done) == f"<Simulated plate on {IRB}: {done.seconds:.2f} s, 9 findings>"
    finding = compiled.findings[2]
    assert str(finding) == f"DX315 {PLATE} POINT #81, #82: {finding.message} ({finding.cure})"
    assert repr(finding) == f"<INFO {finding}>"


def test_exceptions_say_what_to_do(tmp_path):
    with pytest.raises(Refused) as caught:
        assistant.load(PLATE, unit="inches")
    assert "(" in str(caught.value) and caught.value.findings[0].cure in str(caught.value)
    rule = error("XX101", "`{name}` is wrong", "mend it")
    many = Refused(*(rule(name=n, path="f", line=n) for n in range(9)))
    assert str(many).startswith("XX101 f:0: `0` is wrong (mend it); XX101 f:1: ")
    assert str(many).endswith("; and 4 more") and len(many.findings) == 9


def test_what_was_compiled_is_written_whole_or_not_at_all(tmp_path):
    compiled = assistant.compile(PLATE, language="rapid", robot=IRB)
    (file,) = compiled.write(tmp_path / "new" / "out")
    assert file == tmp_path / "new" / "out" / "plate.mod"
    assert file.read_bytes() == compiled.files["plate.mod"]
    (tmp_path / "file").write_text("")
    with pytest.raises(Refused) as caught:
        compiled.write(tmp_path / "file")
    assert caught.value.exit_status == 2


def test_an_edited_file_is_not_written_over_without_a_word(tmp_path):
    first = assistant.from_poses([[300, 0, 300, 0, 1, 0, 0]], unit="mm", name="p", speed=20)
    other = assistant.from_poses([[300, 9, 300, 0, 1, 0, 0]], unit="mm", name="p", speed=20)
    (file,) = assistant.compile(first, language="rapid", robot=IRB).write(tmp_path)
    again = assistant.compile(other, language="rapid", robot=IRB)
    again.write(tmp_path)
    assert file.read_bytes() == again.files["p.mod"], "nobody had edited it"
    edited = file.read_text("utf-8").replace("v20", "v10")
    file.write_text(edited, encoding="utf-8")
    before = {one: one.read_bytes() for one in tmp_path.rglob("*") if one.is_file()}
    for compiled in (again, assistant.compile(first, language="rapid", robot=IRB)):
        with pytest.raises(Refused, match="CO331"):
            compiled.write(tmp_path)
    assert before == {one: one.read_bytes() for one in tmp_path.rglob("*") if one.is_file()}
    again.write(tmp_path, overwrite=True)
    assert file.read_bytes() == again.files["p.mod"]
    foreign = tmp_path / "foreign"
    write(foreign / "p.mod", "MODULE p\nENDMODULE\n")
    with pytest.raises(Refused, match="CO331"):
        again.write(foreign)


def test_a_translation_is_written(tmp_path):
    done = assistant.translate(
        SAMPLES / "rapid" / "gluing.mod", to="melfa-basic-5", robot="rv-4frl"
    )
    assert repr(done).startswith("<Translation Gluing to melfa-basic-5: ")
    with pytest.raises(Refused):
        done.write(tmp_path / "out")
    draft = assistant.translate(
        SAMPLES / "rapid" / "gluing.mod", to="melfa-basic-5", robot="rv-4frl", draft=True
    )
    assert {file.name for file in draft.write(tmp_path / "out")} == set(draft.files) != set()


def test_files_and_programs_are_checked_alike(tmp_path):
    odd = write(tmp_path / "odd" / "odd.mod", ODD)
    done = assistant.check(odd)
    assert not done.ok and [f.code for f in done.findings] == ["RA204"]
    assert done.files == (str(odd),) and repr(done) == "<Check not ok: 1 finding>"
    assert assistant.check(write(tmp_path / "clean.mod", CLEAN)).ok
    several = assistant.check([odd, write(tmp_path / "broken" / "broken.mod", BROKEN)])
    assert {f.code for f in several.findings} == {"RA204", "RA101"} and len(several.files) == 2
    missing = assistant.check(tmp_path / "none.mod")
    assert missing.unreadable and not missing.ok
    ignored = assistant.check(write(odd, ODD.replace("tool0;", "tool0; ! assistant: ignore RA204")))
    assert ignored.ok and [f.code for f in ignored.ignored] == ["RA204"]


def test_a_program_is_checked_for_a_robot():
    far = assistant.from_poses([[3000, 0, 300, 0, 1, 0, 0]], unit="mm")
    assert assistant.check(far).ok
    done = assistant.check(far, robot=IRB)
    assert not done.ok and done.findings[0].code.startswith("RB")
    compiled = assistant.compile(PLATE, language="rapid", robot=IRB)
    assert assistant.check([compiled, assistant.load(PLATE)], robot=IRB).ok
    with pytest.raises(Refused, match="irb99"):
        assistant.check(far, robot="irb99")


def test_what_cannot_be_run_is_not_simulated():
    far = assistant.from_poses([[3000, 0, 300, 0, 1, 0, 0]], unit="mm", robot=IRB)
    with pytest.raises(Refused, match="RB"):
        assistant.simulate(far)
    with pytest.raises(Refused, match="CL010"):
        assistant.simulate(assistant.from_poses([[300, 0, 300, 0, 1, 0, 0]], unit="mm"))


def test_a_contact_in_the_cell_is_told():
    pytest.importorskip("coal")
    done = assistant.simulate(PLATE, cell=SAMPLES / "cell" / "clamped.toml")
    assert not done.ok and any(f.code.startswith("CK4") for f in done.findings)


def shown(one):
    """The page of a notebook, read by libxml2."""
    text = one._repr_html_()
    assert "\x1b" not in text and "\u202e" not in text
    page = html.fromstring(text)
    assert not page.xpath("//script | //@onclick | //@src | //link")
    return page


def test_pages_show_the_way_of_the_tool():
    compiled = assistant.compile(PLATE, language="rapid", robot=IRB)
    page = shown(compiled)
    assert len(page.xpath("//svg//polyline")) > 4
    points = [
        tuple(map(float, point.split(",")))
        for line in page.xpath("//svg//polyline/@points")
        for point in line.split()
    ]
    assert all(0 <= x <= 600 and 0 <= y <= 220 for x, y in points)
    assert "x 235.0 to 310.0 mm, y -85.0 to 85.0 mm" in page.text_content()
    assert "    PROC main()\n" in page.xpath("//pre")[0].text
    assert len(page.xpath("//tr")) == len(compiled.findings)
    swing = assistant.from_joints(
        [[0, 0, 0, 0, 30, 0], [40, 0, 0, 0, 30, 0]], unit="deg", robot=IRB
    )
    assert len(shown(swing).xpath("//polyline")) == 2
    still = assistant.from_joints([[0, 0, 0, 0, 30, 0]], unit="deg", robot=IRB)
    assert not shown(still).xpath("//svg")
    same = assistant.from_poses([[300, 0, 300, 0, 1, 0, 0]] * 3, unit="mm")
    shown(same)


def test_pages_are_bounded_and_obey_nothing():
    rule = error("XX101", "`{name}` is wrong", "mend {name}")
    page = shown(rule(name=NASTY, path=NASTY, line=3))
    assert "<script>alert(1)</script>" in page.text_content()
    many = assistant.from_poses([[300, i / 100, 300, 0, 1, 0, 0] for i in range(9000)], unit="mm")
    assert len(many._repr_html_()) < 200_000
    from assistant.api.analysis import Check

    listed = shown(Check(tuple(rule(name=NASTY, line=i) for i in range(400))))
    assert len(listed.xpath("//tr")) == 50 and "and 350 more" in listed.text_content()


def test_a_simulation_and_a_translation_have_pages():
    page = shown(assistant.simulate(PLATE, robot=IRB))
    assert re.search(r"main: \d+\.\d\d s a call", page.text_content())
    done = assistant.translate(
        SAMPLES / "rapid" / "gluing.mod", to="melfa-basic-5", robot="rv-4frl"
    )
    assert shown(done).xpath("//table")
