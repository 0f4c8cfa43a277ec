"""What servoing says: how it ended, and why it did not begin."""

from __future__ import annotations

from assistant.base.diagnostics import error

TARGET_NOT_SEEN = error(
    "VS201",
    "it is not seen for sure: {reason}; nothing was moved",
    "light it, free the view, or jog the arm to where all of it is in the picture",
)
TARGET_LOST = error(
    "VS202",
    "it was lost from sight ({reason}) at picture {number}, {left} from the goal; the arm was "
    "brought to rest",
    "free the view, and start from where the arm is",
)
STALE_PICTURES = error(
    "VS203",
    "pictures come {age:.2f} s late at picture {number}, {left} from the goal; the arm was brought "
    "to rest",
    "look at the camera and its line, or allow older pictures in the file of what is led where",
)
SINGULAR_INTERACTION = error(
    "VS204",
    "what is seen does not tell how to move: the interaction matrix is singular (condition "
    "{condition:.3g}) at picture {number}; the arm was brought to rest",
    "use points that are not in one line, more of them, or one more camera",
)
ERROR_GROWS = error(
    "VS205",
    "the error grows: it was {first:.3g} and is {now:.3g} at picture {number}; the arm was brought "
    "to rest",
    "look whether the camera stands where its file says, and lower the gain",
)
SERVO_TIMEOUT = error(
    "VS206",
    "the goal was not reached in {seconds:g} s: {left} were left; the arm was brought to rest",
    "look at the log, then allow more time or a larger tolerance",
)
BARRED_BY_LIMIT = error(
    "VS207",
    "the way to the goal is barred by {what}, {left} from the goal; the arm was brought to rest",
    "choose another goal or start, or widen the limit if it is safe",
)
ARM_OUTSIDE_BOUNDS = error(
    "VS208",
    "the arm stands outside of its limits: {what}; nothing was moved",
    "jog it into them, or correct the limits",
)
BAD_SETTING = error("VS209", "`{name}` cannot be {value}: {reason}", "give another one")
BAD_SERVO_FILE = error("VS210", "the servo file {what}", "{cure}")
NO_SERVO_SOURCE = error(
    "VS211", "no source of pictures is known of camera `{camera}`", "write `source` into its table"
)
MIXED_CAMERAS = error(
    "VS212",
    "camera `{camera}` is carried by `{parent}`, and {why}",
    "use one camera in the hand, or cameras that stand in the world",
)
PICTURES_ENDED = error(
    "VS213",
    "camera `{camera}` gives no more pictures after picture {number}",
    "look at the camera and its line",
)
