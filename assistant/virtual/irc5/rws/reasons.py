"""Why requests are refused: numbers and words as controllers send them.

Captured from RobotWare 6.16 and 7.21 in the tests of the public client
ichbinmeraj/abb-rws-client (tests/fixtures/errors, src/ControllerError.ts). The first status is
that of RWS 1.0. A number that no public source states for a case is said so beside it.
"""

from __future__ import annotations

from typing import Final

from assistant.virtual.irc5.rws.answers import Reason

HELD_BY_OTHER: Final = Reason(-1073445862, "Requested resource is held by someone else", 403, 403)
NO_MASTERSHIP: Final = Reason(
    -1073445859, "The user does not have required mastership for the operation.", 403, 403
)
NOT_PERMITTED: Final = Reason(-1073445881, "Rejected", 403, 403)
NO_RESOURCE: Final = Reason(-1073414146, "Resource not found", 404, 404)
NO_FILE: Final = Reason(-1073414146, "Resource does not exist", 404, 404)
NO_PATH: Final = Reason(-1073438713, "Path does not exist", 404, 404)
NO_VOLUME: Final = Reason(-1073438716, "Virtual root does not exist", 400, 400)
NO_MODULE: Final = Reason(-1073414146, "Resource not found", 404, 404)
NO_MODULE_2: Final = Reason(-1073442813, "module name/parameter is invalid or missing", 400, 400)
NO_MODULE_TO_UNLOAD: Final = Reason(-1073442816, "Unknown module name", 400, 400)
NO_MODULE_FILE: Final = Reason(-1073438708, "", 400, 400)
"""RWS 1.0 sends no words; that 2.0 answers the same is assumed."""
NO_SYMBOL: Final = Reason(-1073414146, "Symbol not found", 400, 404)
NO_SYMBOL_2: Final = Reason(-1073442816, "Symbol not found", 404, 404)
NO_SIGNAL: Final = Reason(-1073445866, "Invalid IO signal name passed in the uri", 404, 404)
NO_TASK: Final = Reason(-1073445879, "Task does not exist", 404, 404)
BAD_ARGUMENT: Final = Reason(-1073445879, "Invalid action parameter value", 400, 400)
WRONG_STATE: Final = Reason(-1073442809, "Operation not allowed in the current state", 400, 403)
"""400 is what RWS 1.0 sends for a start that is not allowed; 403 is assumed of 2.0."""
UNSPECIFIED: Final = Reason(-1073445885, "Unspecified Error", 400, 400)
"""Of what failed without a number in any public source, as a load of a text with errors."""
NO_EVENTS: Final = Reason(-1073414146, "Resource does not exist on the controller", 400, 400)
NO_METHOD: Final = Reason(-1073445879, "Method not allowed", 405, 405)
UNACCEPTABLE: Final = Reason(-1073445879, "Not acceptable", 406, 406)
NOT_THIS_TYPE: Final = Reason(-1073445879, "Unsupported media type", 415, 415)
INTERNAL_ERROR: Final = Reason(-1073445885, "Unspecified Error", 500, 500)
"""The virtual controller itself has gone wrong."""
TOO_MANY_REQUESTS: Final = Reason(-1073445885, "Too many sessions", 503, 503)
