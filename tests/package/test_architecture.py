"""The layers of `docs/architecture.md`, read from the imports; and no function too long or too
branched to read."""

from __future__ import annotations

import ast
import importlib.util
import re
import sys
from pathlib import Path

import pytest
from import_graph import LAYERS, cycles, layer, modules, statements

ROOT = Path(__file__).resolve().parents[2]

LATE = {
    "bpy": "the command line's help lists the samples where there is no Blender",
    "gpu": "not there without a graphics card",
    "aud": "loaded with the first preview as sound",
    "fcl": "native",
    "fcntl": "not there on Windows",
    "soxr": "native",
    "fastjsonschema": "slow to import, needed for files and device profiles",
    "io_scene_gltf2": "Blender's glTF exporter, which the user may have disabled",
    "matplotlib": "optional: the study's plots",
}
"""Packages that may be imported inside a function, and why."""

GATEWAYS = {
    "__init__": "Blender imports the package before it enables the add-on, and the core is used "
    "without the add-on"
}
"""Modules that may import others of this package inside a function, and why."""

BLENDER = {
    "bpy",
    "mathutils",
    "bmesh",
    "gpu",
    "gpu_extras",
    "aud",
    "blf",
    "bpy_extras",
    "bl_math",
    "idprop",
}


def height(part: str) -> int:
    return next((k for k, row in enumerate(LAYERS) if part in row), -1)


def test_every_module_is_on_a_floor(root):
    assert {module for module in modules(root) if height(layer(module)) < 0} == {"core", "addon"}


def test_a_floor_uses_only_those_below_it(found):
    own = [(layer(one.importer), layer(one.imported), str(one)) for one in found if one.own]
    upward = [line for a, b, line in own if a != b and height(a) <= height(b)]
    assert upward == []


def test_no_module_imports_itself_by_way_of_others(found):
    assert cycles((one.importer, one.imported) for one in found if one.own) == []


def test_the_core_knows_neither_blender_nor_the_add_on(found):
    assert [
        str(one)
        for one in found
        if one.importer.startswith("core.") and not one.own and one.imported in BLENDER
    ] == []


def test_scene_files_become_results_through_the_front_door_alone(found):
    inner = {"core.tracer", "core.contacts.scene_contacts"}
    users = {layer(one.importer) for one in found if one.own and one.imported in inner}
    assert users.isdisjoint({"study", "command_line"})


def test_plug_ins_import_public_modules_alone(found, root):
    """Those in the table of docs/plugins.md, and their own."""
    page = (root / "docs" / "plugins.md").read_text(encoding="utf-8").split("## Public modules")[1]
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    public = {name for row in rows for name in re.findall(r"`([\w.]+)`", row)}
    assert public <= modules(root).keys()
    imported = [one for one in found if one.own and one.importer.startswith("plugins.")]
    assert imported
    assert [
        str(one)
        for one in imported
        if one.imported not in public and one.imported.split(".")[:2] != one.importer.split(".")[:2]
    ] == []


def test_imports_stand_at_the_head_of_a_module(found):
    inside = [one for one in found if one.inside]
    assert [str(one) for one in inside if one.own and one.importer not in GATEWAYS] == []
    assert [str(one) for one in inside if not one.own and one.imported not in LATE] == []


@pytest.fixture(scope="module")
def code_size(root):
    """The module `benchmarks/code_size.py`."""
    specification = importlib.util.spec_from_file_location(
        "code_size", root / "benchmarks" / "code_size.py"
    )
    module = sys.modules["code_size"] = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_functions_are_under_84_lines_and_a_complexity_of_20(code_size, root):
    large = [
        item for item in code_size.functions(root) if item.lines >= 84 or item.complexity >= 20
    ]
    assert [(item.place, item.lines, item.complexity) for item in large] == []


def test_code_is_counted_without_comments_docstrings_and_blank_lines(code_size):
    lines = [
        '"""Docstring',
        'of two lines."""',
        "# comment",
        "",
        'x = """text',
        'of two lines"""',
        "def f(a):",
        "    return (",
        "        a)",
    ]
    source = "\n".join(lines) + "\n"
    assert code_size.code_lines(source, ast.parse(source)) == {5, 6, 7, 8, 9}


@pytest.mark.skipif(sys.version_info < (3, 12), reason="f-strings are one token before Python 3.12")
@pytest.mark.parametrize(
    ("source", "count"),
    [
        ('"""A docstring."""\nx = 1  # comment\n"""What x is."""\n', 3),
        ("def f(\n    a,\n):\n    return a\n", 9),
        ('x = "two words"\ny = ""\n', 4 + 3),
        ('f"{a} and then {b:.2f}"\n', 2 + 3 + 2 + 5),  # start and end; {a}; two words; {b:.2f}
    ],
)
def test_tokens_are_counted_with_the_words_of_strings(code_size, source, count):
    assert code_size.tokens(source, ast.parse(source)) == count


@pytest.mark.parametrize(
    ("name", "source", "count"),
    [
        ("a.cs", 'var a = "two words"; // a comment\n/* of\nlines */ f(a);', 6 + 5),
        ("a.js", "const a = `one` === '' ? 1.5 : b.c;", 11),
        ("a.gd", '# a comment\nvar a := "#"  # another\n', 5),
        ("a.txt", "three words here", 0),
    ],
)
def test_tokens_of_other_languages(code_size, tmp_path, name, source, count):
    (tmp_path / name).write_text(source)
    assert code_size.size_in_tokens(tmp_path / name) == count


def test_the_tour_of_a_frame_names_what_is_there():
    """Each row of the table in docs/architecture.md: a file, and the function in it to read
    first."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    tour = text.split("Seven files, opened in this order", 1)[1].split("\n\n", 2)[1]
    rows = [line.split("|")[1:3] for line in tour.splitlines()[2:]]
    assert len(rows) == 7
    for file, words in rows:
        path = ROOT / file.strip().strip("`")
        source = path.read_text(encoding="utf-8")
        first = re.findall(r"`([\w.]+)`", words)[0]
        for name in first.split("."):
            assert re.search(rf"^ *(?:def|class) {name}\b", source, re.MULTILINE), (file, name)


def test_the_glossary_names_what_is_there(root):
    """The column "in the code" of docs/glossary.md: classes, functions, members, modules and
    packages."""
    known = set()
    for part in ("core", "addon"):
        for path in (root / part).rglob("*.py"):
            known |= {path.stem, path.parent.name}
            for node, _ in statements(ast.parse(path.read_text(encoding="utf-8")), False):
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                    known.add(node.name)
                if isinstance(node, ast.ClassDef):
                    fields = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
                    names = [field.id for field in fields if isinstance(field, ast.Name)]
                    names += [item.name for item in node.body if isinstance(item, ast.FunctionDef)]
                    known |= {f"{node.name}.{name}" for name in names}
                if isinstance(node, ast.FunctionDef):
                    known |= {argument.arg for argument in (*node.args.args, *node.args.kwonlyargs)}
    rows = (root / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
    told = " ".join(row.split("|")[3] for row in rows if row.startswith("|"))
    names = re.findall(r"`([\w.]+)`", told)
    assert len(names) > 50
    assert [name for name in names if name not in known] == []
