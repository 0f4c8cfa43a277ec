"""Libraries out of C: by the system's compiler for this machine, by others for other systems."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.blocks.fmu import rules
from assistant.blocks.fmu.model import Model

COMPILER_TIMEOUT: Final = 300.0
"""Seconds of a compiler; zig makes its own C library when it is first used, which takes 80."""
COMPILER_FLAGS: Final = ("-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
"""No contraction: a product and a sum are rounded each, as numpy does."""
PREFIX_FLAG: Final = "-DFMI2_OVERRIDE_FUNCTION_PREFIX"


@dataclass(frozen=True, slots=True)
class Platform:
    """What libraries are made for.

    name: as FMI has it, and the folder in `binaries/`. ending: of its libraries.
    commands: programs that compile for it, the first that is there counts.
    target: as zig calls it. flags: of its own. needed: what to install for it.
    """

    name: str
    ending: str
    commands: tuple[str, ...]
    target: str
    flags: tuple[str, ...] = ()
    needed: str = ""


PLATFORMS: Final = {
    "linux64": Platform(
        "linux64", ".so", ("gcc", "cc", "clang"), "x86_64-linux-gnu.2.17", ("-fPIC",), "gcc"
    ),
    "win64": Platform(
        "win64",
        ".dll",
        ("x86_64-w64-mingw32-gcc",),
        "x86_64-windows-gnu",
        (),
        "mingw-w64 or the Python package ziglang",
    ),
    "darwin64": Platform(
        "darwin64", ".dylib", (), "x86_64-macos", ("-fPIC",), "the Python package ziglang"
    ),
}
"""Names of FMI 2.0 → platforms."""


def this_platform() -> str:
    """The platform of this machine."""
    systems = {"linux": "linux64", "win32": "win64", "darwin": "darwin64"}
    return systems.get(sys.platform, "")


def compiled(model: Model, *, everywhere: bool = False) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """The FMU of a model with its libraries, and what could not be made.

    everywhere: also for systems that this machine is not, by what cross compilers there are.
    Raises Refused where a compiler fails.
    """
    own = this_platform()
    wanted = [own, *(name for name in PLATFORMS if everywhere and name != own)]
    libraries, findings = {}, []
    for name in wanted:
        command = _compiler_command(name, own)
        if command is not None:
            platform = PLATFORMS[name]
            path = f"{name}/{model.identifier}{platform.ending}"
            libraries[path] = _compile_library(model, platform, command)
        elif name == own:
            findings.append(rules.NO_COMPILER())
        else:
            needed = PLATFORMS[name].needed
            findings.append(rules.NO_CROSS_COMPILER(platform=name, what=needed))
    return model.packed(libraries), tuple(findings)


def _compiler_command(name: str, own: str) -> list[str] | None:
    """The compiler for a platform, None if there is none."""
    platform = PLATFORMS.get(name)
    if platform is None:
        return None
    commands = ("cc", "clang", "gcc") if name == own else platform.commands
    found = next(filter(None, map(shutil.which, commands)), None)
    if found is not None:
        return [found]
    zig = shutil.which("zig")
    if zig is not None:
        return [zig, "cc", "-target", platform.target]
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", platform.target]
    return None


def _compile_library(model: Model, platform: Platform, command: list[str]) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        for file, data in model.sources.items():
            (folder / file).write_bytes(data)
        output = f"{model.identifier}{platform.ending}"
        words = [*command, *COMPILER_FLAGS, *platform.flags, PREFIX_FLAG, "model.c", "-o", output]
        words += _linked_libraries(model, platform)
        try:
            done = subprocess.run(  # noqa: S603 - a compiler of the system, on our own source
                words,
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=COMPILER_TIMEOUT,
                check=False,
            )
            reason = done.stderr.strip().splitlines()[:1] if done.returncode else []
            if done.returncode == 0:
                return (folder / output).read_bytes()
        except (OSError, subprocess.TimeoutExpired) as wrong:
            reason = [str(wrong)]
    said = reason[0] if reason else "it says nothing"
    raise Refused(rules.NOT_COMPILED(compiler=command[0], reason=said), exit_status=2)


def _linked_libraries(model: Model, platform: Platform) -> list[str]:
    """What is linked: mathematics, of Windows what the model needs of it."""
    if platform.name == "win64":
        return [f"-l{library}" for library in model.libraries]
    return ["-lm"]
