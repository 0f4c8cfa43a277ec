"""The toy language is one of the languages while the laws are tested."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from assistant import languages


@pytest.fixture(autouse=True, scope="module")
def toy() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(languages.ROOMS, "toy", "tests.languages.toy")
        yield
