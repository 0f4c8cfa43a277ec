"""Virtual controllers of both makers over sockets, and projects whose targets they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5

PASSWORD = "no dictionary has it"
MODULE = """MODULE seam
  CONST robtarget p1:=[[400,0,{0}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC seam_go()
    MoveJ p1, v100, fine, tool0;
  ENDPROC
ENDMODULE
"""
STEPS = "1 Mov P1\n2 Hlt\nP1=(300.00,0.00,{0}.00,180.00,0.00,180.00)(6,0)\n"


@dataclass(frozen=True)
class Bench:
    """cell: the virtual controller. file: of the program, name: that it has there. there: writes
    or reads it on the controller by another way than the studio's.
    """

    cell: VirtualCr | VirtualIrc5
    file: str
    name: str
    text: str
    change: Callable[[str], None]
    read: Callable[[], str]


@contextmanager
def irc5(folder: Path, home: Path) -> Iterator[Bench]:
    """Behind Robot Web Services 1.0, with a password."""
    with VirtualIrc5(home, password=PASSWORD, rwss=None) as cell:
        _project(folder, cell.rws_address, "irb1200-7-0.7", "seam.mod", MODULE.format(300))
        there = cell.folder / "seam.mod"

        def change(text: str) -> None:
            there.write_text(text, encoding="utf-8")

        def read() -> str:
            return there.read_text("utf-8") if there.exists() else ""

        yield Bench(cell, "seam.mod", "seam.mod", MODULE, change, read)


@contextmanager
def cr(folder: Path, home: Path) -> Iterator[Bench]:
    """Behind the controller link."""
    with VirtualCr("rv-4frl", language="melfa-basic-5", folder=home) as cell:
        _project(folder, cell.address, "rv-4frl", "seam.prg", STEPS.format(400))
        from assistant.controllers import connect

        def change(text: str) -> None:
            with connect(cell.address) as session:
                session.write("SEAM", text.encode())

        def read() -> str:
            with connect(cell.address) as session:
                return (session.read("SEAM") or b"").decode()

        yield Bench(cell, "seam.prg", "SEAM", STEPS, change, read)


BENCHES = {"irc5": irc5, "cr": cr}


@contextmanager
def serial(folder: Path) -> Iterator[VirtualCr]:
    """Behind its serial line, which one session has at a time."""
    with VirtualCr("rv-4frl", language="melfa-basic-5", serial=True) as cell:
        _project(folder, cell.serial_address, "rv-4frl", "seam.prg", STEPS.format(400))
        yield cell


def _project(folder: Path, address: str, robot: str, file: str, text: str) -> None:
    (folder / file).write_text(text, encoding="utf-8")
    table = f'[controllers.cell1]\naddress = "{address}"\nrobot = "{robot}"\ntimeout = 5\n'
    targets = f'\n[targets.cell1]\nprograms = ["{file}"]\n'
    (folder / "assistant.toml").write_text(table + targets, encoding="utf-8")
