"""The command that installs an extra names the copy that runs, and never an index."""

from __future__ import annotations

import importlib.util
import json
import shlex
import sys
from importlib import metadata
from pathlib import Path

import pytest

from assistant.base import installation
from assistant.base.installation import install_command, missing_extra

REQUIRES = """\
Metadata-Version: 2.4
Name: robot-assistant
Version: 0.1.0
Requires-Dist: click>=8
Requires-Dist: coal<4,>=3.0; extra == "cell"
Requires-Dist: scipy>=1.14; python_version >= "3.11" and extra == 'cell'
Requires-Dist: robot-assistant[cell]; extra == "plan"
Requires-Dist: ompl>=2.0; extra == "plan"
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A copy in a folder of packages, and what pip wrote about where it came from."""

    def made(**origin):
        site = tmp_path / "site-packages"
        info = site / "robot_assistant-0.1.0.dist-info"
        info.mkdir(parents=True, exist_ok=True)
        (info / "METADATA").write_text(REQUIRES, encoding="utf-8")
        if origin:
            (info / "direct_url.json").write_text(json.dumps(origin), encoding="utf-8")
        found = metadata.PathDistribution(info)
        monkeypatch.setattr(metadata, "distribution", lambda _name: found)
        return site / "assistant"

    return made


def asked(extra, package, prefix="/nowhere"):
    words = shlex.split(install_command(extra, package=package, prefix=str(prefix)))
    assert words[1:4] == ["-m", "pip", "install"]
    return words[4:]


def test_a_checkout_is_installed_from_its_folder():
    root = Path(installation.__file__).parents[2]
    words = shlex.split(install_command("plot"))
    assert words[-2:] == ["--editable", f"{root}[plot]"]


def test_a_wheel_is_installed_from_its_file(installed, tmp_path):
    wheel = tmp_path / "my wheels" / "robot_assistant-0.1.0-py3-none-any.whl"
    package = installed(url=wheel.as_uri(), archive_info={})
    assert asked("plot", package) != [f"{wheel}[plot]"], "the file is gone"
    wheel.parent.mkdir()
    wheel.touch()
    assert asked("plot", package) == [f"{wheel}[plot]"]


def test_of_a_repository_its_address_is_named(installed):
    package = installed(url="https://host/robot.git", vcs_info={"vcs": "git"})
    assert asked("cell", package) == ["robot-assistant[cell] @ git+https://host/robot.git"]


def test_without_an_origin_the_libraries_are_named(installed):
    package = installed()
    assert sorted(asked("plan", package)) == ["coal<4,>=3.0", "ompl>=2.0", "scipy>=1.14"]


def test_pipx_installs_into_its_own_environment(installed, tmp_path):
    (tmp_path / "pipx_metadata.json").touch()
    command = install_command("cell", package=installed(), prefix=str(tmp_path))
    assert command.startswith("pipx runpip robot-assistant install ")


def test_an_environment_without_pip_asks_uv(installed, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    words = shlex.split(install_command("cell", package=installed(), prefix="/nowhere"))
    assert words[:5] == ["uv", "pip", "install", "--python", sys.executable]


def test_the_command_is_in_the_cure():
    rule = missing_extra("XX101", "{what} is missing", "plot")
    assert rule(what="it").cure == f"install it with `{install_command('plot')}`"
