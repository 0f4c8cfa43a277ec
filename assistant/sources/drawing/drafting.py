"""Drafting: what a drawing holds for people only, by names of layers, blocks and line types.

A robot follows edges. Borders, title blocks, centre lines, hidden edges, dimensions, construction
lines and hatches are drawn with the same entities, so names tell them apart, and the shape of
borders (`sheets`) and of lines along dimensions (`extension_lines`). Each word of the tables is of
English, German, French, Spanish, Italian, Russian, Chinese or Japanese, or a short form of a CAD
system.

A word counts where a name has it as a separate word: `Hidden (ISO)`, `A-ANNO-DIMS`,
`Mittellinien`; `cutline` and `outline` have none. Words that parts have as well (`center`, `frame`)
count only if the name has nothing else but words such as `line`. A word of work (`cut`, `drill`,
`glue`) makes a layer one that is worked, whatever else its name has: `border_cut`.

A line type is drafting if its pattern has gaps, or if it has the name of one that has: not every
program that writes a drawing also writes the patterns.

What the process file names is never drafting: a layer with a table there, a layer, a block or a
line type under `follow`.
"""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.sources.contours.curves import Arc, Curve, sample
from assistant.sources.contours.work_words import (
    names_work,
    plain_name,
    plain_word,
    words_of_name,
)
from assistant.sources.drawing.balloons import find_balloons
from assistant.sources.drawing.extension_lines import ExtensionLines, find_extension_lines
from assistant.sources.drawing.findings import (
    DRAFTING,
    DRAFTING_FOLLOWED,
    ENDS_ON_BORDER,
    MAY_BE_EXTENSION_LINES,
    MAY_BE_SHEET,
    shown,
)
from assistant.sources.drawing.sheets import Sheet, find_sheets
from assistant.sources.drawing.traversal import CONTINUOUS, PlacedEntity
from assistant.sources.process import LeftOut, Process, matches_any

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfentity import DXFEntity

_WORDS: Final[Mapping[str, str]] = {
    "border": """
        border borders drawingborder sheetborder titleborder drawingframe sheetframe pageframe
        titleframe paperborder
        rahmen zeichnungsrahmen blattrahmen blattrand zeichnungsrand
        bordure encadrement cadredessin
        recuadro marcodibujo
        squadratura cornicedisegno
        図枠 用紙枠
        рамка 图框
    """,
    "title block": """
        title titles titleblock titleblk ttlb tblock
        schriftfeld schriftkopf plankopf titelblock titelfeld stueckliste
        cartouche cartouches nomenclature
        cajetin rotulo
        cartiglio
        表題欄 部品表
        штамп 标题栏 明细栏 明细表
    """,
    "centre line": """
        centerline centreline centermark centremark
        mittellinie mittelachse symmetrielinie symmetrieachse
        traitaxe lignecentre lignesaxes
        lineacentro ejesimetria
        mezzeria lineaasse assesimmetria
        中心線 一点鎖線
        осевая осевые осевыелинии 中心线 点画线 点划线
    """,
    "hidden line": """
        hidden hiddenedge hiddenedges invisible
        verdeckt verdeckte unsichtbar unsichtbare
        cache caches cachee cachees
        oculto oculta ocultos ocultas
        nascosto nascosta nascosti nascoste
        隠れ線 隠線 かくれ線 破線
        невидимая невидимые невидимыелинии 虚线 隐藏线
    """,
    "phantom line": """
        phantom
        fantome
        想像線 二点鎖線
        双点画线 双点划线
    """,
    "thin line": "细实线 波浪线",
    "symbol": """
        roughness surfacefinish datumsymbol rou
        rauheit oberflaechenzeichen rugosite rugosidad rugosita
        шероховатость 粗糙度 表面粗さ
    """,
    "dimension": """
        dims dimension dimensions dimensioning dimline leader leaders
        bemassung bemassungen masslinie masszahl massangabe
        cotation cotations
        acotado acotacion acotaciones dimensiones
        quotatura quotature dimensioni
        寸法 引出線
        размер размеры выноска выноски 尺寸 标注 引线
    """,
    "construction": """
        construction constructionline constructiongeometry sketchgeometry
        hilfslinie hilfsgeometrie hilfskonstruktion konstruktionslinie konstruktionsgeometrie
        lignesconstruction
        construccion auxiliar auxiliares
        costruzione ausiliario ausiliaria ausiliari ausiliarie
        補助線 作図線
        вспомогательная вспомогательные 辅助线 构造线
    """,
    "hatch": """
        hatch hatches hatching crosshatch crosshatching sectionlining
        schraffur schraffuren schraffierung
        hachure hachures hachurage
        sombreado rayado
        campitura campiture retino
        ハッチ
        штриховка 剖面线 填充
    """,
    "construction points of dimensions": "defpoints",
}
_WEAK_WORDS: Final[Mapping[str, str]] = {
    "border": "frame cadre marco cornice",
    "centre line": """
        center centre centers centres cl axis axes mitte achse achsen axe eje ejes asse assi
        centro centri 中心
    """,
    "dimension": "dim cote cotes cota cotas quota quote masse anno annotation annotations",
}
"""Words that parts have as well."""
_NEUTRAL_WORDS: Final = """
    line lines linie linien ligne lignes linea lineas linee trait traits d de des du di del dela la
    le les layer layers ebene calque capa livello mark marks iso din ansi jis gost narrow thin wide
    schmal iv arc arcs circle geometry geometrie geometria of the 線
"""
"""Words that say nothing about what a layer is for."""
_SUFFIXES: Final = ("lines", "line", "linien", "linie", "layer", "marks", "mark", "n", "s", "線")
"""Endings with which a word is still that word."""
_LINE_TYPES: Final[Mapping[str, str]] = {
    "centre line": """
        CENTER CENTRE CENTERLINE CENTRELINE CHAIN DASHDOT DASH_DOT LONG_DASH_DOT MITTE MITTELLINIE
        STRICHPUNKT AXES AXE TIRETPT CENTRO TRAZO_Y_PUNTO ASSE TRATTOPUNTO 中心線 一点鎖線
    """,
    "hidden line": """
        HIDDEN DASHED DASH DASHES DASHED_SPACE VERDECKT GESTRICHELT STRICHLINIE CACHE INTERROMPU
        TIRETE OCULTA OCULTAS LINEAS_OCULTAS TRAZOS NASCOSTA TRATTEGGIATA 隠れ線 破線
    """,
    "phantom line": """
        PHANTOM DOUBLE_DASH_CHAIN DIVIDE DASHDOTDOT LONG_DASH_DOUBLE_DOT GETRENNT FANTOME DIVISE
        FANTASMA DIVIDI 想像線 二点鎖線
    """,
    "dotted line": "DOT DOTS DOTTED PUNKT PUNKTIERT POINTILLE PUNTOS PUNTO 点線",
    "border line": "BORDER RAND BORDURE BORDE BORDO",
}
_LINE_TYPE_PREFIX: Final = re.compile(r"(?:SLD|SE|ISO|ACAD|AM|SW)[-_ ]")
_LINE_TYPE_SUFFIX: Final = re.compile(r"[-_ ]*(?:X?2|\(?\.5X\)?|\(?2X\)?|_?TINY|SMALL)$")
_NUMBERED_LINE_TYPE: Final = re.compile(r"ACAD_ISO(?:0[2-9]|1[0-5])W100|JIS_0[289].*")
"""Line types of standards that are known by numbers; all of them have gaps."""
_ANONYMOUS_BLOCKS: Final[Mapping[str, str]] = {
    "*d": "dimension",
    "*x": "hatch",
    "*t": "title block",
}
"""What CAD systems put into blocks without a name, by the start of what they call these."""
_NUMBERED_BLOCK: Final = re.compile(r"([A-Za-z]+)-\d+-\d+(?: - \d+)?")
"""Blocks of systems for steelwork: the kind of an object with the numbers of drawing and object."""
_NUMBERED_BLOCKS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("mark", "sectionmark", "detailmark", "levelmark", "weldmark"), "symbol"),
    **dict.fromkeys(("text", "unknown"), "text"),
}
"""What is in them that is not work; `unknown` has titles and tables of the form."""


def _by_word(table: Mapping[str, str]) -> dict[str, str]:
    return {plain_word(word): kind for kind, words in table.items() for word in words.split()}


_KINDS: Final = _by_word(_WORDS)
_WEAK_KINDS: Final = _by_word(_WEAK_WORDS)
_LINE_TYPE_KINDS: Final = _by_word(_LINE_TYPES)
_NEUTRAL: Final = frozenset(map(plain_word, _NEUTRAL_WORDS.split()))
_WITHOUT_SPACES: Final = tuple(word for word in _KINDS if not word.isascii())
"""Words of a language that is written without spaces: they count anywhere in a name."""


@cache
def layer_kind(name: str) -> str:
    """What is drawn on a layer or in a block of this name, empty if it may be work."""
    if names_work(name):
        return ""
    plain = plain_name(name)
    words = words_of_name(name)
    # `Title Block`, `center-line`: two words that are one in the table.
    pairs = [a + b for a, b in pairwise(words)]
    for word in (*words, *pairs):
        if kind := _kind_in(_KINDS, word):
            return kind
    for word in _WITHOUT_SPACES:
        if word in plain:
            return _KINDS[word]
    meaning = [word for word in words if word not in _NEUTRAL and len(word) > 1]
    kinds = {_kind_in(_WEAK_KINDS, word) for word in meaning}
    return kinds.pop() if len(kinds) == 1 else ""


def _kind_in(table: Mapping[str, str], word: str) -> str:
    """The kind of a word, with or without an ending."""
    stems = [word, *(word.removesuffix(end) for end in _SUFFIXES if word.endswith(end))]
    return next((table[stem] for stem in stems if stem in table), "")


@cache
def block_kind(name: str) -> str:
    """What a block of this name is, empty if it may be work."""
    numbered = _NUMBERED_BLOCK.fullmatch(name)
    kind = _NUMBERED_BLOCKS.get(numbered[1].lower(), "") if numbered else ""
    return kind or _ANONYMOUS_BLOCKS.get(name[:2].lower(), "") or layer_kind(name)


@cache
def line_type_kind(name: str) -> str:
    """What a line type of this name is for, empty if it may be of edges."""
    upper = unicodedata.normalize("NFKC", name).upper().strip()
    if _NUMBERED_LINE_TYPE.fullmatch(upper):
        return "broken line"
    plain = _LINE_TYPE_SUFFIX.sub("", _LINE_TYPE_PREFIX.sub("", upper)).replace(" ", "_")
    return _LINE_TYPE_KINDS.get(plain_word(plain), "") or (
        "hidden line" if plain.startswith(("HIDDEN_", "DASHED_")) else ""
    )


def line_type_kinds(document: Drawing) -> dict[str, str]:
    """What the line types of a document are for, by their names in small letters, if it is not
    edges.
    """
    kinds = {}
    for one in document.linetypes:
        name = str(one.dxf.name)
        gaps = any(tag.code == _DASH_LENGTH and tag.value < 0.0 for tag in one.pattern_tags.tags)
        kind = line_type_kind(name) or ("broken line" if gaps else "")
        if kind:
            kinds[name.casefold()] = kind
    return kinds


def symbol_blocks(document: Drawing) -> frozenset[str]:
    """Return the blocks, in small letters, that are symbols with a text, such as the letter of a
    datum: drafting on a layer for it, but for a bar or two on a layer of thick lines.
    """
    found = set()
    for block in document.blocks:
        by_kind: dict[str, list[DXFEntity]] = defaultdict(list)
        for one in block:
            by_kind[one.dxftype()].append(one)
        if "ATTDEF" not in by_kind or "INSERT" in by_kind:
            continue
        drawn = [one for kind in _CURVE_TYPES for one in by_kind[kind]]
        bars = [one for one in drawn if not layer_kind(str(one.dxf.layer))]
        if not 1 <= len(bars) <= _MOST_BARS or len(bars) == len(drawn):
            continue
        if any(names_work(str(one.dxf.layer)) for one in bars):
            continue
        height = max(float(one.dxf.get("height", 0.0)) for one in by_kind["ATTDEF"])
        if all(
            one.dxftype() == "LINE" and one.dxf.start.distance(one.dxf.end) <= _BAR_PART * height
            for one in bars
        ):
            found.add(str(block.name).casefold())
    return frozenset(found)


_CURVE_TYPES: Final = ("LINE", "ARC", "CIRCLE", "LWPOLYLINE", "POLYLINE", "SPLINE", "ELLIPSE")
_MOST_BARS: Final = 2
"""Lines of a symbol that are on no layer for drafting, at most."""
_BAR_PART: Final = 3.0
"""Length of such a line by the height of the text, at most."""
BORDER: Final = "border"
"""Name under `follow` and `leave_out` of what is known by its shape."""
_DASH_LENGTH: Final = 49
"""Group code of a dash's length, below 0 for a gap."""
_MOST_LISTED: Final = 12
"""Names that one finding lists."""


@dataclass(frozen=True, slots=True)
class Reason:
    """Why an entity is drafting. what: `layer`, `block`, `line type` or `border`, which is known
    by its shape. kind: what it is for.
    """

    what: str
    name: str
    kind: str


_ON_LINE: Final = 0.05
"""mm from a line within which a point is on it."""


@dataclass(slots=True)
class Drafting:
    """Which entities of a document are drafting; counts them while it is asked.

    aside: entities by reason. followed: those that are followed because the process file names
    their layer, by reason and layer. ending: lines on the border of a sheet that are followed: the
    sheet, the first one's layer, the middle (n, 2) of each, mm in the drawing's world.
    """

    process: Process
    line_types: Mapping[str, str]
    layer_types: Mapping[str, str]
    aside: dict[Reason, int] = field(default_factory=dict)
    followed: dict[tuple[Reason, str], int] = field(default_factory=dict)
    undecided: list[Sheet] = field(default_factory=list)
    ending: list[tuple[Sheet, str, Floats]] = field(default_factory=list)
    symbols: frozenset[str] = frozenset()
    extensions: Mapping[str, ExtensionLines] = field(default_factory=dict)
    """By the layer in small letters, what runs along extension lines of its dimensions."""
    _stated: frozenset[str] = frozenset()

    @staticmethod
    def of(document: Drawing, process: Process) -> Drafting:
        layers = {str(one.dxf.name).lower(): str(one.dxf.linetype) for one in document.layers}
        stated = frozenset(name.casefold() for name in process.layers)
        kinds, symbols = line_type_kinds(document), symbol_blocks(document)
        lines = {one.layer.casefold(): one for one in find_extension_lines(document.modelspace())}
        return Drafting(process, kinds, layers, symbols=symbols, extensions=lines, _stated=stated)

    def of_layer(self, layer: str) -> str:
        """What a layer is for, empty if the process file names it or it may be work."""
        return "" if self._is_named(layer) else layer_kind(layer)

    def of_line_type(self, line_type: str) -> str:
        """The same of a line type."""
        if matches_any(self.process.follow, line_type):
            return ""
        return self.line_types.get(line_type.casefold(), "") or line_type_kind(line_type)

    def leaves_out(self, placed: PlacedEntity) -> bool:
        """True if an entity is drafting, or if the process file leaves its line type out."""
        if self.process.leaves_out(placed.layer):
            return False  # it is left out anyway, by who reads it
        if self.process.leaves_out_part(placed.layer, placed.line_type, placed.blocks):
            return True
        return self.reason(placed) is not None

    def reason(self, placed: PlacedEntity) -> Reason | None:
        """Why an entity is drafting, None if it may be work; it is counted."""
        layer = placed.layer
        if kind := self.of_layer(layer):
            reason: Reason | None = Reason("layer", layer, kind)
        elif self._is_extension_line(placed):
            reason = Reason("layer", layer, "extension lines of dimensions")
        else:
            reason = self._reason_beside_layer(placed)
        if reason is None:
            return None
        if not self._is_named(layer):
            self.aside[reason] = self.aside.get(reason, 0) + 1
            return reason
        key = reason, layer
        self.followed[key] = self.followed.get(key, 0) + 1
        return None

    def borders(
        self, curves: Sequence[Curve], aside: Sequence[Curve], texts: Sequence[Floats]
    ) -> dict[int, Reason]:
        """Curves of borders, title blocks and balloons, known by their shape, by row; counted.

        aside: those that are drafting by their names, which may be a part of a border. texts: where
        annotations of the drawing are. What may be a part as well is a finding.
        """
        if matches_any(self.process.follow, BORDER):
            return {}
        rows = [
            row
            for row, curve in enumerate(curves)
            if not matches_any(self.process.follow, curve.layer)
            and not self.process.leaves_out(curve.layer)
        ]
        placement = self.process.placement
        back = Pose() if placement is None else placement.inverse()
        places = np.array(texts).reshape(-1, 3)
        there = back.moved(places[np.isfinite(places).all(axis=1)])[:, :2]
        found: dict[int, Reason] = {}
        tables = self._stated
        given = [curves[row] for row in rows]
        for sheet in find_sheets(given, aside, there, back, annotated=bool(texts)):
            own = [rows[row] for row in sheet.rows if row < len(rows)]
            if not own:
                continue
            if not sheet.sure and not matches_any(self.process.leave_out, BORDER):
                if not tables or any(curves[row].layer.casefold() in tables for row in own):
                    self.undecided.append(sheet)
                continue
            reason = Reason(BORDER, f"{sheet.text} mm", sheet.what)
            found |= dict.fromkeys(own, reason)
            self.aside[reason] = self.aside.get(reason, 0) + len(own)
            ends = sorted(rows[row] for row in sheet.ending if row < len(rows))
            ends = [
                row
                for row in ends
                if (not tables or curves[row].layer.casefold() in tables)
                and not self._is_left_out(curves[row], back)
            ]
            if ends:
                middle = back.moved(sample([curves[row] for row in ends], (0.5,))[:, 0])[:, :2]
                self.ending.append((sheet, curves[ends[0]].layer, middle))
        for balloons in find_balloons(given, aside, there, back):
            own = [row for row in (rows[each] for each in balloons) if row not in found]
            if not own:
                continue
            radius = cast("Arc", curves[own[0]]).radius
            reason = Reason(BORDER, f"⌀{2.0 * radius:.4g} mm", "balloons around texts")
            found |= dict.fromkeys(own, reason)
            self.aside[reason] = self.aside.get(reason, 0) + len(own)
        return found

    def _is_left_out(self, line: Curve, back: Pose) -> bool:
        """True if the process file leaves a line along an axis out by a point on it."""
        ends = back.moved(sample([line], (0.0, 1.0))[0])[:, :2]
        low, high = ends.min(axis=0) - _ON_LINE, ends.max(axis=0) + _ON_LINE
        return any(
            one.at is not None
            and one.concerns(line.layer)
            and bool(((one.at >= low) & (one.at <= high)).all())
            for one in self.process.left_out
        )

    def _is_extension_line(self, placed: PlacedEntity) -> bool:
        known = self.extensions.get(placed.layer.casefold())
        return (
            known is not None
            and known.sure
            and not placed.blocks
            and placed.entity.dxf.handle in known.handles
            and not self._is_named(placed.layer)
        )

    def _is_named(self, layer: str) -> bool:
        return layer.casefold() in self._stated or matches_any(self.process.follow, layer)

    def _is_decided(self, layer: str) -> bool:
        """True if the process file names a layer, or its name says what it is for."""
        return (
            self._is_named(layer)
            or self.process.leaves_out(layer)
            or bool(layer_kind(layer))
            or names_work(layer)
        )

    def _reason_beside_layer(self, placed: PlacedEntity) -> Reason | None:
        for block in placed.blocks:
            kind = block_kind(block) or ("symbol" if block.casefold() in self.symbols else "")
            if kind and not matches_any(self.process.follow, block):
                return Reason("block", block, kind)
        line_type = placed.line_type
        kind = self.of_line_type(line_type)
        if not kind:
            return None
        own = self.layer_types.get(placed.layer.lower(), CONTINUOUS)
        # Who names a layer means all of it that is drawn as the layer is.
        if line_type.casefold() == own.casefold() and self._is_named(placed.layer):
            return None
        return Reason("line type", line_type, kind)

    def listed(self) -> str:
        """What was left out, for people."""
        rows = [
            f"{one.what} `{shown(one.name)}` ({one.kind}, {count})"
            for one, count in self.aside.items()
        ]
        return _cut(rows)

    def findings(self) -> Iterator[Diagnostic]:
        """One finding about what was left out, one about what the process file follows, and one for
        each sheet that may be a part.
        """
        for lines in self.extensions.values():
            if not (lines.sure or self._stated or self._is_decided(lines.layer)):
                yield MAY_BE_EXTENSION_LINES(
                    count=len(lines.handles),
                    layer=shown(lines.layer),
                    dimensions=lines.dimensions,
                    key=shown(lines.layer),
                )
        for sheet in self.undecided:
            yield MAY_BE_SHEET(size=sheet.text, name=sheet.what)
        for sheet, layer, middles in self.ending:
            x, y = middles[0].round(3).tolist()
            yield ENDS_ON_BORDER(
                count=len(middles),
                size=sheet.text,
                at=f"{x:g}, {y:g}",
                layer=shown(layer),
                entry=LeftOut(layer, at=(x, y)).text,
            )
        if self.aside:
            first = next(iter(self.aside))
            yield DRAFTING(
                count=sum(self.aside.values()), what=self.listed(), cure=self._cure(first)
            )
        if self.followed:
            rows = [
                f"{one.what} `{shown(one.name)}` on layer `{shown(layer)}` ({one.kind}, {count})"
                for (one, layer), count in self.followed.items()
            ]
            one, layer = next(iter(self.followed))
            block, line_type = (one.name, None) if one.what == "block" else (None, one.name)
            entry = LeftOut(layer, line_type, block)
            yield DRAFTING_FOLLOWED(
                count=sum(self.followed.values()), what=_cut(rows), entry=entry.text
            )

    def cure(self) -> str:
        """How the first of what was left out is followed after all."""
        return self._cure(next(iter(self.aside)))

    def _cure(self, one: Reason) -> str:
        if one.what == BORDER:
            return f'write follow = ["{BORDER}"] at the top of the process file'
        if one.what == "layer" and self.process.layers:
            return f'add [layers."{shown(one.name)}"] to the process file for the layer'
        return f'write follow = ["{shown(one.name)}"] at the top of the process file'


def _cut(rows: Sequence[str]) -> str:
    more = f", and {len(rows) - _MOST_LISTED} more" if len(rows) > _MOST_LISTED else ""
    return ", ".join(rows[:_MOST_LISTED]) + more
