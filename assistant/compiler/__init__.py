"""From any source to a proven program of a robot language."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.compiler.checking import Checked, check_files
    from assistant.compiler.comparing import Comparison, compare
    from assistant.compiler.compiling import Compiled, compile
    from assistant.compiler.loading import Loaded
    from assistant.compiler.motion import Proving
    from assistant.compiler.opening import load
    from assistant.compiler.proof import Proof
    from assistant.compiler.translating import Translation, translate

_LAZY: Final = {
    "Checked": ("assistant.compiler.checking", "Checked"),
    "Comparison": ("assistant.compiler.comparing", "Comparison"),
    "Compiled": ("assistant.compiler.compiling", "Compiled"),
    "Loaded": ("assistant.compiler.loading", "Loaded"),
    "Proof": ("assistant.compiler.proof", "Proof"),
    "Proving": ("assistant.compiler.motion", "Proving"),
    "Translation": ("assistant.compiler.translating", "Translation"),
    "check_files": ("assistant.compiler.checking", "check_files"),
    "compare": ("assistant.compiler.comparing", "compare"),
    "compile": ("assistant.compiler.compiling", "compile"),
    "load": ("assistant.compiler.opening", "load"),
    "translate": ("assistant.compiler.translating", "translate"),
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
