"""Cures of templates of written programs."""

from __future__ import annotations

from typing import Final

from tests.findings.cures.case import Case

COMPILE: Final = "compile p.pseudo -l rapid -o out"
PROGRAM: Final = """\
program p

tool nozzle tip [0, 0, 60] mass 0.3 kg centre [0, 0, 20]
target start [280, 50, 250] [0, 0, 1, 0]

procedure main
  move linear start speed 50 mm/s blend fine tool nozzle
end
"""
SOUND: Final = "MODULE {{ name }}\n{{ header }}\n{{ declarations }}\n{{ routines }}\nENDMODULE\n"
FILE: Final = "style/rapid/module.mod.j2"


def template(code: str, wrong: str, right: str = SOUND) -> Case:
    """A template with a fault, and without."""
    files = {
        "p.pseudo": PROGRAM,
        "assistant.toml": '[style]\ntemplate = "style"\nauthor = "Ann"\n',
        FILE: wrong,
    }
    return Case(code, COMPILE, files, change={FILE: right})


def above(line: str) -> str:
    return SOUND.replace("{{ header }}", f"{line}\n{{{{ header }}}}")


CASES: Final = (
    template("CO601", above("{% if author %}"), above("    ! {{ author }}")),
    template("CO602", above("    ! {{ auther }}"), above("    ! {{ author }}")),
    template("CO603", above("    ! {{ author.upper() }}"), above("    ! {{ author|upper }}")),
    template("CO604", above("    ! " + "x" * 300_000)),
    template("CO611", above("    MoveL start,v50,fine,nozzle;"), above("    ! MoveL start")),
    template("CO612", SOUND.replace("{{ routines }}\n", "")),
    template("CO613", above("{{ header }}")),
    template("CO614", SOUND.replace("{{ header }}", "! {{ header }}")),
    template(
        "CO615", "MODULE {{ name }}\n{{ declarations }}\n{{ header }}\n{{ routines }}\nENDMODULE"
    ),
    template("CO616", above("    ! robot: irb120-3-0.6"), above("    ! the robot: irb120-3-0.6")),
    template("CO617", above("    ! Müller"), above("    ! Mueller")),
    Case(
        "CO619",
        COMPILE,
        {"p.pseudo": PROGRAM, "assistant.toml": '[style]\ntemplate = "style"\n'},
        change={FILE: SOUND},
    ),
)
