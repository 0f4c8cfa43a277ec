"""Signals as the system parameters of a controller state them."""

from __future__ import annotations

from pathlib import Path

from assistant.languages.rapid.reading.controller_backup import signals_file, signals_of_file
from assistant.program.program import Signal
from tests.tables import every_row

HEAD = "EIO:CFG_1.0:6:1::\n#\nEIO_SIGNAL:\n\n"


def one(row: str) -> Signal:
    ((_, signal),) = signals_of_file(f"{HEAD}      {row}\n").signals.items()
    return signal


@every_row(
    ("row", "signal"),
    [
        ('-Name "a" -SignalType "DI" -DeviceMap "3"', Signal("digital", "input", 3)),
        ('-Name "a" -SignalType "DO" -Unit "B1" -UnitMap "0"', Signal("digital", "output", 0)),
        ('-Name "a" -SignalType "GO" -DeviceMap "8-11"', Signal("group", "output", 8, 4)),
        ('-Name "a" -SignalType "GI" -DeviceMap "4,5-6"', Signal("group", "input", 4, 3)),
        ('-Name "a" -SignalType "GI" -DeviceMap "0-3,8-11"', Signal("group", "input", None, 8)),
        ('-Name "a" -SignalType "GI" -DeviceMap "3-0"', Signal("group", "input", None, 4)),
        ('-Name "a" -SignalType "AO" -DeviceMap "0-15"', Signal("analog", "output")),
        ('-Name "a" -SignalType "DO"', Signal("digital", "output")),
        ('-Name "a" -SignalType "DO"\\\n      -Label "x -y" -DeviceMap "7"',
         Signal("digital", "output", 7)),
    ],
)  # fmt: skip
def test_a_signal_has_its_kind_and_the_bit_of_its_map(row: str, signal: Signal) -> None:
    assert one(row) == signal


def test_devices_have_their_numbers_one_behind_the_other() -> None:
    rows = [
        '-Name "a" -SignalType "DO" -Device "B1" -DeviceMap "0"',
        '-Name "b" -SignalType "DO" -Device "B2" -DeviceMap "0"',
        '-Name "c" -SignalType "DO" -Device "B1" -DeviceMap "20"',
        '-Name "d" -SignalType "DI" -Device "B2" -DeviceMap "0"',
    ]
    found = signals_of_file(HEAD + "\n".join(f"      {row}" for row in rows)).signals
    assert {name: signal.number for name, signal in found.items()} == {
        "a": 0, "b": 32, "c": 20, "d": 0,
    }  # fmt: skip


def test_what_is_connected_and_what_cannot_be_read_is_told() -> None:
    text = f'{HEAD}      -Name "a" -SignalType "XX"\n#\nEIO_CROSS:\n      -Res "Out" -Act1 "a"\n'
    found = signals_of_file(text)
    assert (found.signals, found.unread, found.crossed) == ({}, ("a",), frozenset({"out"}))
    assert not signals_of_file("\x00\x01 nothing").known


def test_the_file_of_a_backup_is_found_whatever_its_case(tmp_path: Path) -> None:
    module = tmp_path / "RAPID" / "TASK1" / "PROGMOD" / "m.mod"
    module.parent.mkdir(parents=True)
    assert signals_file(module) is None
    file = tmp_path / "syspar" / "EIO.CFG"
    file.parent.mkdir()
    file.write_text(HEAD, encoding="utf-8")
    assert signals_file(module) == file
    (module.parent / "eio.cfg").write_text(HEAD, encoding="utf-8")
    assert signals_file(module) == module.parent / "eio.cfg"
