"""An interpreter of RAPID over its typed tree, which knows nothing of how it is translated."""

from assistant.virtual.rapid.running import run
from assistant.virtual.rapid.signals import Inputs

__all__ = ["Inputs", "run"]
