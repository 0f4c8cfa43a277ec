"""From the trees of MELFA-BASIC files to the pseudo-program."""

from __future__ import annotations

from typing import Final

PASSES: Final = (
    "procedures",  # blocks, subroutines, functions and interrupt handlers in code lines
    "symbols",  # names of a file: variables, targets, signals, functions
    "untranslatable_reasons",  # why a statement has no equivalent
    "computed_positions",  # pallets, sums and products of positions
    "expressions",  # expressions and their types
    "settings",  # speed, corner, tool and base at each line, along every path that leads there
    "paths",  # runs of moves
    "simple_statements",  # assignments, definitions, channels, waits
    "moves",  # single moves, and what they set on their way
    "statements",  # lines and blocks as statements
    "procedure_reader",  # the statements of a procedure
    "declarations",  # headings, arrays, targets and signatures of a file
    "program",  # the files of a program as one
    "vendor_only",  # equivalents of what no other language has
    "position_angles",  # angles and flags beside positions, for other languages
    "angle_units",  # angles in degrees, for languages whose functions take these
    "for_other_vendor",  # the program for another language
)
"""Modules in the order of their imports: none imports a later one."""
