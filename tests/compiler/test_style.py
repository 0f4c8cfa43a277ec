"""The frame of written programs comes from templates, and is proven like all else."""

import json
import os
import re
import subprocess
import sys

import pytest

from assistant import languages, robots
from assistant.base.diagnostics import Refused, Unreadable
from assistant.cli import main
from assistant.compiler import compile, translate
from assistant.compiler.style import (
    PLAIN_STYLE,
    Style,
    apply_style,
    comment_value,
    jinja_environment,
    style_of,
)
from assistant.program import pseudo
from assistant.resources import resource

PROGRAM = """\
program weld
# seam of the bracket

tool nozzle tip [0, 0, 60] mass 0.3 kg centre [0, 0, 20]
signal glue digital output 8

target start [280, 50, 250] [0, 0, 1, 0]
target corner [320, 50, 250] [0, 0, 1, 0]

variable passes number = 0

procedure main
  move joint start speed 200 mm/s joint 20 % blend fine tool nozzle
  # the bead
  for round from 1 to 3
    set glue = 1
    # each edge
    move linear corner speed 50 mm/s blend 1 mm tool nozzle
    if passes > 1
      call back
    end
    passes = passes + 1
  end
  set glue = 0
end

procedure back
  move linear start speed 50 mm/s blend fine tool nozzle
end
"""
RAPID = "MODULE {{ name }}\n{{ header }}\n{{ declarations }}\n{{ routines }}\nENDMODULE\n"
MELFA = "{{ header }}\n{{ code }}\n{{ positions }}\n"
FILES = {"rapid": "rapid/module.mod.j2"}
TARGETS = (("rapid", "irb1200-7-0.7"), ("melfa-basic-4", "rv-2aj"), ("melfa-basic-5", "rv-4frl"),
           ("melfa-basic-6", "rv-4frl"))  # fmt: skip


@pytest.fixture
def project(tmp_path, monkeypatch):
    """Writes a project with a template; gives what compiles its program."""
    monkeypatch.chdir(tmp_path)

    def made(template, language="rapid", style="", program=PROGRAM, *, bare=False, **options):
        file = tmp_path / "style" / FILES.get(language, "melfa/program.prg.j2")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(template, "utf-8")
        text = f'[style]\ntemplate = "style"\n{style}'
        (tmp_path / "assistant.toml").write_text(text, "utf-8")
        (tmp_path / "weld.pseudo").write_text(program, "utf-8")
        robot = None if bare else dict(TARGETS)[language]
        return compile("weld.pseudo", language=language, robot=robot, **options)

    return made


def text_of(compiled):
    (data,) = compiled.files.values()
    return data.decode()


def refused(project, template, language="rapid", style=""):
    """The findings about a template; those of an arm are none of them."""
    try:
        compiled = project(template, language, style, bare=True)
    except Refused as wrong:
        return wrong.findings
    assert not compiled.ok
    assert not compiled.files
    return [one for one in compiled.findings if one.code.startswith("CO")]


@pytest.mark.parametrize(("language", "robot"), TARGETS)
def test_the_templates_of_the_package_are_what_the_printer_writes(language, robot, tmp_path):
    program = pseudo.parse(PROGRAM)
    spoken = languages.get(language)
    arm = {"robot": robot}
    written = text_of(compile(program, language=language, **arm))
    adapted = compile(program, language=language, **arm).program
    printed = spoken.encode(spoken.build(adapted, robots.get(robot)))
    assert written.encode() == printed
    assert apply_style(printed, spoken, PLAIN_STYLE, adapted, None).data == printed
    # A copy of the template, as a project begins with, adds nothing either.
    shipped = FILES.get(language, "melfa/program.prg.j2")
    (tmp_path / shipped).parent.mkdir()
    (tmp_path / shipped).write_text(resource("templates", shipped).read_text("utf-8"), "utf-8")
    assert apply_style(printed, spoken, Style(tmp_path), adapted, None).data == printed


@pytest.mark.parametrize(("name", "text"), [
    ("rapid/module.mod.j2", RAPID), ("melfa/program.prg.j2", MELFA),
])  # fmt: skip
def test_jinja_reads_the_templates_of_the_package_as_we_do(name, text):
    shipped = resource("templates", name).read_text("utf-8")
    assert shipped == text
    values = dict.fromkeys(re.findall(r"\w+", text), "X\nY")
    plain = re.sub(r"\{\{ (\w+) \}\}", lambda match: values[match[1]], text)
    rendered = jinja_environment().from_string(shipped).render(values)
    assert re.sub("\ue002[0-9]+\ue003", "", rendered) == plain


@pytest.mark.slow
def test_compiling_without_a_template_imports_no_jinja(tmp_path):
    (tmp_path / "weld.pseudo").write_text(PROGRAM, "utf-8")
    code = (
        "import sys; from assistant.compiler import compile;"
        "assert compile('weld.pseudo', language='rapid').files;"
        "sys.exit('jinja2' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=120)


def test_a_module_gets_comments_attributes_and_another_order(project):
    template = (
        "! {{ project }}\nMODULE {{ name }}(NOSTEPIN, VIEWONLY)\n    ! by {{ author }}\n"
        "{{ header }}\n{% if revision %}\n    ! rev {{ revision }}\n{% endif %}\n"
        "{% if not unit %}\n    ! for {{ robot }}, {{ language }}, {{ program }}\n{% endif %}\n"
        "\n{{ targets }}\n    ! data\n{{ data }}\n{{ routines }}\nENDMODULE\n! end of {{ name }}\n"
    )
    compiled = project(template, style='project = "Line 3"\nauthor = "Ann"\n')
    assert compiled.ok, compiled.findings
    lines = text_of(compiled).split("\r\n")
    assert lines[:3] == ["! Line 3", "MODULE weld(NOSTEPIN, VIEWONLY)", "    ! by Ann"]
    assert "    ! for irb1200-7-0.7, ABB RAPID, weld" in lines
    assert not any("rev" in line for line in lines)
    words = ("program: weld", "robtarget start", "! data", "tooldata", "PROC main")
    order = [next(at for at, line in enumerate(lines) if word in line) for word in words]
    assert order == sorted(order)
    assert lines[-2] == "! end of weld"
    plain = compile(pseudo.parse(PROGRAM), language="rapid", robot="irb1200-7-0.7")
    assert sorted(x for x in text_of(plain).split("\r\n") if x and "MODULE" not in x) == sorted(
        x
        for x in lines
        if x and "MODULE" not in x and not re.match(r" *! (Line|by|for|data|end)", x)
    )
    assert "proven" in compiled.proof.line()


@pytest.mark.parametrize(("language", "robot"), TARGETS[1:])
def test_comments_of_a_numbered_language_get_numbers(project, language, robot):
    template = (
        "' {{ project }}\n\n{{ comments }}\n' code of {{ program }}\n{{ heading }}\n"
        "{{ code }}\n{{ positions }}"
    )
    compiled = project(template, language, style='project = "Line 3"\n')
    assert compiled.ok, compiled.findings
    lines = text_of(compiled).split("\r\n")
    step = 10 if language == "melfa-basic-4" else 1
    code = [line for line in lines if line[:1].isdigit()]
    assert [int(line.split()[0]) for line in code] == [step * n for n in range(1, len(code) + 1)]
    assert code[0] == f"{step} ' Line 3"
    assert sum("' code of weld" in line for line in code) == 1
    plain = text_of(compile(pseudo.parse(PROGRAM), language=language, robot=robot))
    bare = [re.sub("^[0-9]+ ", "", line) for line in lines]
    bare.remove("' Line 3")
    bare.remove("' code of weld")
    assert bare == [re.sub("^[0-9]+ ", "", line) for line in plain.split("\r\n")]


MOVE = "    PROC more()\n        MoveL start,v50,fine,nozzle;\n    ENDPROC\n"
RAPID_FAULTS = (
    (RAPID.replace("ENDMODULE", MOVE + "ENDMODULE"), "CO611", 5),
    (RAPID.replace("{{ header }}", "{{ header }}\n    CONST num more:=1;"), "CO611", 3),
    (RAPID.replace("{{ name }}", "other"), "CO611", 1),
    (RAPID.replace("{{ name }}", "{{ name }}(SYSMODULE)"), "CO611", 1),
    (RAPID.replace("{{ routines }}\n", ""), "CO612", 5),
    (RAPID.replace("ENDMODULE\n", ""), "CO612", 5),
    (RAPID.replace("{{ header }}\n", "{{ header }}\n{{ header }}\n"), "CO613", 3),
    (RAPID.replace("{{ routines }}", "{{ routines }}\n{{ data }}"), "CO613", 5),
    (RAPID.replace("{{ header }}", "{{ header|upper }}"), "CO614", 2),
    (RAPID.replace("{{ header }}", "! {{ header }}"), "CO614", 2),
    (RAPID.replace("{{ header }}\n", "").replace("{{ routines }}", "{{ routines }}\n{{ header }}"),
     "CO615", 4),
    (RAPID.replace("{{ header }}", "    ! robot: irb120-3-0.6\n{{ header }}"), "CO616", 2),
    (RAPID.replace("{{ header }}", "    ! für alle\n{{ header }}"), "CO617", 2),
    ("", "CO612", 1),
    (RAPID.replace("{{ header }}", "{{ header }}\n{{ nmae }}"), "CO602", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n{% if project %}\n! x\n"), "CO601", 7),
    (RAPID.replace("{{ header }}", "{{ header }}\n{{ 10 ** 10 ** 9 }}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ 'a' * 10000000000 }}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ ''.__class__.__mro__ }}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ name.upper() }}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ name|center(99999999999) }}"), "CO601", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n{% include '/etc/passwd' %}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ range(9) }}"), "CO603", 3),
    (RAPID.replace("{{ header }}", "{{ header }}\n! {{ 1 / 0 }}"), "CO603", 3),
)  # fmt: skip


@pytest.mark.parametrize(("template", "code", "line"), RAPID_FAULTS)
def test_a_template_that_changes_the_program_is_refused_at_its_line(project, template, code, line):
    found = refused(project, template)
    assert (code, line) in [(one.code, one.line) for one in found], found
    assert all(one.path.endswith("module.mod.j2") and one.cure for one in found)


MELFA_FAULTS = (
    ("10 MOV PSTART2\n" + MELFA, "CO611", 1),
    (MELFA.replace("{{ code }}", "M1=1\n{{ code }}"), "CO611", 2),
    (MELFA.replace("{{ code }}", "' code\n{{ code }}"), "CO615", 2),
    (MELFA.replace("{{ header }}", "{{ header }}\n{{ heading }}"), "CO613", 2),
    (MELFA.replace("{{ header }}", "{{ heading }}\n{{ comments }}"), "CO615", 2),
    (MELFA.replace("{{ positions }}", "' values\n{{ positions }}"), "CO615", 3),
    (MELFA.replace("{{ code }}\n", ""), "CO612", 3),
    (MELFA.replace("{{ header }}", "' robot-assistant: end\n{{ header }}"), "CO616", 1),
    ("' " + "x" * 200 + "\n" + MELFA, "CO618", 1),
)


@pytest.mark.parametrize(("template", "code", "line"), MELFA_FAULTS)
def test_a_template_of_numbered_lines_is_refused_at_its_line(project, template, code, line):
    found = refused(project, template, "melfa-basic-4")
    assert (code, line) in [(one.code, one.line) for one in found], found


def test_the_line_of_a_fault_is_that_of_the_template_after_blocks(project):
    template = RAPID.replace(
        "{{ header }}",
        "{% if 1 %}\n    ! a\n{% for x in 'abc' %}\n    ! {{ x }}\n{% endfor %}\n{% endif %}\n"
        "{# a remark\n of two lines #}\n{{ header }}\n    MoveL start,v50,fine,nozzle;",
    )
    (found,) = refused(project, template)
    assert (found.code, found.line) == ("CO611", 11)


def test_a_proof_fails_where_a_template_gets_a_statement_past_the_lines(project, monkeypatch):
    """The text as a whole is read back, whatever the check of lines lets through."""
    monkeypatch.setattr("assistant.compiler.style._check", lambda *_: None)
    template = RAPID.replace("ENDMODULE", MOVE + "ENDMODULE")
    (found,) = refused(project, template)[:1]
    assert found.code == "CO618"
    dropped = refused(project, RAPID.replace("{{ routines }}\n", ""))
    assert {one.code for one in dropped} == {"CO618"}


def test_a_template_without_end_ends(project, monkeypatch):
    monkeypatch.setenv("ROBOT_ASSISTANT_BUDGET", "0.02")
    loops = "{% for a in x %}" * 9 + "{% endfor %}" * 9
    template = "{% set x = 'abcdefghijklmnopqrstuvwxyz' %}" + loops + "\n" + RAPID
    (found,) = refused(project, template)
    assert found.code == "LM001"
    assert found.path.endswith("module.mod.j2")


def test_a_template_that_writes_without_end_ends(project):
    loops = "{% for a in x %}" * 5 + "! a\n" + "{% endfor %}" * 5
    template = "{% set x = 'abcdefghijklmnopqrstuvwxyz' %}" + loops + "\n" + RAPID
    (found,) = refused(project, template)
    assert found.code == "CO604"
    assert found.line in (1, 2)


@pytest.mark.parametrize(("value", "said"), [
    ("a\nMoveL start,v50,fine,nozzle;", "a MoveL start,v50,fine,nozzle;"),
    ("a\r\n\u2028\x85b", "a b"), ("Müller", "Mueller"), ("{{ 1 }}", "{{ 1 }}"),
    ("\ue000x\ue001", None),
])  # fmt: skip
def test_values_of_a_project_stay_in_their_comments(project, value, said):
    template = RAPID.replace("{{ header }}", "    ! P {{ project }}\n{{ header }}")
    compiled = project(template, style=f"project = {json.dumps(value)}\n")
    assert compiled.ok, compiled.findings
    assert said is None or f"    ! P {said}\r\n" in text_of(compiled)
    assert len(comment_value("x" * 1000)) < 200


def test_a_value_that_reads_as_an_item_is_refused(project):
    template = RAPID.replace("{{ header }}", "    ! {{ project }}\n{{ header }}")
    (found,) = refused(project, template, style='project = "entry: back"\n')
    assert (found.code, found.line) == ("CO616", 2)


def test_each_module_of_a_long_program_gets_its_frame(project, tmp_path):
    project(
        RAPID.replace("{{ header }}", "    ! {{ unit or 'main' }} of {{ program }}\n{{ header }}")
    )
    for name in ("positioning.csv", "positioning.process.toml"):
        (tmp_path / name).write_bytes(resource("samples", name).read_bytes())
    compiled = compile("positioning.csv", language="rapid", robot="irb1200-7-0.7", most_targets=10)
    assert compiled.ok, compiled.findings
    texts = {name: data.decode() for name, data in compiled.files.items()}
    assert len(texts) > 1
    for name, text in texts.items():
        unit = re.search(r"unit of: ", text)
        who = name.removesuffix(".mod") if unit else "main"
        assert f"    ! {who} of positioning\r\n" in text


def test_a_translation_gets_the_frame_of_its_project(project, tmp_path):
    project("' {{ project }}\n" + MELFA, "melfa-basic-4", style='project = "Line 3"\n')
    plain = compile(pseudo.parse(PROGRAM), language="rapid", robot="irb1200-7-0.7")
    plain.write(tmp_path / "in")
    done = translate("in/weld.mod", to="melfa-basic-5", robot="rv-4frl",
                     from_robot="irb1200-7-0.7", process=None)  # fmt: skip
    assert done.files, done.compiled.findings
    assert all(b"1 ' Line 3" in data for data in done.files.values())


def run(*words):
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    return int(ended.value.code or 0)


def test_what_is_written_keeps_its_layout_and_its_edits(project, tmp_path, capsys):
    template = RAPID.replace("{{ header }}", "    ! {{ author }}\n{{ header }}")
    project(template, style='author = "Ann"\n')
    assert (
        run("compile", "weld.pseudo", "-l", "rapid", "--robot", "irb1200-7-0.7", "-o", "out") == 0
    )
    written = (tmp_path / "out/weld.mod").read_bytes()
    assert b"! Ann" in written
    assert run("fmt", "out/weld.mod", "--check") == 0, capsys.readouterr()
    back = compile("out/weld.mod", language="rapid", robot="irb1200-7-0.7")
    assert back.ok


def test_a_project_builds_anew_what_a_changed_template_frames(project, tmp_path, capsys):
    project(RAPID, style='author = "Ann"\n')
    with (tmp_path / "assistant.toml").open("a") as file:
        file.write(
            '[controllers.cell]\naddress = "virtual:irc5"\nrobot = "irb1200-7-0.7"\n'
            '[programs.weld]\nsource = "weld.pseudo"\n[targets.cell]\nprograms = ["weld"]\n'
        )
    assert run("build") == 0, capsys.readouterr()
    built = tmp_path / "build/cell/weld.mod"
    assert b"Ann" not in built.read_bytes()
    template = tmp_path / "style/rapid/module.mod.j2"
    template.write_text(RAPID.replace("{{ header }}", "    ! {{ author }}\n{{ header }}"))
    assert run("build") == 0, capsys.readouterr()
    assert b"! Ann" in built.read_bytes()
    assert run("plan") in (0, 1), capsys.readouterr()
    capsys.readouterr()
    template.write_text(RAPID + "MoveL start,v50,fine,nozzle;\n")
    assert run("build") == 1
    assert "CO611" in capsys.readouterr().err


def test_a_project_without_a_template_of_a_language_has_that_of_the_package(project, tmp_path):
    compiled = project("! x\n" + RAPID)
    assert compiled.ok
    other = compile("weld.pseudo", language="melfa-basic-4", robot="rv-2aj")
    assert text_of(other) == text_of(
        compile(pseudo.parse(PROGRAM), language="melfa-basic-4", robot="rv-2aj")
    )


@pytest.mark.parametrize(("table", "code"), [
    ('template = "gone"', "CO619"), ('template = "../style"', "CO619"), ("template = 1", "CT303"),
    ('templates = "style"', "CT302"), ('template = "/etc"', "CO619"), ('author = ""', "CT303"),
])  # fmt: skip
def test_a_style_that_is_wrong_is_refused(tmp_path, table, code):
    (tmp_path / "assistant.toml").write_text(f"[style]\n{table}\n", "utf-8")
    with pytest.raises(Refused) as refused:
        style_of(tmp_path)
    assert [one.code for one in refused.value.findings] == [code]
    assert refused.value.exit_status == 2
    assert refused.value.findings[0].line == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_is_no_template_and_is_not_waited_for(project, tmp_path):
    project(MELFA, "melfa-basic-4")
    (tmp_path / "style/rapid").mkdir()
    os.mkfifo(tmp_path / "style/rapid/module.mod.j2")
    with pytest.raises(Unreadable) as refused:
        compile("weld.pseudo", language="rapid", robot="irb1200-7-0.7")
    assert [one.code for one in refused.value.findings] == ["IN009"]


def test_a_style_may_be_given_in_python(tmp_path):
    folder = tmp_path / "rapid"
    folder.mkdir()
    (folder / "module.mod.j2").write_text("! {{ revision }}\n" + RAPID)
    program = pseudo.parse(PROGRAM)
    compiled = compile(program, language="rapid", style=Style(tmp_path, {"revision": "C"}))
    assert text_of(compiled).startswith("! C\r\nMODULE weld\r\n")


DEEP = '{% for a in "ab" %}' * 25 + "x" + "{% endfor %}" * 25


@pytest.mark.parametrize(("line", "code"), [
    (DEEP, "CO601"),  # what Python refuses of the code that Jinja2 makes of it
    ("{% if name %}" * 120 + "! x" + "{% endif %}" * 120, "CO601"),
    ("{% macro a(x, x) %}{% endmacro %}", "CO601"),
    ("{% macro a(x) %}{% endmacro %}{{ a(x=1, x=2) }}", "CO601"),
    ("! \ue0025\ue003", "CO617"),  # the marks of lines and sections are no text of templates
    ("\ue000routines\ue001", "CO617"),
    ('{% if name %}\n{{ "\\ue002" }}{% endif %}' + "9" * 5000 + '{{ "\\ue003" }}', "CO614"),
    ("! a\x0b", None),  # white space at the end of a line is left out
    ("! a\tb", "CO617"),
])  # fmt: skip
def test_templates_that_mislead_their_reader_are_refused(project, line, code):
    found = refused(project, f"{line}\n{RAPID}") if code else []
    assert [one.code for one in found][:1] == ([code] if code else [])
    if code is None:
        assert text_of(project(f"{line}\n{RAPID}")).startswith("! a\r\nMODULE")


@pytest.mark.parametrize("frame", ["\x0cMODULE {{ name }}", "\xa0MODULE {{ name }}"])
def test_the_frame_of_a_module_is_printable(project, frame):
    found = refused(project, RAPID.replace("MODULE {{ name }}", frame, 1))
    assert found[0].code == "CO617"
    assert found[0].line == 1


@pytest.mark.parametrize(("attributes", "sound"), [
    ("NOSTEPIN", True), ("NOSTEPIN,READONLY", True), ("NOSTEPIN, VIEWONLY", True), ("NOVIEW", True),
    ("NOVIEW,NOSTEPIN", False), ("VIEWONLY,READONLY", False), ("READONLY,NOSTEPIN", False),
    ("NOSTEPIN,NOSTEPIN", False), ("SYSMODULE", False),
])  # fmt: skip
def test_attributes_are_those_that_a_controller_takes_together(project, attributes, sound):
    template = RAPID.replace("MODULE {{ name }}", f"MODULE {{{{ name }}}}({attributes})", 1)
    if sound:
        assert text_of(project(template)).startswith(f"MODULE weld({attributes})")
    else:
        assert refused(project, template)[0].code == "CO611"
