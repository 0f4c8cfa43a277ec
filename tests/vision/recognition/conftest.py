from __future__ import annotations

import pytest

from assistant.vision.opencv import opencv
from assistant.vision.recognition.object_library import Library
from assistant.vision.recognition.recogniser import Recogniser
from tests.vision.recognition.scenes import library


@pytest.fixture(scope="session")
def ten(tmp_path_factory) -> Library:
    """Ten known objects: six parts by their drawings, four cards by a view of each."""
    return library(tmp_path_factory.mktemp("drawings"))


@pytest.fixture(scope="session")
def recogniser(ten) -> Recogniser:
    return Recogniser(opencv(), ten)
