"""From the trees of MELFA-BASIC files to the pseudo-program."""

from __future__ import annotations

from typing import Final

PASSES: Final = (
    "structure",  # where procedures, blocks and scopes begin and end in the code lines of a file
    "values",  # what its names and expressions mean
    "settings",  # speed, corner, tool and base at each line, along every way that leads there
    "statements",  # lines and runs of lines as statements
    "files",  # a file as procedures, the files of a program as one
    "told",  # what takes the place of what no other language has
    "exported",  # what other languages are told
)
"""In the order in which a program goes through them; none asks a later one."""
