import itertools

import haptic_tracing
import pytest
from packaging.requirements import Requirement
from packaging.tags import Tag
from packaging.utils import canonicalize_name, parse_wheel_filename

PYTHONS = ("cp311", "cp313", "cp314")
SYSTEMS = {
    "windows-x64": ("win", "amd64"),
    "macos-x64": ("macosx", "x86_64"),
    "macos-arm64": ("macosx", "arm64"),
    "linux-x64": ("manylinux", "x86_64"),
}
SHIPPED_WITH_BLENDER = {"numpy"}
COMMAND_LINE_ONLY = {"tqdm", "python-osc"}
NEEDED_BY_THEM = {
    "cffi",
    "pycparser",
}  # sounddevice calls PortAudio through cffi, which comes with pycparser


def carried(manifest) -> list[tuple[str, str, frozenset[Tag]]]:
    parsed = (parse_wheel_filename(wheel.removeprefix("./wheels/")) for wheel in manifest["wheels"])
    return [(name, str(version), tags) for name, version, _, tags in parsed]


def runs_on(tag: Tag, python: str) -> bool:
    """Whether a wheel is built for this CPython: for it alone, or for the stable interface of an
    earlier one (PEP 384)."""
    return tag.interpreter == python or (
        tag.abi == "abi3"
        and int(tag.interpreter.removeprefix("cp3")) <= int(python.removeprefix("cp3"))
    )


def test_versions_agree(manifest, project, root):
    cited = (root / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {haptic_tracing.__version__}\n" in cited
    assert manifest["version"] == project["project"]["version"] == haptic_tracing.__version__


def test_licences_agree(manifest, project, root):
    assert manifest["license"] == [f"SPDX:{project['project']['license']}"]
    text = (root / "LICENSE").read_text(encoding="utf-8")
    assert "GNU GENERAL PUBLIC LICENSE" in text
    assert "Version 3, 29 June 2007" in text


def test_the_page_of_licences_names_what_is_carried(pins, root):
    page = (root / "docs" / "third_party.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| [")]
    named = {row[0].partition("[")[2].partition("]")[0]: row[1] for row in rows}
    assert named == {canonicalize_name(name): version for name, version in pins.items()}
    assert all(row[2] for row in rows)


def test_permissions_say_why_as_the_platform_wants_it(manifest):
    for reason in manifest["permissions"].values():
        assert 0 < len(reason) <= 64 and reason[-1].isalnum()


def test_every_wheel_has_the_pinned_version(manifest, pins):
    pinned = {(canonicalize_name(name), version) for name, version in pins.items()}
    assert {(name, version) for name, version, _ in carried(manifest)} == pinned


def test_pins_are_the_run_time_dependencies(project, pins):
    declared = map(Requirement, project["project"]["dependencies"])
    requirements = {canonicalize_name(requirement.name): requirement for requirement in declared}
    pinned = {
        canonicalize_name(name): version
        for name, version in pins.items()
        if name not in NEEDED_BY_THEM
    }
    assert requirements.keys() - SHIPPED_WITH_BLENDER - COMMAND_LINE_ONLY == pinned.keys()
    assert all(requirements[name].specifier.contains(version) for name, version in pinned.items())


def test_every_python_and_platform_has_every_wheel(manifest, pins):
    assert set(manifest["platforms"]) == set(SYSTEMS)
    available = {
        name: tags for name, _, tags in carried(manifest) if Tag("py3", "none", "any") in tags
    }
    for name, python, (system, machine) in itertools.product(pins, PYTHONS, SYSTEMS.values()):
        name = canonicalize_name(name)
        fitting = [
            tag
            for wheel, _, tags in carried(manifest)
            for tag in tags
            if wheel == name
            and runs_on(tag, python)
            and tag.platform.startswith(system)
            and tag.platform.endswith(machine)
        ]
        assert name in available or fitting, (
            f"no wheel of {name} for {python} on {system} {machine}"
        )


@pytest.mark.parametrize("python", ["3.11", "3.13"])
def test_environments_have_the_wheels_that_are_carried_and_all_that_is_declared(
    python, project, pins, root
):
    lines = (
        (root / "packaging" / f"constraints-{python}.txt").read_text(encoding="utf-8").splitlines()
    )
    fixed = {
        canonicalize_name(name): version
        for name, _, version in (line.partition("==") for line in lines)
    }
    carried_versions = {canonicalize_name(name): version for name, version in pins.items()}
    assert carried_versions.items() <= fixed.items()
    groups = project["project"]["optional-dependencies"].values()
    declared = map(
        Requirement, [*project["project"]["dependencies"], *itertools.chain.from_iterable(groups)]
    )
    specified = {
        canonicalize_name(item.name): item.specifier
        for item in declared
        if item.name not in SHIPPED_WITH_BLENDER
    }
    assert [
        name
        for name, specifier in specified.items()
        if name not in fixed or not specifier.contains(fixed[name])
    ] == []


def test_permissions_are_the_ones_used(manifest):
    assert set(manifest["permissions"]) == {"clipboard", "files", "network"}
