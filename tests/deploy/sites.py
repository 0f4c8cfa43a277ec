"""Virtual controllers of both makes with what a deployment installs on them."""

from assistant.controllers import connect
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5

MODULE = "MODULE {}\r\n  PROC {}()\r\n    WaitTime {};\r\n  ENDPROC\r\nENDMODULE\r\n"
PROGRAM = (
    "10 OVRD 50\r\n20 MOV P1\r\n30 DLY {}\r\n40 END\r\n"
    "P1=(+250.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)\r\n"
)


class Irc5Site:
    """A virtual IRC5, its programs as text, and how to make good and bad ones."""

    names = ("a.mod", "b.mod", "c.mod")

    def __init__(self, folder):
        self.folder = folder
        self.controller = VirtualIrc5(folder / "home")
        self.controller.start()

    def client(self):
        return connect(self.controller.address, password=self.controller.password, timeout=10)

    def text(self, name):
        file = self.controller.folder / name
        return file.read_bytes().decode() if file.exists() else None

    def put(self, name, text):
        (self.controller.folder / name).write_bytes(text.encode())

    def source(self, name, value, wrong=False):
        stem = name.split(".")[0]
        text = MODULE.format(stem.upper(), stem + "_main", value)
        return text.replace("WaitTime", "WaitTime (") if wrong else text

    def no_room(self):
        """The next file of more than a few hundred bytes does not fit."""
        self.controller.stop()
        self.controller = VirtualIrc5(
            self.controller.folder, password=self.controller.password, quota=9000
        )
        self.controller.start()

    def restart(self):
        port, password = self.controller.port, self.controller.password
        self.controller.stop()
        self.controller = VirtualIrc5(self.controller.folder, port=port, password=password)
        self.controller.start()


class CrSite:
    """The same of a virtual CR controller."""

    names = ("A", "B", "C")

    def __init__(self, folder):
        self.folder = folder
        self.controller = VirtualCr(folder=folder / "cr")
        self.controller.start()

    def client(self):
        return connect(self.controller.address, timeout=10)

    def text(self, name):
        return self.controller.text(name)

    def put(self, name, text):
        with self.client() as client:
            client.write(name, text.encode())

    def source(self, name, value, wrong=False):
        text = PROGRAM.format(value)
        return text.replace("MOV P1", "MOV ((") if wrong else text

    def no_room(self):
        self.controller.state.store.capacity = 800

    def restart(self):
        port = self.controller.port
        self.controller.stop()
        self.controller = VirtualCr(folder=self.folder / "cr", port=port)
        self.controller.start()
