"""Words in names of layers and processes that say what is done along their contours.

A contour of a layer that cuts, drills or deburrs is an edge of the part. One of a layer that glues,
seals, welds, paints or engraves lies on a surface: the part has no hole there. Each word is of
English, German, French, Spanish, Italian, Russian, Chinese or Japanese.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from functools import cache
from typing import Final, Literal

from assistant.sources.process import Layer

EdgeKind = Literal["edge", "surface", "unknown"]
"""Kind of a layer's contours: edges of the part, lines on it, or either."""

_WORDS_OF_WORK: Final[Mapping[EdgeKind, str]] = {
    "edge": """
        cut cuts cutting cutter laser plasma waterjet kerf drill drills drilling punch punching
        mill milling route routing deburr deburring trim
        schneiden schnitt schneid laserschnitt bohren stanzen fraesen fraesung entgraten
        coupe decoupe percage poinconnage fraisage ebavurage
        corte cortar taladro taladrado fresado
        taglio foratura fresatura
        切断 рез резка 切割 打孔
    """,
    "surface": """
        engrave engraving etch etching glue gluing adhesive seal sealing sealant dispense
        dispensing bead weld welds welding polish polishing spray spraying paint painting marking
        scribe scribing
        gravur gravieren kleben klebe klebung kleber dichten dichtung schweissen schweiss
        schweissnaht polieren lackieren
        gravure collage colle joint soudure soudage
        grabado pegado pegamento sello soldadura
        incisione incollaggio colla guarnizione saldatura
        溶接 接着 塗布 刻印 гравировка сварка клей 焊接 涂胶 雕刻
    """,
    "unknown": "path toolpath robot grind grinding schleifen bahn 加工",
}
_EDGES: Final = """
    hole holes bore bores slot slots pocket pockets opening openings cutout outline outlines contour
    contours profile edge edges chamfer deburred
    bohrung bohrungen durchgangsbohrung durchgangsbohrungen loch loecher langloch ausschnitt kontur
    aussenkontur innenkontur umriss kante kanten fase fasen
    trou trous alesage rainure contours chanfrein arete aretes
    agujero agujeros ranura contorno chaflan
    foro fori asola asole smusso spigolo
    穴 孔 外形 輪郭 轮廓 отверстие отверстия контур паз
"""
"""Words for edges of parts, which say less than words of work."""
_ON_SURFACE: Final = (
    *("glu", "adhes", "seal", "dispens", "bead", "weld", "paint", "spray", "engrav", "primer"),
    *("kleb", "dicht", "raupe", "schweiss", "lack", "sprueh", "gravur", "gravier", "beschrift"),
    *("silicon", "silikon", "gasket", "solder", "stitch", "marquage", "marcado", "marcatura"),
)
"""Beginnings of words for work on surfaces, for compounds such as `Kleberaupe`."""
_DIAMETER: Final = re.compile(r"[Ø⌀]|%%c|(?<![A-Za-z])[DM]_?[0-9]", re.IGNORECASE)
"""A size that holes are named by."""
_WORD: Final = re.compile(r"[^\W\d_]+")
_CAMEL: Final = re.compile(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])")


def plain_word(text: str) -> str:
    """Small letters without accents; full-width letters as usual ones."""
    spelled = unicodedata.normalize("NFKC", text).casefold()
    for umlaut, letters in (("ä", "ae"), ("ö", "oe"), ("ü", "ue")):
        spelled = spelled.replace(umlaut, letters)
    # Only accents of Latin letters: in Japanese the marks of voiced sounds are letters as well.
    parts = unicodedata.normalize("NFD", spelled)
    kept = "".join(c for c in parts if not "\u0300" <= c <= "\u036f")
    return unicodedata.normalize("NFC", kept)


def plain_name(name: str) -> str:
    """A name as `plain_word` has it, with its words apart: `cutLine` is `cut line`."""
    return plain_word(_CAMEL.sub(" ", name))


def words_of_name(name: str) -> list[str]:
    """The words of a name, each as `plain_word` has it."""
    return _WORD.findall(plain_name(name))


_WORK: Final[Mapping[EdgeKind, frozenset[str]]] = {
    kind: frozenset(map(plain_word, words.split())) for kind, words in _WORDS_OF_WORK.items()
}
_ALL_WORK: Final = frozenset[str]().union(*_WORK.values())
_EDGE_WORDS: Final = frozenset(map(plain_word, _EDGES.split()))


def _has_word(name: str, words: frozenset[str]) -> bool:
    """True if a name has one of the words, those of languages without spaces anywhere in it."""
    plain = plain_name(name)
    return bool(words.intersection(words_of_name(name))) or any(
        word in plain for word in words if not word.isascii()
    )


def names_work(name: str) -> bool:
    """True if a word of a name means work, such as `cut`."""
    return _has_word(name, _ALL_WORK)


@cache
def _named_kind(name: str) -> EdgeKind:
    cuts = _has_word(name, _WORK["edge"])
    covers = _has_word(name, _WORK["surface"]) or any(
        word.startswith(_ON_SURFACE) for word in words_of_name(name)
    )
    if covers:
        return "unknown" if cuts else "surface"
    if cuts or _has_word(name, _EDGE_WORDS) or _DIAMETER.search(name):
        return "edge"
    return "unknown"


def edge_kind(name: str, layer: Layer) -> EdgeKind:
    """Return the kind of a layer's contours. name: of the layer in the drawing."""
    shaping = layer.shaping
    # A tool beside the contours, such as a nozzle inside of an edge, follows edges.
    if shaping.offset > 0.0 or any(shaping.allowances):
        return "edge"
    kind = _named_kind(f"{name} {layer.process}")
    return "edge" if kind == "unknown" and shaping.sided else kind
