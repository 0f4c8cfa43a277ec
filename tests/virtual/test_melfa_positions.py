"""Arithmetic of positions in MELFA-BASIC against matrices of four by four, of random positions.

The matrices are made here, by R = Rz(C)·Ry(B)·Rx(A).
"""

from __future__ import annotations

import numpy as np
import pytest

from assistant import languages
from assistant.base.arrays import Floats
from assistant.virtual import melfa
from assistant.virtual.melfa import Given
from assistant.virtual.melfa.values import Position


def matrix(values: Floats) -> Floats:
    """X, Y, Z in mm and A, B, C in degrees as a matrix of four by four."""
    a, b, c = np.radians(values[3:])
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = z @ y @ x, values[:3]
    return made


def drawn(rng: np.random.Generator) -> Floats:
    return np.round(np.concatenate([rng.uniform(-900, 900, 3), rng.uniform(-179, 179, 3)]), 2)


def shown(first: Floats, second: Floats, expression: str) -> Floats:
    """What an expression of P1 and P2 comes to."""
    found: list[Position] = []

    def show(given: Given) -> int:
        (value,) = given.arguments
        assert isinstance(value, Position)
        found.append(value)
        return 0

    lines = [
        f"P{n}=({','.join(f'{v:.2f}' for v in values)})(7,0)"
        for n, values in ((1, first), (2, second))
    ]
    tree = languages.get("melfa-basic-5").parse(f"1 M1=Show({expression})\n" + "\n".join(lines))
    done = melfa.run(tree, commands={"Show": show})
    assert done.ended == "end" and not tree.findings, done.message
    (value,) = found
    return np.array(value.values[:6], dtype=np.float64)


@pytest.mark.parametrize("seed", range(25))
def test_products_quotients_and_inverses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn(rng), drawn(rng)
    a, b = matrix(one), matrix(other)
    wanted = {
        "P1*P2": a @ b,
        "P1/P2": a @ np.linalg.inv(b),
        "Inv(P1)": np.linalg.inv(a),
        "P1*Inv(P2)*P2*P1": a @ a,
    }
    for expression, made in wanted.items():
        assert np.allclose(matrix(shown(one, other, expression)), made, atol=1e-7), expression


@pytest.mark.parametrize("seed", range(10))
def test_sums_go_element_by_element(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn(rng), drawn(rng)
    assert np.allclose(shown(one, other, "P1+P2"), one + other)
    assert np.allclose(shown(one, other, "(P1-P2)*3/2"), (one - other) * 1.5)


@pytest.mark.parametrize("seed", range(10))
def test_frames_have_their_origin_and_axes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn(rng), drawn(rng)
    made = matrix(shown(one, other, "Fram(P1,P2,P1*(3,4,5,0,0,0))"))
    beside = (matrix(one) @ np.array([3, 4, 5, 1]))[:3] - one[:3]
    along = (other - one)[:3] / np.linalg.norm((other - one)[:3])
    assert np.allclose(made[:3, 3], one[:3]) and np.allclose(made[:3, 0], along, atol=1e-9)
    assert abs(beside @ made[:3, 2]) < 1e-6 and beside @ made[:3, 1] > 0
    assert np.isclose(np.linalg.det(made[:3, :3]), 1.0)


@pytest.mark.parametrize("seed", range(10))
def test_the_middle_is_half_a_turn_of_the_way(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn(rng), drawn(rng)
    half = matrix(shown(one, other, "PosMid(P1,P2,0,0)"))
    a, b = matrix(one)[:3, :3], matrix(other)[:3, :3]
    assert np.allclose(half[:3, 3], (one + other)[:3] / 2)
    step = a.T @ half[:3, :3]
    assert np.allclose(a @ step @ step, b, atol=1e-7)
    assert np.trace(step) >= 1.0 - 1e-9  # no more than a quarter of a turn: the shorter way
