"""The virtual CR controller: its protocols served on this computer.

with VirtualCr("rv-2aj") as controller:
    connect(controller.address)
"""

from assistant.virtual.cr.controller import VirtualCr
from assistant.virtual.cr.session import Faults
from assistant.virtual.cr.slots_and_arm import Contact

__all__ = ["Contact", "Faults", "VirtualCr"]
