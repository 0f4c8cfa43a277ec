"""The client and the virtual IRC5, which were written apart from each other, in both dialects."""

import itertools
import math
import threading

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.rules import Lost
from assistant.controllers.states import Jog, TaskState
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.irc5.cabinet import Signal
from tests.controllers.abb.rws.seam import SEAM, SIGNALS, codes


def until_it_stands(client):
    return next(s for s in client.watch(0.02) if not s.state.running)


def test_what_it_is(client):
    told = client.identify()
    assert told.robot == "ABB IRB 1200-7/0.7" and told.version.split(".")[0] in ("6", "7")


def test_programs_and_what_is_loaded(loaded, irc5):
    assert loaded.names() == ("seam.mod",) and loaded.read("seam.mod") == SEAM
    assert (irc5.folder / "seam.mod").read_bytes() == SEAM
    assert loaded.modules() == ("Seam",)
    assert loaded.module_text("Seam").replace(b"\r\n", b"\n") == SEAM
    assert loaded.state().tasks == (TaskState("T_ROB1", "Seam", 7, False),)
    loaded.unload("Seam")
    assert loaded.modules() == () and loaded.names() == ("seam.mod",)


def test_a_module_with_errors_is_not_loaded(loaded):
    loaded.write("bad.mod", SEAM.replace(b"count+1", b"count+"))
    with pytest.raises(Refused) as refused:
        loaded.load("bad.mod")
    assert codes(refused) == ["CN301"] and "holds its old module" in str(refused.value)
    assert loaded.modules() == ("Seam",) and not loaded.state().right


def test_a_second_main_is_refused_with_what_to_do(loaded):
    loaded.write("two.mod", b"MODULE Two\nPROC main()\nENDPROC\nENDMODULE\n")
    with pytest.raises(Refused) as refused:
        loaded.load("two.mod")
    cure = refused.value.findings[0].cure
    assert codes(refused) == ["CN301"] and "`Seam`" in cure and ".pgf" in cure
    loaded.unload("Seam")
    loaded.load("two.mod")
    assert loaded.modules() == ("Two",) and not loaded.state().right
    loaded.unload("Two")


def test_running(loaded):
    loaded.motors(True)
    loaded.start("T_ROB1", forever=True)
    state = loaded.state()
    assert state.running and state.motors and state.mode == "automatic"
    with pytest.raises(Refused) as refused:
        loaded.load("seam.mod")
    assert codes(refused) == ["CN209"] and "stop" in refused.value.findings[0].cure
    loaded.stop()
    assert not loaded.state().running
    loaded.load("seam.mod")
    loaded.start()
    until_it_stands(loaded)
    assert loaded.variable("count", "Seam") == "1"
    assert loaded.outputs(["doGripper"]) == {"doGripper": 1}
    assert any(fault.number == 10151 for fault in loaded.log())
    loaded.motors(False)
    assert not loaded.state().motors


def test_where_it_is(client):
    position = client.position()
    assert position.joints == (0, 0, 0, 0, 30, 0) and position.text.startswith("[[422.01")
    assert sum(q * q for q in position.quaternion) == pytest.approx(1)


def test_data(loaded):
    assert loaded.variable("tGrip").startswith("[TRUE,[[0,0,100],")
    loaded.set_variable("count", "41")
    loaded.set_variable("arr", "[4,5,6]", "Seam", "T_ROB1")
    assert loaded.variable("count") == "41" and loaded.variable("arr") == "[4,5,6]"
    for name, value, code in (
        ("count", '"text"', "CN301"),
        ("fixed", "1", "CN209"),
        ("nothing", "1", "CN209"),
        ("count", "1\r\n2", "CN308"),
        ("a/b", "1", "CN308"),
    ):
        with pytest.raises(Refused) as refused:
            loaded.set_variable(name, value)
        assert codes(refused) == [code]
    assert loaded.variable("count") == "41"


def test_signals(client):
    assert client.inputs([]) == {"diStart": 0}
    assert client.outputs([]) == {"doGripper": 0, "aoSpeed": 0}
    client.set_output("doGripper", 1)
    client.set_output("aoSpeed", 1.5)
    assert client.outputs(["aoSpeed", "doGripper"]) == {"aoSpeed": 1.5, "doGripper": 1}
    client.set_output("aoSpeed", 0)
    for name, value, code in (
        ("doGripper", 2, "CN308"),
        ("doGripper", math.inf, "CN308"),
        ("aoSpeed", math.nan, "CN308"),
        ("diStart", 1, "CN209"),
        ("doNone", 1, "CN209"),
        ("do/Gripper", 1, "CN308"),
    ):
        with pytest.raises(Refused) as refused:
            client.set_output(name, value)
        assert codes(refused) == [code]


def test_parameters(client):
    name = "EIO/EIO_SIGNAL/doGripper"
    told = {f"{name}/Name": "doGripper", f"{name}/SignalType": "DO", f"{name}/Device": "DRV_1"}
    assert client.parameters([name]) == told
    assert len(client.parameters(["EIO/EIO_SIGNAL"])) == 3 * len(SIGNALS)
    for value in ("DRV_2", "DRV_1"):
        client.set_parameter(f"{name}/Device", value)
        assert client.parameters([name])[f"{name}/Device"] == value
    for act in (
        lambda: client.set_parameter(f"{name}/Name", "doOther"),
        lambda: client.set_parameter(f"{name}/Device", "a&Access=All"),
        lambda: client.parameters(["EIO/EIO_UNIT"]),
        lambda: client.parameters(["EIO"]),
        lambda: client.parameters(["EIO/EIO_SIGNAL/doNone"]),
    ):
        with pytest.raises(Refused) as refused:
            act()
        assert codes(refused)[0] in ("CN209", "CN301", "CN308")
    assert not client.state().right and client.parameters([name]) == told


def test_a_signal_among_many_of_like_names(tmp_path):
    many = [Signal(f"di{n}", "DI") for n in range(130)] + [Signal("zdi1", "DI"), Signal("d", "DI")]
    with (
        VirtualIrc5(tmp_path / "home", signals=many, robot=None) as irc5,
        connect(irc5.rwss_address, password=irc5.password, certificate=irc5.certificate) as client,
    ):
        assert client.inputs(["zdi1", "d", "di99"]) == {"zdi1": 0, "d": 0, "di99": 0}
        assert len(client.inputs([])) == 132
        assert len(client.parameters(["EIO/EIO_SIGNAL"])) == 3 * 132


def test_speed_ratio(client):
    client.set_override(40)
    assert client.state().override == 40
    client.set_override(100)
    with pytest.raises(Refused) as refused:
        client.set_override(101)
    assert codes(refused) == ["CN308"] and client.state().override == 100


def test_what_it_cannot(client):
    for act in (
        lambda: client.jog(Jog("J1", 1.0)),
        lambda: client.hand(1, open=True),
        lambda: client.parameters(),
        lambda: client.load("none.mod", "T_OTHER"),
    ):
        with pytest.raises(Refused) as refused:
            act()
        assert codes(refused) == ["CN209"] and refused.value.findings[0].cure


def test_watching_sees_a_program_run(loaded):
    loaded.motors(True)
    samples = []
    for sample in loaded.watch(0.02, ["doGripper"]):
        samples.append(sample)
        if len(samples) == 2:
            loaded.start(forever=True)
        seen = [one.state.running for one in samples]
        if sample.state.running and sample.signals["doGripper"]:
            loaded.stop()
        elif True in seen and not sample.state.running:
            break
    assert [running for running, _ in itertools.groupby(s.state.running for s in samples)] == [
        False,
        True,
        False,
    ]
    assert samples[0].signals == {"doGripper": 0} and samples[-1].position.joints[4] == 30
    assert samples[1].seconds >= 0.02


def test_events(loaded):
    with loaded.subscribe(["mode", "signal:doGripper", "variable:T_ROB1/Seam/count"]) as events:
        first = {e.kind: e.values for e in (events.next(5), events.next(5), events.next(5))}
        assert first["pnl-opmode-ev"] == {"opmode": "AUTO"}
        assert first["rap-value-ev"] == {"value": "0"}
        loaded.set_output("doGripper", 1)
        event = events.next(5)
        assert event.kind == "ios-signalstate-ev" and event.values["lvalue"] == "1"
        loaded.set_variable("count", "5")
        assert events.next(5).values == {"value": "5"}
        assert events.next(0.01) is None


@pytest.mark.slow
def test_events_again_and_again(client):
    """What TLS sends after its handshake is in the way of one request in a thousand, if it can."""
    for _ in range(2000):
        with client.subscribe(["mode"]) as events:
            assert events.next(5).values == {"opmode": "AUTO"}


@pytest.mark.parametrize("name", ["nothing", "signal:doNone", "/rw/x&2=/rw/y", "/rw/nothing;state"])
def test_nothing_is_told_of_what_is_not_there(client, name):
    with pytest.raises(Refused) as refused, client.subscribe([name]):
        pass
    assert codes(refused)[0] in ("CN209", "CN301", "CN308")


def test_events_end_with_the_controller(tmp_path):
    with (
        VirtualIrc5(tmp_path / "home") as irc5,
        connect(irc5.rws_address, password=irc5.password, timeout=5) as client,
        client.subscribe(["mode"]) as events,
    ):
        events.next(5)
        stopping = threading.Thread(target=irc5.stop)
        stopping.start()
        with pytest.raises(Lost) as refused:
            events.next(10)
        stopping.join()
    assert codes(refused) == ["CN204"]


def test_remote_access_in_manual_mode(tmp_path):
    with (
        VirtualIrc5(tmp_path / "home", mode="MANR", signals=SIGNALS) as irc5,
        connect(irc5.rws_address, password=irc5.password, timeout=5) as client,
    ):
        assert client.state().mode == "manual"
        client.write("seam.mod", SEAM)
        with pytest.raises(Refused) as refused:
            client.load("seam.mod")
        assert "pendant" in refused.value.findings[0].cure
        with pytest.raises(Refused) as refused:
            client.remote_access(wait=0.1)
        assert codes(refused) == ["CN307"]
        irc5.cabinet.grants = True
        client.remote_access(wait=5)
        client.load("seam.mod")
        assert client.modules() == ("Seam",)
