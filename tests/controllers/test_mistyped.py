"""However an address is mistyped, a password in it is never repeated, in whatever is printed."""

import json
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.cli import main
from assistant.cli.app import refuse_passwords
from assistant.controllers import connect
from assistant.controllers.address import holds_password, parse, without_password

MISTYPED = [
    "robot:{}@host", "ftp:robot:{}@h", "ftp:/robot:{}@h", "ftp://robot:{}%40h", "ftp://robot%3A{}@h",
    "//robot:{}@h", "ftp://robot:{}@h", "FTP//robot:{}@h", "ftp;//robot:{}@h", "ftp:\\\\robot:{}@h",
    "http://robot:{}@h", "ftp://robot@{}@h", "ftp://robot:{}@h:99999", "ftp://robot%253A{}%2540h",
    "ftp://[robot:{}@h", "ftp://h?password={}", "ftp://robot@h?mode={}", "ftp://h#robot:{}@x",
    "melfa://robot:{}@h", "melfa-serial://robot:{}@x", "virtual:robot:{}@h", "robot/{}@h",
    "ftp://robot:{}@h/\x01", " ftp://robot:{}@h", "ftp://robot:{}@h/HOME:/x", "sftp:robot/{}@h",
    "rws:robot:{}%40h:80", "user=robot;password={}@h",
]  # fmt: skip
"""All with an `@` or what stands for one."""
WITHOUT = ["ftp://robot:{}", "robot:{}", "ftp:robot:{}", "rws://h:{}/HOME:"]
"""A host that was forgotten; what is no port may be a password."""
PASSWORDS = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cs", "Cc", "Zs", "Zl", "Zp"]),
    min_size=0,
    max_size=12,
).map(lambda text: f"Ge{text}heim7")


def shown_of(refused):
    return [f"{refused}", *(repr(finding) for finding in refused.findings)]


@given(st.sampled_from([*MISTYPED, *WITHOUT]), PASSWORDS)
@example("ftp://robot:{}@h", "Gep@ss/w:rd?heim7")
@example("ftp://robot:{}%40h", "Ge/heim7")
def test_an_address_is_refused_without_its_password(form, password):
    text = form.format(password)
    assert password not in without_password(text)
    with pytest.raises(Refused) as refused:
        parse(text)
    assert refused.value.exit_status == 2
    ends = (password,) if "@" in password else (password, "heim7")  # what is behind it is a host
    assert not [said for said in shown_of(refused.value) for end in ends if end in said]


@pytest.mark.parametrize(
    "text",
    [
        "ftp://robot@h:21/HOME:/x@y".replace("x@y", "x%40y"), "ftp://anna%40firm@h:21", "rws://h",
        "melfa-serial:///dev/serial/by-path/pci-0000:00:14.0", "ftp://[::1]:21", "virtual:irc5",
    ],
)  # fmt: skip
def test_what_holds_none_is_shown(text):
    assert not holds_password(text)
    if "://" in text:
        assert without_password(text) == text and parse(text)


@pytest.mark.parametrize("word", ["C:/Users/me@firm/x.mod", 'text="a:b@c"', "me@firm/x.mod"])
def test_what_only_looks_like_an_address_is_let_through(word):
    refuse_passwords(["check", word])


COMMANDS = (
    ("ls", "{}"),
    ("ls", "more", "{}"),
    ("deploy", "seam.mod", "--to", "{}"),
    ("deploy", "seam.mod", "--to={}", "--format", "json"),
    ("deploy", "seam.mod", "--to", "{}", "--junit", "report.xml", "--history", "history"),
    ("plan", "seam.mod", "--to", "{}", "--format", "markdown"),
    ("check", "{}", "--format", "sarif"),
    ("rollback", "--to", "{}"),
)
TABLES = (
    '[controllers]\ncell1 = "{}"\n',
    '[controllers]\n"{}" = "melfa://h"\n',
    '[controllers.cell1]\naddress = "ftp://h"\nuser = "{}"\n',
    "[controllers.cell1]\naddress = {}\n",
    '[programs]\np = {{files = ["seam.mod"]}}\n[targets.t]\ncontroller = "{}"\nprograms = ["p"]\n',
    '[targets."{}"]\ncontroller = "cell1"\n',
    '[deploy]\ncanary = "{}"\n',
    '[severity]\n"{}" = "off"\n',
)
TOLD = [form for form in MISTYPED if holds_password(form)]
"""Those in which a password is seen wherever they stand: as a name, or as an argument too many."""
FORMS = [TOLD[0], *(pytest.param(form, marks=pytest.mark.slow) for form in TOLD[1:])]
ABOUT_A_PROJECT = (("ls", "cell1"), ("deploy", "--format", "json"))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seam.mod").write_text("MODULE seam\nENDMODULE\n")
    return tmp_path


def printed(capsys, command):
    with pytest.raises(SystemExit) as ended:
        main(list(command))
    out, err = capsys.readouterr()
    assert "CL900" not in out + err
    return ended.value.code, out, err


def assert_nowhere(password, folder, *texts):
    assert not [text for text in texts if password in text]
    for file in folder.rglob("*"):
        assert password not in str(file)
        assert not file.is_file() or password not in file.read_text(errors="replace")


@pytest.mark.parametrize("form", FORMS)
def test_no_command_prints_or_keeps_it(form, here, capsys):
    password = "Geheim7"
    for command in COMMANDS:
        typed = [word.format(form.format(password)) if "{}" in word else word for word in command]
        code, out, err = printed(capsys, typed)
        assert code == 2
        assert_nowhere(password, here, out, err)
        if "json" in command:
            assert json.loads(out)["findings"][0]["code"] in ("CN101", "CN102", "CN103")


@pytest.mark.parametrize("form", FORMS)
def test_no_command_prints_it_out_of_the_project(form, here, capsys):
    password = "Geheim7"
    for table in TABLES:
        Path("assistant.toml").write_text(table.format(form.format(password)))
        for command in ABOUT_A_PROJECT:
            _, out, err = printed(capsys, command)
            assert password not in out + err, table


def test_a_user_of_the_environment_may_hold_it_as_well(here, monkeypatch):
    for name in ("ROBOT_ASSISTANT_USER", "ROBOT_ASSISTANT_CELL1_USER"):
        monkeypatch.setenv(name, "robot:Geheim7")
        Path("assistant.toml").write_text('[controllers]\ncell1 = "ftp://h"\n')
        with pytest.raises(Refused) as refused:
            connect("cell1", password="other")
        assert [finding.code for finding in refused.value.findings] == ["CN114"]
        assert not [said for said in shown_of(refused.value) if "Geheim7" in said]
        monkeypatch.delenv(name)
