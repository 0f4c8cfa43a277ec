"""From the typed trees of RAPID to the pseudo-program."""

from __future__ import annotations

from typing import Final

PASSES: Final = (
    "expressions",
    "name_clashes",  # names that are declared more than once
    "clocks",  # as timers, for other languages with a sum
    "declared_data",  # tools, work objects, speeds, zones, targets, variables; paths
    "statements",  # with calls of instructions and triggers
    "vendor_effects",  # signals of vendor statements, and the active tool and work object
    "flatten",  # records as plain data, for other languages
    "program",  # modules as procedures and data
    "vendor_statements",  # the instruction in each, and its replacement
    "operator_dialogs",  # messages and questions to the operator
    "channels",  # files, serial lines and sockets
    "vendor_only",  # constructs that RAPID alone has, for other languages
    "for_other_vendor",  # a program for the language of another vendor
)
"""In the order in which a program goes through them; none asks a later one."""
