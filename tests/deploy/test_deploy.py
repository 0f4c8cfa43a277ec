"""Planning and deploying through the real clients to the virtual controllers."""

import json
import socket

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused, Severity, Unreadable
from assistant.controllers import connect
from assistant.deploy import EVERY, Change, FileState
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.bad_ftp import FtpPeer
from tests.deploy.sites import MODULE, PROGRAM, CrSite, Irc5Site
from tests.wire import Wire


@pytest.fixture(params=[Irc5Site, CrSite], ids=["irc5", "cr"])
def site(request, tmp_path):
    site = request.param(tmp_path)
    yield site
    site.controller.stop()


@pytest.fixture
def files(site, tmp_path):
    """A local file for each name, with content 2; on the controller: A with 1, B with 2, no C."""
    local = tmp_path / "out"
    local.mkdir()
    paths = []
    for name in site.names:
        path = local / (name if "." in name else f"{name.lower()}.prg")
        path.write_bytes(site.source(name, 2).encode())
        paths.append(path)
    site.put(site.names[0], site.source(site.names[0], 1))
    site.put(site.names[1], site.source(site.names[1], 2))
    return paths


def plan(files, controller):
    """A plan that replaces what no deployment put there, as these tests do at the beginning."""
    return deploying.plan(files, controller, replace=[EVERY])


def deploy(planned, **options):
    return deploying.deploy(planned, files_only=True, patience=0.0, **options)


def on_controller(site):
    return [site.text(name) for name in site.names]


def codes(findings):
    return [finding.code for finding in findings]


def test_a_plan_says_what_is_new_changed_and_same(site, files):
    before = on_controller(site)
    planned = plan(files, site.client())
    assert [f.name for f in planned.files] == list(site.names)
    assert [f.change for f in planned.files] == [Change.CHANGED, Change.SAME, Change.NEW]
    changed, same, new = planned.files
    assert same.diff == "" and len(planned.changes) == 2
    removed = [line for line in changed.diff.splitlines() if line.startswith("-")]
    added = [line for line in changed.diff.splitlines() if line.startswith("+")]
    assert len(removed) == len(added) == 2 and "1" in removed[1] and "2" in added[1]
    assert new.diff.startswith("--- /dev/null") and "DLY 2" in new.diff + " DLY 2"
    assert on_controller(site) == before, "a plan changes nothing"


def test_a_deployment_installs_verifies_and_keeps_a_backup(site, files, tmp_path):
    before = on_controller(site)
    seen = []
    planned = plan(files, site.client())
    deployment = deploy(
        planned, history=tmp_path / "kept", progress=lambda file: seen.append(file.name)
    )
    assert deployment.ok and deployment.findings == ()
    assert codes(planned.notes) == ["DP223"]
    a, b, c = site.names
    assert deployment.states == {
        a: FileState.INSTALLED, b: FileState.SAME, c: FileState.INSTALLED,
    }  # fmt: skip
    assert seen == [a, c]
    assert on_controller(site) == [site.source(name, 2) for name in site.names]
    assert deployment.folder == tmp_path / "kept" / planned.address.label / "0001"
    assert (deployment.folder / f"before/1-{a}").read_bytes().decode() == before[0]
    kept = json.loads((deployment.folder / "programs.json").read_text())
    assert [row["before"]["file"] for row in kept] == [f"before/1-{a}", None]
    record = json.loads((deployment.folder / "record.json").read_text())
    assert set(record["programs"]) == set(site.names)
    assert "2 installed" in deployment.summary


def test_doing_it_again_changes_nothing(site, files, tmp_path):
    client = site.client()
    assert deploy(plan(files, client), history=tmp_path / "kept").ok
    again = deploy(plan(files, client), history=tmp_path / "kept")
    assert again.ok and set(again.states.values()) == {FileState.SAME} and again.folder is None
    kept = tmp_path / "kept" / client.address.label
    assert [f.name for f in kept.iterdir() if f.is_dir()] == ["0001"]


def test_a_failure_puts_everything_back(site, files, tmp_path):
    before = on_controller(site)
    rows = ["    ! " + "x" * 60] * 140
    long = site.source(site.names[2], 2)
    if site.names == CrSite.names:
        long += "".join(f"{n} DLY 1.25\r\n" for n in range(100, 2000, 10))
    else:
        long = long.replace("ENDPROC", "\r\n".join(rows) + "\r\n  ENDPROC")
    files[2].write_bytes(long.encode())
    site.no_room()
    deployment = deploy(plan(files, site.client()), history=tmp_path / "kept")
    assert not deployment.ok
    a, b, c = site.names
    assert deployment.states == {
        a: FileState.PUT_BACK, b: FileState.SAME, c: FileState.UNTOUCHED,
    }  # fmt: skip
    assert on_controller(site) == before
    assert codes(deployment.findings)[-1] == "DP301"
    assert "is what it was before" in deployment.summary


def test_a_restart_in_the_middle_puts_everything_back(site, files, tmp_path):
    before = on_controller(site)

    def progress(file):
        if file.name == site.names[2]:
            site.restart()

    deployment = deploy(plan(files, site.client()), history=tmp_path / "kept", progress=progress)
    assert not deployment.ok and FileState.UNKNOWN not in deployment.states.values()
    assert on_controller(site) == before
    assert codes(deployment.findings) == ["CN204", "DP301"]


def test_a_controller_that_stays_away_leaves_an_unknown_state(site, files, tmp_path):
    def progress(file):
        if file.name == site.names[2]:
            site.controller.stop()

    old = site.text(site.names[0])
    deployment = deploy(plan(files, site.client()), history=tmp_path / "kept", progress=progress)
    assert not deployment.ok
    a, _, c = site.names
    assert deployment.states[a] == deployment.states[c] == FileState.UNKNOWN
    assert "do not start" in deployment.summary
    lost = [f for f in deployment.findings if f.code == "DP303"]
    assert len(lost) == 2 and any(str(deployment.folder) in f.message for f in lost)
    assert (deployment.folder / f"before/1-{a}").read_bytes().decode() == old


def test_an_interruption_puts_everything_back(site, files, tmp_path):
    before = on_controller(site)

    def progress(file):
        if file.name == site.names[2]:
            raise KeyboardInterrupt

    deployment = deploy(plan(files, site.client()), history=tmp_path / "kept", progress=progress)
    assert not deployment.ok and on_controller(site) == before
    assert codes(deployment.findings)[0] == "DP304"


def test_a_plan_is_not_carried_out_over_somebody_elses_change(site, files, tmp_path):
    planned = plan(files, site.client())
    site.put(site.names[0], site.source(site.names[0], 7))
    before = on_controller(site)
    deployment = deploy(planned, history=tmp_path / "kept")
    assert not deployment.ok and codes(deployment.findings) == ["DP201"]
    assert on_controller(site) == before
    assert list((tmp_path / "kept").rglob("journal.jsonl")) == []


def test_a_backup_that_cannot_be_written_stops_it(site, files, tmp_path):
    before = on_controller(site)
    (tmp_path / "kept").write_text("a file where a folder should be")
    deployment = deploy(plan(files, site.client()), history=tmp_path / "kept")
    assert not deployment.ok and codes(deployment.findings) == ["DP203"]
    assert on_controller(site) == before


def test_nobody_there(site, files):
    client = site.client()
    planned = plan(files, client)
    before = on_controller(site)
    site.controller.stop()
    with pytest.raises(Refused) as refused:
        plan(files, client)
    assert codes(refused.value.findings) == ["CN201"]
    deployment = deploy(planned)
    assert not deployment.ok and codes(deployment.findings) == ["CN201"]
    assert deployment.folder is None and "is what it was before" in deployment.summary
    assert on_controller(site) == before


def test_a_broken_program_is_never_sent(site, files):
    before = on_controller(site)
    files[2].write_bytes(site.source(site.names[2], 2, wrong=True).encode())
    with pytest.raises(Refused) as refused:
        plan(files, site.client())
    assert all(f.path == str(files[2]) and f.line for f in refused.value.findings)
    assert on_controller(site) == before


def test_rules_of_the_language_keep_a_program_back(tmp_path):
    zone = tmp_path / "a.mod"
    text = MODULE.format("A", "main", 1).replace("WaitTime 1", "WaitTime")
    zone.write_text(text, newline="")
    jump = tmp_path / "b.prg"
    jump.write_text("10 GOTO *NOWHERE\r\n20 END\r\n", newline="")
    with VirtualIrc5(tmp_path / "home") as irc5, VirtualCr() as cr:
        for file, client in (
            (zone, connect(irc5.address, password=irc5.password)),
            (jump, connect(cr.address)),
        ):
            with pytest.raises(Refused) as refused:
                plan([file], client)
            assert any(f.path == str(file) and f.line for f in refused.value.findings)


def test_files_that_cannot_be_read(site, files, tmp_path):
    with pytest.raises(Unreadable):
        plan([*files, tmp_path / "missing.mod"], site.client())
    with pytest.raises(Unreadable):
        plan([tmp_path], site.client())
    with pytest.raises(Refused) as refused:
        plan([], site.client())
    assert codes(refused.value.findings) == ["DP101"]


def test_two_files_of_one_name(site, files, tmp_path):
    twin = tmp_path / "twin"
    twin.mkdir()
    other = twin / files[0].name.upper()
    other.write_bytes(files[0].read_bytes())
    with pytest.raises(Refused) as refused:
        plan([*files, other], site.client())
    assert codes(refused.value.findings) == ["DP102"]


def test_a_program_for_the_other_make(tmp_path):
    rapid, melfa = tmp_path / "seam.prg", tmp_path / "seam1.prg"
    rapid.write_text(MODULE.format("SEAM", "main", 1), newline="")
    melfa.write_text(PROGRAM.format(1), newline="")
    text = tmp_path / "notes.txt"
    text.write_text("no program at all\n")
    with VirtualCr() as cr, pytest.raises(Refused) as refused:
        plan([rapid], connect(cr.address))
    assert codes(refused.value.findings) == ["DP103"]
    with VirtualIrc5(tmp_path / "home") as irc5:
        client = connect(irc5.address, password=irc5.password)
        with pytest.raises(Refused) as refused:
            plan([melfa], client)
        assert codes(refused.value.findings) == ["DP103"]
        with pytest.raises(Refused) as refused:
            plan([text], client)
        assert codes(refused.value.findings) == ["DP104"]


def test_modules_go_before_the_program_file_that_names_them(tmp_path):
    module, program = tmp_path / "seam.mod", tmp_path / "a.pgf"
    module.write_text(MODULE.format("SEAM", "main", 1), newline="")
    program.write_text("<Program><Module>seam.mod</Module></Program>")
    with VirtualIrc5(tmp_path / "home") as irc5:
        planned = plan([program, module], connect(irc5.address, password=irc5.password))
        assert [f.name for f in planned.files] == ["seam.mod", "a.pgf"]
        assert deploy(planned, history=tmp_path / "kept").ok


def test_what_comes_back_otherwise_is_put_back(tmp_path):
    file = tmp_path / "a.prg"
    file.write_text(PROGRAM.format(2), newline="")

    def mischief(told):
        """Alters a speed after each SAVE of the new program, as a broken store might."""
        if "SAVE" in told and "A" in controller.state.store:
            steps = controller.state.store["A"].steps
            if steps[30] == "30 DLY 2":
                steps[10] = "10 OVRD 100"

    with VirtualCr(report=mischief) as controller:
        with connect(controller.address) as client:
            client.write("A", PROGRAM.format(1).encode())
        deployment = deploy(plan([file], connect(controller.address)), history=tmp_path / "kept")
        assert not deployment.ok and codes(deployment.findings) == ["DP202", "DP301"]
        finding = deployment.findings[0]
        assert "OVRD 50" in finding.message and "OVRD 100" in finding.message
        assert controller.text("A") == PROGRAM.format(1)
        assert deployment.states == {"A": FileState.PUT_BACK}


def test_a_server_that_alters_a_byte_is_caught(tmp_path):
    file = tmp_path / "a.mod"
    text = MODULE.format("A", "main", 2).encode()
    file.write_bytes(text)
    old = MODULE.format("A", "main", 1).encode()
    with FtpPeer({"a.mod": old}, alter=lambda data: data.replace(b"2;", b"9;")) as peer:
        deployment = deploy(plan([file], peer.connect()), history=tmp_path / "kept")
        assert not deployment.ok and codes(deployment.findings) == ["CN206"]
        assert deployment.states == {"a.mod": FileState.UNTOUCHED}
        assert peer.files["a.mod"] == old


def test_a_program_somebody_edits_stops_the_rest(tmp_path):
    files = []
    for name in "abc":
        file = tmp_path / f"{name}.prg"
        file.write_text(PROGRAM.format(3), newline="")
        files.append(file)
    with VirtualCr() as controller:
        planned = plan(files, connect(controller.address))
        with Wire(controller.port) as other:
            other.ask("1;1;LOAD=B")
            deployment = deploy(planned, history=tmp_path / "kept")
        assert not deployment.ok and controller.names() == ()
        assert deployment.states["A"] is FileState.PUT_BACK
        assert deployment.states["C"] is FileState.UNTOUCHED
        assert "4170" in deployment.findings[0].message


def test_the_default_backup_folder_is_numbered_and_one_for_each_controller(
    tmp_path, monkeypatch, site, files
):
    monkeypatch.chdir(tmp_path)
    client = site.client()
    for value in (2, 3, 4):
        files[0].write_bytes(site.source(site.names[0], value).encode())
        assert deploy(plan(files[:1], client)).ok
    root = tmp_path / ".robot-assistant" / "deployments" / client.address.label
    assert sorted(f.name for f in root.iterdir() if f.is_dir()) == ["0001", "0002", "0003"]
    kept = [
        (root / n / f"before/1-{site.names[0]}").read_bytes().decode()
        for n in ("0001", "0002", "0003")
    ]
    assert kept == [site.source(site.names[0], value) for value in (1, 2, 3)]


def test_no_motion_is_ever_asked_for(tmp_path):
    told = []
    file = tmp_path / "a.prg"
    file.write_text(PROGRAM.format(2), newline="")
    with VirtualCr(report=told.append) as controller:
        assert deploy(plan([file], connect(controller.address)), history=tmp_path / "kept").ok
    sent = {line.split(";", 2)[2].split("'")[0][:4] for line in told}
    assert sent <= {
        *("OPEN", "PDIR", "NEW", "LOAD", "ECLR", "EMDA", "SAVE", "LIST", "CLOS"),
        *("STAT", "PNRR", "ERRO"),
    }  # fmt: skip


def test_what_a_plan_shows_holds_no_password(site, files):
    planned = plan(files, site.client())
    password = getattr(site.controller, "password", "none of it")
    assert password not in repr(planned)


def test_severities_of_what_was_undone_do_not_hide_the_cause(tmp_path):
    file = tmp_path / "a.prg"
    file.write_text(PROGRAM.format(2), newline="")
    with VirtualCr(capacity=10) as controller:
        deployment = deploy(plan([file], connect(controller.address)), history=tmp_path / "kept")
        assert deployment.findings[0].severity is Severity.ERROR
        assert "4110" in deployment.findings[0].message and controller.names() == ()


def test_a_difference_says_nothing_to_the_terminal(tmp_path):
    file = tmp_path / "a.mod"
    file.write_text(MODULE.format("A", "main", 1), newline="")
    old = MODULE.format("A", "main", 1).replace("MODULE A", "! \x1b[2J\x9b1m\x07\r\nMODULE A")
    with FtpPeer({"a.mod": old.encode("latin-1")}) as peer:
        diff = plan([file], peer.connect()).files[0].diff
    assert "[2J" in diff and not set(diff) & {"\x1b", "\x9b", "\x07", "\r"}


def test_a_closed_port_is_never_a_success(tmp_path):
    file = tmp_path / "a.mod"
    file.write_text(MODULE.format("A", "main", 1), newline="")
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(Refused) as refused:
        plan([file], connect(f"ftp://u@127.0.0.1:{port}", password="p"))
    assert refused.value.exit_status != 0 and codes(refused.value.findings) == ["CN201"]


def test_a_rollback_says_that_everything_is_what_it_was_before(site, files, tmp_path):
    before = on_controller(site)
    assert deploy(plan(files, site.client()), history=tmp_path / "kept").ok
    back = deploying.rollback(site.client(), history=tmp_path / "kept", patience=0.0)
    assert back.ok and back.back and on_controller(site) == before
    assert set(back.states.values()) == {FileState.PUT_BACK}
    assert "is what it was before" in back.summary and "installed" not in back.summary
