"""Boards that cameras are calibrated with: chessboards, and ChArUco boards with known corners.

`chessboard 9x6 25`: 9 × 6 inner corners, squares of 25 mm.
`charuco 7x5 40 30`: 7 × 5 squares of 40 mm with markers of 30 mm, of the dictionary 5X5_100 or the
one that is named behind.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.cameras.drawing import Picture
from assistant.vision.opencv import opencv, silent

USUAL_DICTIONARY: Final = "5X5_100"
BOARD_TEXT: Final = re.compile(
    r"(?P<kind>chessboard|charuco) (?P<columns>\d{1,3})x(?P<rows>\d{1,3}) (?P<square>\d+(?:\.\d+)?)"
    r"(?: (?P<marker>\d+(?:\.\d+)?))?(?: (?P<dictionary>[4-7]X[4-7]_(?:50|100|250|1000)))?"
)
BOARD_EXAMPLES: Final = "write `chessboard 9x6 25`, or `charuco 7x5 40 30`"
FEWEST_CORNERS: Final = 6
"""Corners of a view that counts."""


@dataclass(frozen=True, slots=True)
class Board:
    """columns, rows: inner corners of a chessboard, squares of a ChArUco board. square, marker: mm,
    edges.
    """

    kind: Literal["chessboard", "charuco"]
    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = USUAL_DICTIONARY

    @staticmethod
    def parse(text: str) -> Board:
        """What a text says; raises Refused (exit status 2)."""
        found = BOARD_TEXT.fullmatch(" ".join(text.split()))
        if found is None:
            raise _bad_board(text, "it is none of the two forms", BOARD_EXAMPLES)
        columns, rows = int(found["columns"]), int(found["rows"])
        square, marker = float(found["square"]), float(found["marker"] or 0.0)
        charuco = found["kind"] == "charuco"
        if not (3 <= columns <= 60 and 3 <= rows <= 60 and 0.1 <= square <= 1000.0):
            raise _bad_board(text, "its numbers are those of no board", BOARD_EXAMPLES)
        if charuco != (0.0 < marker < square):
            raise _bad_board(
                text, "a marker is smaller than its square, and only ChArUco has it", BOARD_EXAMPLES
            )
        if not charuco and found["dictionary"]:
            raise _bad_board(text, "a chessboard has no dictionary", BOARD_EXAMPLES)
        named = found["dictionary"] or USUAL_DICTIONARY
        if charuco and columns * rows // 2 > int(named.partition("_")[2]):
            raise _bad_board(text, f"it has more markers than {named}", "name a larger dictionary")
        kind: Literal["chessboard", "charuco"] = "charuco" if charuco else "chessboard"
        return Board(kind, columns, rows, square, marker, named)

    @property
    def across(self) -> tuple[int, int]:
        """Inner corners, along the rows and down."""
        less = 1 if self.kind == "charuco" else 0
        return self.columns - less, self.rows - less

    @property
    def corners(self) -> Floats:
        """(n, 3) mm of its inner corners; x along the rows from the first one, y down them."""
        columns, rows = self.across
        u, v = np.meshgrid(np.arange(columns), np.arange(rows))
        flat = np.column_stack([u.ravel(), v.ravel(), np.zeros(u.size)]).astype(np.float64)
        return np.asarray(flat * self.square)

    def picture(self, dots: int = 60) -> Picture:
        """The board to print or to draw, so many dots a square, without a margin (ChArUco).

        A chessboard has one square more than corners each way.
        """
        cv = opencv()
        if self.kind == "charuco":
            size = self.columns * dots, self.rows * dots
            drawn = self._opencv(cv).generateImage(size, marginSize=0)
            return np.repeat(np.asarray(drawn)[..., None], 3, axis=2)
        squares = np.indices((self.rows + 1, self.columns + 1)).sum(axis=0) % 2
        drawn = np.kron(squares, np.ones((dots, dots))) * 255
        return np.repeat(drawn.astype(np.uint8)[..., None], 3, axis=2)

    @property
    def turned_alike(self) -> bool:
        """Whether it looks the same when it is turned by half a turn: its corners are not told
        apart then.
        """
        return self.kind == "chessboard" and (self.columns + self.rows) % 2 == 0

    @property
    def size(self) -> tuple[float, float]:
        """Mm of `picture`."""
        more = 0 if self.kind == "charuco" else 1
        return (self.columns + more) * self.square, (self.rows + more) * self.square

    @property
    def on_card(self) -> Pose:
        """Its frame, x along the rows and y down them, in that of a card with its picture."""
        width, height = self.size
        return Pose(
            (self.square - width / 2.0, height / 2.0 - self.square, 0.0), (0.0, 1.0, 0.0, 0.0)
        )

    def _opencv(self, cv: Any) -> Any:
        named = cv.aruco.getPredefinedDictionary(getattr(cv.aruco, f"DICT_{self.dictionary}"))
        squares = self.columns, self.rows
        with silent():  # it would say that markers are large for their squares
            return cv.aruco.CharucoBoard(squares, self.square, self.marker, named)


@dataclass(frozen=True, slots=True, eq=False)
class BoardView:
    """Corners of a board in a picture. rows: (n,) of `Board.corners`. pixels: (n, 2)."""

    name: str
    rows: Rows
    pixels: Floats


def find_board(board: Board, picture: Picture, name: str) -> BoardView | None:
    """The board in a picture, None if it is not seen; raises Refused for a mirrored one."""
    cv = opencv()
    grey = cv.cvtColor(picture, cv.COLOR_BGR2GRAY)
    found = (
        _find_charuco(cv, board, grey)
        if board.kind == "charuco"
        else _find_chessboard(cv, board, grey)
    )
    if found is None:
        if board.kind == "charuco":
            mirror = _find_charuco(cv, board, np.ascontiguousarray(grey[:, ::-1]))
            if mirror is not None:
                raise Refused(rules.MIRRORED_BOARD(name=name))
        return None
    rows, pixels = found
    return BoardView(name, rows, pixels)


def _find_charuco(cv: Any, board: Board, grey: Any) -> tuple[Rows, Floats] | None:
    detector = cv.aruco.CharucoDetector(board._opencv(cv))
    corners, ids, _, _ = detector.detectBoard(grey)
    if ids is None or len(ids) < FEWEST_CORNERS:
        return None
    rows = np.asarray(ids).ravel().astype(np.intp)
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    flat = np.ptp(board.corners[rows], axis=0)[:2].min() <= 0.0
    return None if flat else (rows, pixels)


def _find_chessboard(cv: Any, board: Board, grey: Any) -> tuple[Rows, Floats] | None:
    found, corners = cv.findChessboardCornersSB(grey, board.across)
    if not found:
        return None
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    return np.arange(len(pixels), dtype=np.intp), pixels


def _bad_board(text: str, reason: str, cure: str) -> Refused:
    shown = "".join(c if c.isprintable() else "?" for c in text)[:60]
    return Refused(rules.BAD_BOARD(text=shown, reason=reason, cure=cure), exit_status=2)
