"""Clients of real controllers, a folder a maker; `controller.py` is what all of them answer.

with controllers.connect("ftp://engineer@192.168.125.1", ask=getpass) as controller:
    controller.write("seam.mod", data)
"""

from assistant.controllers.address import Address, parse
from assistant.controllers.controller import Controller, Programs, connect
from assistant.controllers.credentials import Credentials

__all__ = ["Address", "Controller", "Credentials", "Programs", "connect", "parse"]
