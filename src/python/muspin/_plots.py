"""Pictures of a results folder in matplotlib: the numbers of a picture's table, on the axes of its SVG."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

_SVG = "{http://www.w3.org/2000/svg}"
#: Letters of labels and units as the column names of a table write them.
_LABEL, _UNIT = {"µ": "mu", "σ": "sigma"}, {"°": "deg", "µ": "u", "/": " per ", "·": " "}


@dataclass
class _Panel:
    """A panel of a picture with its curves: name, abscissae, ordinates."""

    left_top_right_bottom: list[float]
    x: list[Any]
    y: list[Any]
    title: str = ""
    curves: list[tuple[str, list[Any], list[Any]]] = field(default_factory=list)


def _slug(text: str) -> str:
    for letter, words in _LABEL.items():
        text = text.replace(letter, words)
    return "_".join(re.findall(r"[^\W_]+", text.lower()))


def _key(axis: list[Any]) -> str:
    unit = str(axis[4])
    for letter, words in _UNIT.items():
        unit = unit.replace(letter, words)
    return "_".join(part for part in (_slug(str(axis[3])), _slug(unit)) if part)


def _values(cells: list[str]) -> list[Any]:
    """Numbers, or the names of positions."""
    try:
        return [float(cell) if cell else float("nan") for cell in cells]
    except ValueError:
        return cells


def _texts(svg: Any) -> list[tuple[str, float, float]]:
    """Every text of a picture with its place."""
    found = []
    for text in svg.iter(f"{_SVG}text"):
        words = "".join(text.itertext()).strip()
        found.append((words, float(text.get("x", "nan")), float(text.get("y", "nan"))))
    return found


def _looks(svg: Any) -> dict[str, tuple[str, str]]:
    """Colour and dash of each curve of the legend."""
    looks = {}
    parts = list(svg.iter())
    for line, text in zip(parts, parts[1:]):
        if line.tag == f"{_SVG}polyline" and text.tag == f"{_SVG}text" and line.get("stroke") not in (None, "none"):
            dash = "--" if line.get("stroke-dasharray") else "-"
            looks.setdefault("".join(text.itertext()).strip(), (str(line.get("stroke")), dash))
    return looks


def _titles(panels: list[_Panel], texts: list[tuple[str, float, float]], names: set[str]) -> None:
    """Gives each panel the nearest text of `names` that begins above its left edge."""
    for panel in panels:
        left, top, _, _ = panel.left_top_right_bottom
        above = [text for text in texts if text[0] in names and abs(text[1] - left) < 2.0 and text[2] <= top]
        panel.title = max(above, key=lambda text: text[2])[0] if above else ""


def _fill_long(panels: list[_Panel], rows: list[list[str]], texts: list[tuple[str, float, float]]) -> None:
    _titles(panels, texts, {row[0] for row in rows})
    groups: dict[tuple[str, str], list[list[str]]] = {}
    for row in rows:
        groups.setdefault((row[0], row[1]), []).append(row)
    for (title, name), found in groups.items():
        panel = next((panel for panel in panels if panel.title == title), panels[0] if len(panels) == 1 else None)
        if panel is not None:
            panel.curves.append((name, _values([row[2] for row in found]), _values([row[3] for row in found])))


def _fill_wide(panels: list[_Panel], head: list[str], rows: list[list[str]], texts: list[tuple[str, float, float]]) -> None:
    columns = [_values([row[k] for row in rows]) for k in range(len(head))]
    prefixes = {words for words, _, _ in texts if words and any(name.startswith(f"{_slug(words)}_") for name in head[1:])}
    if len(panels) > 1:
        _titles(panels, texts, prefixes)
    for name, column in zip(head[1:], columns[1:]):
        def fits(panel: _Panel) -> bool:
            start = f"{_slug(panel.title)}_" if panel.title else ""
            return name.startswith(start) and re.search(rf"(^|_){re.escape(_key(panel.y))}(_\d+)?$", name) is not None
        # The longest title that fits: one may begin as another does.
        panel = max(filter(fits, panels), key=lambda panel: len(panel.title), default=None)
        if panel is None:
            continue
        start = len(_slug(panel.title)) + 1 if panel.title else 0
        short = re.sub(rf"_?{re.escape(_key(panel.y))}(_\d+)?$", "", name[start:])
        panel.curves.append((short, columns[0], column))


def _draw(axes: Any, panel: _Panel, looks: dict[str, tuple[str, str]]) -> None:
    for axis, set_scale, set_label in ((panel.x, axes.set_xscale, axes.set_xlabel), (panel.y, axes.set_yscale, axes.set_ylabel)):
        if axis[0]:
            set_scale("log")
        set_label(f"{axis[3]} ({axis[4]})" if axis[4] else axis[3])
    by_slug = {_slug(name): (name, *look) for name, look in looks.items()}
    labelled = set()
    for k, (name, x, y) in enumerate(panel.curves):
        # Lower edges and error bars stand behind the values that they belong to.
        after = panel.curves[k + 1] if k + 1 < len(panel.curves) else ("", [], [])
        extra = re.fullmatch(rf"{re.escape(name)}[_ ](lower|standard[_ ]deviation)", after[0])
        if re.search(r"[_ ](lower|standard[_ ]deviation)$", name):
            continue
        # A table has a row for every abscissa of any curve.
        kept = [k for k, cell in enumerate(y) if cell == cell]
        edge = [after[2][k] for k in kept] if extra else []
        x, y = [x[k] for k in kept], [y[k] for k in kept]
        words, color, dash = by_slug.get(_slug(name), (name, None, "-"))
        label = words if words not in labelled else None
        labelled.add(words)
        if extra and extra[1] == "lower":
            axes.fill_between(x, edge, y, color=color, alpha=0.25, label=label)
        elif any(isinstance(cell, str) for cell in y):
            axes.barh(y, x, label=label)
        elif any(isinstance(cell, str) for cell in x):
            axes.plot(x, y, marker="o", linestyle="none", color=color, label=label)
        else:
            axes.plot(x, y, color=color, linestyle=dash, marker="o" if len(x) < 16 else None, label=label)
        if extra and extra[1] != "lower":
            axes.errorbar(x, y, yerr=edge, fmt="none", ecolor="grey")
    if panel.title:
        axes.set_title(panel.title)
    if any(words for words in labelled):
        axes.legend(fontsize="small")


def draw(table: str, picture: str) -> Any:
    """The matplotlib figure of a picture, its SVG and its table given as texts."""
    try:
        from matplotlib import pyplot  # type: ignore[import-untyped,import-not-found,unused-ignore]
    except ImportError as error:
        raise ImportError("plot needs matplotlib: pip install matplotlib") from error
    svg = ElementTree.fromstring(picture)
    metadata = svg.find(f"{_SVG}metadata")
    panels = [_Panel(p["r"], p["x"], p["y"]) for p in json.loads(metadata.text if metadata is not None and metadata.text else "[]")]
    head, *rows = list(csv.reader(io.StringIO(table)))
    if not panels:
        raise ValueError("this picture has no axes; its file is for a browser")
    texts = _texts(svg)
    if head[:2] == ["panel", "series"]:
        _fill_long(panels, rows, texts)
    else:
        _fill_wide(panels, head, rows, texts)
    # Panels side by side share their upper edge.
    tops = sorted({panel.left_top_right_bottom[1] for panel in panels})
    lefts = sorted({panel.left_top_right_bottom[0] for panel in panels})
    size = (4.5 * len(lefts) + 2.5, 2.6 * len(tops) + 1.4)
    figure, grid = pyplot.subplots(len(tops), len(lefts), squeeze=False, figsize=size, layout="constrained")
    for axes in grid.flat:
        axes.set_visible(False)
    looks = _looks(svg)
    for panel in panels:
        left, top, _, _ = panel.left_top_right_bottom
        axes = grid[tops.index(top)][lefts.index(left)]
        axes.set_visible(True)
        _draw(axes, panel, looks)
    title = svg.find(f"{_SVG}title")
    figure.suptitle(title.text if title is not None else "")
    return figure
