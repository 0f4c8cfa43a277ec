"""Parameters that a restore leaves alone unless they are named, and those that no backup holds.

Their names are those of the CR controllers' parameter lists (BFP-A8869, BFP-A5993) and of
parameter files of RT ToolBox; a pattern stands for a family.
"""

from __future__ import annotations

import re
from typing import Final

ORIGIN: Final = "it belongs to the origin of this arm; another one would move to wrong places"
SAFETY: Final = "it limits what the arm may do, or watches over it"
NETWORK: Final = "it belongs to the lines of this controller; another one could not be reached"
MACHINE: Final = "it says what this controller and its arm are"

LEFT_OUT_PARAMETERS: Final = (
    (re.compile(r"DATINST.*|HOME.*|JRC.*|USE?RORG|ME?ORG.*|ORG.*|MEDORG.*"), ORIGIN),
    (re.compile(r"MEINS.*|MEOFF.*|DJNT"), ORIGIN),
    (re.compile(r"ME[JPM]AR|AREA.*|USERAREA.*|SFC.*|COL.*|CAV.*|ESP.*|DOOR.*|AUTOENA"), SAFETY),
    (re.compile(r"SF[A-Z]*|SS[12].*|SLS.*|SLP.*|STR(?:DLY|CRC).*|SRSW.*|SRPRM.*"), SAFETY),
    (re.compile(r"NET.*|COMDEV|CBAU.*|CPRC.*|CPRTY.*|CSTOP.*|CTERM.*|CLEN.*|COMSPEC"), NETWORK),
    (re.compile(r"MXTCOM.*|MONMODE|MONPORT"), NETWORK),
    (re.compile(r"RCSERIAL|RCTYPE|MECHA\d*|MAINVER|SRVVER\d*|.*VER|PRGEXT"), MACHINE),
)
"""Patterns of names → why a restore leaves them out."""
SECRET_PARAMETER: Final = re.compile(r".*(?:PSW|PSSW|PASSW|PWD|KEYW).*")
"""Names of parameters that may hold a password: no backup has them."""


def why_left_out(name: str) -> str | None:
    """Why a restore leaves a parameter out, None if it does not."""
    return next(
        (reason for pattern, reason in LEFT_OUT_PARAMETERS if pattern.fullmatch(name)), None
    )
