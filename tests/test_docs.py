"""What the README and the docs tell people to type works."""

from __future__ import annotations

import ast
import functools
import json
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import get_args

import jsonschema
import pytest

import assistant
from assistant import languages, robots
from assistant.base.diagnostics import Severity
from assistant.compiler.comparison import read_names
from assistant.compiler.loader import load, with_project_settings
from assistant.compiler.simulated_run import read_script
from assistant.controllers import controllers_of
from assistant.findings import rulebook
from assistant.findings.severities import severities_for
from assistant.program import pseudo
from assistant.program.statements import Move
from assistant.project.project_file import project_schema
from assistant.sources.process.file import read_process
from assistant.virtual.melfa import Options
from assistant.virtual.melfa.options import choose
from assistant.virtual.proving.comparison import NOT_COMPARED, Uncompared
from assistant.vision.cameras.camera_file import read_cameras
from assistant.vision.pointing.devices import read_device
from assistant.vision.servoing.servo_task import read_servo
from docs import api, comparing, findings, house, limits, pictures
from tests.forks import Forks

PROJECT = Path(__file__).parent.parent
PAGES = [PROJECT / "README.md", *sorted((PROJECT / "docs").rglob("*.md"))]
NAMES = {page: str(page.relative_to(PROJECT)) for page in PAGES}
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.M | re.S)
CHANGES = re.compile(r"^```python\n([^`]*)^```\n\n```diff\n(.*?)^```", re.M | re.S)
"""Python that changes a program, and the lines that it changes."""
PICTURE = re.compile(r"^!\[[^]]+\]\((?:docs/)?pictures/(\w+)\.png\)$", re.M)
LASTING = ("docs/around.md", "docs/controllers/use-cases.md", "docs/free-turns.md")
"""Pages whose commands move an arm in real time, or compute, for a minute."""
EXITS = re.compile(r"\s+# exits (\d)$")
READY = b"listening"


def blocks(page: Path, kind: str) -> list[str]:
    return [text for found, text in BLOCK.findall(page.read_text("utf-8")) if found == kind]


def examples(kind: str) -> list[tuple[str, str]]:
    """Page and text of each block of that kind in all pages."""
    return [(NAMES[page], text) for page in PAGES for text in blocks(page, kind)]


def commands(page: Path) -> list[str]:
    """The lines after a `$ ` prompt."""
    lines = [line for block in blocks(page, "console") for line in block.splitlines()]
    return [line[2:] for line in lines if line.startswith("$ ")]


def test_there_are_commands_in_the_readme():
    assert commands(PROJECT / "README.md")


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=name, marks=[pytest.mark.slow] if name in LASTING else [])
        for page, name in NAMES.items()
    ],
)
def test_the_commands_of_a_page_work(page, tmp_path, forks):
    shutil.copytree(PROJECT / "samples", tmp_path / "samples")
    environment = forks.environment(ROBOT_ASSISTANT_PASSWORD="secret", NO_COLOR="1", BROWSER="true")
    servers: list[subprocess.Popen[bytes]] = []
    try:
        for line in commands(page):
            expected = int(match[1]) if (match := EXITS.search(line)) else 0
            command = EXITS.sub("", line)
            if command.endswith(" &"):
                servers.append(_server(command[:-2], tmp_path, environment))
                continue
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=tmp_path,
                env=environment,
                capture_output=True,
                text=True,
            )
            said = done.stdout + done.stderr
            assert done.returncode == expected, f"{command}\n{said}"
            assert "Traceback" not in said
    finally:
        for server in servers:
            server.send_signal(signal.SIGINT)
            server.communicate(timeout=10)


def _server(command: str, folder: Path, environment: dict[str, str]) -> subprocess.Popen[bytes]:
    server = subprocess.Popen(
        ["bash", "-c", f"exec {Path(sys.executable).parent}/{command}"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
    )
    assert server.stdout is not None
    line = server.stdout.readline()
    assert READY in line, line
    return server


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("page", "text"), examples("python"))
def test_the_python_of_a_page_runs(page, text, tmp_path, forks):
    assert output(text, tmp_path, forks)


@pytest.mark.parametrize("page", PAGES, ids=NAMES.get)
def test_what_the_python_of_a_page_changes_is_shown(page, tmp_path, forks):
    for text, shown in CHANGES.findall(page.read_text("utf-8")):
        changed = [x for x in output(text, tmp_path, forks).splitlines() if re.match(r"[-+] ", x)]
        assert changed == shown.splitlines()


def output(text: str, folder: Path, forks: Forks) -> str:
    """What the Python of a page prints, beside the samples."""
    shutil.copytree(PROJECT / "samples", folder / "samples", dirs_exist_ok=True)
    done = forks.python("-c", text, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


FILE = re.compile(r"`((?:tests|samples)/[\w./-]*)`")


def test_what_the_page_about_the_papers_names_is_there() -> None:
    named = FILE.findall((PROJECT / "docs" / "papers.md").read_text("utf-8"))
    assert len(named) > 30
    assert [name for name in named if not (PROJECT / name).exists()] == []


LINK = re.compile(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)")


@functools.cache
def anchors(page: Path) -> set[str]:
    """What the headings of a page can be linked by."""
    heads = re.findall(r"^#+ +(.*)$", page.read_text("utf-8"), re.M)
    return {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=NAMES.get)
def test_the_links_of_a_page_lead_somewhere(page):
    for path, anchor in LINK.findall(page.read_text("utf-8")):
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), path
        assert not anchor or anchor in anchors(there), f"{path}#{anchor}"


@pytest.mark.parametrize(("page", "text"), examples("pseudo"))
def test_the_pseudo_programs_of_a_page_are_exact(page, text):
    assert pseudo.print_program(pseudo.parse(text)).text == text


LIMITS = "[melfa-basic]"
SETTINGS = dict.fromkeys(("[severity]", "[rapid]", LIMITS), "assistant.toml")
OF_PROJECTS = ("[controllers", "[programs", "[targets", "[deploy", "[style")
SETTINGS |= dict.fromkeys(OF_PROJECTS, "assistant.toml")
SETTINGS["[tool."] = "pyproject.toml"
"""How the settings of a project begin, and the file that they are in."""


def six_joints() -> str:
    """A URDF with the axes that a robot file of a page speaks of."""
    links = "".join(f'<link name="l{i}"/>' for i in range(7))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        '<limit lower="-2" upper="2" velocity="1"/></joint>'
        for i in range(6)
    )
    return f'<robot name="arm">{links}{joints}</robot>'


@pytest.mark.parametrize(("page", "text"), examples("toml"))
def test_the_files_of_a_page_are_read(page, text, tmp_path):
    name = next((n for begin, n in SETTINGS.items() if text.startswith(begin)), "x.process.toml")
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    if text.startswith(("[[set]]", "[[answer]]", "[options]")):
        script = read_script(file)
        assert script.changes or script.answers or choose(script.options) != Options()
        return
    if text.startswith("[cameras"):
        assert read_cameras(file).cameras
        return
    if text.startswith("[names]"):
        assert read_names(file)
        return
    if text.startswith("moves = "):
        moves = tomllib.loads(text)["moves"]
        names = dict.fromkeys(move if isinstance(move, str) else move["to"] for move in moves)
        target = '[[targets]]\nname = "{}"\nposition = [400, {}, 300]\nquaternion = [0, 1, 0, 0]\n'
        targets = "".join(target.format(name, 10 * at) for at, name in enumerate(names))
        moved = tmp_path / "moves.toml"
        moved.write_text(f"{text}{targets}[signals.grip]\nnumber = 1\n", encoding="utf-8")
        (main,) = load(moved).program.procedures
        assert sum(isinstance(one, Move) for one in main.body) == len(moves)
        return
    if text.startswith("kind = "):
        assert read_device(file).marks
        return
    if text.startswith("law = "):
        assert read_servo(file).target is not None
        return
    if text.startswith("urdf = "):
        (tmp_path / "arm.urdf").write_text(six_joints(), encoding="utf-8")
        assert robots.load(file).limits.shape == (6, 2)
    elif name in SETTINGS.values():
        settings = severities_for(tmp_path)
        assert not settings.findings
        if text.startswith("[controllers"):
            assert controllers_of(tmp_path)
        if text.startswith(OF_PROJECTS):
            jsonschema.Draft7Validator(project_schema()).validate(tomllib.loads(text))
            return
        language = languages.get("melfa-basic-5")
        said = with_project_settings(language, tmp_path) is not language
        assert said if LIMITS in text else settings.levels
    else:
        process = read_process(file)
        tables = process.layers, process.signals, process.tools, process.frames, process.lines
        assert any(tables) or process.placement is not None


def test_the_findings_page_is_what_the_rules_say():
    written = (PROJECT / "docs" / "findings.md").read_text(encoding="utf-8")
    assert written == findings.page(), "python -m docs.findings > docs/findings.md"


def test_the_page_about_limits_is_what_they_are():
    written = (PROJECT / "docs" / "limits.md").read_text(encoding="utf-8")
    assert written == limits.page(), "python -m docs.limits > docs/limits.md"


def test_the_page_about_comparing_is_what_is_compared():
    written = (PROJECT / "docs" / "comparing.md").read_text(encoding="utf-8")
    assert written == comparing.page(), "python -m docs.comparing > docs/comparing.md"
    assert set(NOT_COMPARED) == set(get_args(Uncompared))


def test_the_page_about_python_is_what_the_docstrings_say():
    written = (PROJECT / "docs" / "api.md").read_text(encoding="utf-8")
    assert written == api.page(), "python -m docs.api > docs/api.md"
    assert all(f"### assistant.{name}\n" in written for name in api.FUNCTIONS)


def imported_names(text: str) -> set[str]:
    """Dotted names of this package that Python code imports, such as `assistant.robots`."""
    found = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    return {
        f"{node.module}.{name.name}"
        for node in found
        if (node.module or "").partition(".")[0] == "assistant"
        for name in node.names
    }


def test_everything_public_is_on_the_page_about_python():
    """`__all__` of the package and its modules on top, and whatever pages and samples import."""
    cells = json.loads((PROJECT / "docs" / "tutorial.ipynb").read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    code += [text for _, text in examples("python")]
    code += [file.read_text("utf-8") for file in (PROJECT / "samples" / "python").glob("*.py")]
    names = set().union(*map(imported_names, code))
    names |= {f"assistant.{name}" for name in assistant.__all__ if name != "__version__"}
    for name in api.MODULES:
        names |= {f"assistant.{name}.{one}" for one in api.offered(getattr(assistant, name))}
    page = (PROJECT / "docs" / "api.md").read_text(encoding="utf-8")
    assert api.unlisted(page, sorted(names)) == []
    for name in names:
        last = name.rpartition(".")[2]
        without = re.sub(rf"^(#+ |- `)([\w.]+\.)?{last}\b.*\n", "", page, flags=re.M)
        assert api.unlisted(without, [name]) == [name]
    blocks = page.partition("### assistant.blocks.robot\n")[2].partition("\n### ")[0]
    assert blocks.count("- `") == blocks.count("blockargs") > 10, "each block has its signature"


def test_every_finding_says_what_to_do():
    """An info may be just that."""
    asking = [rule for rule in rulebook.rules().values() if rule.severity is not Severity.INFO]
    assert [rule.code for rule in asking if not rule.cure.strip()] == []


def test_each_picture_of_a_page_is_made_by_a_command():
    shown = {name for page in PAGES for name in PICTURE.findall(page.read_text("utf-8"))}
    stored = {file.stem: file.stat().st_size for file in pictures.FOLDER.glob("*.png")}
    assert shown == stored.keys() == pictures.PICTURES.keys()
    assert max(stored.values()) <= 80 * 1024


@pytest.mark.slow
def test_the_rooms_of_languages_are_counted() -> None:
    assert house.code_lines('"""Says."""\n\n# Why\nx = [\n    1,  # one\n]\n') == 3
    sizes = house.sizes()
    for name in ("rapid", "melfa_basic"):
        assert {"tree", "reading", "text", "checks", "lift", "lower", "tables"} <= set(sizes[name])
    lines = house.table(sizes).splitlines()
    assert lines[-1].split()[1:] == [str(sum(inside.values())) for inside in sizes.values()]


ON_AN_INDEX = re.compile(r"pip[x]? install[^`\n]*?(?<![\w./\\-])robot-assistant(?![\w.-]*[/\\])")


def test_no_page_and_no_message_asks_an_index_for_the_package() -> None:
    """It is on none: a stranger's package may have its name tomorrow."""
    texts = [*PAGES, PROJECT / "CHANGELOG.md", PROJECT / "action.yml"]
    for folder in ("assistant", "samples", "templates"):
        texts += [f for f in (PROJECT / folder).rglob("*") if f.suffix in {".py", ".toml", ".yml"}]
    wrong = {str(f): ON_AN_INDEX.findall(f.read_text("utf-8", "replace")) for f in texts}
    assert {file: found for file, found in wrong.items() if found} == {}
    assert ON_AN_INDEX.search("pip install 'robot-assistant[studio]'")
    assert ON_AN_INDEX.search("pip install robot-assistant\n")
