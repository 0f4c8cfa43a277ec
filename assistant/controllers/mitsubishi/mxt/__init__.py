"""Real-time external control (`Mxt`) and the real-time monitor of CR controllers, over UDP."""

from assistant.controllers.mitsubishi.mxt.client import CYCLES, Mxt
from assistant.controllers.mitsubishi.mxt.monitor import Monitor, MonitorSample
from assistant.controllers.mitsubishi.mxt.program import program

__all__ = ["CYCLES", "Monitor", "MonitorSample", "Mxt", "program"]
