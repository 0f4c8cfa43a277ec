"""Cases: reading, emitting and proving many poses, beside plain Python and polars."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from assistant import languages, sources
from assistant.base import rotations
from assistant.compiler.read_back_proof import prove_read_back
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow


def poses(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) mm and unit quaternions (n, 4), the same ones at each run."""
    random = np.random.default_rng(1)
    positions = random.uniform(-700.0, 700.0, (n, 3))
    return positions, rotations.canonical(random.normal(size=(n, 4)))


def program(n: int) -> Program:
    positions, quaternions = poses(n)
    path = Path.of("scan", positions, quaternions, speeds=[Speed(150.0)], blends=[Blend(10.0)])
    return Program("scan", (Procedure("main", (Follow(path),)),))


def npy(n: int) -> FilePath:
    path = FilePath(tempfile.mkdtemp()) / "scan.npy"
    np.save(path, np.hstack(poses(n)))
    return path


def csv(n: int) -> FilePath:
    path = FilePath(tempfile.mkdtemp()) / "scan.csv"
    header = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"
    np.savetxt(path, np.hstack(poses(n)), "%.9f", ",", header=header, comments="")
    return path


def adapted(language: str) -> Callable[[int], tuple[Any, Program]]:
    def prepare(n: int) -> tuple[Any, Program]:
        spoken = languages.get(language)
        return spoken, spoken.adapt(program(n)).program

    return prepare


def emit(given: tuple[Any, Program]) -> dict[str, bytes]:
    spoken, said = given
    units = dict.fromkeys([None, *(p.unit for p in said.procedures)])
    return {
        spoken.file_name(said, unit): spoken.encode(spoken.build(said, unit=unit)) for unit in units
    }


def emitted(language: str) -> Callable[[int], tuple[Any, Program, dict[str, bytes]]]:
    def prepare(n: int) -> tuple[Any, Program, dict[str, bytes]]:
        spoken, said = adapted(language)(n)
        return spoken, said, emit((spoken, said))

    return prepare


def prove_all(given: tuple[Any, Program, dict[str, bytes]]) -> None:
    spoken, said, files = given
    proof = prove_read_back(spoken, said, files)
    if not proof.holds:
        raise SystemExit(f"the proof does not hold: {proof.findings[:3]}")


def python_rapid(given: tuple[np.ndarray, np.ndarray]) -> bytes:
    """What a plain script does: one formatted line a target and one a move."""
    positions, quaternions = given
    declarations = [
        "    CONST robtarget scan_%d:=[[%.4f,%.4f,%.4f],[%.9f,%.9f,%.9f,%.9f],[0,0,0,0],"
        "[9E9,9E9,9E9,9E9,9E9,9E9]];\r\n" % (i, *p, *q)
        for i, (p, q) in enumerate(
            zip(positions.tolist(), quaternions.tolist(), strict=True), start=1
        )
    ]
    moves = [f"        MoveL scan_{i},v150,z10,tool0;\r\n" for i in range(1, len(positions) + 1)]
    return "".join(declarations + moves).encode()


def polars_table(given: tuple[np.ndarray, np.ndarray]) -> None:
    """The fastest vectorised formatter found: the seven numbers only, as CSV."""
    import polars

    positions, quaternions = given
    columns = dict(zip("abcdefg", np.hstack([positions, quaternions]).T, strict=True))
    polars.DataFrame(columns).write_csv(float_precision=9)


def polars_read(path: FilePath) -> None:
    import polars

    polars.read_csv(path)


Case = tuple[Callable[[int], Any], Callable[[Any], object]]

CASES: dict[str, Case] = {
    "read .npy": (npy, sources.read),
    "read .csv": (csv, sources.read),
    "polars read_csv, the same .csv": (csv, polars_read),
    "emit RAPID": (adapted("rapid"), emit),
    "prove RAPID (parse, lift, compare)": (emitted("rapid"), prove_all),
    "emit MELFA-BASIC VI": (adapted("melfa-basic-6"), emit),
    "prove MELFA-BASIC VI (parse, lift, compare)": (emitted("melfa-basic-6"), prove_all),
    "plain Python loop, the same RAPID": (poses, python_rapid),
    "polars write_csv, the seven numbers only": (poses, polars_table),
}
