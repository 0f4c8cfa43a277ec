"""Findings of editing itself."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error

NO_NAME: Final = error("ED001", "the name `{name}` {why}", "choose another name")
TAKEN: Final = error(
    "ED002",
    "`{name}` is taken: line {first} of `{file}` has it already",
    "choose a name that is not in use there, or rename that one first",
)
NOT_DECLARED: Final = error(
    "ED003",
    "nothing with a name that can be changed stands here",
    "put the cursor on a name that the program declares",
)
NO_LIBRARY: Final = error(
    "ED010",
    "the language server is made with the library {name}, which is not installed",
    "install the extra: pip install 'robot-assistant[lsp]'",
)
NOT_BOUND: Final = error(
    "ED011",
    "the port {port} cannot be listened on: {reason}",
    "choose another port: `robot-assistant lsp --tcp 0` takes a free one",
)
