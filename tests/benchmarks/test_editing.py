"""The benchmark of typing: keys that leave the text as it was."""

from __future__ import annotations

import pytest

from assistant.editing.service import Workspace
from benchmarks import editing


@pytest.mark.parametrize("language", editing.TITLES)
def test_typing_leaves_the_text_as_it_was(language):
    text, workspace = editing.program(language, 60), Workspace()
    document = workspace.open(f"/nowhere/x.{editing.SUFFIXES[language]}", text)
    assert document.language == language
    for number, change in enumerate(editing.keys(text, 3)):
        document = workspace.change(document.path, [change], number)
    assert document.text == text


def test_a_time_is_told_for_each_key():
    whole, times = editing.measured("rapid", 60, 2)
    assert whole > 0 and len(times) == 18
