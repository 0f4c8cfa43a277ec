"""Keeping: what was edited in a written program stays when its source is compiled again.

`made.py` tells what of a program is which place of its source; `merging.py` finds what was edited
and brings it into the new program, `statements.py` what of that is statements; `texts.py` writes
the text; `files.py` does all that with files; `remembered.py` remembers what was written.
"""

from assistant.compiler.keeping.files import Keeper, Kept
from assistant.compiler.keeping.remembered import (
    WRITTEN,
    replaced,
    with_sources,
    write_unedited,
    written_in,
)
from assistant.compiler.keeping.sides import MergeChoices

__all__ = [
    "WRITTEN",
    "Keeper",
    "Kept",
    "Wishes",
    "replaced",
    "with_sources",
    "write_unedited",
    "written_in",
]
