"""NPY and NPZ files: arrays of numbers, read without running what is in the file.

The header is read as numpy.lib.format documents it, versions 1 and 2. Object arrays are refused.
"""

from __future__ import annotations

import ast
import io
import lzma
import math
import re
import struct
import zipfile
import zlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.budgets import most_unpacked
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Severity, Unreadable, error
from assistant.sources.tables.headers import shown

ERROR: Final = Severity.ERROR
_NOT_NPY = error("TB401", "this is no NPY array: {reason}", "write it with `numpy.save`")
_TRUNCATED = error(
    "TB402",
    "the array says {shape} but the file ends after {there} of its {wanted} bytes",
    "copy or write the file again",
)
_OBJECT_ARRAY = error(
    "TB403", "the array holds Python objects, which are never loaded", "save an array of float64"
)
_WRONG_TYPE = error("TB404", "the array holds `{dtype}`, not numbers", "save an array of float64")
_HALF_PRECISION = error(
    "TB405",
    "the array holds half-precision numbers, too coarse for positions",
    "save an array of float64",
)
_NOT_NPZ = error("TB406", "this is no NPZ archive: {reason}", "write it with `numpy.savez`")
_TOO_LARGE = error(
    "TB407", "the archive unpacks to {size:.0f} MB, more than {most:.0f} MB", "split it"
)
_NOT_AN_ARRAY = error(
    "TB408", "the archive holds {name}, which is no array", "write it with `numpy.savez`"
)

BROKEN_ZIP: Final = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    NotImplementedError,
    RuntimeError,
    EOFError,
    OSError,
    ValueError,
)
"""Exceptions that the zip reader raises for damaged, encrypted and unknown content."""
_NUMBER_TYPES: Final = {("f", 4), ("f", 8), *((kind, 2**i) for kind in "iu" for i in range(4))}
"""Kinds and sizes of elements that are taken."""
_NPY_MAGIC: Final = b"\x93NUMPY"
_MOST_DIMENSIONS: Final = 64
_MOST_SIZE: Final = 2**63 - 1
"""Largest number of elements, and of bytes, of arrays of numpy 2, extents of 0 not counted."""
_LONGEST_HEADER: Final = 1 << 16
_LONGEST_TEXT: Final = 1000


def read_npy(data: bytes, path: str, place: str | None = None) -> Floats:
    """The array of an NPY file's bytes as float64; nothing in them is ever executed.

    The size is checked before anything is allocated. Raises Unreadable or Refused.
    """
    header = _npy_header(data, path, place)
    kind, size = header.kind, header.size
    if kind == "O":
        raise Refused(_OBJECT_ARRAY(path=path, place=place))
    if (kind, size) == ("f", 2):
        raise Refused(_HALF_PRECISION(path=path, place=place))
    if (kind, size) not in _NUMBER_TYPES:
        raise Refused(_WRONG_TYPE(path=path, place=place, dtype=header.descr[:60]))
    return _npy_elements(data, path, place, header).astype(np.float64, copy=False)


def read_npz(data: bytes, path: str) -> tuple[dict[str, Floats], dict[str, str]]:
    """The arrays of numbers and the scalar texts of an NPZ file, in the file's order.

    Raises Unreadable or Refused.
    """
    arrays: dict[str, Floats] = {}
    texts: dict[str, str] = {}
    for member, content in _archive_members(data, path):
        name = member.removesuffix(".npy")
        # `numpy.savez` adds `.npy` to every name; anything else is no array of its.
        if name == member or name in arrays or name in texts:
            raise Unreadable(_NOT_AN_ARRAY(path=path, name=shown(member)))
        text = _npy_text(content, path, name)
        if text is not None:
            texts[name] = text
        else:
            arrays[name] = read_npy(content, path, shown(name))
    return arrays, texts


def _archive_members(data: bytes, path: str) -> list[tuple[str, bytes]]:
    """Names and bytes of what a zip archive holds; raises Unreadable."""
    too_large = None
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            # Sizes are checked before anything is unpacked: a small archive can expand without end.
            size, most = sum(member.file_size for member in archive.infolist()), most_unpacked()
            if size <= most:
                return [(member.filename, archive.read(member)) for member in archive.infolist()]
            too_large = _TOO_LARGE(path=path, size=size / 1e6, most=most / 1e6)
    except BROKEN_ZIP as error:
        raise Unreadable(_NOT_NPZ(path=path, reason=_reason_of(error))) from None
    raise Unreadable(too_large)


@dataclass(frozen=True, slots=True)
class _NpyHeader:
    """An NPY header; descr: byte order, kind and size of an element; start: offset."""

    descr: str
    fortran: bool
    shape: tuple[int, ...]
    start: int

    @property
    def kind(self) -> str:
        return self.descr.lstrip("<>|=")[:1]

    @property
    def size(self) -> int:
        digits = self.descr.lstrip("<>|=")[1:]
        return int(digits) if digits else 0


def _npy_header(data: bytes, path: str, place: str | None) -> _NpyHeader:
    """The header, as numpy.lib.format documents it, version 1 and 2."""
    try:
        if not data.startswith(_NPY_MAGIC) or len(data) < len(_NPY_MAGIC) + 6:
            raise ValueError("it does not begin like one")
        wide = {b"\1\0": 2, b"\2\0": 4}.get(data[6:8])
        if wide is None:
            raise ValueError(f"version {data[6]}.{data[7]} of the format is not known")
        # The header is read before it is believed: its length may be anything.
        start = 8 + wide + int.from_bytes(data[8 : 8 + wide], "little")
        if start > min(len(data), _LONGEST_HEADER):
            raise ValueError("its header is not all there")
        # `literal_eval` runs nothing, unlike `eval`.
        said = ast.literal_eval(data[8 + wide : start].decode("latin-1").strip())
        if not isinstance(said, dict) or said.keys() != {"descr", "fortran_order", "shape"}:
            raise ValueError("its header does not say type, order and shape")
        descr, fortran, shape = said["descr"], said["fortran_order"], said["shape"]
        # The digits are bounded, as `int` of a long text takes long.
        if not isinstance(descr, str) or not re.fullmatch(r"[<>|=]?[a-zA-Z]\d{0,9}", descr):
            raise ValueError("its elements are records")
        if not (isinstance(shape, tuple) and all(type(n) is int and n >= 0 for n in shape)):
            raise ValueError("its shape is no list of extents")
    except (ValueError, SyntaxError, TypeError, RecursionError, MemoryError) as error:
        raise Unreadable(_NOT_NPY(path=path, place=place, reason=_reason_of(error))) from None
    return _NpyHeader(descr, bool(fortran), shape, start)


def _npy_elements(
    data: bytes, path: str, place: str | None, header: _NpyHeader
) -> NDArray[np.generic]:
    dtype: np.dtype[np.generic] = np.dtype(header.descr)
    # Extents of 0 hide overflows of the others, so they count as 1.
    full = math.prod(max(extent, 1) for extent in header.shape) * dtype.itemsize
    if len(header.shape) > _MOST_DIMENSIONS or full > _MOST_SIZE:
        raise Unreadable(_NOT_NPY(path=path, place=place, reason="no array has such a shape"))
    count = math.prod(header.shape)
    wanted, there = count * dtype.itemsize, len(data) - header.start
    if wanted > there:
        extents = " x ".join(str(extent) for extent in header.shape)
        raise Unreadable(
            _TRUNCATED(path=path, place=place, shape=extents[:60], there=there, wanted=wanted)
        )
    flat = np.frombuffer(data, dtype=dtype, count=count, offset=header.start)
    return flat.reshape(header.shape, order="F" if header.fortran else "C")


def _npy_text(data: bytes, path: str, name: str) -> str | None:
    """The text of a scalar of characters, None for anything else."""
    header = _npy_header(data, path, shown(name))
    if header.kind != "U" or header.shape != () or not 0 < header.size <= _LONGEST_TEXT:
        return None
    try:
        return str(_npy_elements(data, path, shown(name), header))
    except (ValueError, SystemError) as error:  # code points that there are not
        if isinstance(error, Refused):
            raise
        raise Unreadable(_NOT_NPY(path=path, place=shown(name), reason=_reason_of(error))) from None


def _reason_of(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
