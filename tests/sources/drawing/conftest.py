"""Drawings made with ezdxf, saved to real files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import ezdxf
import pytest
from ezdxf.document import Drawing

Save = Callable[..., Path]


@pytest.fixture
def drawing() -> Drawing:
    """An empty drawing in millimetres."""
    return ezdxf.new("R2010", units=4)


@pytest.fixture
def save(tmp_path: Path) -> Save:
    """Saves a drawing and gives its path."""

    def _save(document: Drawing, name: str = "part.dxf", fmt: str = "asc") -> Path:
        path = tmp_path / name
        document.saveas(path, fmt=fmt)
        return path

    return _save
