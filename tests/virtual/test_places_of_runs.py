"""Where a run was when it ended, and where each of its events comes from."""

from __future__ import annotations

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import start_slot
from assistant.virtual.rapid.interpreter import start_task

TABLE = "".join(f"{n}0 MOV P1\n" for n in range(1, 5)) + "P1=(300,0,300,180,0,180)(6,0)\n"
TARGET = "CONST robtarget p{}:=[[400,{},400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
ROW = "MoveL p{},v100,fine,tool0;\n"
RUN = (
    "MODULE a\n"
    + "".join(TARGET.format(n, n) for n in range(1, 11))
    + "PROC main()\n"
    + "".join(ROW.format(n) for n in range(1, 11))
    + "ENDPROC\nENDMODULE\n"
)
ENDLESS = "MODULE a\nPROC main()\nWHILE TRUE DO\nWaitTime 1;\nENDWHILE\nENDPROC\nENDMODULE\n"


def rapid(text: str, **limits: float) -> Kernel:
    kernel = Kernel(**limits)
    start_task(kernel, [languages.get("rapid").parse(SourceText(text, "it"))])
    return kernel


def test_each_move_of_a_table_has_its_line() -> None:
    kernel = Kernel()
    start_slot(kernel, [languages.get("melfa-basic-4").parse(SourceText(TABLE, "it"))])
    assert [row.place for row in kernel.run().log] == [("it", n) for n in range(1, 5)]
    assert [row.place for row in rapid(RUN).run().log] == [("it", n) for n in range(13, 23)]


def test_a_run_of_too_many_statements_tells_where_it_was() -> None:
    run = rapid(ENDLESS, most_steps=50).run()
    assert (run.ended, run.task, run.steps) == ("steps", "T_ROB1", 50)
    assert run.place in (("it", 3), ("it", 4))


def test_a_run_that_takes_too_long_tells_where_it_was() -> None:
    run = rapid(ENDLESS, most_time=9.5).run()
    assert (run.ended, run.place, run.seconds) == ("time", ("it", 4), 9.0)


def test_a_program_that_waits_for_ever_tells_where() -> None:
    run = rapid("MODULE a\nPROC main()\n\nWaitDI ready,1;\nENDPROC\nENDMODULE\n").run()
    assert (run.ended, run.task, run.place) == ("stopped", "T_ROB1", ("it", 4))
