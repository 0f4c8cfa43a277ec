"""From the typed trees of RAPID to the pseudo-program."""

from __future__ import annotations

from typing import Final

PASSES: Final = (
    "timers",  # clocks that are restarted and read
    "local_names",  # data that only one module has, apart from that of others
    "plain",  # records as plain data, for other languages
    "expressions",
    "modules",  # calls between modules that one task holds
    "data",  # declared tools, work objects, speeds, zones, targets, variables
    "instructions",  # calls that the pseudo-program has a statement for
    "triggers",  # outputs that moves set on their way
    "paths",  # runs of targets and of moves through them
    "statements",
    "processes",  # what moves with a process are given
    "kept_signals",  # signals that only kept texts name
    "ways",  # what kept texts do to what holds along the ways
    "places",  # where the position is read
    "program",  # modules as procedures and data
    "plain_data",  # the program of plain data, beside its cell
    "extents",  # how many elements arrays have
    "stopwatches",  # clocks that are stopped and go on
    "kept_calls",  # calls that other languages have other statements for
    "operator",  # messages and questions to a person
    "told",  # instructions of RAPID alone, for other languages
    "gateways",  # bytes that go over lines of texts
    "socket_states",  # what was done with sockets last
    "channels",  # files, serial lines and sockets
    "dates",  # the date as text, as others write it
    "exported",  # what other languages are told
)
"""In the order in which a program goes through them; none asks a later one."""
