import ast
import re
import subprocess
import sys
from fnmatch import fnmatch

import pytest
from haptic_tracing.core.message import Cause

PARTS = ("addon", "command_line", "core", "pictures", "plugins", "sample_scenes", "study")
# The places where one machine keeps its own files: home folders, workplaces, Windows profiles.
MACHINE_PATH = re.compile(
    r"(?<![\w.:/-])(?:/(?:root|work|farm)/|/(?:home|Users)/\w|[A-Z]:\\Users\\\w)"
)


@pytest.fixture(scope="session")
def committed(root) -> list[str]:
    answer = subprocess.run(
        ["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=True
    )
    return [path for path in answer.stdout.split("\0") if path and (root / path).is_file()]


def test_package_list_equals_the_folders(root, project):
    folders = {
        path.parent.relative_to(root)
        for part in PARTS
        for path in (root / part).rglob("__init__.py")
    }
    expected = {".".join(["haptic_tracing", *folder.parts]) for folder in folders}
    listed = project["tool"]["setuptools"]["packages"]
    assert set(listed) == expected | {"haptic_tracing"}
    assert len(listed) == len(set(listed))


def test_every_data_file_is_in_the_package_data(committed, project):
    patterns = []
    for package, names in project["tool"]["setuptools"]["package-data"].items():
        folder = "/".join(package.split(".")[1:])
        patterns += [f"{folder}/{name}" for name in names]
    data = [path for path in committed if path.split("/")[0] in PARTS and not path.endswith(".py")]
    assert [path for path in data if not any(fnmatch(path, pattern) for pattern in patterns)] == []


def test_no_path_of_one_machine(committed, root):
    found = []
    for path in committed:
        content = (root / path).read_bytes()
        if b"\0" in content[:8192] or path.endswith("test_repository_against_its_rules.py"):
            continue
        lines = content.decode("utf-8").splitlines()
        found += [
            f"{path}:{number}: {line.strip()}"
            for number, line in enumerate(lines, 1)
            if MACHINE_PATH.search(line)
        ]
    assert found == []


def test_no_built_file_is_committed(committed):
    assert [
        path
        for path in committed
        if path.endswith((".whl", ".zip", ".pyc", ".so", ".blend", ".egg-info"))
    ] == []


def test_what_is_shipped_imports_only_what_is_there_in_blender(found):
    in_blender = {
        "aud",
        "bl_ui",
        "blf",
        "bmesh",
        "bpy",
        "bpy_extras",
        "gpu",
        "gpu_extras",
        "idprop",
        "io_scene_gltf2",
        "mathutils",
    }
    in_blender |= {"numpy", "rna_keymap_ui", "rna_prop_ui"}
    carried = {"fcl", "hid", "hidraw", "fastjsonschema", "soxr"}
    allowed = set(sys.stdlib_module_names) | in_blender | carried
    shipped = [
        one
        for one in found
        if one.importer.split(".")[0] in ("addon", "core", "sample_scenes") and not one.own
    ]
    assert shipped and [str(one) for one in shipped if one.imported not in allowed] == []


def test_every_cause_of_a_message_is_used(root):
    sources = [
        path
        for path in (root / "core").rglob("*.py")
        if path.name not in ("message.py", "sentences.py")
    ]
    sources += [root / "addon" / "live_output" / "player.py"]
    texts = [text for path in sources if "Cause" in (text := path.read_text(encoding="utf-8"))]
    used = {
        node.attr
        for text in texts
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "Cause"
    }
    assert used == {cause.name for cause in Cause}
