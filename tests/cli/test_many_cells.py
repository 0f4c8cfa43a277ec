"""What is told of a deployment to many controllers: for people, as JSON and as JUnit XML.

The XML is read by libxml2, another parser than the one that wrote it, against the elements and
attributes of Jenkins' junit-10.xsd (xunit-plugin).
"""

import io
import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack

import pytest
from lxml import etree

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused, error
from assistant.cli import main
from assistant.cli.presentation import Format
from assistant.cli.rollout import (
    RolloutOptions,
    end_in_order,
    junit_report,
    run_rollout,
    write_junit,
)
from assistant.controllers import connect
from assistant.controllers.address import parse
from assistant.deploy import (
    EVERY,
    Cell,
    CellState,
    Change,
    Deployment,
    FileState,
    Held,
    Outcome,
    Plan,
    PlannedFile,
    Rollout,
)
from assistant.deploy.site import Site
from assistant.virtual.cr import VirtualCr

PROGRAM = "10 OVRD 50\r\n20 DLY {}\r\n30 END\r\n"
DTD = etree.DTD(
    io.StringIO("""
<!ELEMENT testsuites (testsuite*)>
<!ATTLIST testsuites name CDATA #IMPLIED time NMTOKEN #IMPLIED tests NMTOKEN #IMPLIED
  failures NMTOKEN #IMPLIED errors NMTOKEN #IMPLIED>
<!ELEMENT testsuite (properties?, testcase*)>
<!ATTLIST testsuite name CDATA #REQUIRED tests NMTOKEN #REQUIRED failures NMTOKEN #REQUIRED
  errors NMTOKEN #REQUIRED skipped NMTOKEN #IMPLIED time NMTOKEN #IMPLIED>
<!ELEMENT properties (property*)>
<!ELEMENT property EMPTY>
<!ATTLIST property name CDATA #REQUIRED value CDATA #REQUIRED>
<!ELEMENT testcase (skipped | error | failure)?>
<!ATTLIST testcase name CDATA #REQUIRED classname CDATA #IMPLIED time NMTOKEN #IMPLIED>
<!ELEMENT skipped (#PCDATA)>
<!ATTLIST skipped message CDATA #IMPLIED>
<!ELEMENT error (#PCDATA)>
<!ATTLIST error type CDATA #IMPLIED message CDATA #IMPLIED>
<!ELEMENT failure (#PCDATA)>
<!ATTLIST failure type CDATA #IMPLIED message CDATA #IMPLIED>
""")
)
MARKUP = "]]></failure><x a='1'>&amp;&lt;\"'\U0001f600"
NASTY = MARKUP + "\x1b[31m\x00\x07\x9b2J\r\n\u202e\ud800\ufffe end"
BROKEN = error("XX101", "`{text}` is wrong", "mend {text}")
ADDRESS = parse("melfa://192.168.0.20")


def read(data):
    """The report, read by libxml2 and held against the elements that pipelines know."""
    root = etree.fromstring(data)
    assert DTD.validate(root), DTD.error_log
    return root


@pytest.fixture
def files(tmp_path):
    """Local programs A and B; the working folder is one of its own."""
    paths = []
    for name in ("a", "b"):
        path = tmp_path / f"{name}.prg"
        path.write_bytes(PROGRAM.format(2).encode())
        paths.append(path)
    return paths


@pytest.fixture
def two(files, tmp_path):
    """Cells of two controllers, the second of which has an A of somebody else."""
    with VirtualCr() as one, VirtualCr() as other:
        with connect(other.address) as client:
            client.write("A", PROGRAM.format(1).encode())
        yield [(one, "cell1"), (other, "cell2")]


def cells_of(two, files, history, replace=()):
    def cell(controller, name):
        client = connect(controller.address, timeout=10)
        return Cell(
            name,
            client.address,
            lambda: deploying.plan(files, client, replace=replace, history=history),
        )

    return [cell(controller, name) for controller, name in two]


def test_a_deployment_in_words_and_as_junit(two, files, tmp_path, capsys):
    report, kept = tmp_path / "report.xml", tmp_path / "kept"
    cells = cells_of(two, files, kept, [EVERY])
    assert run_rollout(cells, RolloutOptions("cell1", 2, report), kept, False, Format.TEXT) == 0
    told = capsys.readouterr()
    assert re.search(r"^cell1: done; 2 installed \(melfa://", told.out, re.M)
    assert told.out.endswith("2 of 2 controllers are done\n")
    assert "cell2 (melfa://" in told.err and "DP223" in told.err, "what was replaced"
    root = read(report.read_bytes())
    assert [s.get("name") for s in root] == ["cell1", "cell2"]
    assert root.get("tests") == "6" and root.get("failures") == root.get("errors") == "0"
    cases = [c.get("name") for c in root[0].iter("testcase")]
    assert cases == ["A", "B", "deployment"]
    properties = {p.get("name"): p.get("value") for p in root[1].iter("property")}
    assert properties["state"] == "done" and properties["kept in"].startswith(str(kept))


def test_a_conflict_as_json_and_as_junit(two, files, tmp_path, capsys):
    report, kept = tmp_path / "report.xml", tmp_path / "kept"
    cells = cells_of(two, files, kept)
    assert run_rollout(cells, RolloutOptions(junit=report), kept, False, Format.JSON) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["ok"] is False and "failed: cell2; not begun: cell1" in told["summary"]
    first, second = told["controllers"]
    assert (first["state"], second["state"]) == ("not begun", "failed")
    assert [f["code"] for f in first["findings"]] == ["DP403"]
    assert [f["change"] for f in second["files"]] == ["conflict", "create"]
    assert {f["code"] for f in second["findings"]} == {"DP222", "DP204"}
    root = read(report.read_bytes())
    first, second = root
    assert (first.get("skipped"), first.get("failures")) == ("3", "0")
    assert (second.get("skipped"), second.get("failures"), second.get("tests")) == ("2", "1", "3")
    (failure,) = second.iter("failure")
    assert failure.get("type") == "DP204" and "--pull" in failure.text


def test_a_table_on_a_terminal(two, files, tmp_path, capsys, monkeypatch):
    ours, theirs = pty.openpty()
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    cells = cells_of(two, files, tmp_path / "kept", [EVERY])
    with os.fdopen(theirs, "w") as terminal, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", terminal)
        assert run_rollout(cells, RolloutOptions(), tmp_path / "kept", False, Format.TEXT) == 0
        terminal.flush()
        shown = ""
        while shown.count("\n") < 4:  # a terminal hands over what it has so far
            assert select.select([ours], [], [], 30)[0], shown
            shown += os.read(ours, 10_000).decode()
    os.close(ours)
    head, first, second, last = shown.splitlines()
    assert head.split() == ["controller", "address", "result", "programs"]
    assert first.split()[0] == "cell1" and "done" in second
    assert last == "2 of 2 controllers are done"


def outcomes(text):
    """Each kind of outcome, with a text in every place that comes from outside."""
    findings = (BROKEN(text=text, place=text), BROKEN(text=text, path=text, line=3))
    states = {text: FileState.UNKNOWN}
    deployment = Deployment(ADDRESS, states, findings)
    planned = PlannedFile(text, text, Change.NEW, b"", Held(), Held(b""))
    plan = Plan(ADDRESS, (planned,), Site(connect(ADDRESS)))
    return Rollout(
        (
            Outcome(text, ADDRESS, CellState.FAILED, plan, deployment, findings, 1, 1.5),
            Outcome("two", ADDRESS, CellState.FAILED, findings=findings, status=2),
            Outcome("three", ADDRESS, CellState.NOT_BEGUN, findings=findings, status=1),
        )
    )


def test_the_xml_is_well_formed_whatever_messages_hold(capsys):
    root = read(junit_report(outcomes(NASTY)))
    assert len(root) == 3 and [s.get("errors") for s in root] == ["0", "1", "0"]
    program, whole = root[0].iter("failure")
    assert MARKUP in program.text and MARKUP in whole.text and MARKUP in root[0].get("name")
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", "".join(root.itertext()))
    for code in [*range(0x20), 0x7F, 0x80, 0x9F, 0xD800, 0xDFFF, 0xFFFE, 0xFFFF, 0x1FFFE]:
        read(junit_report(outcomes(f"a{chr(code)}b")))


def test_no_character_of_outside_steers_the_terminal(capsys):
    from assistant.cli.rollout import print_rollout

    print_rollout(outcomes(NASTY))
    told = capsys.readouterr()
    assert "�[31m" in told.err and told.out.count("\n") == 4
    for text in (told.out, told.err):
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", text)


def test_a_report_is_written_whole_or_not_at_all(tmp_path):
    report = tmp_path / "report.xml"
    write_junit(outcomes("a"), report)
    before = report.read_bytes()
    write_junit(outcomes("a"), report)
    assert report.read_bytes() == before and os.listdir(tmp_path) == ["report.xml"]
    (tmp_path / "folder.xml").mkdir()
    with pytest.raises(Refused) as refused:
        write_junit(outcomes("a"), tmp_path / "folder.xml")
    assert refused.value.exit_status == 2
    assert sorted(os.listdir(tmp_path)) == ["folder.xml", "report.xml"]


def test_whatever_ends_the_program_asks_for_an_end_in_order():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        before = signal.getsignal(number)
        with end_in_order() as halt:
            signal.raise_signal(number)
            signal.raise_signal(number)
            assert halt.asked, number
        assert signal.getsignal(number) is before


# --------------------------------------------------------------------------------- the command line


TARGETS = """
[controllers]
cell1 = "{0}"
cell2 = "{1}"
cell3 = "{2}"

[targets.cell1]
programs = ["a.prg", "b.prg"]
[targets.cell2]
programs = ["a.prg", "b.prg"]
[targets.cell3]
programs = ["a.prg", "b.prg"]

[deploy]
canary = "cell2"
parallel = 2
"""


@pytest.fixture
def project(files, tmp_path, monkeypatch):
    """A project with three real controllers; the working folder is that of its file."""
    monkeypatch.chdir(tmp_path)
    told = {}
    with ExitStack() as stack:
        there = []
        for index in range(3):

            def report(line, index=index):
                told.get(index, lambda line: None)(line)

            there.append(stack.enter_context(VirtualCr(report=report)))
        text = TARGETS.format(*(controller.address for controller in there))
        (tmp_path / "assistant.toml").write_text(text)
        yield there, told


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code


@pytest.mark.slow
def test_every_target_of_a_project_with_its_canary_first(project, tmp_path, capsys):
    there, told = project
    seen = []
    for index in range(3):
        told[index] = lambda line, index=index: seen.append(index) if "DLY 2" in line else None
    assert run("build") == 0
    assert run("deploy", "--junit", "report.xml") == 0
    assert seen and seen[0] == 1 and 1 not in seen[seen.index(0) :]
    assert all(one.text("A") == one.text("B") == PROGRAM.format(2) for one in there)
    told = capsys.readouterr().out
    assert told.endswith("3 of 3 controllers are done\n")
    root = read((tmp_path / "report.xml").read_bytes())
    assert [suite.get("name") for suite in root] == ["cell1", "cell2", "cell3"]
    one_more = ("deploy", "--target", "cell3", "--target", "cell1", "--canary")
    assert run(*one_more, "cell3", "--format", "json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in answer["controllers"]] == ["cell1", "cell3"]
    assert run("plan", "--target", "cell1", "--target", "cell4") == 2
    assert "no target `cell4`" in capsys.readouterr().err
    assert run("deploy", "--canary", "cell9", "--junit", "other.xml") == 2
    assert "DP401" in capsys.readouterr().err and not (tmp_path / "other.xml").exists()


@pytest.mark.slow
def test_two_targets_of_one_virtual_controller(files, tmp_path, monkeypatch, capsys):
    """It runs once for both, and they follow each other."""
    monkeypatch.chdir(tmp_path)
    text = '[controllers]\ncell1 = "virtual:cr"\n'
    for task, name in enumerate("ab", 1):
        text += f'[targets.{name}]\ncontroller = "cell1"\nprograms = ["{name}.prg"]\n'
        text += f'task = "SLOT{task}"\n'
    (tmp_path / "assistant.toml").write_text(text)
    assert run("build") == 0
    assert run("deploy", "--format", "json") == 0
    answer = json.loads(re.search(r"^\{.*", capsys.readouterr().out, re.M | re.S)[0])
    assert [one["state"] for one in answer["controllers"]] == ["done", "done"]
    assert run("verify", "--to", "cell1") == 0
    assert {"A: as deployed", "B: as deployed"} <= set(capsys.readouterr().out.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_process_that_is_told_to_end_ends_in_order(project, tmp_path, name):
    """While two are under way: both take back what they began, the third is not begun."""
    there, told = project
    text = (tmp_path / "assistant.toml").read_text()
    (tmp_path / "assistant.toml").write_text(text.replace('canary = "cell2"\n', ""))
    for one in there:
        with connect(one.address) as client:
            client.write("A", PROGRAM.format(1).encode())
            client.write("B", PROGRAM.format(1).encode())
    assert run("build") == 0
    both, process, sent = threading.Barrier(2), [], threading.Event()

    def report(line):
        if "DLY 2" in line and not sent.is_set():
            if both.wait(30) == 0:
                process[0].send_signal(getattr(signal, name))
                process[0].send_signal(getattr(signal, name))
                time.sleep(0.5)  # until the signal is there
                sent.set()
            sent.wait(30)

    told |= {0: report, 1: report}
    command = [sys.executable, "-m", "assistant", "deploy", "--replace", "*", "--format", "json"]
    process.append(
        subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    )
    out, err = process[0].communicate(timeout=60)
    answer = json.loads(out)
    assert process[0].returncode == 128 + getattr(signal, name)
    assert [one["state"] for one in answer["controllers"]] == ["failed", "failed", "not begun"]
    assert "ending in order" in err.decode()
    assert all(one.text("A") == one.text("B") == PROGRAM.format(1) for one in there)
    journals = deploying.all_journals(tmp_path / ".robot-assistant" / "deployments")
    assert [journal.result for journal in journals] == ["taken back"] * 2
