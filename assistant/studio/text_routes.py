"""Texts: opened, typed in, asked about and saved. What answers is loaded by the first of them."""

from __future__ import annotations

from typing import Any, Final

from assistant.studio.answering import Asked, Does, asks, changes
from assistant.studio.studio import Studio


def _later(name: str) -> Does:
    def answer(studio: Studio, asked: Asked) -> Any:
        from assistant.studio import text_answers

        return getattr(text_answers, name)(studio, asked)

    return answer


ASKED: Final = (
    *("open_text", "close", "on_disk", "change", "words", "settled", "fixes", "completions"),
    *("hover", "definition", "renameable", "rename", "formatted", "translation"),
)
ROUTES: Final = (
    *(asks(f"/text/{name}", _later(name)) for name in ASKED),
    changes("/text/save", _later("save")),
)
