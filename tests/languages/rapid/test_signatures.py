"""The tables of standard routines, types and data: whole, consistent and right where sampled."""

from __future__ import annotations

from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.constants import LONGEST_NAME, SPEEDS, ZONES
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.signatures import Parameter, Signature
from tests.tables import every_row

ALL = [found for name in predefined.rows() if (found := signature(name))]


def known(name: str) -> Signature:
    found = signature(name)
    assert found is not None
    return found


def test_every_line_is_a_routine_of_its_own() -> None:
    assert len(ALL) == len(predefined.rows()) > 597
    assert len({routine.name.lower() for routine in ALL}) == len(ALL)
    assert {routine.kind for routine in ALL} == {"PROC", "FUNC"}


@every_row("routine", ALL)
def test_a_routine_is_declared_as_rapid_could(routine: Signature) -> None:
    parameters = [one for slot in routine.slots for one in slot.alternatives]
    names = [name for slot in routine.slots for name in {p.name.lower() for p in slot.alternatives}]
    assert len(set(names)) == len(names)
    assert all(len(name) <= LONGEST_NAME for name in (routine.name, *names))
    types = {one.type for one in parameters} | {routine.result}
    assert types <= {"", *predefined.types()}
    switches = [s for s in routine.slots if any(p.type == "switch" for p in s.alternatives)]
    assert all(slot.optional for slot in switches)
    assert routine.kind == "FUNC" or not routine.result


def test_moves_take_what_the_manual_says() -> None:
    move = known("movel")
    given = [slot.alternatives[0].name for slot in move.required]
    assert given == ["ToPoint", "Speed", "Zone", "Tool"]
    assert move.required[-1].alternatives == (Parameter("Tool", "tooldata", "PERS"),)
    named = [{one.name for one in slot.alternatives} for slot in move.optional]
    assert {"V", "T"} in named
    assert {"Corr"} in named
    assert not any("Corr" in names for names in named if len(names) > 1)
    assert "Corr" not in {p.name for s in known("MoveJ").slots for p in s.alternatives}


def test_alternatives_modes_arrays_and_results() -> None:
    incr = known("Incr")
    assert [(p.type, p.mode) for p in incr.slots[0].alternatives] == [
        ("num", "INOUT"),
        ("dnum", "INOUT"),
    ]
    assert known("WaitSyncTask").required[1].alternatives[0].dimensions == -1
    assert known("CRobT").result == "robtarget"
    assert known("Present").required[0].alternatives[0].mode == "REF"
    assert known("CapAPTrSetup").open
    assert known("WZBoxDef").option == "World Zones"
    assert signature("MoveQ") is None


def test_records_say_their_components_in_order() -> None:
    types = predefined.types()
    robtarget = types["robtarget"].components
    assert robtarget is not None
    assert list(robtarget.items()) == [
        ("trans", "pos"),
        ("rot", "orient"),
        ("robconf", "confdata"),
        ("extax", "extjoint"),
    ]
    assert types["capdata"].components is None
    assert types["dionum"].of == "num"
    for one in types.values():
        assert {type.lower() for type in (one.components or {}).values()} <= set(types)
        assert not one.of or types[one.of].kind == "VALUE"


def test_data_are_of_known_types() -> None:
    data = predefined.data()
    assert {one.type for one in data.values()} <= set(predefined.types())
    assert {n for n, one in data.items() if one.type == "zonedata"} == set(ZONES)
    assert set(SPEEDS) <= {n for n, one in data.items() if one.type == "speeddata"}
    assert data["tool0"].storage == "PERS"


def test_standard_names_are_those_of_the_table() -> None:
    sets = (predefined.INSTRUCTIONS, predefined.FUNCTIONS, predefined.OPTION_ROUTINES)
    assert frozenset().union(*sets) == set(predefined.rows())
    assert sum(map(len, sets)) == len(ALL)
    assert "movel" in predefined.INSTRUCTIONS
    assert "offs" in predefined.FUNCTIONS
    assert "arcl" in predefined.OPTION_ROUTINES
