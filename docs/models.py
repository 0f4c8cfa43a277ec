"""Draws the models of samples/blocks for their page: the diagram, below it signals of its run."""

from __future__ import annotations

import importlib.util
import io
import sys
from pathlib import Path
from types import ModuleType
from typing import Final

PROJECT: Final = Path(__file__).parent.parent
FOLDER: Final = PROJECT / "samples" / "blocks"


def names() -> list[str]:
    """Of the models, each a file of the folder."""
    return sorted(file.stem for file in FOLDER.glob("*.py"))


def loaded(name: str) -> ModuleType:
    """A model as a module: it gives its diagram and its run by `simulated()`."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def model(name: str) -> bytes:
    """The picture of a model, as PNG."""
    from matplotlib.figure import Figure

    from assistant.blocks.display import draw_diagram, draw_signals

    module = loaded(name)
    diagram, ran = module.simulated()
    shown = module.DRAWN
    figure = Figure(figsize=(9.0, 2.6 + 0.95 * len(shown)), layout="constrained")
    (upper,), (lower,) = figure.subfigures(
        2, 1, squeeze=False, height_ratios=[2.6, 0.95 * len(shown)]
    )
    draw_diagram(upper.subplots(), diagram)
    below = lower.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    draw_signals(list(below), ran, list(shown))
    for axes, said in zip(below, shown.values(), strict=True):
        axes.set_title(said, fontsize=8, loc="left", pad=2)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=100, metadata={"Software": None})
    return out.getvalue()
