"""What is installed is what was looked at, and what is built is the same wherever it is built."""

from __future__ import annotations

import base64
import hashlib
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.tables import every_row

PROJECT = Path(__file__).parent.parent
PINNED = re.compile(r"^(?P<name>[a-z0-9-]+)==(?P<version>[^ ;]+)(?: ; (?P<when>.+?))? \\$", re.M)
PYTHONS = ("3.11", "3.12", "3.13")
IMPORT = re.compile(
    r"^ *(?:from (\w+)[\w.]* import |import (\w+)[\w.]*(?: as \w+)?(?:$|  #))", re.M
)
HANDED_ON = {"assistant", "_typeshed", "anyio", "lsprotocol"}
"""Modules that come with Python's types, starlette and pygls."""


def needed() -> list[Requirement]:
    """What the project, its tests and lint ask for, and what builds it."""
    stated = tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))
    extras = stated["project"]["optional-dependencies"]
    rows = [Requirement(row) for row in stated["dependency-groups"]["backends"]]
    waiting = [*stated["project"]["dependencies"], *extras["lint"]]
    for row in waiting:
        one = Requirement(row)
        if one.name == stated["project"]["name"]:
            waiting += [deeper for extra in sorted(one.extras) for deeper in extras[extra]]
        else:
            rows.append(one)
    return rows


def pins() -> dict[str, list[re.Match[str]]]:
    """The rows of both lists by the names of their packages."""
    found: dict[str, list[re.Match[str]]] = {}
    for name in ("backends.txt", "pins.txt"):
        for row in PINNED.finditer((PROJECT / ".ci" / name).read_text("utf-8")):
            found.setdefault(row["name"], []).append(row)
    return found


@every_row("python", PYTHONS)
@every_row("one", needed())
def test_a_version_is_pinned_of_all_that_is_asked_for(one, python):
    here = {"python_version": python, "python_full_version": f"{python}.1", "sys_platform": "linux"}
    if one.marker is not None and not one.marker.evaluate(here):
        return
    rows = [
        row["version"]
        for row in pins()[canonicalize_name(one.name)]
        if row["when"] is None or Requirement(f"x; {row['when']}").marker.evaluate(here)
    ]
    assert rows
    assert all(one.specifier.contains(version) for version in rows), "`make pins` is to be run"


def modules_of(name: str) -> Iterator[str]:
    """The modules of a distribution that is installed."""
    try:
        top = importlib.metadata.distribution(name).read_text("top_level.txt")
        files = importlib.metadata.files(name) or [] if top is None else []
    except importlib.metadata.PackageNotFoundError:
        return
    yield from (top or "").split()
    yield from (file.parts[0].partition(".")[0] for file in files)


def test_all_that_the_package_imports_is_asked_for():
    stated = tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = stated["optional-dependencies"]
    (every,) = map(Requirement, extras["all"])
    rows = [*stated["dependencies"], *(row for name in every.extras for row in extras[name])]
    asked = {canonicalize_name(Requirement(row).name) for row in rows}
    odd = imported() - set(sys.stdlib_module_names) - HANDED_ON - asked
    assert odd <= {module for name in asked for module in modules_of(name)}


def imported() -> set[str]:
    """The first words of the modules that the package imports, anywhere in it."""
    texts = (file.read_text("utf-8") for file in (PROJECT / "assistant").rglob("*.py"))
    return {name for text in texts for pair in IMPORT.findall(text) for name in pair if name}


@pytest.mark.parametrize("name", ["backends.txt", "pins.txt"])
def test_each_pin_has_hashes_and_nothing_tells_where_it_came_from(name):
    text = (PROJECT / ".ci" / name).read_text("utf-8")
    assert text.splitlines()[1] == "#    make pins"
    for row in PINNED.finditer(text):
        following = text[row.end() :].lstrip("\n").split("\n", 1)[0]
        assert re.fullmatch(r" {4}--hash=sha256:[0-9a-f]{64}(?: \\)?", following), row[0]
    lines = [line for line in text.splitlines() if not line.startswith(("    --hash", "    #"))]
    assert all(PINNED.match(line) for line in lines[2:])
    assert not re.search("://|file:|-url|find-links", text)


def wheel(folder: Path, name: str, version: str) -> tuple[Path, str]:
    """A package of one module, as pip installs it, and its digest."""
    made = folder / f"{name}-{version}-py3-none-any.whl"
    info = f"{name}-{version}.dist-info"
    files = {
        f"{name}.py": b"",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n".encode(),
        f"{info}/WHEEL": b"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    rows = [f"{file},sha256={_digest(data)},{len(data)}" for file, data in files.items()]
    with zipfile.ZipFile(made, "w") as archive:
        for file, data in files.items():
            archive.writestr(file, data)
        archive.writestr(f"{info}/RECORD", "\n".join([*rows, f"{info}/RECORD,,"]) + "\n")
    return made, hashlib.sha256(made.read_bytes()).hexdigest()


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a shell script, for make")
@pytest.mark.parametrize("case", ["another hash", "another version", "another version, only pins"])
def test_another_file_than_the_pinned_one_is_never_installed(tmp_path, case):
    (tmp_path / ".ci").mkdir()
    shutil.copy(PROJECT / ".ci" / "install", tmp_path / ".ci")
    _, digest = wheel(tmp_path, "pinned", "1.0" if case == "another hash" else "2.0")
    wrong = digest if case != "another hash" else "0" * 64
    for name in ("backends.txt", "pins.txt"):
        (tmp_path / ".ci" / name).write_text(f"pinned==1.0 --hash=sha256:{wrong}\n")
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
    mode = {"PINS": "only"} if "only" in case else {}
    offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(tmp_path), "PIP_CONFIG_FILE": os.devnull}
    done = subprocess.run(
        [tmp_path / ".ci" / "install", sys.executable],
        env={**clean, **mode, **offline},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert ("DO NOT MATCH THE HASHES" in done.stderr) == (case == "another hash")
    assert ("NO HASH IS LOOKED AT" in done.stderr) == (case == "another version")
    assert not list((tmp_path / ".venv").rglob("pinned*"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_the_same_files_are_built_to_the_same_bytes(tmp_path, kind):
    """Whatever the folder, the order, times and modes of files, the time zone and the umask."""
    parts = ["LICENSE", "README.md", "pyproject.toml", "assistant", "docs", "grammars"]
    parts += ["samples", "templates"]
    files = [file for part in parts for file in _files(PROJECT / part)]
    made = []
    for name, order, mask, zone, time in (
        ("here", files, 0o022, "UTC", 1_600_000_000),
        ("elsewhere/deeper", files[::-1], 0o077, "Asia/Tokyo", 1_700_000_001),
    ):
        folder = tmp_path / name
        for file in order:
            copy = folder / file.relative_to(PROJECT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(file.read_bytes())
            copy.chmod(0o666 & ~mask)
            os.utime(copy, (time, time))
        subprocess.run(
            [sys.executable, "-m", "build", f"--{kind}", "--no-isolation"],
            cwd=folder,
            env={**os.environ, "TZ": zone, "SOURCE_DATE_EPOCH": "1750000000"},
            umask=mask,
            check=True,
            capture_output=True,
        )
        (built,) = (folder / "dist").iterdir()
        made.append((built.name, built.read_bytes()))
    assert made[0] == made[1]


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    found = [file for file in path.rglob("*") if file.is_file()]
    return [file for file in found if "__pycache__" not in file.parts]
