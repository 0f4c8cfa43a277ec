"""Deployments to controllers whose tasks hold modules in a memory of their own."""

import shutil
import time

import pytest

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.states import Identity
from assistant.deploy import EVERY, Change, FileState
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.irc5.cabinet import BackgroundTask
from assistant.virtual.irc5.rws_faults import Fault

SEAM = """MODULE Seam
  ! taught on Monday
  CONST robtarget p10:=[[400.00,0.00,500.00],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS num nDone:=0;
  PERS pos shift:=[1.5,2,3.25];
  PROC weld()
    MoveL p10, v100, z10, tool0;   ! slowly
    nDone := nDone + 1;
    WaitTime {};
  ENDPROC
ENDMODULE
"""
OTHER = "MODULE Other\n  PROC main()\n    weld;\n  ENDPROC\nENDMODULE\n"
TAUGHT = "[[401.25,0.01,499.98],[1,0,0,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]]"


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    with VirtualIrc5(tmp_path_factory.mktemp("cell") / "home") as controller:
        yield controller


@pytest.fixture
def irc5(cell):
    """A controller without files and modules, as it was delivered."""
    cell.cabinet.do(lambda programs: (programs.stop(), programs.restore([])))
    cell.cabinet.do(lambda programs: setattr(programs, "anew", False))
    cell.cabinet.behind.clear()
    cell.cabinet.serial = ""
    for path in cell.folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    return cell


@pytest.fixture(params=["rws", "rwss"])
def either(request, irc5):
    """A client of each dialect."""
    return over(irc5, request.param)


@pytest.fixture
def client(irc5):
    return over(irc5, "rwss")


def over(irc5, scheme="rwss"):
    address = irc5.rws_address if scheme == "rws" else irc5.rwss_address
    return connect(address, password=irc5.password, timeout=10, certificate=irc5.certificate)


@pytest.fixture
def work(tmp_path):
    return Work(tmp_path)


class Work:
    """A folder of local programs, with their history."""

    def __init__(self, folder):
        self.folder, self.history = folder, folder / "history"

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text, newline="")
        return path

    def plan(self, client, *files, **options):
        return deploying.plan(files, client, history=self.history, **options)

    def deploy(self, planned, **options):
        return deploying.deploy(planned, history=self.history, patience=0.0, **options)

    def installed(self, client, *files, **options):
        done = self.deploy(self.plan(client, *files, load=True, **options))
        assert done.ok, done.findings
        return done

    def back(self, client, **options):
        return deploying.rollback(client, history=self.history, patience=0.0, **options)


def codes(findings):
    return [finding.code for finding in findings]


def until(true, seconds=10.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def text(irc5, module="seam"):
    """A module as it is in memory; None if it is not loaded."""
    return irc5.cabinet.do(lambda p: p.text(p.modules[module]) if module in p.modules else None)


def test_another_layout_is_no_difference_and_a_value_is(irc5, client, work):
    seam = work.file("seam.mod", SEAM.format(1))
    done = work.installed(client, seam)
    assert done.states == {"seam.mod": FileState.INSTALLED}
    assert text(irc5) == SEAM.format(1) == (irc5.folder / "seam.mod").read_text()
    irc5.cabinet.do(lambda programs: setattr(programs, "anew", True))
    assert "!" not in text(irc5) and "[[400,0,500]" in text(irc5)
    (same,) = work.plan(client, seam).files
    assert (same.change, same.taught) == (Change.SAME, "")
    with client:
        client.set_variable("shift", "[1.5,2,3.26]")
    (changed,) = work.plan(client, seam).files
    assert changed.change is Change.CONFLICT
    lines = [line for line in changed.taught.splitlines()[2:] if line[0] in "+-"]
    assert [line.replace(" ", "") for line in lines] == [
        "-PERSposshift:=[1.5,2,3.25];",
        "+PERSposshift:=[1.5,2,3.26];",
    ]
    again = work.plan(client, seam, replace=["seam.mod"])
    assert work.deploy(again).ok and "shift:=[1.5,2,3.25]" in text(irc5)


@pytest.mark.parametrize("anew", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_taught_point_is_a_conflict_with_its_difference(irc5, work, anew):
    client = over(irc5)
    seam = work.file("seam.mod", SEAM.format(1))
    work.installed(client, seam)
    irc5.cabinet.do(lambda programs: setattr(programs, "anew", anew))
    irc5.teach("Seam", "p10", TAUGHT)
    work.file("seam.mod", SEAM.format(2))
    planned = work.plan(client, seam)
    (file,) = planned.files
    assert file.change is Change.CONFLICT and codes(planned.notes) == ["DP222"]
    changes = [line for line in file.taught.splitlines()[2:] if line[0] in "+-"]
    assert len(changes) == 2 and "400.00" in changes[0] and "401.25" in changes[1]
    refused = work.deploy(planned)
    assert codes(refused.findings) == ["DP204"] and "401.25" in text(irc5)
    assert (irc5.folder / "seam.mod").read_text() == SEAM.format(1)


def test_what_a_program_counted_is_a_conflict_and_so_is_what_changes_after_the_plan(irc5, work):
    client = over(irc5)
    seam = work.file("seam.mod", SEAM.format(1))
    other = work.file("other.mod", OTHER.replace("weld;", "nDone:=nDone+0.5;"))
    work.installed(client, seam, other)
    irc5.cabinet.panel.set_motors(True)
    irc5.cabinet.do(lambda programs: (programs.reset(), programs.start("once")))
    until(lambda: not irc5.cabinet.do(lambda programs: programs.running))
    planned = work.plan(client, seam, other)
    assert [f.name for f in planned.conflicts] == ["seam.mod"]
    assert "nDone:=0.5;" in planned.files[0].taught
    work.file("seam.mod", SEAM.format(2))
    planned = work.plan(client, seam, replace=[EVERY])
    irc5.teach("Seam", "p10", TAUGHT)
    assert codes(work.deploy(planned).findings) == ["DP201"] and TAUGHT in text(irc5)


def test_what_was_taught_comes_back_with_a_rollback(irc5, either, work):
    """File and memory differ, and each becomes again what it was, byte for byte."""
    seam = work.file("seam.mod", SEAM.format(1))
    work.installed(either, seam)
    irc5.teach("Seam", "p10", TAUGHT)
    with either:
        either.set_variable("nDone", "17")
    held = text(irc5)
    assert "nDone:=17" in held and TAUGHT in held
    work.file("seam.mod", SEAM.format(2))
    work.installed(either, seam, replace=[EVERY])
    assert text(irc5) == SEAM.format(2)
    done = work.back(either)
    assert done.ok and text(irc5) == held
    assert (irc5.folder / "seam.mod").read_text() == SEAM.format(1)


def test_a_new_module_leaves_memory_and_disk_with_a_rollback(irc5, client, work):
    other = work.file("other.mod", OTHER.replace("weld;", "WaitTime 1;"))
    work.installed(client, other)
    work.installed(client, work.file("seam.sys", SEAM.format(1).replace("Seam", "Seam(SYSMODULE)")))
    assert text(irc5) is not None
    assert work.back(client).ok
    assert text(irc5) is None and not (irc5.folder / "seam.sys").exists()
    assert text(irc5, "other") is not None


@pytest.mark.slow
def test_comments_alone_are_brought_into_memory_too(irc5, work):
    client = over(irc5)
    seam = work.file("seam.mod", SEAM.format(1))
    work.installed(client, seam)
    new = SEAM.format(1).replace("Monday", "Tuesday")
    work.file("seam.mod", new)
    work.installed(client, seam)
    assert text(irc5) == new
    assert work.back(client).ok and text(irc5) == SEAM.format(1)


def test_a_module_that_gets_another_name_in_its_file(irc5, client, work):
    """The old one leaves the memory, where their procedures would clash; a rollback brings it."""
    seam = work.file("seam.mod", SEAM.format(1))
    work.installed(client, seam)
    irc5.teach("Seam", "p10", TAUGHT)
    held = text(irc5)
    work.file("seam.mod", SEAM.format(2).replace("MODULE Seam", "MODULE Bead"))
    work.installed(client, seam, replace=[EVERY])
    assert text(irc5) is None and text(irc5, "bead") is not None
    assert work.back(client).ok
    assert text(irc5) == held and text(irc5, "bead") is None


def test_a_name_that_a_loaded_module_has_is_refused_before_anything_is_changed(irc5, work):
    client = over(irc5)
    (irc5.folder / "main.mod").write_text(OTHER.replace("Other", "MainModule"))
    with client:
        client.load("main.mod")
    clash = SEAM.format(1).replace("PROC weld", "PROC MAIN")
    seam = work.file("seam.mod", clash)
    with pytest.raises(Refused) as refused:
        work.plan(client, seam, load=True)
    (finding,) = refused.value.findings
    assert finding.code == "DP106"
    assert finding.message.startswith("`MAIN` is declared by the module `Seam` (procedure)")
    assert "by the module `MainModule` (procedure)" in finding.message
    assert text(irc5) is None and not (irc5.folder / "seam.mod").exists()
    local = work.file("seam.mod", clash.replace("PROC MAIN", "LOCAL PROC MAIN"))
    assert work.deploy(work.plan(client, local, load=True)).ok


def test_two_files_of_one_module(irc5, work):
    one, two = (work.file(name, SEAM.format(1)) for name in ("one.mod", "two.mod"))
    with pytest.raises(Refused) as refused:
        work.plan(over(irc5), one, two, load=True)
    assert "DP105" in codes(refused.value.findings)


def test_a_file_of_several_modules(irc5, work):
    """It is not sent; one that was there comes back with a rollback."""
    client, both = over(irc5), SEAM.format(1) + OTHER
    seam = work.file("seam.mod", both)
    with pytest.raises(Refused) as refused:
        work.plan(client, seam)
    assert codes(refused.value.findings) == ["DP142"]
    (irc5.folder / "seam.mod").write_text(both)
    work.file("seam.mod", SEAM.format(1))
    work.installed(client, seam, replace=[EVERY])
    assert work.back(client).ok
    assert (irc5.folder / "seam.mod").read_text() == both and text(irc5) is None


def test_a_module_behind_a_mark_and_a_blank_line(irc5, work):
    client, new = over(irc5), "\ufeff" + SEAM.format(1).replace("MODULE Seam", "MODULE\n  Seam")
    work.installed(client, work.file("seam.mod", new))
    assert work.back(client).ok and text(irc5) is None


def test_names_move_between_modules_of_one_deployment(irc5, client, work):
    """Loaded one after the other, each would meet the procedure in the other's old module."""
    one, two = (
        "MODULE A\nPROC x()\nENDPROC\nENDMODULE\n",
        "MODULE B\nPROC y()\nENDPROC\nENDMODULE\n",
    )
    files = [work.file("a.mod", one), work.file("b.mod", two)]
    work.installed(client, *files)
    work.file("a.mod", one.replace("x()", "y()"))
    work.file("b.mod", two.replace("y()", "x()"))
    work.installed(client, *files)
    assert "PROC y" in text(irc5, "a") and "PROC x" in text(irc5, "b")
    assert work.back(client).ok
    assert "PROC x" in text(irc5, "a") and "PROC y" in text(irc5, "b")


@pytest.mark.parametrize(
    ("cut", "finish"),
    [
        ("mastership", "resume"),
        ("loadmod", "rollback"),
        pytest.param("mastership", "rollback", marks=pytest.mark.slow),
        pytest.param("loadmod", "resume", marks=pytest.mark.slow),
    ],
)
def test_a_death_between_file_and_memory(irc5, client, work, finish, cut):
    """Before the load is asked for, and before its answer arrives."""
    files = [work.file("seam.mod", SEAM.format(1)), work.file("other.mod", OTHER)]
    work.installed(client, *files)
    irc5.teach("Seam", "p10", TAUGHT)
    held = text(irc5)
    work.file("seam.mod", SEAM.format(2))

    def dies(entry):
        irc5.faults.add(Fault("cut", f"{cut}|/rw/system|/logout"))

    done = work.deploy(work.plan(client, *files, replace=[EVERY]), progress=dies)
    irc5.faults.clear()
    assert not done.ok and done.states["seam.mod"] is FileState.UNKNOWN
    done = getattr(deploying, finish)(client, history=work.history, patience=0.0)
    assert done.ok and "DP235" in codes(done.findings)
    file = (irc5.folder / "seam.mod").read_text()
    wanted = (SEAM.format(1), held) if finish == "rollback" else (SEAM.format(2), SEAM.format(2))
    assert (file, text(irc5)) == wanted and text(irc5, "other") == OTHER


def test_a_running_task_is_refused_before_anything_is_changed(irc5, client, work):
    seam = work.file("seam.mod", SEAM.format(1))
    main = work.file(
        "main.mod", "MODULE M\n  PROC main()\n    WaitTime 99;\n  ENDPROC\nENDMODULE\n"
    )
    work.installed(client, main)
    irc5.cabinet.panel.set_motors(True)
    irc5.cabinet.do(lambda programs: (programs.reset(), programs.start()))
    before = sorted(path.name for path in irc5.folder.iterdir())
    done = work.deploy(work.plan(client, seam, load=True))
    assert codes(done.findings) == ["DP206"] and "T_ROB1" in done.findings[0].message
    with pytest.raises(Refused) as refused:
        work.back(client)
    assert codes(refused.value.findings) == ["DP206"]
    assert sorted(path.name for path in irc5.folder.iterdir()) == before
    only_file = work.deploy(work.plan(client, seam))
    assert only_file.ok, "a file that is not loaded is nobody's"
    assert irc5.cabinet.do(lambda programs: programs.running)


def test_tasks_in_the_background_mind_only_their_own_modules(irc5, work):
    client = over(irc5)
    irc5.cabinet.behind["T_BACK"] = BackgroundTask(
        modules={"Watch": OTHER.replace("Other", "Watch")}
    )
    seam = work.file("seam.mod", SEAM.format(1))
    work.installed(client, seam)
    watch = work.file("watch.mod", OTHER.replace("Other", "Watch"))
    planned = work.plan(client, watch, task="T_BACK", replace=[EVERY])
    assert codes(work.deploy(planned).findings) == ["DP206"]
    assert not (irc5.folder / "watch.mod").exists()


def test_a_module_in_several_tasks_is_said(irc5, client, work):
    irc5.cabinet.behind["T_BACK"] = BackgroundTask(running=False, modules={"Seam": SEAM.format(1)})
    seam = work.file("seam.mod", SEAM.format(2))
    planned = work.plan(client, seam, load=True)
    assert codes(planned.notes) == ["DP234"] and "T_BACK" in planned.notes[0].message
    assert work.deploy(planned).ok
    assert irc5.cabinet.behind["T_BACK"].modules["Seam"] == SEAM.format(1)
    behind = work.plan(client, seam, task="T_BACK")
    assert codes(behind.notes) == ["DP234", "DP222"] and "`T_ROB1`" in behind.notes[1].message
    work.installed(client, seam, task="t_back", replace=[EVERY])
    assert irc5.cabinet.behind["T_BACK"].modules["Seam"] == SEAM.format(2)
    assert deploying.verify(client, history=work.history).ok
    with pytest.raises(Refused) as refused:
        deploying.rollback(client, 1, history=work.history)
    assert codes(refused.value.findings) == ["DP236"]
    assert work.back(client).ok
    assert irc5.cabinet.behind["T_BACK"].modules["Seam"] == SEAM.format(1)
    assert text(irc5) == SEAM.format(2)


def test_a_lost_program_pointer_is_said(irc5, work):
    client = over(irc5)
    main = work.file("main.mod", OTHER.replace("weld;", "WaitTime 1;"))
    work.installed(client, main)
    with client:
        client.load("main.mod")
    main.write_text(OTHER.replace("weld;", "WaitTime 2;"))
    done = work.installed(client, main)
    assert codes(done.findings) == ["DP235"] and "T_ROB1" in done.findings[0].message
    assert not irc5.cabinet.do(lambda programs: programs.running or programs.ready)


@pytest.mark.slow
def test_attributes_of_a_module_do_not_keep_it_from_being_replaced(irc5, work):
    client = over(irc5)
    heading = "MODULE Seam(SYSMODULE,NOSTEPIN,READONLY)"
    seam = work.file("seam.mod", SEAM.format(1).replace("MODULE Seam", heading))
    work.installed(client, seam)
    irc5.teach("Seam", "p10", TAUGHT)
    held = text(irc5)
    work.file("seam.mod", SEAM.format(2).replace("MODULE Seam", heading))
    work.installed(client, seam, replace=[EVERY])
    assert work.back(client).ok and text(irc5) == held


def test_a_module_whose_text_is_kept_secret(irc5, client, work):
    """It could not be taken back: it is not loaded, nor is one replaced that is there."""
    secret = SEAM.format(1).replace("MODULE Seam", "MODULE Seam(NOVIEW)")
    seam = work.file("seam.mod", secret)
    with pytest.raises(Refused) as refused:
        work.plan(client, seam, load=True)
    assert codes(refused.value.findings) == ["DP141"] and not (irc5.folder / "seam.mod").exists()
    (irc5.folder / "seam.mod").write_text(secret)
    with client:
        client.take_in("seam.mod")
    plain = work.file("seam.mod", SEAM.format(2))
    with pytest.raises(Refused) as refused:
        work.plan(client, plain, replace=[EVERY])
    assert "reading the module `Seam`" in refused.value.findings[0].message
    assert (irc5.folder / "seam.mod").read_text() == secret
    other = work.file("other.mod", OTHER.replace("weld;", "WaitTime 1;"))
    work.installed(client, other)


@pytest.mark.slow
def test_a_list_of_modules_goes_along_and_is_not_loaded(irc5, work):
    client = over(irc5)
    seam = work.file("seam.mod", SEAM.format(1))
    program = work.file("cell.pgf", "<Program><Module>seam.mod</Module></Program>")
    work.installed(client, program, seam)
    with client:
        assert client.modules() == ("Seam",)
    work.file("seam.mod", SEAM.format(2))
    work.installed(client, program, seam)
    assert work.back(client).ok and text(irc5) == SEAM.format(1)


def test_another_controller_at_the_address_is_refused(irc5, client, work):
    irc5.cabinet.serial = "12-34567"
    seam = work.file("seam.mod", SEAM.format(1))
    with pytest.raises(Refused) as refused:
        work.plan(client, seam, meant=Identity(serial="12-00000", robot="irb120-3-0.58"))
    assert codes(refused.value.findings) == ["DP233", "DP233"]
    meant = Identity(serial="12-34567", robot="irb1200-7-0.7")
    planned = work.plan(client, seam, load=True, meant=meant)
    irc5.cabinet.serial = "12-99999"
    assert codes(work.deploy(planned).findings) == ["DP207"]
    irc5.cabinet.serial = "12-34567"
    assert work.deploy(planned).ok
    irc5.cabinet.serial = "12-99999"
    with pytest.raises(Refused) as refused:
        work.back(client)
    assert codes(refused.value.findings) == ["DP207"] and text(irc5) is not None
    seam.write_text(SEAM.format(2))
    after = work.plan(client, seam)
    assert codes(after.notes) == ["DP231", "DP222"] and after.conflicts


def test_what_a_connection_does_not_tell_is_a_warning(irc5, work):
    seam = work.file("seam.mod", SEAM.format(1))
    client = connect(irc5.address, password=irc5.password, timeout=10)
    planned = work.plan(client, seam, meant=Identity(serial="12-34567"))
    assert codes(planned.notes) == ["DP232"]
