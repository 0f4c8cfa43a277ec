"""Cameras from their pictures of a board: lenses, where they stand to each other, and to an arm."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath

import numpy as np

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.calibration.boards import Board, BoardView, find_board
from assistant.vision.calibration.hand_eye import HandEyeFound, Mounting, find_hand_eye
from assistant.vision.calibration.lenses import LensFound, find_lens
from assistant.vision.calibration.pairs import PairFound, find_pair
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.camera_file import CalibrationRecord, Rig
from assistant.vision.cameras.capture import pictures_in, read_picture
from assistant.vision.cameras.pairing import pairing_finding


@dataclass(frozen=True, slots=True, eq=False)
class BoardPictures:
    """Pictures of one camera. views: of each picture, None where the board is not found."""

    name: str
    size: tuple[int, int]
    files: tuple[str, ...]
    views: tuple[BoardView | None, ...]
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class RigFound:
    """lenses, pairs: by camera; pairs to the first one. hand_eye: of the first, where poses were
    given.
    """

    rig: Rig
    lenses: Mapping[str, LensFound]
    pairs: Mapping[str, PairFound]
    hand_eye: HandEyeFound | None
    findings: tuple[Diagnostic, ...]


def find_board_in_folder(board: Board, name: str, folder: str | FilePath) -> BoardPictures:
    """Finds the board in the pictures of a folder; raises Refused for one that holds none."""
    files = pictures_in(folder) if FilePath(folder).is_dir() else []
    if not files:
        raise Refused(rules.NO_PICTURES(name=name, folder=folder), exit_status=2)
    size, views, findings = (0, 0), list[BoardView | None](), list[Diagnostic]()
    for number, file in enumerate(files):
        picture = read_picture(file)
        given = picture.shape[1], picture.shape[0]
        if number and given != size:
            told = [f"{w} × {h}" for w, h in (given, size)]
            finding = rules.UNEQUAL_SIZES(name=file, given=told[0], wanted=told[1])
            raise Refused(finding, exit_status=2)
        size = given
        views.append(find_board(board, picture, str(file)))
        if views[-1] is None:
            findings.append(rules.NO_BOARD(name=file))
    names = tuple(file.name for file in files)
    return BoardPictures(name, size, names, tuple(views), tuple(findings))


def calibrate_rig(
    board: Board,
    looked: Sequence[BoardPictures],
    *,
    flanges: Sequence[Pose] | None = None,
    mounting: Mounting = "stand",
    flange: str = "flange",
    today: datetime.date | None = None,
) -> RigFound:
    """The cameras of a rig, the first one at the world's origin unless the arm tells where it is.

    flanges: poses of the flange in the base, one a picture. mounting: of the first camera, in the
    hand or beside the arm; its pose is then in the flange, or in the base, where the others stand
    as well. flange: how the file calls the flange. Raises Refused where pictures do not tell it.
    """
    if board.turned_alike and (len(looked) > 1 or flanges is not None):
        raise Refused(rules.AMBIGUOUS_BOARD(columns=board.columns, rows=board.rows), exit_status=2)
    findings = [finding for one in looked for finding in one.findings]
    lenses = {
        one.name: find_lens(board, [v for v in one.views if v is not None], one.size, one.name)
        for one in looked
    }
    findings += [finding for found in lenses.values() for finding in found.findings]
    first = looked[0]
    found = _place_on_arm(first, lenses[first.name], flanges, mounting)
    findings += () if found is None else found.findings
    place = Pose() if found is None else found.best.camera
    carried = found is not None and mounting == "hand"
    pairs = {one.name: _place_pair(board, first, one, lenses) for one in looked[1:]}
    findings += [finding for pair in pairs.values() for finding in pair.findings]
    parent = flange if carried else WORLD
    cameras = {first.name: Camera(first.name, lenses[first.name].lens, place, parent)}
    for one in looked[1:]:
        pose = place @ pairs[one.name].pose
        cameras[one.name] = Camera(one.name, lenses[one.name].lens, pose, parent)
    records = _calibration_records(
        lenses, pairs, found, today or datetime.datetime.now().astimezone().date()
    )
    return RigFound(Rig(cameras, records), lenses, pairs, found, tuple(findings))


def _calibration_records(
    lenses: Mapping[str, LensFound],
    pairs: Mapping[str, PairFound],
    hand_eye: HandEyeFound | None,
    day: datetime.date,
) -> dict[str, CalibrationRecord]:
    records = {name: CalibrationRecord(day, round(one.residual, 4)) for name, one in lenses.items()}
    for name, pair in pairs.items():
        records[name] = replace(records[name], pair=round(pair.residual, 4))
    if hand_eye is not None:
        name, best = next(iter(lenses)), hand_eye.best
        mm, degrees = round(best.mm, 4), round(best.degrees, 5)
        records[name] = replace(records[name], mm=mm, degrees=degrees)
    return records


def with_sources(rig: Rig, sources: Mapping[str, str]) -> Rig:
    """The rig with where the pictures of its cameras come from."""
    return replace(rig, sources=dict(sources))


def _place_pair(
    board: Board, first: BoardPictures, other: BoardPictures, lenses: Mapping[str, LensFound]
) -> PairFound:
    if len(first.views) != len(other.views):
        raise Refused(_uneven_views(first, other.name, len(other.views)))
    pairing = pairing_finding(first.name, first.files, other.name, other.files)
    if pairing is not None:
        raise Refused(pairing)
    both = [
        (one, two)
        for one, two in zip(first.views, other.views, strict=True)
        if one is not None and two is not None
    ]
    found = lenses[first.name], lenses[other.name]
    residual = max(one.residual for one in found)
    both_lenses = found[0].lens, found[1].lens
    free = found[0].sigma > 0.0, found[1].sigma > 0.0
    return find_pair(board, both_lenses, both, (first.name, other.name), residual, free)


def _place_on_arm(
    looked: BoardPictures, lens: LensFound, flanges: Sequence[Pose] | None, mounting: Mounting
) -> HandEyeFound | None:
    if flanges is None:
        return None
    if len(flanges) != len(looked.views):
        raise Refused(_uneven_views(looked, "poses of the arm", len(flanges)))
    seen = [i for i, view in enumerate(looked.views) if view is not None]
    names = [f"{i + 1} ({looked.files[i]})" for i in seen]
    focal, centre = max(lens.lens.focal), float(lens.sigma[2:4].max())
    unsure = float(lens.sigma[:2].max()) / focal, float(np.degrees(centre / focal))
    hands = [flanges[i] for i in seen]
    return find_hand_eye(hands, lens.poses, mounting, names, lens.noise_mm, unsure)


def _uneven_views(looked: BoardPictures, others: str, count: int) -> Diagnostic:
    here = len(looked.views)
    return rules.UNEVEN_VIEWS(name=looked.name, others=others, count=here, other=count)
