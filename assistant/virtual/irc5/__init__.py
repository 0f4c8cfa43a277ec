"""The virtual IRC5: its protocols served on this computer.

with VirtualIrc5("home") as controller:
    connect(controller.address, password=controller.password)
"""

from assistant.virtual.irc5.cabinet import Signal
from assistant.virtual.irc5.controller import VirtualIrc5

__all__ = ["Signal", "VirtualIrc5"]
