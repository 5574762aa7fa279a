"""The results of a study with people: tables, and a page that lays them out like the paper's."""

from __future__ import annotations

import json
import tomllib
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from pandas import DataFrame, Series

from ...core.formats.io.atomic import write_text
from ...core.forms import Form, JsonObject
from .body import body
from .plan import HERE
from .record import read_plan, scores, tidy
from .statistics import friedman, pairs, share

FEWEST = 6
"""People below whose number nothing is tested."""
LEAST_MISSED = 100.0
"""Milliseconds of a section from which on it is listed if they were not played."""
PUBLISHED = tomllib.loads((HERE / "published.toml").read_text("utf-8"))
"""What the paper prints."""


def analyse(folder: Path) -> list[Path]:
    """Write all answers and the tables as CSV, and ``analysis.html``, into the folder of a study.
    Raises ValueError."""
    plan = read_plan(folder)
    form, answers = plan["form"], tidy(folder, plan)
    if not (answers["step"] == "rank").any():
        raise ValueError(f"{folder}: nobody has ranked the conditions yet")
    kept = answers[answers["excluded"] == ""]
    rated = scores(kept, form)
    factors = {name: rated[name] for name in rated.columns.unique(0) if len(rated) >= FEWEST}
    reasons = answers.groupby("participant")["excluded"].first()
    missed = answers[answers["item"] == "missed_ms"].astype({"value": float})
    missed = missed[missed["value"] > LEAST_MISSED].rename(columns={"value": "ms"})
    places, maps = _places(kept, plan)
    tables = {
        "excluded": reasons[reasons != ""].reset_index(),
        "preferred": DataFrame(_preferred(rated["(ranking)"])),
        "factors": DataFrame(
            {"factor": name, **friedman(ratings), "paper": PUBLISHED["friedman"].get(name)}
            for name, ratings in factors.items()
        ),
        "pairs": DataFrame(
            {"factor": name, **row, "paper": PUBLISHED["pairs"].get(name, {}).get(row["pair"])}
            for name, ratings in factors.items()
            for row in pairs(ratings, form["smallest_effect"])
        ),
        "places": DataFrame(places),
        "missed": missed[["participant", "condition", "scene", "ms"]],
    }
    text = Template((HERE / "analysis.html").read_text("utf-8")).substitute(
        {
            name: table.to_html(
                index=False, na_rep="", border=0, classes="numbers", float_format="%.3g"
            )
            for name, table in tables.items()
        },
        title=escape(form["title"]),
        style=(HERE.parent / "report.css").read_text("utf-8"),
        count=len(reasons),
        planned=len(plan["orders"]),
        kept=(reasons == "").sum(),
        rules=json.dumps(form["exclusion"]),
        ranks=_ranks(rated["(ranking)"]),
        effect=form["smallest_effect"],
        maps=maps,
    )
    tables["answers"] = answers.assign(value=answers["value"].map(_plain))
    files = {f"{name}.csv": table.to_csv(index=False) for name, table in tables.items()}
    files["analysis.html"] = text
    return [write_text(folder / name, [content]) for name, content in files.items()]


def _plain(value: Any) -> Any:
    """An answer as spreadsheets show it: text that they would take for a formula behind a quote."""
    is_formula = isinstance(value, str) and value.lstrip().startswith(("=", "+", "-", "@"))
    return f"'{value}" if is_formula else value


def _preferred(order: DataFrame) -> list[JsonObject]:
    """First choices and mean ranks by condition."""
    first = (order == 1).sum()
    return [
        {"condition": name, "people": first[name], "mean rank": column.mean()}
        | share("share", first[name], len(column))
        | {"paper": PUBLISHED["preferred"].get(name)}
        for name, column in order.items()
        if len(column)
    ]


def _places(kept: DataFrame, plan: Form) -> tuple[list[JsonObject], str]:
    """Where vibration was felt against where it was: rows, and maps as HTML."""
    rows, maps = [], ""
    placed = kept[kept["step"] == "place"].groupby(["scene", "condition"], sort=False)
    for (scene, condition), group in placed:
        listeners = Series(plan["levels"][condition][scene], plan["listeners"])
        levels = (listeners**2).groupby(level=0, sort=False).sum() ** 0.5  # of each body part
        felt, noticed = group.dropna(subset="x"), group.loc[group["item"] == "noticed", "value"]
        strongest = levels.idxmax()
        rows.append(
            {
                "scene": scene,
                "condition": condition,
                "strongest": strongest,
                **share("noticed", noticed.sum(), len(noticed)),
                "at the strongest": (felt["value"] == strongest).mean(),
            }
        )
        shares = (levels / (levels.max() or 1.0)).to_dict()
        picture = body(shares, *felt[["item", "x", "y"]].to_numpy())
        caption = escape(f"{scene}, {condition}")
        maps += f"<figure>{picture}<figcaption>{caption}</figcaption></figure>"
    return rows, maps


def _ranks(order: DataFrame) -> str:
    """How many people gave each condition which rank, as a table of bars."""
    ranks = order.astype(int).rename(columns=escape)
    counts = ranks.apply(Series.value_counts).T.add_prefix("rank ").fillna(0).astype(float)
    bar = f'{{0:g}} <meter max="{len(order)}" value="{{0:g}}"></meter>'.format
    return str(counts.to_html(escape=False, border=0, float_format=bar))
