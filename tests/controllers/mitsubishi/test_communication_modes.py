"""Table II of Kohrt et al.: which way to speak with a controller suits which use case.

Each cell is tried over real sockets and pseudo terminals, by a command or a sample. What the paper
marks works, and what it does not is refused in a sentence, before anything has moved.
"""

from __future__ import annotations

import csv
import re
import runpy
import shlex
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from assistant.controllers import connect
from assistant.virtual.cr import VirtualCr
from assistant.virtual.melfa.communication_lines import line_to
from tests.cli.test_commands import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")

SAMPLES = Path(__file__).parents[3] / "samples" / "python"
TABLE_II = """
RTEC  ETH    SDO            X - - - - -
DL    ETH    SD             - - - X X X
DL    RS232  SD             - - - X X X
CL    ETH    Robot command  - X - - - -
CL    RS232  Robot command  - - X - - -
CL    ETH    Robot program  - - - X - -
CL    RS232  Robot program  - - - - X -
"""
"""As it is printed: mode, physical layer and type of command, then use cases 1 to 6."""

TRIED = {
    "RTEC ETH SDO": """
        follow ethernet way.csv --by mxt --port {packets}
        single_moves.py {at_packets}                             # CN201
        single_moves.py melfa-serial://{packets}                 # CN101
        run_program.py {at_packets}                              # CN201
        run_program.py melfa-serial://{packets}                  # CN101
        follow ethernet way.csv --by data-link --port {packets}  # CN209
    """,
    "DL ETH SD": """
        follow ethernet way.csv --by mxt --line {tcp}            # CN209
        single_moves.py data-ethernet                            # CN204
        single_moves.py melfa-serial://{tcp}                     # CN101
        run_program.py ethernet --status {tcp}
        run_program.py serial --status {tcp}
        follow second way.csv --by data-link --line {tcp_control} --line {second_status}
    """,
    "DL RS232 SD": """
        follow ethernet way.csv --by mxt --line {pty}            # CN209
        single_moves.py melfa://{pty}                            # CN101
        single_moves.py data-serial                              # CN204
        run_program.py ethernet --status {pty}
        run_program.py serial --status {pty}
        follow third way.csv --by data-link --line {pty_control} --line {third_status}
    """,
    "CL ETH Robot command": """
        follow ethernet way.csv --by controller-link             # CL250
        single_moves.py ethernet
        single_moves.py melfa-serial://{ethernet}                # CN101
        start ethernet "MOV J1"                                  # CN207
        start melfa-serial://{ethernet} "MOV J1"                 # CN101
        follow ethernet way.csv --by data-link --line {ethernet} --line {tcp}  # CN209
    """,
    "CL RS232 Robot command": """
        follow serial way.csv --by mxt                           # CN209
        single_moves.py melfa://{serial}                         # CN101
        single_moves.py serial
        start melfa://{serial} "MOV J1"                          # CN101
        start serial "MOV J1"                                    # CN207
        follow serial way.csv --by data-link --line {serial} --line {tcp}  # CN209
    """,
    "CL ETH Robot program": """
        follow ethernet way.csv --by controller-link             # CL250
        jog ethernet SQUARE 1                                    # CO712
        jog melfa-serial://{ethernet} SQUARE 1                   # CN101
        run_program.py ethernet
        run_program.py melfa-serial://{ethernet}                 # CN101
        follow ethernet way.csv --by data-link --line {tcp} --line {ethernet}  # CN209
    """,
    "CL RS232 Robot program": """
        follow serial way.csv --by mxt                           # CN209
        jog melfa://{serial} SQUARE 1                            # CN101
        jog serial SQUARE 1                                      # CO712
        run_program.py melfa://{serial}                          # CN101
        run_program.py serial
        follow serial way.csv --by data-link                     # CN209
    """,
}
"""What asks for a use case by the line of a row, and the code of the finding that refuses it.

`ethernet` and `serial` are the controller link of one controller, `tcp` and `pty` lines for data
link of its programs, `packets` its UDP port of real-time control.
"""
WAY = """x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,speed_mm_s
160,0,478,0,0,1,0,500
170,0,470,0,0,1,0,500
"""
LASTING = ("RTEC", "DL")
"""Modes whose use cases take a second or more."""


def rows():
    """Each row of the paper, and what is tried of it: (name, marks, commands)."""
    for line in TABLE_II.strip().splitlines():
        *words, marks = re.fullmatch(r"(\w+) +(\w+) +(.+?) +((?:[X-] ?){6})", line).groups()
        name = " ".join(words)
        commands = [command.split("#") for command in TRIED[name].strip().splitlines()]
        yield (
            name,
            marks.split(),
            [(text.strip(), "".join(code).strip()) for text, *code in commands],
        )


CELLS = [
    pytest.param(
        mark,
        command,
        code,
        id=f"{name}, {number}",
        marks=[pytest.mark.slow] if mark == "X" and name.startswith(LASTING) else [],
    )
    for name, marks, commands in rows()
    for number, (mark, (command, code)) in enumerate(zip(marks, commands, strict=True), start=1)
]


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    """A folder of a project that names three controllers, and what their lines are called.

    The second and third are led by data link, in real time: their programs miss a client after 2 s.
    COM1 is Ethernet on the second, serial on the third.
    """
    folder = tmp_path_factory.mktemp("modes")
    pty, silent = folder / "pty", folder / "silent"
    with ExitStack() as open_:
        status, leave = line_to(f"pty:{pty}")
        open_.callback(leave)
        control, leave = line_to("0")
        open_.callback(leave)
        quick = {"servo_time": 0.02, "pace": 20.0}
        one = open_.enter_context(VirtualCr(serial=True, lines={"COM1:": status}, **quick))
        asked_in_vain = {"serial": f"pty:{silent}", "framing": "data link"}
        two = open_.enter_context(VirtualCr(lines={"COM1:": control}, **asked_in_vain))
        three = open_.enter_context(VirtualCr(serial=True, framing="data link"))
        data = {name: f"127.0.0.1:{port}" for name, (_, port) in one.data_ports.items()}
        named = {
            "ethernet": one.address,
            "serial": one.serial_address,
            "second": two.address,
            "third": three.address,
            "data-ethernet": f"melfa://{data['COM3:']}",
            "data-serial": f"melfa-serial://{silent}",
        }
        (folder / "assistant.toml").write_text(
            "".join(
                f'[controllers.{name}]\naddress = "{address}"\nrobot = "rv-2aj"\n'
                f"timeout = {0.3 if name.startswith('data-') else 20}\n"
                for name, address in named.items()
            )
        )
        (folder / "way.csv").write_text(WAY)
        yield (
            folder,
            {
                "ethernet": one.address.removeprefix("melfa://"),
                "serial": one.serial_path,
                "packets": one.mxt_port,
                "at_packets": f"melfa://127.0.0.1:{one.mxt_port}",
                "tcp": data["COM2:"],
                "pty": pty,
                "tcp_control": f"127.0.0.1:{control.address[1]}",
                "second_status": f"127.0.0.1:{two.data_ports['COM2:'][1]}",
                "pty_control": three.serial_path,
                "third_status": f"127.0.0.1:{three.data_ports['COM2:'][1]}",
            },
        )


def asked(capsys, monkeypatch, command):
    """Exit status, output and errors of a command, or of a sample as Python runs it."""
    first, *words = shlex.split(command)
    if not first.endswith(".py"):
        return run(capsys, first, *words, "--yes")
    with monkeypatch.context() as patched, pytest.raises(SystemExit) as ended:
        patched.setattr(sys, "argv", [first, *words, "--yes"])
        runpy.run_path(str(SAMPLES / first), run_name="__main__")
        raise SystemExit
    told = ended.value.code
    said = capsys.readouterr()
    return (1, said.out, f"{told}\n") if isinstance(told, str) else (told or 0, said.out, said.err)


def place_of(name):
    """Where an arm stands, mm; nothing runs there, and neither an error nor an override is left."""
    with connect(name) as controller:
        state = controller.state()
        assert not state.running and not state.faults and state.override == 100
        return controller.position().position


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("mark", "command", "code"), CELLS)
def test_table_ii(mark, command, code, lines, capsys, monkeypatch):
    folder, places = lines
    monkeypatch.chdir(folder)
    assert (mark == "X") == (code == ""), "the paper and what is tried here differ"
    text = command.format(**places)
    follows = text.startswith("follow") and mark == "X"
    name = text.split()[1] if follows else "ethernet"
    if follows:
        assert run(capsys, "motors", name, "on", "--yes")[0] == 0
        text += " --log run.csv"
    before = place_of(name)
    status, out, said = asked(capsys, monkeypatch, text)
    if code:
        assert status in (1, 2) and said.startswith(code) and said.count("\n") <= 2, said
        assert place_of(name) == before
        return
    assert status == 0, said
    if follows:
        assert place_of(name) == pytest.approx((170, 0, 470), abs=0.1)
        with (folder / "run.csv").open(newline="") as file:
            assert len(list(csv.reader(file))) > 3, "there was no feedback on the way"
    else:
        assert place_of(name) == pytest.approx(before, abs=0.05)
        told = [line for line in out.splitlines() if "at " in line]
        assert len(told) >= (10 if "--status" in text else 1), out
