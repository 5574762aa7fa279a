"""The imports between the modules of this package and from other packages, read from the source."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

PARTS = ("core", "addon", "sample_scenes", "pictures", "study", "command_line", "plugins")


LAYERS = (
    ("core.forms", "core.frozen", "core.plugins"),
    ("core.declaration",),
    ("core.arrays", "core.message", "core.regular_file", "core.unchanged"),
    ("core.signals", "core.perception"),
    ("core.scene",),
    ("core.contacts",),
    ("core.events",),
    ("core.graph",),
    ("core.propagation", "core.collisions"),
    ("core.render",),
    ("core.tracer", "core.diagnosis", "core.felt"),
    ("core.formats",),
    ("core.run_time", "core.devices"),
    ("addon.blender", "addon.changes", "addon.gateway", "addon.translations"),
    ("addon.properties",),
    ("addon.scene_reader",),
    ("addon.session",),
    ("addon.view", "addon.bake", "addon.io", "addon.live_output"),
    ("addon.authoring",),
    ("sample_scenes",),
    ("addon.operators",),
    ("addon.panels",),
    ("addon.registration",),
    ("__init__",),
    ("pictures",),
    ("study",),
    ("command_line",),
    ("plugins",),
)
"""From the lowest layer up. Layers of one row do not import each other."""


@dataclass(frozen=True, slots=True)
class Import:
    """One imported name.

    ``importer`` and, where ``own``, ``imported`` are modules relative to the package
    ("core.contacts.tracker"); of other packages ``imported`` is the top-level name. ``inside``: the
    statement stands in a function.
    """

    importer: str
    imported: str
    line: int
    own: bool
    inside: bool

    def __str__(self) -> str:
        return f"{self.importer}:{self.line} imports {self.imported}"


def modules(root: Path) -> dict[str, Path]:
    """File by module name, relative to the package, whose own module is "__init__"."""
    paths = [
        root / "__init__.py",
        *(path for part in PARTS for path in sorted((root / part).rglob("*.py"))),
    ]
    return {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
        for path in paths
    }


def imports(root: Path) -> list[Import]:
    """Every import statement of the package, one entry per name."""
    known = modules(root)
    return [
        found for name, path in known.items() for found in _imports_of(name, path, known.keys())
    ]


def _imports_of(name: str, path: Path, known: Iterable[str]) -> Iterator[Import]:
    package = (
        []
        if name == "__init__"
        else name.split(".")
        if path.name == "__init__.py"
        else name.split(".")[:-1]
    )
    for node, inside in statements(ast.parse(path.read_text(encoding="utf-8")), False):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(name, alias.name.split(".")[0], node.lineno, False, inside)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield Import(name, node.module.split(".")[0], node.lineno, False, inside)
        elif isinstance(node, ast.ImportFrom) and node.level:
            base = (
                ".".join(
                    [
                        *package[: len(package) - node.level + 1],
                        *([node.module] if node.module else []),
                    ]
                )
                or "__init__"
            )
            for target in {
                f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base
                for alias in node.names
            }:
                yield Import(name, target, node.lineno, True, inside)


def statements(node: ast.AST, inside: bool) -> Iterator[tuple[ast.stmt, bool]]:
    """All statements below a node, and whether each stands in a function. Statements hold others in
    lists; expressions hold none."""
    inside = inside or isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    for part in vars(node).values():
        for inner in part if isinstance(part, list) else ():
            if isinstance(inner, ast.stmt):
                yield inner, inside
            if isinstance(inner, (ast.stmt, ast.ExceptHandler, ast.match_case)):
                yield from statements(inner, inside)


def cycles(edges: Iterable[tuple[str, str]]) -> list[list[str]]:
    """The groups of two or more that can each be reached from the others (strongly connected
    components), sorted."""
    import networkx

    graph = networkx.DiGraph(edge for edge in edges if edge[0] != edge[1])
    return sorted(
        sorted(component)
        for component in networkx.strongly_connected_components(graph)
        if len(component) > 1
    )


def layer(module: str) -> str:
    """The part of `LAYERS` that a module belongs to; of a package that only contains layers, its
    own name."""
    return next(
        (part for row in LAYERS for part in row if f"{module}.".startswith(f"{part}.")), module
    )
