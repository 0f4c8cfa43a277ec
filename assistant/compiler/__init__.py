"""From any source to a proven program of a robot language."""

from assistant.compiler.compiling import Compiled, compile, translate
from assistant.compiler.loading import Loaded, load
from assistant.compiler.proof import Proof

__all__ = ["Compiled", "Loaded", "Proof", "compile", "load", "translate"]
