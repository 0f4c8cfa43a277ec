"""The virtual CR controller: its protocols served on this computer.

with VirtualCr("rv-2aj") as controller:
    connect(controller.address)
"""

from assistant.virtual.cr.controller import VirtualCr
from assistant.virtual.cr.faults import Faults
from assistant.virtual.cr.powered import Contact

__all__ = ["Contact", "Faults", "VirtualCr"]
