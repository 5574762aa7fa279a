import tomllib
import zipfile

import pytest

PLATFORMS = ("linux_x64", "macos_arm64", "macos_x64", "windows_x64")
TOP_LEVEL = {
    "blender_manifest.toml",
    "__init__.py",
    "LICENSE",
    "addon",
    "core",
    "manual",
    "plugins",
    "sample_scenes",
    "wheels",
}
WHEEL_PLATFORM = {
    "linux_x64": "manylinux",
    "macos_arm64": "macosx",
    "macos_x64": "macosx",
    "windows_x64": "win_amd64",
}

pytestmark = pytest.mark.slow  # building the zips takes a second


def test_one_zip_per_platform(zips):
    assert sorted(zips) == sorted(PLATFORMS)


@pytest.mark.parametrize("platform", PLATFORMS)
def test_holds_only_what_runs_in_blender(zips, root, platform):
    with zipfile.ZipFile(zips[platform]) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
    assert {name.split("/")[0] for name in names} <= TOP_LEVEL
    assert [name for name in names if "__pycache__" in name or "/." in name] == []
    source = {
        str(path.relative_to(root).as_posix())
        for part in ("addon", "core", "plugins")
        for path in (root / part).rglob("*.py")
    }
    assert source <= set(names)
    pages = {
        path.relative_to(root / "docs").with_suffix(".html").as_posix()
        for path in (root / "docs" / "panels").glob("*.md")
    }
    assert {f"manual/{page}" for page in (*pages, "index.html", "tutorial.html")} <= set(names)


@pytest.mark.parametrize("platform", PLATFORMS)
def test_carries_its_own_platforms_wheels(zips, manifest, platform):
    with zipfile.ZipFile(zips[platform]) as archive:
        wheels = [name for name in archive.namelist() if name.endswith(".whl")]
        written = tomllib.loads(archive.read("blender_manifest.toml").decode("utf-8"))
    names = sorted({name.split("/")[-1].split("-")[0] for name in wheels})
    assert names == sorted(
        wheel.split("/")[-1].split("-")[0]
        for wheel in {w.split("-")[0]: w for w in manifest["wheels"]}.values()
    )
    assert all("none-any" in name or WHEEL_PLATFORM[platform] in name for name in wheels)
    assert written["build"]["generated"]["platforms"] == [platform.replace("_", "-", 1)]
    assert written["id"] == manifest["id"]
