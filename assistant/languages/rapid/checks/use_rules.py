"""The findings about how names, values and routines are used."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

UNKNOWN_ROUTINE: Final = Rule(
    "RA401",
    WARNING,
    "neither RobotWare nor a given module has a routine `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_ROUTINE: Final = Rule(
    "RA402", WARNING, "there is no routine `{name}`, but `{near}`", "write `{near}` if it is meant"
)
UNKNOWN_DATA: Final = Rule(
    "RA403",
    INFO,
    "no given module declares `{name}`",
    "check together with the module that does, or correct the name",
)
MISSING: Final = Rule(
    "RA404", ERROR, "`{routine}` lacks {parameters}", "write `{usage}`, with options as needed"
)
TOO_MANY: Final = Rule(
    "RA405",
    ERROR,
    "`{routine}` does not take {given} arguments",
    "write `{usage}`, with options as needed",
)
UNKNOWN_OPTION: Final = Rule(
    "RA406", ERROR, "`{routine}` has no optional argument `\\{option}`", "{hint}"
)
NEW_OPTION: Final = Rule(
    "RA418",
    WARNING,
    "`{routine}` of RobotWare 6 has no optional argument `\\{option}`",
    "{hint}, unless a later RobotWare has it",
)
EXCLUSIVE: Final = Rule(
    "RA407",
    ERROR,
    "only one of `\\{one}` and `\\{other}` may be given to `{routine}`",
    "leave one of them out",
)
OPTION_WITHOUT_VALUE: Final = Rule(
    "RA408",
    ERROR,
    "`\\{option}` of `{routine}` has no value",
    "write `\\{option}:=` and a {type} behind it",
)
SWITCH_WITH_VALUE: Final = Rule(
    "RA409",
    ERROR,
    "`\\{option}` of `{routine}` is a switch and takes no value",
    "write only `\\{option}`, or leave it out",
)
WRONG_NAME: Final = Rule(
    "RA410",
    ERROR,
    "an argument is named `{name}` where `{parameter}` of `{routine}` stands",
    "write `{parameter}`, or no name at all",
)
WRONG_ARGUMENT: Final = Rule(
    "RA411",
    ERROR,
    "`{parameter}` of `{routine}` is {wanted}, and is given {given}",
    "give it a value of type {wanted}",
)
NO_REFERENCE: Final = Rule(
    "RA412",
    ERROR,
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "hand over data that can be changed",
)
NO_PERSISTENT: Final = Rule(
    "RA413",
    ERROR,
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with PERS",
)
NO_VARIABLE: Final = Rule(
    "RA414",
    WARNING,
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with VAR",
)
FUNCTION_ALONE: Final = Rule(
    "RA415",
    ERROR,
    "`{name}` is a function, which cannot be called as an instruction",
    "use its value: `data:={name}(...);`",
)
NO_FUNCTION: Final = Rule(
    "RA416",
    ERROR,
    "`{name}` is called as a function, but has no value",
    "call it as an instruction of its own, without parentheses",
)
NOT_A_ROUTINE: Final = Rule("RA417", ERROR, "`{name}` is called, but is {what}", "correct the name")
UNKNOWN_TYPE: Final = Rule(
    "RA421",
    WARNING,
    "neither RobotWare nor a given module has a type `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_TYPE: Final = Rule(
    "RA422", WARNING, "there is no type `{name}`, but `{near}`", "write `{near}` if it is meant"
)
COMPONENT_COUNT: Final = Rule(
    "RA423",
    ERROR,
    "a {type} has {count} components, {given} are written",
    "write all of them: {names}",
)
ELEMENT_COUNT: Final = Rule(
    "RA424",
    ERROR,
    "{given} elements are written for an array of {count}",
    "write one for each, or change the declared size",
)
WRONG_VALUE: Final = Rule(
    "RA425", ERROR, "{given} stands where {wanted} should", "write a value of type {wanted}"
)
UNKNOWN_COMPONENT: Final = Rule("RA426", ERROR, "a {type} has no component `{name}`", "{hint}")
INDEX_COUNT: Final = Rule(
    "RA427",
    ERROR,
    "the number of indices is {given}, that of dimensions {count}",
    "write one index for each declared dimension",
)
INDEX_RANGE: Final = Rule(
    "RA430",
    WARNING,
    "index {index} is outside of `{name}`, where it goes from 1{to}",
    "correct the index, or declare more elements",
)
OPERANDS: Final = Rule("RA428", ERROR, "`{operator}` cannot join {left} and {right}", "{hint}")
NO_TRUTH: Final = Rule(
    "RA429",
    ERROR,
    "{given} stands where a condition should",
    "compare it with a value, or use a bool",
)
