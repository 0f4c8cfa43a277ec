"""A debugger of simulated programs that editors speak with, over the Debug Adapter Protocol.

The protocol: https://microsoft.github.io/debug-adapter-protocol/specification (1.71).
"""

from assistant.virtual.debugging.adapter import Adapter, Launch

__all__ = ["Adapter", "Launch"]
