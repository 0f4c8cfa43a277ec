"""What is in an FMU: a description that validates, source that compiles anywhere, libraries."""

from __future__ import annotations

import ctypes
import importlib.util
import io
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.fmu import (
    Model,
    arm_model,
    co_simulation,
    compiled,
    live_model,
    program_model,
)
from assistant.blocks.fmu.robot_models import Motion
from tests.blocks.code.compiled import compiled as built
from tests.blocks.code.compiled import compiler
from tests.blocks.fmu.hosting import packed
from tests.blocks.fmu.test_program import simulated


def models() -> list[Model]:
    simulation = simulated(0.05)
    program = program_model(Motion.of(simulation), simulation.robot, "gluing")
    arms = [arm_model(robots.get(name)) for name in ("rv-2aj", "rh-6frh5520", "rv-4frl")]
    return [*arms, program, live_model(robots.get("rv-2aj"))]


def test_the_descriptions_pass_the_validator_of_fmpy(tmp_path: Path) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="fmpy comes with the extra `test`")
    for model in models():
        file = tmp_path / f"{model.identifier}.fmu"
        file.write_bytes(model.packed({}))
        assert validation.validate_fmu(str(file)) == []
        # It does look at what is not known before the start: one of them less is found.
        with zipfile.ZipFile(file) as archive, zipfile.ZipFile(tmp_path / "less.fmu", "w") as less:
            for name in archive.namelist():
                text = archive.read(name)
                if name == "modelDescription.xml":
                    text = re.sub(rb"(<InitialUnknowns>\s*)<Unknown [^>]*/>", rb"\1", text)
                less.writestr(name, text)
        (found,) = validation.validate_fmu(str(tmp_path / "less.fmu"))
        assert "InitialUnknowns" in found


def test_the_source_compiles_without_a_warning_under_the_name_of_the_model(tmp_path: Path) -> None:
    for model in models():
        for name, data in model.sources.items():
            (tmp_path / name).write_bytes(data)
        output = tmp_path / f"{model.identifier}.so"
        library = built([tmp_path / "model.c"], output, "-fPIC", "-shared", "-O0")
        found = ctypes.CDLL(str(library))
        version = getattr(found, f"{model.identifier}_fmi2GetVersion")
        version.restype = ctypes.c_char_p
        assert version() == b"2.0"
        assert not hasattr(found, "fmi2GetVersion")


def test_a_library_shows_the_functions_of_fmi_only(tmp_path: Path) -> None:
    tool = shutil.which("nm")
    if tool is None:
        pytest.skip("this machine has no nm")
    (tmp_path / "one.fmu").write_bytes(packed(arm_model(robots.get("rv-2aj"))))
    with zipfile.ZipFile(tmp_path / "one.fmu") as archive:
        (name,) = (one for one in archive.namelist() if one.startswith("binaries/"))
        library = archive.extract(name, tmp_path)
    done = subprocess.run([tool, "-D", "--defined-only", library], capture_output=True, text=True)
    shown = {line.split()[-1] for line in done.stdout.splitlines()}
    assert len(shown) > 25 and all(name.startswith("fmi2") for name in shown)


def test_the_same_model_gives_the_same_bytes() -> None:
    model = arm_model(robots.get("rv-2aj"))
    assert packed(model) == compiled(model)[0]


def test_other_arms_have_other_guids() -> None:
    assert len({model.guid for model in models()}) == len(models())


def test_without_a_compiler_there_is_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    data, findings = compiled(arm_model(robots.get("rv-2aj")))
    (tmp_path / "one.fmu").write_bytes(data)
    assert [one.code for one in findings] == ["BL401"]
    with zipfile.ZipFile(tmp_path / "one.fmu") as archive:
        assert "sources/model.c" in archive.namelist()
        assert not any(name.startswith("binaries/") for name in archive.namelist())


def test_cross_compilers_that_are_not_there_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if (
        importlib.util.find_spec("ziglang") is not None
        or co_simulation.this_platform() != "linux64"
    ):
        pytest.skip("this machine compiles for others")
    compiler()
    for name in ("cc", "as", "ld"):
        (tmp_path / name).symlink_to(shutil.which(name) or name)
    monkeypatch.setenv("PATH", str(tmp_path))
    data, findings = compiled(arm_model(robots.get("rv-2aj")), everywhere=True)
    assert [one.code for one in findings] == ["BL402", "BL402"]
    assert len(data) > 20_000


def test_a_compiler_that_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho 'no space left' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin")
    with pytest.raises(Refused, match="no space left") as refused:
        compiled(arm_model(robots.get("rv-2aj")))
    assert [one.code for one in refused.value.findings] == ["BL403"]
    assert co_simulation.this_platform() in co_simulation.PLATFORMS


@pytest.mark.slow
def test_libraries_for_other_systems_are_made_where_a_compiler_is() -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("the Python package ziglang is not here")
    begins = {"linux64": b"\x7fELF", "win64": b"MZ", "darwin64": b"\xcf\xfa\xed\xfe"}
    for model in (arm_model(robots.get("rv-2aj")), live_model(robots.get("rv-2aj"))):
        data, findings = compiled(model, everywhere=True)
        assert findings == ()
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            made = [name for name in archive.namelist() if name.startswith("binaries/")]
            found = {name.split("/")[1]: archive.read(name) for name in made}
        assert found.keys() == begins.keys()
        assert all(found[name].startswith(begin) for name, begin in begins.items())
