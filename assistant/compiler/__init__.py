"""From any source to a proven program of a robot language."""

from assistant.compiler.checking import Checked, check_files
from assistant.compiler.compiling import Compiled, compile, translate
from assistant.compiler.loading import Loaded, load
from assistant.compiler.proof import Proof

__all__ = ["Checked", "Compiled", "Loaded", "Proof", "check_files", "compile", "load", "translate"]
