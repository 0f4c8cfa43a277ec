"""Merge of edits: edits of a written program survive when its source is compiled again.

`contour_origins.py` relates the parts of a program to the parts of its source; `three_way_merge.py`
finds the edits and puts them into the new program; `edited_files.py` does that with texts and
files; `last_output.py` stores the last output, from which edits are known.
"""

from __future__ import annotations

from assistant.compiler.merge_edits.edited_files import Keeper, Kept
from assistant.compiler.merge_edits.last_output import (
    WRITTEN,
    replaced,
    with_sources,
    write_unedited,
    written_in,
)
from assistant.compiler.merge_edits.three_way_merge import MergeChoices

__all__ = [
    "WRITTEN",
    "Keeper",
    "Kept",
    "MergeChoices",
    "replaced",
    "with_sources",
    "write_unedited",
    "written_in",
]
