"""Random contours as CAD systems export them, and what a program in RAPID does about them.

A contour is known by points on its true curve. It is written as entities whose coordinates have a
few decimals, with curves as chords, repeated points and gaps; the DXF text is made here. The
emitted text is read by expressions, and measured with numpy and shapely.
"""

import itertools
import math
import random
import re
from dataclasses import dataclass, field

import numpy as np
import shapely

FINE_STEP = 0.02
"""mm between points of a true curve."""


@dataclass
class Exported:
    """curve: closed points (n, 2). corners: (point, whether it turns left) where it truly turns."""

    curve: np.ndarray
    corners: list = field(default_factory=list)
    entities: list = field(default_factory=list)


@dataclass
class Way:
    """points: (n, 2) along a way, arcs in chords. targets: (m, 2) of its moves, the start first.
    stops: targets inside of it at which the arm stops.
    """

    points: np.ndarray
    targets: np.ndarray
    stops: np.ndarray


def rounded_polygon(rng, x, y, size, sharpest):
    """Straight sides; corners that turn much stay sharp, others are rounded."""
    count = rng.randrange(3, 8)
    while True:
        turn = rng.uniform(0.0, math.tau)
        angles = [turn + math.tau * (i + rng.uniform(-0.25, 0.25)) / count for i in range(count)]
        far = [size * rng.uniform(0.45, 1.0) for _ in range(count)]
        points = [complex(x, y) + f * complex(math.cos(a), math.sin(a))
                  for f, a in zip(far, angles, strict=True)]  # fmt: skip
        before = points[-1:] + points[:-1]
        after = points[1:] + points[:1]
        turns = [
            math.degrees(math.atan2(*reversed(_parts((c - b) / (b - a)))))
            for a, b, c in zip(before, points, after, strict=True)
        ]
        if min(abs(b - a) for a, b in zip(before, points, strict=True)) > 0.3 * size:
            break
    parts, corners = [], []
    for (a, b, c), bend in zip(zip(before, points, after, strict=True), turns, strict=True):
        if abs(bend) > sharpest:
            corners.append(((b.real, b.imag), bend > 0.0))
            parts.append(("point", b))
            continue
        half = math.tan(math.radians(abs(bend) / 2.0))
        most = 0.4 * min(abs(b - a), abs(c - b))
        radius = min(rng.uniform(3.0, 9.0), most / half if half else 9.0)
        if radius < 2.5:
            return rounded_polygon(rng, x, y, size, sharpest)
        back, on = (a - b) / abs(a - b), (c - b) / abs(c - b)
        start, end = b + back * radius * half, b + on * radius * half
        centre = start + back * (1j if bend < 0.0 else -1j) * radius
        parts.append(("arc", start, end, centre, radius, bend))
    return parts, corners


def _parts(z):
    return z.real, z.imag


def smooth(rng, x, y, size):
    """Points on a wavy closed curve, an ellipse or a circle."""
    kind = rng.randrange(3)
    angle = np.linspace(0.0, math.tau, rng.choice([90, 360, 1200, 4000]), endpoint=False)
    if kind == 0:
        far = size * (0.75 + 0.12 * np.sin(rng.randrange(2, 6) * angle))
        points = np.stack([far * np.cos(angle), far * np.sin(angle)], axis=1)
    else:
        flat = 1.0 if kind == 1 else rng.uniform(0.5, 0.9)
        points = 0.8 * size * np.stack([np.cos(angle), flat * np.sin(angle)], axis=1)
    return points + np.array([x, y])


def exported(rng, x, y, size, tolerance, sharpest=85.0):
    """One contour at a place, with its entities."""
    decimals = rng.randrange(3, 7)
    gap = rng.choice([0.0, 1e-4, 1e-3, 0.6 * tolerance])
    if rng.random() < 0.35:
        points = smooth(rng, x, y, size)
        made = Exported(np.vstack([points, points[:1]]))
        chain = [("line", a, b) for a, b in zip(points, np.roll(points, -1, axis=0), strict=True)]
    else:
        parts, corners = rounded_polygon(rng, x, y, size, sharpest)
        chain, curve = [], []
        as_chords = rng.random() < 0.5
        for part, following in zip(parts, parts[1:] + parts[:1], strict=True):
            here = part[1] if part[0] == "point" else part[2]
            if part[0] == "arc":
                bow = _bow(part, FINE_STEP)
                curve += bow
                if as_chords:
                    bow = _bow(part, rng.choice([0.01, 0.05, 0.2]))
                    chain += [("line", _xy(a), _xy(b)) for a, b in itertools.pairwise(bow)]
                else:
                    chain.append(part)
            else:
                curve.append(here)
            chain.append(("line", _xy(here), _xy(following[1])))
        points = np.array([_xy(p) for p in curve])
        made = Exported(np.vstack([points, points[:1]]), corners)
    made.entities = _written(rng, chain, decimals, gap)
    return made


def _xy(z):
    return np.array([z.real, z.imag])


def _bow(part, step):
    """Complex points of an arc, its ends among them."""
    _, start, end, centre, radius, bend = part
    count = max(math.ceil(math.radians(abs(bend)) * radius / step), 2)
    turns = [math.radians(bend) * i / count for i in range(count)]
    return [centre + (start - centre) * complex(math.cos(t), math.sin(t)) for t in turns] + [end]


def _written(rng, chain, decimals, gap):
    """Entities as DXF text: rounded, some of them turned, repeated points and gaps between."""
    made = []
    gaps = set(rng.sample(range(len(chain)), min(3, len(chain) // 3)))
    for i, part in enumerate(chain):
        if part[0] == "line":
            a, b = part[1:]
            length = float(np.hypot(*(b - a)))
            if gap and i in gaps and length > 4.0 * gap:
                a = a + (b - a) * (gap / length)
            if rng.random() < 0.05:  # a point again, or a little beside it
                beside = a + np.array([rng.choice([0.0, 10.0**-decimals]), 0.0])
                made.append(_line(a, beside, decimals))
                a = rng.choice([a, beside])
            ends = (a, b) if rng.random() < 0.5 else (b, a)
            made.append(_line(*ends, decimals))
        else:
            made.append(_arc(part, decimals))
    if len(made) < 60:
        rng.shuffle(made)
    return made


def _line(a, b, decimals):
    numbers = zip((10, 20, 30, 11, 21, 31), (*a, 0.0, *b, 0.0), strict=True)
    return "0\nLINE\n8\nCUT\n" + "".join(f"{c}\n{v:.{decimals}f}\n" for c, v in numbers)


def _arc(part, decimals):
    _, start, end, centre, radius, bend = part
    first, last = (start, end) if bend > 0.0 else (end, start)
    angles = [
        math.degrees(math.atan2((p - centre).imag, (p - centre).real)) % 360.0
        for p in (first, last)
    ]
    numbers = zip((10, 20, 30, 40), (centre.real, centre.imag, 0.0, radius), strict=True)
    text = "".join(f"{c}\n{v:.{decimals}f}\n" for c, v in numbers)
    turned = "".join(f"{c}\n{v:.{decimals + 1}f}\n" for c, v in zip((50, 51), angles, strict=True))
    return f"0\nARC\n8\nCUT\n{text}{turned}"


def drawing(contours):
    """DXF text with all of the contours."""
    body = "".join(entity for contour in contours for entity in contour.entities)
    head = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n"
    return f"{head}0\nSECTION\n2\nENTITIES\n{body}0\nENDSEC\n0\nEOF\n"


def sheet(seed, count, tolerance):
    """Contours in a grid, far enough apart for any offset."""
    rng = random.Random(seed)
    return [
        exported(rng, 90.0 * (i % 5) - 180.0, 90.0 * (i // 5), rng.uniform(18.0, 38.0), tolerance)
        for i in range(count)
    ]


TARGET = re.compile(r"robtarget (\w+):=\[\[([^\]]*)\]")
MOVE = re.compile(r"Move([LJC]) (RelTool\(\w+,[^)]*\)|\w+)(?:,(\w+))?,v\w+,(\w+),")


def ways(text):
    """The ways between retracts of a module in RAPID."""
    places = {n: np.array(p.split(","), dtype=float)[:2] for n, p in TARGET.findall(text)}
    found, way = [], []
    for kind, first, second, zone in MOVE.findall(text):
        if first.startswith("RelTool"):
            if len(way) > 1:
                found.append(_way(way))
            way = []
        else:
            via = places[first] if kind == "C" else None
            way.append((via, places[second or first], zone))
    return found


def _way(moves):
    points, targets = [moves[0][1]], [moves[0][1]]
    for via, target, _ in moves[1:]:
        points += [target] if via is None else arc_points(points[-1], via, target)
        targets.append(target)
    stops = [target for _, target, zone in moves[1:-1] if zone == "fine"]
    return Way(np.array(points), np.array(targets), np.array(stops).reshape(-1, 2))


def arc_points(start, via, end):
    """Points on the circle through three, after the first."""
    a, b, c = (complex(*p) for p in (start, via, end))
    w = (c - a) / (b - a)
    centre = a + (b - a) * (w - abs(w) ** 2) / (w - w.conjugate())
    angles = np.unwrap(np.angle([a - centre, b - centre, c - centre]))
    whole = angles[2] - angles[0]
    count = max(math.ceil(abs(whole) * abs(a - centre) / 0.1), 2)
    turns = np.exp(1j * whole * np.arange(1, count + 1) / count)
    along = centre + (a - centre) * turns
    return [*np.stack([along.real, along.imag], axis=1)[:-1], np.asarray(end)]


def shortest_move(way):
    return float(np.hypot(*np.diff(way.targets, axis=0).T).min())


def apart(points, line):
    """Distances (n,) of points from a polyline."""
    tree = shapely.STRtree(shapely.linestrings(np.stack([line[:-1], line[1:]], axis=1)))
    return tree.query_nearest(shapely.points(points), all_matches=False, return_distance=True)[1]


def dense(points, step=0.05):
    return shapely.get_coordinates(shapely.LineString(points).segmentize(step))
