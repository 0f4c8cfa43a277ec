"""Japanese texts with the rows of characters that IBM added, as Windows writes them.

cp932 has 360 characters twice: in rows ED and EE of NEC and in rows FA to FC of IBM. Python
writes the former, Windows the latter; both read either. The codec `cp932_ibm` writes the latter,
so that the bytes of such a file come back.
"""

from __future__ import annotations

import codecs
import re
from functools import cache
from typing import Final

CP932_IBM: Final = "cp932_ibm"


@cache
def _ibm_rows() -> tuple[re.Pattern[str], dict[str, bytes]]:
    codes = [bytes((row, cell)) for row in (0xFA, 0xFB, 0xFC) for cell in range(0x40, 0xFD)]
    known = {code.decode("cp932", "ignore"): code for code in codes}
    twice = {c: code for c, code in known.items() if len(c) == 1 and _is_of_nec(c)}
    return re.compile(f"([{''.join(twice)}])"), twice


def _is_of_nec(character: str) -> bool:
    return character.encode("cp932")[0] in (0xED, 0xEE)


def _encode_ibm(text: str, errors: str = "strict") -> tuple[bytes, int]:
    pattern, rows = _ibm_rows()
    parts = pattern.split(text)
    return b"".join(rows.get(part) or part.encode("cp932", errors) for part in parts), len(text)


def _decode_ibm(data: bytes, errors: str = "strict") -> tuple[str, int]:
    return codecs.decode(data, "cp932", errors), len(data)


def _find_cp932_ibm(name: str) -> codecs.CodecInfo | None:
    return codecs.CodecInfo(_encode_ibm, _decode_ibm, name=CP932_IBM) if name == CP932_IBM else None  # type: ignore[arg-type]


codecs.register(_find_cp932_ibm)
