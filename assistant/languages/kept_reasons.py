"""Why languages keep statements as their text, where that is no matter of one vendor's words."""

from __future__ import annotations

from typing import Final

from assistant.program.statements import Reason

SETTINGS_DIFFER: Final = Reason(
    "its settings differ with the way that leads here", "set them where the ways meet"
)
NO_EQUIVALENT: Final = Reason(
    "no statement of other languages says it", "say it in plain statements"
)
CONTROLLER_STATE: Final = Reason(
    "it reads or writes a state of the controller itself", "keep the state in a variable of its own"
)
DEPENDED_ON: Final = Reason(
    "something below depends on this setting and stays as its text",
    "see to that first",
    serves=True,
)
NOT_FIRST: Final = Reason(
    "it ends a called program from within a subroutine", "set a variable and return, end above"
)
ENDS_CYCLE: Final = Reason(
    "it ends the cycle of the whole program from within a subroutine",
    "set a variable and return, ask for it in the main program, end there",
)
INTERRUPTS: Final = Reason(
    "it belongs to an interrupt, which works beside the program",
    "write the interrupt in the other language, or ask for the signal where it matters",
)
TASKS: Final = Reason(
    "it controls programs that run beside this one",
    "let the cell's controller start them, or say it in the other language",
)
CAMERAS: Final = Reason(
    "it talks to a camera in the maker's own protocol",
    "read the camera over a line in the other language",
)
COMMUNICATION: Final = Reason(
    "it talks over a line or to a file", "write the communication in the other language"
)
COMPLIANCE: Final = Reason(
    "it makes the arm soft or asks for force, which each maker does in an own way",
    "use the other robot's soft or force control",
)
CONVEYORS: Final = Reason(
    "it follows a conveyor in the maker's own way", "use the other robot's conveyor tracking"
)
TUNING: Final = Reason(
    "it sets how the controller watches or tunes the arm",
    "leave it out, or set the other's own",
)
SERVO: Final = Reason("it switches motors or brakes", "leave that to the operator")
