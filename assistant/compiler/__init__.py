"""From any source to a proven program of a robot language."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.compiler.checker import Checked, check_files
    from assistant.compiler.comparison import Comparison, compare
    from assistant.compiler.compilation import Compiled, compile
    from assistant.compiler.loader import Loaded
    from assistant.compiler.motion_proof import Proving
    from assistant.compiler.program_files import load
    from assistant.compiler.read_back_proof import Proof
    from assistant.compiler.translation import Translation, translate

_LAZY: Final = {
    "Checked": ("assistant.compiler.checker", "Checked"),
    "Comparison": ("assistant.compiler.comparison", "Comparison"),
    "Compiled": ("assistant.compiler.compilation", "Compiled"),
    "Loaded": ("assistant.compiler.loader", "Loaded"),
    "Proof": ("assistant.compiler.read_back_proof", "Proof"),
    "Proving": ("assistant.compiler.motion_proof", "Proving"),
    "Translation": ("assistant.compiler.translation", "Translation"),
    "check_files": ("assistant.compiler.checker", "check_files"),
    "compare": ("assistant.compiler.comparison", "compare"),
    "compile": ("assistant.compiler.compilation", "compile"),
    "load": ("assistant.compiler.program_files", "load"),
    "translate": ("assistant.compiler.translation", "translate"),
}

__all__ = [
    "Checked",
    "Comparison",
    "Compiled",
    "Loaded",
    "Proof",
    "Proving",
    "Translation",
    "check_files",
    "compare",
    "compile",
    "load",
    "translate",
]

__getattr__ = offered(__name__, _LAZY)
