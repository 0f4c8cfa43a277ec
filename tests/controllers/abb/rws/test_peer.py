"""What the virtual IRC5 has not: loading parameters, write access of RobotWare 8, bad events."""

import json
import sys
import threading
from contextlib import contextmanager

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder
from assistant.controllers.rules import Lost
from tests.controllers.abb.rws.literal import ONE, TWO
from tests.controllers.abb.rws.peer import Rws1, Rws2, framed, li, refusal, rows
from tests.controllers.abb.rws.seam import codes

BACKINFO = b">>SYSTEM_ID:\r\ncell\r\n\r\n>>TASK1: (T_ROB1,,)\r\nPROGMOD/m.mod @ \r\n"
SYS, MOC = b"SYS:CFG_1.0:6:1::\n#\nSYS_MISC:\n", b"MOC:CFG_1.0:6:1::\n"


def backing_up(kind, **files):
    """A controller whose backup has these files, and is not ready at the first look."""
    home = kind.home.removesuffix("HOME")
    states = iter(
        ["Backup in Progress", "Backup Ready", "Backup in Progress"] + ["Backup Ready"] * 9
    )

    def make(body):
        place = body.removeprefix(f"backup=/fileservice/{home}")
        assert place.startswith("BACKUP/assistant_")
        for name, data in files.items():
            peer.files[f"{home}{place}/{name}"] = data
        return 202, "", {"Location": "/progress/7"}

    def state(body):
        return rows(li("ctrl-backup-state", "backup", backup_state=next(states)))

    one = kind is Rws1
    answers = {
        f"POST /ctrl/backup{'?action=backup' if one else '/create'}": make,
        f"GET /ctrl/backup{'?action=backupstate' if one else '/state'}": state,
        "GET /progress/7": rows(li("progress", "7", state="ready", code="294912")),
        "POST /rw/cfg?action=validate" if one else "POST /rw/cfg/none": (204, ""),
        f"POST /rw/cfg{'?action=load' if one else '/load'}": (204, ""),
    }
    peer = kind({**(ONE if one else TWO), **answers})
    return peer


@pytest.mark.parametrize("kind", [Rws1, Rws2])
def test_parameters_are_restored_by_loading_them(kind, tmp_path):
    files = {"BACKINFO/backinfo.txt": BACKINFO, "SYSPAR/SYS.cfg": SYS, "SYSPAR/MOC.cfg": MOC}
    with backup_folder.appearing_folder(tmp_path / "saved", "abb") as place:
        new = {"SYSPAR/SYS.cfg": SYS + b"x\n", "SYSPAR/MOC.cfg": MOC + b"x\n"}
        for name, data in {**files, **new}.items():
            backup_folder.put_file(place, name, data)
    with backing_up(kind, **files) as peer, peer.connect() as client:
        restoring = client.restore(tmp_path / "saved")
        assert list(restoring.changes) == ["SYSPAR/SYS.cfg"] and restoring.needs_restart
        assert list(restoring.left_out) == ["SYSPAR/MOC.cfg"]
        assert not any("BACKUP" in name for name in peer.files)
        peer.log.clear()
        restoring.apply()
        assert peer.held == {}
        home = peer.home.removesuffix("HOME")
        form = f"filepath={home}TEMP/SYS.cfg&action-type=replace"
        loading = [(p, b) for m, p, b in peer.asked("POST") if p.startswith("/rw/cfg")]
        if kind is Rws1:
            assert loading == [("/rw/cfg?action=validate", form), ("/rw/cfg?action=load", form)]
        else:
            assert loading == [("/rw/cfg/load", form)]
        stored = [b for m, p, b in peer.log if m == "PUT" and p.endswith("TEMP/SYS.cfg")]
        assert stored == [(SYS + b"x\n").decode()] and peer.files == {}


def test_a_backup_that_fails_on_the_controller_leaves_nothing(tmp_path):
    peer = backing_up(Rws1, **{"BACKINFO/backinfo.txt": BACKINFO})
    failed = rows(li("ctrl-backup-state", "backup", backup_state="Error during backup"))
    peer.answers["GET /ctrl/backup?action=backupstate"] = failed
    with peer, peer.connect() as client:
        with pytest.raises(Refused) as refused:
            client.backup(tmp_path / "saved")
        assert codes(refused) == ["CN209"] and "error during backup" in str(refused.value)
    assert list(tmp_path.iterdir()) == [] and peer.files == {}


def test_a_backup_without_its_index_is_not_taken_for_one(tmp_path):
    with backing_up(Rws1, **{"SYSPAR/SYS.cfg": SYS}) as peer, peer.connect() as client:
        with pytest.raises(Refused) as refused:
            client.backup(tmp_path / "saved")
        assert codes(refused) == ["CN222"] and list(tmp_path.iterdir()) == []


def test_write_access_of_robotware_8():
    """RobotWare 8 has given mastership up: 410, and a control station that registers."""
    gone = {f"POST /rw/mastership/edit/{act}": (410, "") for act in ("request", "release")}
    station = {
        "POST /rw/controlstation/register/remote": (204, ""),
        "POST /rw/controlstation/writeaccess/request": (204, ""),
        "POST /rw/controlstation/writeaccess/release": (
            403,
            refusal(-1073435873, "The control station does not have SPoC."),
        ),
    }
    with Rws2({**TWO, **gone, **station}) as peer, peer.connect() as client:
        client.set_override(50)
        client.set_override(60)
        posts = [path.rpartition("/")[2] for _, path, _ in peer.asked("POST")]
    speed = "speedratio?action=setspeedratio"
    assert posts == ["request", "remote", "request", speed, "release", "request", speed, "release"]
    form = next(body for _, path, body in peer.log if path.endswith("remote"))
    assert "control-station-name=robot-assistant&control-station-id=%7B" in form


@pytest.mark.parametrize("kind", [Rws1, Rws2])
def test_events_come_through_a_websocket_into_which_nothing_is_sent(kind):
    first = rows('<li class="pnl-opmode-ev"><a href="/rw/panel/opmode;opmode" rel="self"/>'
                 '<span class="opmode">AUTO</span></li>')  # fmt: skip
    answer = (201, first, {"Location": "ws://10.0.0.1:80/poll/3"})
    answers = {"POST /subscription": answer, "DELETE /subscription/3": (200, "")}
    with kind({**(ONE if kind is Rws1 else TWO), **answers}) as peer, peer.connect() as client:
        with client.subscribe(["mode", "signal:doGripper"]) as events:
            assert events.next(5).values == {"opmode": "AUTO"}
            peer.events.put(first.replace("AUTO", "MANR"))
            event = events.next(5)
            assert (event.resource, event.values) == ("/rw/panel/opmode;opmode", {"opmode": "MANR"})
            peer.events.put(None)
            with pytest.raises(Lost):
                events.next(5)
        own = "robapi2_subscription" if kind is Rws1 else "rws_subscription"
        assert peer.polls == [own]
    form = next(body for _, path, body in peer.log if path == "/subscription")
    assert form == (
        "resources=1&1=/rw/panel/opmode;opmode&1-p=1"
        "&resources=2&2=/rw/iosystem/signals/Local/DRV_1/doGripper;state&2-p=2"
    )


POLLED = {"POST /subscription": (201, rows(), {"Location": "/poll/3"})}


@contextmanager
def listening():
    """A controller that somebody listens to, and what they hear."""
    with (
        Rws1({**ONE, **POLLED}) as peer,
        peer.connect() as client,
        client.subscribe(["mode"]) as events,
    ):
        yield peer, events
        peer.events.put(None)


def test_an_event_in_parts_with_a_ping_between():
    event = rows(li("pnl-opmode-ev", opmode="AUTO")).encode()
    with listening() as (peer, events):
        peer.events.put(framed(event[:20], 0x01) + b"\x89\x02hi" + framed(event[20:30], 0x00)[:7])
        assert events.next(0.1) is None
        peer.events.put(framed(event[20:30], 0x00)[7:] + framed(event[30:], 0x80) + framed(event))
        assert [events.next(5).values for _ in range(2)] == [{"opmode": "AUTO"}] * 2
        assert events.next(0) is None


def test_pings_without_end_do_not_keep_anybody_waiting():
    with listening() as (peer, events):
        over = threading.Event()

        def ping():
            for _ in range(20_000):  # about ten seconds of them
                peer.events.put(b"\x89\x00")
                if over.wait(0.0005):
                    break

        pinging = threading.Thread(target=ping)
        pinging.start()
        assert events.next(0.2) is None
        assert pinging.is_alive()
        over.set()
        pinging.join()


def test_an_address_of_events_that_opens_no_websocket():
    with Rws1({**ONE, **POLLED, "GET /poll/3": (200, rows())}) as peer, peer.connect() as client:
        with pytest.raises(Refused) as refused, client.subscribe(["mode"]):
            pass
        assert codes(refused) == ["CN209"] and "HTTP 200" in str(refused.value)
        assert client.state() is not None


def test_an_event_that_is_garbage():
    with listening() as (peer, events):
        peer.events.put("<html><li>")
        with pytest.raises(Refused) as refused:
            events.next(5)
        assert codes(refused) == ["CN222"]


@pytest.mark.parametrize(
    "body",
    [
        "<html><body>", "[]", '{"a":', "<a/>", "\0\1", '<!DOCTYPE x [<!ENTITY a "b">]><html/>',
        json.dumps({"state": []}), '{"state":[{"_type":"pnl-ctrlstate"}]}',
    ],
)  # fmt: skip
def test_answers_that_make_no_sense(body):
    execution = {"GET /rw/rapid/execution": body}
    with Rws1({**ONE, **execution}) as peer, peer.connect() as client:
        with pytest.raises(Refused) as refused:
            client.state()
        assert codes(refused) == ["CN222"]


@pytest.mark.parametrize("kind", [Rws1, Rws2])
def test_watching_a_controller_that_has_no_events_to_give(kind):
    with kind(ONE if kind is Rws1 else TWO) as peer, peer.connect() as client:
        looks = client.watch(0.01, ["doGripper"])
        first, second = next(looks), next(looks)
        looks.close()
        assert first.state == second.state and second.state.override == 70
        assert second.signals == {"doGripper": 1.0} and second.seconds > first.seconds
        asked = [path for _, path, _ in peer.asked("GET") if path.endswith("/rw/panel/opmode")]
        assert len(asked) == 2


@pytest.mark.parametrize("package", ["httpx", "websockets"])
def test_a_package_that_is_not_installed(package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with Rws1(ONE) as peer, pytest.raises(Refused) as refused, peer.connect():
        pass
    assert codes(refused) == ["CN220"] and "[rws]" in refused.value.findings[0].cure
    assert peer.log == []
