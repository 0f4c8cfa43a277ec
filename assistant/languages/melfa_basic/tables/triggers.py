"""What `WthIf` asks to do something at a place of a move's way.

Sources: COSIROP help (MELFA-BASIC IV commands), WTH: what stands behind it is done as the motion
begins; WTHIF: the condition is looked at from the start of the motion on, and no `Dly` may stand
behind what is done. M_RDst: mm that are left to the target, M_Ratio: percent of the way that is
done (list of status variables, and the help's example on the rate of arrival). How M_RDst counts
the way of a joint move or an arc, or in a rounded corner, no manual at hand tells.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.program.statements import Measure

TRIGGER_MEASURES: Final[Mapping[str, tuple[Measure, str]]] = {
    "M_RDst": ("end", "<="),
    "M_Ratio": ("share", ">="),
}
"""What status variables measure, and how they are compared with a place that is reached."""
