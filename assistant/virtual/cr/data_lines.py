"""Lines of the data link: what `Open "COM2:"` of a program leads to."""

from __future__ import annotations

from collections.abc import Callable, Container
from typing import Final

from assistant.virtual.cr.parameter_table import Parameters
from assistant.virtual.melfa.communication import LOOPBACK
from assistant.virtual.melfa.lines import Line, TcpClient, TcpServer

DATA_LINK: Final = "2"
"""Protocol of a line that programs open (CPRCE11 to CPRCE19, CPRC232)."""
SERIAL_PORT: Final = "RS232"
FIRST_OPTION: Final = 11


class DataLines:
    """lines: by what programs open, as `COM2:`. ports: (host, port) that clients connect to, by the
    same names. first_port: of the first network line, the others follow; 0 for any that are free.
    without: names that lead elsewhere.
    """

    def __init__(
        self,
        parameters: Parameters,
        host: str,
        first_port: int,
        serial: Line | None,
        *,
        without: Container[str] = (),
    ) -> None:
        """Raises OSError if a port is taken."""
        self.lines: dict[str, Line] = {}
        self.ports: dict[str, tuple[str, int]] = {}
        self._ends: list[Callable[[], None]] = []
        try:
            for number, device in enumerate(parameters["COMDEV"], start=1):
                if f"COM{number}:" in without:
                    continue
                if device == SERIAL_PORT and serial is not None:
                    self.lines[f"COM{number}:"] = serial
                elif device.startswith("OPT"):
                    self._network(f"COM{number}:", device, parameters, (host, first_port))
        except OSError:
            self.shut()
            raise

    def _network(
        self, name: str, device: str, parameters: Parameters, first: tuple[str, int]
    ) -> None:
        """A line OPT11 to OPT19, if it is one of the data link."""
        option = device.removeprefix("OPT")
        index = int(option) - FIRST_OPTION if option.isdigit() else -1
        if not 0 <= index < len(parameters["NETMODE"]):
            return
        if parameters[f"CPRCE{option}"] != (DATA_LINK,):
            return
        host, port = first
        if parameters["NETMODE"][index] == "0":
            target = parameters["NETHSTIP"][index], int(parameters["NETPORT"][index + 1])
            if target[0] in LOOPBACK:  # a virtual controller connects to no other computer
                self.lines[name] = TcpClient(*target)
            return
        server = TcpServer(port + index if port else 0, host)
        self.lines[name], self.ports[name] = server, server.address
        self._ends.append(server.shut)

    def shut(self) -> None:
        for end in self._ends:
            end()
        self._ends.clear()
