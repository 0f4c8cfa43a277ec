"""Clients of real controllers, a folder a maker; `controller.py` is what all of them answer.

with controllers.connect("ftp://engineer@192.168.125.1", ask=getpass) as controller:
    controller.write("seam.mod", data)

Instead of an address the name of a controller does, of the table `[controllers]` of the project.
"""

from assistant.controllers.address import Address, Credentials, parse
from assistant.controllers.controller import Controller, Programs, connect
from assistant.controllers.named import Named, controllers_of, named

__all__ = [
    "Address",
    "Controller",
    "Credentials",
    "Named",
    "Programs",
    "connect",
    "controllers_of",
    "named",
    "parse",
]
