"""Texts: opened, typed in, asked about and saved. What answers is loaded by the first of them."""

from __future__ import annotations

from typing import Any, Final

from assistant.studio.answering import Answering, Question, asks, changes
from assistant.studio.studio import Studio


def _text_answer(name: str) -> Answering:
    def answer(studio: Studio, asked: Question) -> Any:
        from assistant.studio import text_answers

        return getattr(text_answers, name)(studio, asked)

    return answer


TEXT_QUESTIONS: Final = (
    *("open_text", "close", "on_disk", "change", "words", "settled", "fixes", "completions"),
    *("hover", "definition", "renameable", "rename", "formatted", "translation"),
)
TEXT_ROUTES: Final = (
    *(asks(f"/text/{name}", _text_answer(name)) for name in TEXT_QUESTIONS),
    changes("/text/save", _text_answer("save")),
)
