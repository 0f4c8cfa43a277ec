"""Random closed contours in each other, and what programs do about them, by other means: polygon
arithmetic of pyclipper, and points read out of the emitted text.
"""

import math
import random
import re
from dataclasses import dataclass

import ezdxf
import numpy as np
import pyclipper

SCALE = 1e4
"""Whole numbers of pyclipper in a mm."""


@dataclass
class Drawn:
    """outline: (n, 2) mm, chords at most a micrometre off. holder: row of the one around it."""

    outline: np.ndarray
    holder: int
    depth: int


def nested(seed, count):
    """Contours, and a DXF document with them: circles, stars, and boxes with bulges."""
    rng = random.Random(seed)
    found, entities = [], []

    def put(x, y, size, holder, depth):
        if len(found) >= count or size < 13.0:
            return
        kind, row = rng.randrange(4), len(found)
        if kind == 0:
            inner = size * 0.9
            entities.append((x, y, inner))
            found.append(Drawn(circle(x, y, inner), holder, depth))
        elif kind == 1:
            half = size * 0.62
            bulges = (0.0, 0.3, 0.0, -0.2)
            corners = [(x - half, y - half), (x + half, y - half)]
            corners += [(x + half, y + half), (x - half, y + half)]
            inner = half * 0.85
            entities.append([(*c, b) for c, b in zip(corners, bulges, strict=True)])
            found.append(Drawn(with_bulges(entities[-1]), holder, depth))
        else:
            n, first = rng.randrange(4, 11), rng.uniform(0.0, math.tau)
            angles = [first + math.tau * i / n for i in range(n)]
            far = [size * rng.uniform(0.75, 1.0) for _ in range(n)]
            points = [
                (x + f * math.cos(a), y + f * math.sin(a)) for f, a in zip(far, angles, strict=True)
            ]
            inner = size * 0.75 * math.cos(math.pi / 4.0) * 0.9
            entities.append([(*p, 0.0) for p in points])
            found.append(Drawn(np.array(points), holder, depth))
        if rng.random() < 0.6:
            put(x, y, inner - 12.0, row, depth + 1)
        else:
            half = (inner - 12.0) / 2.0 - 5.0
            put(x - half - 5.0, y, half, row, depth + 1)
            put(x + half + 5.0, y, half, row, depth + 1)

    place = 0
    while len(found) < count:
        x, y = 100.0 + place % 6 * 140.0, -350.0 + place // 6 * 140.0
        put(x, y, rng.uniform(24.0, 64.0), -1, 0)
        place += 1
    document = ezdxf.new(units=4)
    space, layer = document.modelspace(), {"layer": "CUT"}
    for entity in rng.sample(entities, len(entities)):
        if isinstance(entity, tuple):
            space.add_circle(entity[:2], entity[2], dxfattribs=layer)
        else:
            space.add_lwpolyline(entity, format="xyb", close=True, dxfattribs=layer)
    return found, document


def circle(x, y, radius):
    angle = np.linspace(0.0, math.tau, 1440, endpoint=False)
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)


def with_bulges(corners):
    """A polyline of DXF: a bulge is the tangent of a quarter of the angle of its arc."""
    points = []
    for (x0, y0, bulge), (x1, y1, _) in zip(corners, corners[1:] + corners[:1], strict=True):
        if not bulge:
            points.append((x0, y0))
            continue
        turn = 4.0 * math.atan(bulge)
        a, b = complex(x0, y0), complex(x1, y1)
        centre = a + (b - a) / (1.0 - complex(math.cos(turn), math.sin(turn)))
        for part in np.linspace(0.0, 1.0, 200, endpoint=False):
            p = centre + (a - centre) * complex(math.cos(part * turn), math.sin(part * turn))
            points.append((p.real, p.imag))
    return np.array(points)


TARGET = re.compile(r"robtarget (\w+):=\[\[([^\]]*)\]")
MOVE = re.compile(r"Move([LJC]) (\w+)(?:,(\w+))?,v")
ABOVE = re.compile(r"Move[LJ] RelTool\((\w+),")


def followed(text):
    """Of RAPID: points (n, 3) of each way between retracts, arcs in chords of a fifth of a mm."""
    places = {n: np.array(p.split(","), dtype=float) for n, p in TARGET.findall(text)}
    ways, way = [], []
    for line in text.splitlines():
        if ABOVE.search(line):
            if len(way) > 1:
                ways.append(np.array(way))
            way = []
        elif move := MOVE.search(line):
            kind, first, second = move.groups()
            if kind == "C":
                way += arc(way[-1], places[first], places[second])
            else:
                way.append(places[first])
    return ways


def arc(start, via, end):
    """Points after the start on the circle through three, in their plane z."""
    a, b, c = (complex(*p[:2]) for p in (start, via, end))
    w = (c - a) / (b - a)
    centre = a + (b - a) * (w - abs(w) ** 2) / (w - w.conjugate())
    about = (b - centre) / (a - centre)
    whole = (c - centre) / (a - centre)
    turn = math.atan2(whole.imag, whole.real)
    half = math.atan2(about.imag, about.real)
    if half > 0.0:
        turn %= math.tau
    else:
        turn = -(-turn % math.tau)
    if not abs(half) % math.tau <= abs(turn):  # the way to via is the longer part
        turn -= math.copysign(math.tau, turn)
    count = max(math.ceil(abs(turn) * abs(a - centre) / 0.2), 1)
    found = []
    for i in range(1, count + 1):
        angle = turn * i / count
        p = centre + (a - centre) * complex(math.cos(angle), math.sin(angle))
        found.append(np.array([p.real, p.imag, start[2] + (end[2] - start[2]) * i / count]))
    found[-1] = np.array(end)
    return found


def whole(points):
    return [tuple(p) for p in np.round(np.asarray(points)[:, :2] * SCALE).astype(np.int64).tolist()]


def forbidden(outlines, away):
    """Where a point is nearer than `away` to what stays of nested outlines, by their parity."""
    union = pyclipper.Pyclipper()
    union.AddPaths([whole(o) for o in outlines], pyclipper.PT_SUBJECT, True)
    parity = (pyclipper.PFT_EVENODD, pyclipper.PFT_EVENODD)
    stays = union.Execute(pyclipper.CT_UNION, *parity)
    wider = pyclipper.PyclipperOffset(2.0, 0.001 * SCALE)
    wider.AddPaths(stays, pyclipper.JT_ROUND, pyclipper.ET_CLOSEDPOLYGON)
    return wider.Execute(away * SCALE)


def gouges(way, zone):
    """The stretches of a way inside a zone, as open polylines in mm."""
    clip = pyclipper.Pyclipper()
    clip.AddPath(whole(way), pyclipper.PT_SUBJECT, False)
    clip.AddPaths(zone, pyclipper.PT_CLIP, True)
    nonzero = (pyclipper.PFT_NONZERO, pyclipper.PFT_NONZERO)
    tree = clip.Execute2(pyclipper.CT_INTERSECTION, *nonzero)
    return [np.array(p) / SCALE for p in pyclipper.OpenPathsFromPolyTree(tree)]


def distances(points, line):
    """From points (n, 2) to a polyline (m, 2), (n,)."""
    a, b = line[:-1], line[1:]
    way = b - a
    size = np.maximum((way**2).sum(axis=1), 1e-18)
    share = np.clip(((points[:, None] - a) * way).sum(axis=2) / size, 0.0, 1.0)
    return np.linalg.norm(points[:, None] - a - share[..., None] * way, axis=2).min(axis=1)


def area(points):
    x, y = points.T[:2]
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
