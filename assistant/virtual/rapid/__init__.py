"""An interpreter of RAPID over its typed tree, which knows nothing of how it is translated."""

from assistant.virtual.rapid.running import Inputs, run

__all__ = ["Inputs", "run"]
