"""Runs the tutorial notebook as Jupyter does, and keeps what its cells show in it.

python -m docs.tutorial

Its cells run one after the other in this process, without IPython: what the last line of a cell
gives is shown by `_repr_html_` and `_repr_png_` where it has them, else by `repr`.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

NOTEBOOK: Final = Path(__file__).parent / "tutorial.ipynb"


def read(path: Path = NOTEBOOK) -> dict[str, Any]:
    """The notebook as it is stored."""
    loaded: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return loaded


def code(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    """Its cells of code, in their order."""
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def run(notebook: dict[str, Any]) -> Iterator[list[dict[str, Any]]]:
    """Runs each cell of code, in the current folder; what it shows, as a notebook stores it.

    Raises what a cell raises.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(code(notebook), 1):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            value = _run(f"cell {number}", "".join(cell["source"]), names)
        shown: list[dict[str, Any]] = []
        if said.getvalue():
            text = said.getvalue().splitlines(keepends=True)
            shown.append({"name": "stdout", "output_type": "stream", "text": text})
        if value is not None:
            kept = {"data": _shown(value), "execution_count": number, "metadata": {}}
            shown.append({"output_type": "execute_result"} | kept)
        yield shown


def _run(name: str, source: str, names: dict[str, Any]) -> Any:
    """What the last line of a cell gives, None if it gives nothing."""
    tree = ast.parse(source, name)
    last = tree.body[-1] if tree.body else None
    if not isinstance(last, ast.Expr):
        exec(compile(tree, name, "exec"), names)  # noqa: S102 - our own notebook
        return None
    tree.body.pop()
    exec(compile(tree, name, "exec"), names)  # noqa: S102
    return eval(compile(ast.Expression(last.value), name, "eval"), names)  # noqa: S307


def _shown(value: Any) -> dict[str, Any]:
    data: dict[str, Any] = {"text/plain": repr(value).splitlines(keepends=True)}
    if hasattr(value, "_repr_html_"):
        data["text/html"] = value._repr_html_().splitlines(keepends=True)
    png = value._repr_png_() if hasattr(value, "_repr_png_") else None
    if png is not None:
        data["image/png"] = base64.b64encode(png).decode()
    return data


def main() -> None:
    """Stores what the cells show, run where the project is."""
    notebook = read()
    for number, (cell, shown) in enumerate(zip(code(notebook), run(notebook), strict=True), 1):
        cell["outputs"], cell["execution_count"] = shown, number
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", "utf-8")
    sys.stdout.write(f"{NOTEBOOK.name}: {NOTEBOOK.stat().st_size / 1024:.0f} KiB\n")


if __name__ == "__main__":
    main()
