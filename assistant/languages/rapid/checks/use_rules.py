"""The findings about how names, values and routines are used."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

UNKNOWN_ROUTINE: Final = warning(
    "RA401",
    "neither RobotWare nor a given module has a routine `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_ROUTINE: Final = warning(
    "RA402", "there is no routine `{name}`, but `{near}`", "write `{near}` if it is meant"
)
UNKNOWN_DATA: Final = info(
    "RA403",
    "no given module declares `{name}`",
    "check together with the module that does, or correct the name",
)
MISSING_ARGUMENTS: Final = error(
    "RA404", "`{routine}` lacks {parameters}", "write `{usage}`, with options as needed"
)
TOO_MANY: Final = error(
    "RA405",
    "`{routine}` does not take {given} arguments",
    "write `{usage}`, with options as needed",
)
UNKNOWN_OPTION: Final = error(
    "RA406", "`{routine}` has no optional argument `\\{option}`", "{hint}"
)
NEW_OPTION: Final = warning(
    "RA418",
    "`{routine}` of RobotWare 6 has no optional argument `\\{option}`",
    "{hint}, unless a later RobotWare has it",
)
EXCLUSIVE: Final = error(
    "RA407",
    "only one of `\\{one}` and `\\{other}` may be given to `{routine}`",
    "leave one of them out",
)
OPTION_WITHOUT_VALUE: Final = error(
    "RA408",
    "`\\{option}` of `{routine}` has no value",
    "write `\\{option}:=` and a {type} behind it",
)
SWITCH_WITH_VALUE: Final = error(
    "RA409",
    "`\\{option}` of `{routine}` is a switch and takes no value",
    "write only `\\{option}`, or leave it out",
)
WRONG_NAME: Final = error(
    "RA410",
    "an argument is named `{name}` where `{parameter}` of `{routine}` stands",
    "write `{parameter}`, or no name at all",
)
WRONG_ARGUMENT: Final = error(
    "RA411",
    "`{parameter}` of `{routine}` is {wanted}, and is given {given}",
    "give it a value of type {wanted}",
)
NO_REFERENCE: Final = error(
    "RA412",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "hand over data that can be changed",
)
NO_PERSISTENT: Final = error(
    "RA413",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with PERS",
)
NO_VARIABLE: Final = warning(
    "RA414",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with VAR",
)
FUNCTION_ALONE: Final = error(
    "RA415",
    "`{name}` is a function, which cannot be called as an instruction",
    "use its value: `data:={name}(...);`",
)
NO_FUNCTION: Final = error(
    "RA416",
    "`{name}` is called as a function, but has no value",
    "call it as an instruction of its own, without parentheses",
)
NOT_A_ROUTINE: Final = error("RA417", "`{name}` is called, but is {what}", "correct the name")
NAME_WITHOUT_VALUE: Final = error(
    "RA419", "`{name}` is {what}, which has no value of its own", "name data, or call the routine"
)
UNKNOWN_TYPE: Final = warning(
    "RA421",
    "neither RobotWare nor a given module has a type `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_TYPE: Final = warning(
    "RA422", "there is no type `{name}`, but `{near}`", "write `{near}` if it is meant"
)
COMPONENT_COUNT: Final = error(
    "RA423", "a {type} has {count} components, {given} are written", "write all of them: {names}"
)
ELEMENT_COUNT: Final = error(
    "RA424",
    "{given} elements are written for an array of {count}",
    "write one for each, or change the declared size",
)
WRONG_VALUE: Final = error(
    "RA425", "{given} stands where {wanted} should", "write a value of type {wanted}"
)
UNKNOWN_COMPONENT: Final = error("RA426", "a {type} has no component `{name}`", "{hint}")
INDEX_COUNT: Final = error(
    "RA427",
    "the number of indices is {given}, that of dimensions {count}",
    "write one index for each declared dimension",
)
INDEX_RANGE: Final = warning(
    "RA430",
    "index {index} is outside of `{name}`, where it goes from 1{to}",
    "correct the index, or declare more elements",
)
OPERANDS: Final = error("RA428", "`{operator}` cannot join {left} and {right}", "{hint}")
NO_TRUTH: Final = error(
    "RA429", "{given} stands where a condition should", "compare it with a value, or use a bool"
)
