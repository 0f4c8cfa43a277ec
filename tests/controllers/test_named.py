"""The controllers that a project names, and that no password is kept with them."""

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect, controllers_of, named, parse
from assistant.controllers.address import find_credentials, password_variable
from assistant.findings.severities import severities_for

TABLE = """
[controllers]
cell1 = "melfa://192.168.0.20"
cell_2 = {address = "ftp://irc5/HOME:/parts", user = "anna"}

[controllers.cell3]
address = "ftps://irc5"
user = "engineer"
robot = "irb1200-7-0.7"
certificate = "certs/cell3.pem"
timeout = 2.5

[controllers.cell4]
address = "melfa://cr"
robot = "arms/mine.toml"
"""


def project(folder: Path, text: str, name: str = "assistant.toml") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder


def test_names_of_a_project(tmp_path):
    there = controllers_of(project(tmp_path, TABLE) / "programs" / "welding")
    assert list(there) == ["cell1", "cell_2", "cell3", "cell4"]
    assert there["cell1"].address == parse("melfa://192.168.0.20")
    assert there["cell_2"].address == parse("ftp://anna@irc5/HOME:/parts")
    third = there["cell3"]
    assert (third.robot, third.timeout) == ("irb1200-7-0.7", 2.5)
    assert third.certificate == tmp_path / "certs" / "cell3.pem"
    assert str(third.address) == "ftps://engineer@irc5:21"
    assert there["cell4"].robot == str(tmp_path / "arms" / "mine.toml")
    assert severities_for(tmp_path).findings == ()


def test_the_table_of_pyproject(tmp_path):
    text = TABLE.replace("[controllers", "[tool.robot-assistant.controllers")
    there = controllers_of(project(tmp_path, text, "pyproject.toml"))
    assert named("cell1", tmp_path) == there["cell1"]
    assert severities_for(tmp_path).findings == ()


def test_an_address_stands_for_itself(tmp_path):
    one = named("melfa://192.168.0.20:10002", tmp_path)
    assert (one.name, one.word) == ("melfa://192.168.0.20:10002", "192.168.0.20")
    assert (one.address.port, one.robot, one.variables) == (10002, None, "")
    assert controllers_of(tmp_path) == {}


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("controllers = 5", "CN107", 1),
        ('[controllers]\n"cell 1" = "melfa://cr"', "CN105", 2),
        ("[controllers]\ncell1 = 5", "CT304", 2),
        ('[controllers]\ncell1 = "http://cr"', "CN103", 2),
        ('[controllers]\ncell1 = "melfa://cr:0"', "CN101", 2),
        ('[controllers]\ncell1 = "cell2"', "CN103", 2),
        ('[controllers.cell1]\nrobot = "rv-2aj"', "CN108", 1),
        ('[controllers.cell1]\naddress = "melfa://cr"\nrobots = "x"', "CT302", 3),
        ('[controllers.cell1]\naddress = "melfa://cr"\ntimeout = 0', "CT303", 3),
        ('[controllers.cell1]\naddress = "ftp://a@irc5"\nuser = "b"', "CN109", 3),
        ('[controllers]\ncell-1 = "melfa://a"\nCell_1 = "melfa://b"', "CN110", 3),
    ],
)
def test_what_is_refused_with_its_place(tmp_path, text, code, line):
    project(tmp_path, text)
    with pytest.raises(Refused) as refused:
        named("cell1", tmp_path)
    (finding,) = refused.value.findings
    assert (finding.code, finding.line) == (code, line)
    assert finding.path == str(tmp_path / "assistant.toml") and finding.cure
    assert refused.value.exit_status == 2


@pytest.mark.parametrize(
    "text",
    [
        '[controllers]\ncell1 = "ftp://anna:geheim@irc5"',
        '[controllers]\ncell1 = {address = "ftp://anna:geheim@irc5"}',
        '[controllers.cell1]\naddress = "ftp://anna@irc5"\npassword = "geheim"',
        '[controllers.cell1]\naddress = "ftp://anna@irc5"\nPwd = "geheim"',
        '[controllers.cell1]\naddress = "ftp://anna@irc5"\nkennwort = "geheim"',
    ],
)
def test_a_password_is_refused_and_never_shown(tmp_path, text):
    project(tmp_path, text)
    with pytest.raises(Refused) as refused:
        named("cell1", tmp_path)
    (finding,) = refused.value.findings
    assert finding.code == ("CT302" if "kennwort" in text else "CN106")
    assert "geheim" not in repr(finding) and "geheim" not in str(refused.value)


def test_an_unknown_name_tells_the_known_ones(tmp_path):
    with pytest.raises(Refused) as refused:
        named("cell9", project(tmp_path, TABLE))
    (finding,) = refused.value.findings
    assert finding.code == "CN104" and "`cell_2`" in finding.message
    assert refused.value.exit_status == 2


def test_connecting_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(project(tmp_path, TABLE))
    assert connect("cell1").address == parse("melfa://192.168.0.20")
    monkeypatch.setenv("ROBOT_ASSISTANT_CELL_2_PASSWORD", "of-cell-2")
    assert str(connect("cell_2").address) == "ftp://anna@irc5:21/HOME:/parts"


def test_a_controller_has_variables_of_its_own():
    assert password_variable("cell-1", "PASSWORD") == "ROBOT_ASSISTANT_CELL_1_PASSWORD"
    environment = {
        "ROBOT_ASSISTANT_USER": "anna",
        "ROBOT_ASSISTANT_PASSWORD": "of-all",
        "ROBOT_ASSISTANT_CELL1_USER": "bert",
        "ROBOT_ASSISTANT_CELL1_PASSWORD": "of-cell-1",
    }
    address = parse("ftp://irc5")
    own = find_credentials(address, controller="cell1", environment=environment)
    assert (own.user, own.password) == ("bert", "of-cell-1")
    other = find_credentials(address, controller="cell2", environment=environment)
    assert (other.user, other.password) == ("anna", "of-all")


@pytest.mark.parametrize(
    ("address", "code", "said"),
    [
        ("192.168.0.20", "CN117", "melfa://192.168.0.20"),
        ("cell.local:8080", "CN117", "rws://cell.local:8080"),
        ("virtual:cr800", "CN118", "`virtual:irc5` and `virtual:cr`"),
        ("virtual:irc5", "CN118", "assistant.toml"),
        ("telnet://192.168.0.20", "CN103", "`virtual:irc5`"),
    ],
)
def test_an_address_without_a_scheme_says_which_to_try(address, code, said):
    with pytest.raises(Refused) as refused:
        named(address)
    (finding,) = refused.value.findings
    assert finding.code == code and said in f"{finding.message} {finding.cure}"
