"""Whatever is asked, there is one answer, in time, and the controller lives on."""

from itertools import product

import pytest

from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.controller import COMMANDS
from tests.virtual.cr.test_link import load
from tests.wire import Wire

ARGUMENTS = (
    *(
        "",
        "1",
        "-1",
        "+1",
        "TOP",
        "END",
        "<;M",
        ">;P",
        "<;X",
        ";",
        ";;",
        ";;;;",
        "0;0",
        "1;2;3;4;5",
    ),
    *(
        "A",
        "A;B",
        "A;r",
        "A;w",
        "A;+p",
        "A;-p",
        "A.MB4;0",
        "M1=1",
        "A;M1=1",
        "P1=(1,2)(3)",
        "=",
        "=A",
    ),
    *(
        "99999999999999999999",
        "2;ZZZZ",
        "0;FFFF",
        "6000;FFFF",
        "\xff\xfe",
        "\v\v",
        "%s{}\\",
        "F",
        "9",
    ),
    *(
        "A;REP;START;1",
        "A;1;0",
        "A;1;;",
        "240;00",
        "00;00;00;01;00",
        "TASKMAX;x",
        "BZR;;",
        "n\x00ul",
    ),
    *(
        "10 MOV P1",
        "MOV P1",
        "P1=P2*1",
        "M1=1/0",
        "GOTO *NOWHERE",
        "IF M1=1 THEN 10",
        "END",
        "RETURN",
    ),
    *("24-13-4525:99:99", "é" * 100, "(" * 200),
)


@pytest.fixture
def controller():
    with VirtualCr("rv-2aj", pace=50.0, servo_time=0.0) as controller:
        yield controller


@pytest.mark.parametrize(
    "arguments", [ARGUMENTS[::9], pytest.param(ARGUMENTS, marks=pytest.mark.slow)]
)
def test_every_command_answers_whatever_stands_behind_it(controller, arguments):
    with Wire(controller.port) as wire:
        load(wire, "A", "10 M1=1", "20 END", "P1=(+250.00,+0.00,+450.00,+0.00,+180.00)(6,0)")
        for name in COMMANDS:
            wire.ask("1;1;CNTLON")
            wire.ask("1;1;SRVON")
            for argument in arguments:
                for slot in "19":
                    answer = wire.ask(f"1;{slot};{name}{argument}")
                    assert answer[:2] in ("Qo", "Qe"), (name, argument, answer)
        assert wire.ask("1;1;DSTATE")[:2] == "Qo"


def test_every_slot_that_can_be_named_is_answered(controller):
    commands = ("STATE", "DSTATE", "SLOTRD", "PRGRD", "LINENO", "LINERD", "RSTPRG", "RUN")
    with Wire(controller.port) as wire:
        for slot, command in product(("0", "33", "99", "", "8", "9"), commands):
            assert wire.ask(f"1;{slot};{command}")[:2] in ("Qo", "Qe"), (slot, command)
