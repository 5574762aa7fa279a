"""Counts lines of code per folder, and names the longest and the most complex functions.

python benchmarks/code_size.py [COMMIT]     of the working tree, beside those of a commit

A line of code holds something other than a comment or a docstring. A function is as long as the lines of code from its head to its end. Its
complexity is McCabe's as ruff counts it (C901): 1, and 1 more for each branch, loop, exception handler, case and inner function.
"""

from __future__ import annotations

import argparse
import ast
import io
import subprocess
import tarfile
import tempfile
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED = ("core", "addon", "sample_scenes", "pictures", "study", "command_line")
PARTS = (*SHIPPED, "benchmarks", "packaging", "docs", "tests")
LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
BRANCHES = (ast.If, ast.For, ast.AsyncFor, ast.While, ast.ExceptHandler, ast.match_case, *FUNCTIONS)
LISTED = 10
LONG = 40
"""Lines of a function, comments included, from which on its lines of code are counted."""


@dataclass(frozen=True, slots=True)
class Function:
    """``place``: file and line; ``lines`` of code."""

    name: str
    place: str
    lines: int
    complexity: int


def code_lines(source: str, tree: ast.Module) -> set[int]:
    """Numbers of the lines that hold code."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in LAYOUT:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in statements(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines.difference_update(range(node.lineno, (node.end_lineno or 0) + 1))
    return lines


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """The statements, exception handlers and cases below a node: what branches and functions are among. Expressions hold none."""
    for part in vars(node).values():
        for inner in part if isinstance(part, list) else ():
            if isinstance(inner, (ast.stmt, ast.ExceptHandler, ast.match_case)):
                yield inner
                yield from statements(inner)


def functions(root: Path, parts: tuple[str, ...] = SHIPPED) -> Iterator[Function]:
    """Every function and method in those folders."""
    for part in parts:
        for path in sorted((root / part).rglob("*.py")):
            source = path.read_text(encoding="utf-8")
            tree = ast.parse(source)
            spans = {node: range(node.lineno, (node.end_lineno or 0) + 1) for node in statements(tree) if isinstance(node, FUNCTIONS)}
            lines = code_lines(source, tree) if any(len(span) >= LONG for span in spans.values()) else None
            for node, span in spans.items():
                length = len(span) if lines is None else len(lines.intersection(span))
                place = f"{path.relative_to(root).as_posix()}:{node.lineno}"
                yield Function(node.name, place, length, 1 + sum(isinstance(inner, BRANCHES) for inner in statements(node)))


def counts(root: Path) -> dict[str, int]:
    """Lines of code by folder; that of a stage or floor ("core/contacts") and of the folder above it."""
    found: dict[str, int] = {}
    for part in PARTS:
        for path in (root / part).rglob("*.py"):
            source = path.read_text(encoding="utf-8")
            folders = path.relative_to(root).parts[:-1]
            for folder in {part, "/".join(folders[:2])}:
                found[folder] = found.get(folder, 0) + len(code_lines(source, ast.parse(source)))
    return found


def print_counts(now: dict[str, int], before: dict[str, int]) -> None:
    """A Markdown table."""
    print("| folder | before | now |\n|---|---:|---:|")
    for folder in sorted(now.keys() | before.keys()):
        print(f"| {folder} | {before.get(folder, '')} | {now.get(folder, '')} |")
    print(f"| core and addon | {before.get('core', 0) + before.get('addon', 0) or ''} | {now['core'] + now['addon']} |")


def main() -> None:
    parser = argparse.ArgumentParser(description="Counts lines of code per folder.")
    parser.add_argument("commit", nargs="?", help="compare with this commit")
    commit = parser.parse_args().commit
    before: dict[str, int] = {}
    if commit:
        archive = subprocess.run(["git", "archive", commit], cwd=ROOT, capture_output=True, check=True).stdout
        with tempfile.TemporaryDirectory() as folder, tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(folder, filter="data")
            before = counts(Path(folder))
    print_counts(counts(ROOT), before)
    every = list(functions(ROOT))
    for title, key in (("longest", "lines"), ("most complex", "complexity")):
        print(f"\n{title}")
        for function in sorted(every, key=lambda item: -getattr(item, key))[:LISTED]:
            print(f"{getattr(function, key):4}  {function.place} {function.name}")


if __name__ == "__main__":
    main()
