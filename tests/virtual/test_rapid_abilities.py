"""Instructions and functions of an option or add-in, given to a run."""

from __future__ import annotations

from assistant.virtual.events import Said, Waited
from assistant.virtual.rapid import Given
from assistant.virtual.rapid.control_flow import Fault
from tests.virtual.rapid_cell import ran, said


def dispense(call: Given) -> None:
    amount = call.number(0)
    speed = call.optional_number("speed")
    call.machine.task.tell(Said(f"{amount:g} g at {speed or 1.0:g}{' now' * call.has('now')}"))
    if amount > 9:
        raise Fault("the cartridge is empty", "ERR_GLUEFLOW")
    call.machine.task.delay(amount)
    call.place(1).set(amount + 1.0)


def doubled(call: Given) -> float:
    return 2.0 * call.number(0)


ABILITIES = {"Dispense": dispense, "Doubled": doubled}


def test_an_instruction_and_a_function_are_added() -> None:
    main = 'dispense 1.5\\Speed:=3,reg1\\Now;\nTPWrite ""\\Num:=Doubled(reg1);'
    found = ran(main, abilities=ABILITIES)
    assert [e for e in found.events if isinstance(e, Waited)] == [Waited(1.5)]
    assert said(main, abilities=ABILITIES) == ["1.5 g at 3 now", "5"]


def test_what_is_not_given_ends_the_run_and_is_named() -> None:
    assert ran("Dispense 1,reg1;").message.endswith("the instruction or procedure `Dispense`")
    assert ran("reg1:=Doubled(2);").message.endswith("the function `Doubled`")
    assert {ran("Dispense 1,reg1;").ended, ran("reg1:=Doubled(2);").ended} == {"unknown"}


def test_an_error_of_its_own_goes_to_the_handler() -> None:
    main = 'Dispense 10,reg1;\nERROR\nIF ERRNO=ERR_GLUEFLOW TPWrite "empty";\nTRYNEXT;'
    assert said(main, abilities=ABILITIES) == ["10 g at 1", "empty"]


def test_too_few_arguments_are_an_error_of_the_program() -> None:
    found = ran("Dispense;", abilities=ABILITIES)
    assert (found.ended, "0 arguments where 1" in found.message) == ("error", True)


def test_a_routine_of_the_program_comes_first() -> None:
    more = 'PROC Dispense(num a,INOUT num b)\nTPWrite "own";\nENDPROC'
    assert said("Dispense 1,reg1;", more, abilities=ABILITIES) == ["own"]
