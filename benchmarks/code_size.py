"""Measures the size of the code: tokens, lines and bytes of data per folder, and the longest and
the most complex functions.

    python benchmarks/code_size.py [COMMIT]   tables of the working tree, beside those of a commit
    python benchmarks/code_size.py --total    the tokens in four sums
    python benchmarks/code_size.py --store    store them, for --total to show what has changed

Tokens are Python's own, of 3.12 and later, without comments, docstrings and layout. A string
literal counts as many as it has words between spaces, and at least one; so does each piece of an
f-string between its replacement fields. Tokens measure what there is to read however it is laid
out: lines can be packed more densely. In C#, JavaScript and GDScript a token is a name, a number, a
string literal (as in Python), a run of operators, or a bracket or other mark.

A line of code holds something other than a comment or a docstring, and is counted as ruff formats
it at a width of 100 characters. A function is as long as the lines of code from its head to its
end. Its complexity is McCabe's as ruff counts it (C901): 1, and 1 more for each branch, loop,
exception handler, case and inner function. Data are all files but Python's and pictures.
"""

from __future__ import annotations

import argparse
import ast
import io
import json
import re
import subprocess
import sys
import tarfile
import tempfile
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED = ("core", "addon", "plugins", "sample_scenes", "pictures", "study", "command_line")
PARTS = (*SHIPPED, "clients", "benchmarks", "packaging", "docs", "tests")
TOTALS = {
    "heart": ("core", "addon"),
    "plug-ins": ("plugins",),
    "all else in the zip and clients": ("__init__.py", "sample_scenes", "clients"),
    "all tests": ("tests",),
}
"""Files and folders of each sum; the heart is the core and the add-on."""
STORED = ROOT / "benchmarks" / "results" / "code_size.json"
WIDTH = 100
PICTURES = {".png", ".svg"}
LAYOUT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}
COMMENTS = {".cs": r"//.*|/\*[\s\S]*?\*/", ".js": r"//.*|/\*[\s\S]*?\*/", ".gd": r"#.*"}
"""Comments in C#, JavaScript and GDScript."""
STRINGS = r"""\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`"""
OTHERS = r"\w[\w.]*|[-+*/%=<>!&|^~?]+|\S"
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
    return lines - docstring_lines(tree)


def docstring_lines(tree: ast.Module) -> set[int]:
    """Numbers of the lines of docstrings, those below constants and fields included."""
    strings = [
        node
        for node in statements(tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    ]
    return {line for node in strings for line in range(node.lineno, (node.end_lineno or 0) + 1)}


def tokens(source: str, tree: ast.Module) -> int:
    """How many tokens a module has."""
    if sys.version_info < (3, 12):
        raise SystemExit(
            "haptic-tracing: tokens are counted by Python 3.12 or later, which takes f-strings "
            "apart"
        )
    literals = {tokenize.STRING, tokenize.FSTRING_MIDDLE}
    docstrings = docstring_lines(tree)
    count = 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.STRING and token.start[0] in docstrings:
            continue
        if token.type not in LAYOUT:
            count += max(1, len(token.string.split())) if token.type in literals else 1
    return count


def size_in_tokens(path: Path) -> int:
    """How many tokens a file has; 0 if it is in another language."""
    if path.suffix == ".py":
        source = path.read_text(encoding="utf-8")
        return tokens(source, ast.parse(source))
    if path.suffix not in COMMENTS:
        return 0
    found = re.finditer(
        f"(?P<comment>{COMMENTS[path.suffix]})|(?P<string>{STRINGS})|{OTHERS}",
        path.read_text(encoding="utf-8"),
    )
    return sum(
        max(1, len(item[0].split())) if item["string"] else 1
        for item in found
        if not item["comment"]
    )


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """The statements, exception handlers and cases below a node: what branches and functions are
    among. Expressions hold none."""
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
            spans = {
                node: range(node.lineno, (node.end_lineno or 0) + 1)
                for node in statements(tree)
                if isinstance(node, FUNCTIONS)
            }
            lines = (
                code_lines(source, tree)
                if any(len(span) >= LONG for span in spans.values())
                else None
            )
            for node, span in spans.items():
                length = len(span) if lines is None else len(lines.intersection(span))
                place = f"{path.relative_to(root).as_posix()}:{node.lineno}"
                yield Function(
                    node.name,
                    place,
                    length,
                    1 + sum(isinstance(inner, BRANCHES) for inner in statements(node)),
                )


@dataclass(slots=True)
class Size:
    """What a folder holds: ``tokens``, ``lines`` of code, bytes of ``data``."""

    tokens: int = 0
    lines: int = 0
    data: int = 0

    def __iadd__(self, other: Size) -> Size:
        self.tokens += other.tokens
        self.lines += other.lines
        self.data += other.data
        return self


def sizes(commit: str) -> dict[str, Size]:
    """Sizes by folder in a commit: that of a stage or layer ("core/contacts"), of the folder above
    it, and the totals."""
    found: dict[str, Size] = defaultdict(Size)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        archive = subprocess.run(
            ["git", "archive", commit], cwd=ROOT, capture_output=True, check=True
        ).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(root, filter="data")
        counted = {path: size_in_tokens(path) for path in root.rglob("*.*")}
        sums = totals(root)
        ruff = ROOT / ".venv-lint" / "bin" / "ruff"
        subprocess.run([ruff, "format", "--quiet", "--line-length", str(WIDTH), folder], check=True)
        for part in PARTS:
            for path in (root / part).rglob("*"):
                if path.is_dir() or path.suffix in PICTURES:
                    continue
                size = Size(counted.get(path, 0), data=path.stat().st_size)
                if path.suffix == ".py":
                    source = path.read_text(encoding="utf-8")
                    size = Size(counted[path], len(code_lines(source, ast.parse(source))))
                for name in {part, "/".join(path.relative_to(root).parts[:-1][:2])}:
                    found[name] += size
    return found | {name: Size(count) for name, count in sums.items()}


def print_sizes(now: dict[str, Size], before: dict[str, Size]) -> None:
    """A Markdown table; each value after that of the commit, if there is one."""
    print(
        f"| folder | tokens | lines of code at width {WIDTH} | bytes of data "
        "|\n|---|---:|---:|---:|"
    )
    nothing = Size()
    for folder in sorted(now.keys() | before.keys(), key=lambda name: (name in TOTALS, name)):
        new, old = now.get(folder, nothing), before.get(folder, nothing)
        pairs = ((old.tokens, new.tokens), (old.lines, new.lines), (old.data, new.data))
        cells = [f"{a:,} → {b:,} ({b - a:+,})" if before and a != b else f"{b:,}" for a, b in pairs]
        print(f"| {folder} | {' | '.join(cells)} |")


def totals(root: Path) -> dict[str, int]:
    """The sums of the tokens of a tree, as stored."""
    return {
        name: sum(
            size_in_tokens(path)
            for part in parts
            for path in ([root / part] if "." in part else (root / part).rglob("*.*"))
        )
        for name, parts in TOTALS.items()
    }


def print_totals() -> None:
    """One line, with the change since they were stored."""
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    print(
        "tokens: "
        + "; ".join(
            f"{name} {count:,} ({count - stored[name]:+,})" for name, count in totals(ROOT).items()
        )
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures the size of the code.")
    parser.add_argument("commit", nargs="?", help="compare with this commit")
    parser.add_argument("--total", action="store_true", help="print one line")
    parser.add_argument("--store", action="store_true", help="store what --total compares with")
    arguments = parser.parse_args()
    if arguments.store:
        STORED.write_text(json.dumps(totals(ROOT), indent=1) + "\n", encoding="utf-8")
    if arguments.store or arguments.total:
        print_totals()
        return
    work_tree = subprocess.run(
        ["git", "stash", "create"], cwd=ROOT, capture_output=True, check=True, text=True
    ).stdout.strip()
    print_sizes(sizes(work_tree or "HEAD"), sizes(arguments.commit) if arguments.commit else {})
    every = list(functions(ROOT))
    for title, key in (("longest", "lines"), ("most complex", "complexity")):
        print(f"\n{title}")
        for function in sorted(every, key=lambda item: -getattr(item, key))[:LISTED]:
            print(f"{getattr(function, key):4}  {function.place} {function.name}")


if __name__ == "__main__":
    main()
