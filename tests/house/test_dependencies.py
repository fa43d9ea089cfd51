# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What setup.py asks for comes from apt by package.xml, or from pip by a workspace's
list.
"""

import ast
from pathlib import Path
from xml.etree import ElementTree

import pytest
from packaging.requirements import Requirement

from ros_pose_stats.base.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
KEYS = {"Jinja2": "python3-jinja2", "pillow": "python3-pil", "PyYAML": "python3-yaml"}
"""rosdep's keys that are not the name after `python3-`."""

NOBLE = {"numpy": "1.26.4", "scipy": "1.11.4", "matplotlib": "3.6.3"}
"""Versions in Ubuntu 24.04 of what setup.py asks for in some version or newer."""


def setup_value(keyword):
    tree = ast.parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    (value,) = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == keyword
    ]
    return ast.literal_eval(value)


def asked():
    """What core and node need, and the pictures and pages of the tools."""
    lines = [*setup_value("install_requires"), *setup_value("extras_require")["tools"]]
    return {requirement.name: requirement for requirement in map(Requirement, lines)}


def listed(file):
    lines = (ROOT / ".ci" / file).read_text(encoding="utf-8").splitlines()
    return {
        requirement.name: requirement
        for requirement in map(
            Requirement,
            filter(None, [line.partition("#")[0].strip() for line in lines]),
        )
    }


def keys(*tags):
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    return {item.text for tag in tags for item in package.iter(tag)}


def lowest(requirement):
    return [
        specifier for specifier in requirement.specifier if specifier.operator == ">="
    ]


ASKED = asked()
BY_PIP = listed("requirements-workspace.txt")
BY_APT = {
    name
    for name in ASKED
    if KEYS.get(name, f"python3-{name}") in keys("depend", "exec_depend")
}


def test_every_requirement_comes_from_apt_or_from_pip():
    # coverage is there for numba's sake alone.
    assert ASKED.keys() == BY_APT | BY_PIP.keys() - {"coverage"}
    # numpy is on both lists, so that pip leaves it at the distribution's.
    assert BY_APT & BY_PIP.keys() == {"numpy"}
    assert "2.0" in ASKED["numpy"].specifier
    assert "2.0" not in BY_PIP["numpy"].specifier


@pytest.mark.parametrize("name", sorted(BY_PIP.keys() - {"coverage"}))
def test_lower_bounds_of_a_workspace_are_those_of_setup(name):
    assert lowest(BY_PIP[name]) == lowest(ASKED[name])


@pytest.mark.parametrize("name", sorted(BY_APT))
def test_versions_of_the_distribution_suffice(name):
    assert not ASKED[name].specifier or NOBLE[name] in ASKED[name].specifier
    assert name not in BY_PIP or NOBLE[name] in BY_PIP[name].specifier


@pytest.mark.parametrize("extra", ["step", "cluster", "parquet"])
def test_what_extras_need_is_pinned_too(extra):
    (requirement,) = map(Requirement, setup_value("extras_require")[extra])
    (pin,) = listed("requirements.txt")[requirement.name].specifier
    assert pin.version in requirement.specifier


def test_every_module_of_an_extra_has_a_remedy_that_setup_knows():
    """By the name of its distribution, where that is another."""
    distributions = {"PIL": "pillow", "jinja2": "Jinja2"}
    for module, extra in EXTRAS.items():
        names = {
            Requirement(line).name for line in setup_value("extras_require")[extra.name]
        }
        assert distributions.get(module, module) in names


@pytest.mark.parametrize("name", sorted(ASKED))
def test_pinned_versions_suffice(name):
    (pin,) = listed("requirements.txt")[name].specifier
    assert pin.version in ASKED[name].specifier


PIP_KEYS = {"mcap-ros2-support", "python3-trimesh-pip"}
"""rosdep's keys of pip, which the environment of a workspace has."""


def test_rosdep_is_asked_for_nothing_else():
    python = {
        key for key in keys("depend", "exec_depend") if key.startswith("python3-")
    }
    apt_keys = {KEYS.get(name, f"python3-{name}") for name in BY_APT}
    assert python - PIP_KEYS == apt_keys
    assert keys("depend", "exec_depend") >= PIP_KEYS


@pytest.mark.parametrize("file", ["docs/workspace.md", ".ci/Dockerfile"])
def test_what_pip_would_refuse_to_install_for_rosdep_is_skipped(file):
    option = f'--skip-keys "{" ".join(sorted(PIP_KEYS))}"'
    assert option in (ROOT / file).read_text(encoding="utf-8")
