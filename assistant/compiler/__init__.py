"""From any source to a proven program of a robot language."""

from assistant.compiler.checking import Checked, check_files
from assistant.compiler.compiling import Compiled, compile
from assistant.compiler.loading import Loaded, load
from assistant.compiler.proof import Proof
from assistant.compiler.translating import Translation, translate

__all__ = [
    "Checked",
    "Compiled",
    "Loaded",
    "Proof",
    "Translation",
    "check_files",
    "compile",
    "load",
    "translate",
]
