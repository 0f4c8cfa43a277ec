"""Clients of real controllers: ABB IRC5 by FTP, Mitsubishi CR by controller link.

with controllers.connect("ftp://engineer@192.168.125.1", ask=getpass) as controller:
    controller.write("seam.mod", data)
"""

from assistant.controllers.address import Address, parse
from assistant.controllers.controller import Controller, connect
from assistant.controllers.credentials import Credentials

__all__ = ["Address", "Controller", "Credentials", "connect", "parse"]
