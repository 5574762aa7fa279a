"""The extension's documentation as plain HTML: text, links and headings, without pictures."""

import html
import re
import shutil
from pathlib import Path

LEFT_OUT = {"reference"}  # made by Sphinx from the code
PAGE = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>{title}</title>
<style>
body {{
  font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em;
  white-space: pre-wrap
}}
h1, h2, h3 {{ margin: 0 }}</style>
<body>{text}</body></html>
"""


def write(docs: Path, manual: Path) -> None:
    """Write the pages of the folder ``docs`` (Markdown), and the schemas in it, to ``manual``,
    replacing its content."""
    shutil.rmtree(manual, ignore_errors=True)
    for source in sorted(docs.rglob("*.md")):
        if source.stem not in LEFT_OUT:
            target = (manual / source.relative_to(docs)).with_suffix(".html")
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(
                page(source.read_text(encoding="utf-8"), source, docs), encoding="utf-8"
            )
    for source in docs.glob("*.json"):  # the schema, to which a page links
        (manual / source.name).write_bytes(source.read_bytes())


def page(text: str, source: Path, docs: Path) -> str:
    """A page of Markdown as HTML. Lists of pages (toctree) become links."""
    lines = html.escape(text, quote=False).replace("\n  ", "\n\N{NO-BREAK SPACE} ")
    lines = re.sub(
        r"```\{toctree\}\n(.*?)```",
        lambda found: _contents(found[1], source.parent),
        lines,
        flags=re.S,
    )
    lines = re.sub(r"!\[([^\]]*)\]\([^)]*\)\n?", "", lines)
    lines = re.sub(r"\[([^\]]+)\]\(([^)\s]+)\)", _link, lines)
    lines = re.sub(r"\*\*([^*\n]+)\*\*", r"<b>\1</b>", lines)
    lines = re.sub(r"(?<![*\w])\*([^*\n]+)\*(?!\w)", r"<i>\1</i>", lines)
    lines = re.sub(
        r"^(#{1,3}) (.*)$",
        lambda found: f"<h{len(found[1])}>{found[2]}</h{len(found[1])}>",
        lines,
        flags=re.M,
    )
    title = re.search(r"^# (.*)$", text, flags=re.M)
    return PAGE.format(title=html.escape(title[1] if title else source.stem), text=_flowing(lines))


def _link(found: re.Match[str]) -> str:
    target = re.sub(r"\.md(?=#|$)", ".html", found[2])
    return f'<a href="{target}">{found[1]}</a>'


def _contents(entries: str, folder: Path) -> str:
    """The pages that a list of contents names, as links."""
    names = [line for line in entries.splitlines() if line and not line.startswith(":")]
    pages = [
        path
        for name in names
        for path in sorted(folder.glob(f"{name}.md"))
        if path.stem not in LEFT_OUT
    ]
    links = (path.relative_to(folder).with_suffix(".html").as_posix() for path in pages)
    return "\n".join(
        f'<a href="{link}">{link.removesuffix(".html").replace("_", " ")}</a>' for link in links
    )


def _flowing(lines: str) -> str:
    """Join the lines of a paragraph, which the browser wraps."""
    return re.sub(r"(?<=[^\n>|])\n(?=[\w(<*\[`\N{LEFT DOUBLE QUOTATION MARK}])(?!<h)", " ", lines)
