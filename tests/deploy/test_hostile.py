"""Attacks by what a controller tells: its listing, and what deployments keep on its disk.

Whoever can write there can make a record with a digest that fits: what it says is looked at as
any text from outside.
"""

import hashlib
import io
import json
import re
import zipfile
from dataclasses import replace

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.cli import main
from assistant.controllers import connect
from assistant.deploy import EVERY, Held, Step
from assistant.deploy import history as archives
from assistant.deploy.history import Entry, create_journal, journals
from assistant.deploy.record import Digests, new_record, read_record
from assistant.deploy.site import CLAIM, CLAIMANT, RECORD, UNDER_WAY
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.bad_ftp import FtpPeer

MODULE = "MODULE SEAM\r\n  PROC seam_main()\r\n    WaitTime {};\r\n  ENDPROC\r\nENDMODULE\r\n"
OLD, NEW = MODULE.format(1).encode(), MODULE.format(2).encode()
STEERING = (
    "\x1b]0;mine\x07\x1b[2J\x9b31m\r\nDP000 info: all is well\n::error::x\n"
    "[red]r[/red]<img src=x onerror=alert(1)>](http://evil) |a| `b` \u202eevil\u2066\x00"
)
MARKUP = "[red]r[/red]<img src=x onerror=alert(1)>](http://evil) |a| `b` ``"
NAME = "20261123T000000Z-abcdef"
OUTSIDE = (
    "../evil", "../../evil", "..", ".", "/etc/evil", "a/../../evil", "a\\..\\evil", "C:\\evil",
    "evil.mod\r\nDELE seam.mod", "evil\x00.mod", "con", "~evil", "", "a" * 300,
)  # fmt: skip


@pytest.fixture
def project(tmp_path, monkeypatch):
    """The working folder, two below the folder of the test, with a program in it."""
    folder = tmp_path / "some" / "project"
    folder.mkdir(parents=True)
    (folder / "seam.mod").write_bytes(NEW)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", "secret")
    return folder


@pytest.fixture
def irc5(tmp_path, project):
    with VirtualIrc5(tmp_path / "home", password="secret", rws=None, rwss=None) as there:
        (there.folder / "seam.mod").write_bytes(OLD)
        yield there


def client(irc5):
    return connect(irc5.address, password="secret", timeout=10)


def plan(irc5, **options):
    return deploying.plan(["seam.mod"], client(irc5), **options)


def deployed(irc5):
    done = deploying.deploy(plan(irc5, replace=[EVERY]), files_only=True, patience=0.0)
    assert done.ok
    return done


def codes(findings):
    return [finding.code for finding in findings]


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code


def assert_harmless(*texts):
    """No control character is in an answer, and no line of it was made up by somebody else."""
    for text in texts:
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", text)
        assert not re.search(r"^(DP000|::error)", text, re.M)


def signed(content):
    """A record with the digest that its format asks for, as anybody can work it out."""
    text = json.dumps(content, indent=2, sort_keys=True) + "\n"
    full = {**content, "digest": hashlib.sha256(text.encode()).hexdigest()}
    return json.dumps(full, indent=2, sort_keys=True).encode()


def kept_in(irc5, name):
    return json.loads((irc5.folder / name).read_bytes())


def test_names_of_a_listing_lead_nowhere(project, tmp_path, capsys):
    """They are told without what would steer a terminal, and no file is made of them."""
    names = [name for name in OUTSIDE if "\n" not in name] + ["\x1b[2Jx.mod", "[red]x.mod"]
    before = {path for path in tmp_path.rglob("*") if ".robot-assistant" not in path.parts}
    with FtpPeer(dict.fromkeys(names, OLD)) as peer:
        peer.password = "secret"
        address = peer.connect().address
        to = ("deploy", "seam.mod", "--to", address, "--files-only")
        assert run(*to, "--dry-run", "--format", "json") == 0
        assert run(*to) == 0
        assert {"seam.mod", RECORD, UNDER_WAY} <= set(peer.files) - set(names)
        assert all(peer.files[name] == OLD for name in names), "what is not ours is left alone"
    told = capsys.readouterr()
    assert_harmless(told.out, told.err)
    after = {path for path in tmp_path.rglob("*") if ".robot-assistant" not in path.parts}
    assert after == before


def test_a_record_that_was_changed_is_told(irc5, project):
    """Whichever byte it is; what it says counts no more, and nothing is replaced by its word."""
    deployed(irc5)
    (project / "seam.mod").write_bytes(MODULE.format(3).encode())
    file = irc5.folder / RECORD
    record = file.read_bytes()
    assert codes(plan(irc5).findings) == []
    read = read_record(record, RECORD)
    for at in range(len(record)):
        changed = record[:at] + bytes([record[at] ^ 4]) + record[at + 1 :]
        try:
            assert read_record(changed, RECORD) == read
        except Refused as refused:
            assert codes(refused.findings) == ["DP221"]
    file.write_bytes(record.replace(b'"who": "', b'"who": "not '))
    planned = plan(irc5)
    assert codes(planned.findings) == ["DP221", "DP222"] and planned.conflicts
    done = deploying.deploy(planned, files_only=True)
    assert not done.ok and (irc5.folder / "seam.mod").read_bytes() == NEW


@pytest.mark.parametrize("bad", [b"", b"[", b"[]", b"1", b'{"digest": 1}', b"[" * 50_000, b"\xff"])
def test_a_record_that_is_none(irc5, bad):
    (irc5.folder / RECORD).write_bytes(bad)
    (irc5.folder / CLAIMANT).write_bytes(bad)
    assert codes(plan(irc5).findings) == ["DP221", "DP222"]
    (irc5.folder / CLAIM).mkdir()
    done = deploying.deploy(plan(irc5, replace=[EVERY]), files_only=True)
    assert "DP210" in codes(done.findings) and (irc5.folder / "seam.mod").read_bytes() == OLD


def told_of(irc5, capsys, *more):
    """All that is said of a plan, in each form, and of a deployment that is refused."""
    to = ("deploy", "seam.mod", "--to", irc5.address, "--files-only", *more)
    said = []
    for options in (
        (),
        *(("--dry-run", "--format", form) for form in ("text", "json", "markdown")),
    ):
        assert run(*to, *options) == 1
        told = capsys.readouterr()
        said += [told.out, told.err]
    return said


TEXTS = ("name", "who", "time", "commit", "address", "task", "robot", "controller", "serial")


@pytest.mark.parametrize("where", [*TEXTS, "program", "file"])
def test_what_a_record_says_steers_nothing(irc5, capsys, where):
    """Its digest fits: everybody can work that out."""
    deployed(irc5)
    (irc5.folder / "seam.mod").write_bytes(MODULE.format(4).encode())
    content = kept_in(irc5, RECORD)
    del content["digest"]
    if where == "program":
        content["programs"][STEERING] = {"file": None, "loaded": None}
    elif where == "file":
        content["programs"]["seam.mod"]["file"] = STEERING
    else:
        content[where] = STEERING
    (irc5.folder / RECORD).write_bytes(signed(content))
    assert codes(plan(irc5).findings) == ["DP221", "DP222"]
    if where in ("who", "program"):
        assert_harmless(*told_of(irc5, capsys))


def test_markup_in_a_record_stays_text(irc5, capsys):
    """In Markdown for a pull request it stands in code, in JUnit XML it is escaped."""
    deployed(irc5)
    (irc5.folder / "seam.mod").write_bytes(MODULE.format(4).encode())
    content = kept_in(irc5, RECORD)
    del content["digest"]
    content["name"] = content["who"] = MARKUP
    (irc5.folder / RECORD).write_bytes(signed(content))
    *text, markdown, _ = told_of(irc5, capsys)
    assert MARKUP in "".join(text) and MARKUP in markdown
    outside = re.sub(r"(`+) .*? \1(?!`)", "", markdown)
    assert "<img" not in outside and "evil" not in outside


def test_what_a_program_says_steers_nothing(irc5):
    """In the difference that is shown; characters that turn the direction of a text do not, too."""
    text = MODULE.format(4).replace("PROC", "! \x1b[2J \x9b31m \u202e \u2066 \u2028 end\r\n  PROC")
    (irc5.folder / "seam.mod").write_bytes(text.encode())
    (file,) = plan(irc5).files
    assert "-  ! �[2J �31m � � � end\n" in file.diff
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]", file.diff)


def test_what_a_claim_says_steers_nothing(irc5, capsys):
    (irc5.folder / CLAIM).mkdir()
    claim = {"deployment": STEERING, "who": STEERING, "time": STEERING}
    (irc5.folder / CLAIMANT).write_text(json.dumps(claim))
    to = ("deploy", "seam.mod", "--to", irc5.address, "--files-only", "--replace", "*")
    for form in ("text", "json", "markdown"):
        assert run(*to, "--format", form) == 1
        told = capsys.readouterr()
        assert "DP210" in told.err + told.out and "mine" in told.err + told.out
        assert_harmless(told.out, told.err)


# -------------------------------------------------------------------------------------- the archive


def interrupted(irc5, archive):
    """What a computer leaves on a controller that died while it deployed."""
    (irc5.folder / CLAIM).mkdir(exist_ok=True)
    claim = {"deployment": NAME, "who": "somebody@elsewhere", "time": "today"}
    (irc5.folder / CLAIMANT).write_text(json.dumps(claim))
    (irc5.folder / UNDER_WAY).write_bytes(archive)


def packed(tmp_path, entries=None):
    """An archive of a deployment, as another computer keeps it there."""
    entries = entries or [Entry("seam.mod", Held(OLD), Held(NEW))]
    programs = {entry.name: Digests() for entry in entries}
    record = replace(new_record("ftp://elsewhere", None), name=NAME, programs=programs)
    return archives.pack_journal(create_journal(tmp_path / "elsewhere", record, entries))


def unpack(data, place):
    return archives.unpack_journal(data, place, NAME)


def rewritten(archive, change):
    """The archive with what `change` makes of its files, each name and content."""
    with zipfile.ZipFile(io.BytesIO(archive)) as old:
        files = {info.filename: old.read(info) for info in old.infolist()}
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as new:
        for name, content in change(files).items():
            new.writestr(name, content)
    return data.getvalue()


def everything(tmp_path):
    """All files of the test but those of the history, with what is in them."""
    files = (path for path in tmp_path.rglob("*") if path.is_file())
    return {p: p.read_bytes() for p in files if ".robot-assistant" not in p.parts}


def test_an_archive_that_is_whole_is_gone_on_with(irc5, tmp_path):
    """So that the others fail for what is wrong in them."""
    interrupted(irc5, packed(tmp_path))
    done = deploying.resume(client(irc5), patience=0.0)
    assert done.ok and (irc5.folder / "seam.mod").read_bytes() == NEW


@pytest.mark.parametrize("name", OUTSIDE)
def test_names_of_an_archive_lead_nowhere(irc5, tmp_path, project, name):
    """Those of its files, of programs on the controller, and of where these stand."""

    def program(files):
        rows = json.loads(files["programs.json"])
        return {**files, "programs.json": json.dumps([{**rows[0], "name": name}]).encode()}

    def place(files):
        rows = json.loads(files["programs.json"])
        rows[0]["before"]["file"] = name
        return {**files, "programs.json": json.dumps(rows).encode(), name or "x": b"evil"}

    def more(files):
        extra = {name or "before/": b"evil", f"before/{name}": b"evil", f"x/{name}": b"evil"}
        return {**files, **extra}

    archive = packed(tmp_path)
    history = project / ".robot-assistant" / "deployments"
    before = everything(tmp_path)
    for change in [place] if name == "con" else [program, place]:
        with pytest.raises(Refused) as refused:
            unpack(rewritten(archive, change), history / "cell")
        assert codes(refused.value.findings) == ["DP203"]
        assert not list(history.glob("cell/*"))
    journal = unpack(rewritten(archive, more), history / "cell")
    kept = {path.relative_to(journal.folder).as_posix() for path in journal.folder.rglob("*")}
    assert kept == {
        "before", "after", "before/1-seam.mod", "after/1-seam.mod",
        "programs.json", "record.json",
    }  # fmt: skip
    assert everything(tmp_path) == before


def test_no_program_takes_the_place_of_what_deployments_keep(irc5, tmp_path):
    for name in (RECORD, UNDER_WAY, CLAIM, CLAIMANT, RECORD.upper(), "seam.mod~"):
        archive = packed(tmp_path, [Entry(name, Held(None), Held(NEW))])
        with pytest.raises(Refused) as refused:
            unpack(archive, tmp_path / "history")
        assert codes(refused.value.findings) == ["DP203"]


def test_an_archive_with_mistakes_is_refused_and_leaves_nothing(irc5, tmp_path):
    """Cut or changed anywhere, nested without end: always a finding, never a rest."""
    archive = packed(tmp_path)
    history = tmp_path / "history"

    def nested(files):
        return {**files, "programs.json": b"[" * 100_000}

    def nothing(files):
        return {}

    def record(files):
        return {**files, "record.json": files["record.json"].replace(b"somebody", b"other")[:-9]}

    bad = [archive[:at] for at in range(0, len(archive), 29)]
    bad += [rewritten(archive, change) for change in (nested, nothing, record)]
    refusals = 0
    for at in range(0, len(archive), 7):
        bad.append(archive[:at] + bytes([archive[at] ^ 0x55]) + archive[at + 1 :])
    for data in bad:
        try:
            journal = unpack(data, history)
        except Refused as refused:
            refusals += 1
            assert set(codes(refused.findings)) <= {"DP203", "DP221"}
        else:
            (entry,) = journal.entries
            assert entry == Entry("seam.mod", Held(OLD), Held(NEW)), "what counts is as it was"
    assert refusals > len(bad) / 2
    assert all(path.name.isdigit() for path in history.iterdir())


@pytest.mark.parametrize("told", [2**31, 10])
def test_an_archive_that_is_too_long_is_not_unpacked(tmp_path, told):
    """By what its directory tells of a file, or by what is in it and not told there."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("before/1-x", bytes(2**23))
    raw = bytearray(data.getvalue())
    size = raw.rindex(b"PK\x01\x02") + 24  # of the file as it is unpacked (APPNOTE 4.3.12)
    raw[size : size + 4] = told.to_bytes(4, "little")
    with pytest.raises(Refused) as refused:
        unpack(bytes(raw), tmp_path / "history")
    assert codes(refused.value.findings) == ["DP203"]
    assert not list(tmp_path.glob("history/*"))


def test_a_damaged_archive_leaves_the_controller_alone(irc5, tmp_path, capsys):
    """Also where its own text steers: it is told, and nothing is changed."""
    before = dict(everything(irc5.folder))
    for bad in (b"", b"PK\x05\x06" + bytes(18), packed(tmp_path)[:-40]):
        interrupted(irc5, bad)
        for way in (deploying.resume, deploying.rollback):
            with pytest.raises(Refused):
                way(client(irc5), patience=0.0)
    after = everything(irc5.folder)
    assert {path: after[path] for path in before} == before


# -------------------------------------------------------------------------------------- the history


def test_a_history_that_was_changed_is_told_and_not_put_on_a_controller(irc5, project):
    """Line ends that version control changed, an editor, a disk: no byte of it is believed."""
    done = deployed(irc5)
    for name in ("record.json", "programs.json", "before/1-seam.mod"):
        file = done.folder / name
        kept = file.read_bytes()
        for changed in (kept.replace(b"\r\n", b"\n"), kept.replace(b"1", b"3"), b""):
            if changed == kept:
                continue
            file.write_bytes(changed)
            with pytest.raises(Refused) as refused:
                deploying.rollback(client(irc5), patience=0.0)
            assert codes(refused.value.findings) == ["DP203"], (name, changed)
            assert (irc5.folder / "seam.mod").read_bytes() == NEW
        file.write_bytes(kept)
    assert deploying.rollback(client(irc5), patience=0.0).ok
    assert (irc5.folder / "seam.mod").read_bytes() == OLD


def test_steps_that_nobody_wrote_count_as_interrupted(irc5):
    done = deployed(irc5)
    for text in ("[" * 100_000, "1", '{"step": ["done"]}', '{"step": "mine"}', "\x00"):
        (done.folder / "journal.jsonl").write_text(text + "\n")
        (journal,) = journals(done.folder.parent)
        assert journal.open and journal.last is Step.BEGUN
