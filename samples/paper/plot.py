#!/usr/bin/python3
"""Draws the paper's Figs. 8 to 13 from what `bench_paper --json` wrote.

usage: plot.py JSON... [-o FOLDER]
Writes fig08.png to fig13.png into FOLDER (default: beside this script), those whose experiment the files hold. Several files
are taken together; each experiment comes from the last one that holds it. Needs Debian's python3-matplotlib."""
import argparse
import json
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D

# Table 2's averages: pixels, GPU s, CPU s.
PAPER_SIZES = [(154926, 0.33, 2.32), (163185, 0.63, 3.46), (514961, 1.08, 13.69), (2059845, 2.00, 79.48)]
FOLDER = os.path.dirname(os.path.abspath(__file__))
OURS, PAPER, CPU = "C0", "C3", "C7"


def rows_of(files):
    rows, device = {}, ""
    for name in files:
        with open(name) as f:
            table = json.load(f)
        device = table["device"]
        for experiment in {row["experiment"] for row in table["rows"]}:
            rows[experiment] = [row for row in table["rows"] if row["experiment"] == experiment]
    return rows, device


def named(row):
    return row["map"] if row["map"] != "made-up" else "%dx%d" % (row["width"], row["height"])


def in_order(values):
    return list(dict.fromkeys(values))


def kernels_ms(row):
    return sum(row["kernels_ms"].values()) if "kernels_ms" in row else row["som_ms"]["median"]


def grid(axis):
    axis.grid(True, which="both", alpha=0.25)


def fig08(rows):
    """Memory organisations: bars by map."""
    maps = in_order(named(r) for r in rows)
    series = [("MOV1", "1", "#f4a582"), ("MOV2", "2", "#d6604d"), ("MOV2_Tex", "2-texture", "#8c2d1a"), ("hexrelief", None, OURS)]
    picture, axis = plt.subplots(figsize=(8, 4))
    for k, (label, memory, colour) in enumerate(series):
        heights = [next((kernels_ms(r) for r in rows if named(r) == m and r.get("memory") == memory), 0) for m in maps]
        bars = axis.bar([i + 0.2 * (k - 1.5) for i in range(len(maps))], heights, 0.2, label=label, color=colour)
        axis.bar_label(bars, fmt="%.0f", fontsize=6)
    axis.set_xticks(range(len(maps)), maps)
    axis.set_ylabel("SOM kernels, %d iterations, ms" % rows[0]["iterations"])
    axis.set_yscale("log")
    axis.legend(frameon=False, ncol=4, loc="upper left", fontsize=8)
    axis.set_ylim(1, 10 * max(kernels_ms(r) for r in rows))
    return picture


def fig09(rows):
    """Block sizes: a panel for each co."""
    parts = in_order(r["co"] for r in rows)
    picture, axes = plt.subplots(1, len(parts), figsize=(4.2 * len(parts), 3.6), sharey=True, squeeze=False)
    for axis, co in zip(axes[0], parts):
        here = [r for r in rows if r["co"] == co]
        blocks = in_order(next(iter(r["block"].values())) for r in here)
        single = [next(r for r in here if r["block"].get("single") == b)["kernels_ms"]["single"] for b in blocks]
        multiple = [next(r for r in here if r["block"].get("search") == b)["kernels_ms"] for b in blocks]
        x = range(len(blocks))
        axis.plot(x, single, "-o", color=PAPER, label="SK")
        axis.plot(x, [sum(m.values()) for m in multiple], "-s", color="C1", label="MK")
        for key, label, marker in (("extraction", "MK_E", "^"), ("search", "MK_S", "v"), ("learning", "MK_L", "D")):
            axis.plot(x, [m[key] for m in multiple], "--" + marker, linewidth=1, markersize=4, label=label)
        axis.set_xticks(x, blocks)
        axis.set_title("co = %d" % co, fontsize=10)
        axis.set_xlabel("threads of a block")
        grid(axis)
    axes[0][0].set_ylim(0, 1.05 * max(kernels_ms(r) for r in rows))  # shared by all
    axes[0][0].set_ylabel("kernels, %d iterations, ms" % rows[0]["iterations"])
    axes[0][0].legend(frameon=False, fontsize=8, loc="upper left")
    return picture


def fig10(rows):
    """Single against multiple kernels, each at its fastest blocks."""
    parts = in_order(r["co"] for r in rows)
    picture, axis = plt.subplots(figsize=(6, 3.8))
    for k, (label, kernels, colour) in enumerate((("SK", "single", PAPER), ("MK", "multiple", "C1"), ("hexrelief", None, OURS))):
        heights = [next(kernels_ms(r) for r in rows if r["co"] == co and r.get("kernels") == kernels) for co in parts]
        bars = axis.bar([i + 0.27 * (k - 1) for i in range(len(parts))], heights, 0.27, label=label, color=colour)
        axis.bar_label(bars, fmt="%.0f", fontsize=7)
    axis.set_xticks(range(len(parts)), ["co = %d" % co for co in parts])
    axis.set_ylabel("SOM kernels, %d iterations, ms" % rows[0]["iterations"])
    axis.legend(frameon=False, fontsize=8)
    return picture


def fig11(rows):
    """Time against %cost by SSR (colour) and CRR (along the line)."""
    maps = in_order(named(r) for r in rows)
    picture, axes = plt.subplots(2, len(maps), figsize=(4.2 * len(maps), 6.4), squeeze=False)
    ranges = in_order(r["ssr"] for r in rows)
    for column, name in enumerate(maps):
        for line, (solver, title) in enumerate((("paper", "the paper's program"), ("hexrelief", "hexrelief"))):
            axis = axes[line][column]
            for k, ssr in enumerate(ranges):
                here = [r for r in rows if named(r) == name and r["solver"] == solver and r["ssr"] == ssr and "percent_cost" in r]
                axis.plot([r["som_ms"]["median"] for r in here], [r["percent_cost"] for r in here], "-", color="C%d" % k,
                          linewidth=0.8, marker=".", markersize=4, label="SSR %s" % (ssr or "inf"))
                for r in here:
                    if r["crr"] in (1, 100):
                        axis.annotate(str(r["crr"]), (r["som_ms"]["median"], r["percent_cost"]), fontsize=5)
            axis.set_title("%s, %s" % (name, title), fontsize=9)
            axis.set_xlabel("SOM, ms")
            grid(axis)
    for line in axes:
        line[0].set_ylabel("%cost")
    axes[0][0].legend(frameon=False, fontsize=7, ncol=2)
    return picture


def fig12(rows):
    """%cost against iterations."""
    maps = in_order(named(r) for r in rows)
    picture, axes = plt.subplots(1, 2, figsize=(9, 3.8))
    for axis, solver, title in ((axes[0], "paper", "the paper's program"), (axes[1], "hexrelief", "hexrelief")):
        for k, name in enumerate(maps):
            here = [r for r in rows if named(r) == name and r["solver"] == solver and "percent_cost" in r]
            axis.plot([r["iterations"] for r in here], [r["percent_cost"] for r in here], "-", marker=".", color="C%d" % k,
                      label=name)
        axis.set_title(title, fontsize=10)
        axis.set_xlabel("iterations")
        axis.set_ylim(bottom=0)
        grid(axis)
    axes[0].set_ylabel("%cost")
    axes[1].legend(frameon=False, fontsize=8)
    return picture


def fig13(rows):
    """Time against size: Table 2's maps as dots, the made-up scene as lines."""
    picture, axis = plt.subplots(figsize=(8, 5))
    styles = [("paper", PAPER, "o", "the paper's program, this device"),
              ("hexrelief", OURS, "s", "hexrelief, the paper's schedule"),
              ("default", "C2", "^", "hexrelief, default without balancing"),
              ("balanced", "C4", "v", "hexrelief, default (whole stage)"),
              ("cpu", CPU, "D", "hexrelief on the CPU, the paper's schedule (whole stage)")]
    for solver, colour, marker, label in styles:
        here = [r for r in rows if r["solver"] == solver]
        key = "stage_ms" if solver in ("cpu", "balanced") else "som_ms"
        point = lambda r: (r["width"] * r["height"], r[key]["median"] * 1e-3)
        scene = sorted(point(r) for r in here if r["map"] == "made-up")
        maps = [point(r) for r in here if r["map"] != "made-up"]
        if scene:
            axis.plot(*zip(*scene), color=colour, marker=marker, markersize=4, linewidth=1.2, label=label)
        if maps:
            axis.plot(*zip(*maps), linestyle="", color=colour, marker=marker, markersize=4, markerfacecolor="none")
    axis.plot([p for p, _, _ in PAPER_SIZES], [g for _, g, _ in PAPER_SIZES], ":o", color="k", markersize=3, linewidth=1,
              label="the paper's figures, GPU of 2012")
    axis.plot([p for p, _, _ in PAPER_SIZES], [c for _, _, c in PAPER_SIZES], ":x", color="k", markersize=4, linewidth=1,
              label="the paper's figures, CPU")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("pixels")
    axis.set_ylabel("s")
    grid(axis)
    handles, labels = axis.get_legend_handles_labels()
    handles.append(Line2D([], [], linestyle="", marker="o", markerfacecolor="none", color="0.4"))
    labels.append("open: Middlebury's maps; lines: made-up scene")
    axis.legend(handles, labels, frameon=False, fontsize=7)
    return picture


FIGURES = {"memory": ("fig08", fig08), "blocks": ("fig09", fig09), "kernels": ("fig10", fig10), "tradeoff": ("fig11", fig11),
           "iterations": ("fig12", fig12), "size": ("fig13", fig13)}


def save(picture, path):
    """A palette PNG: a third of the bytes."""
    picture.savefig(path, dpi=90, metadata={"Software": "hexrelief"})
    plt.close(picture)
    try:
        from PIL import Image
    except ImportError:
        return
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(64)
    small.save(path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="JSON")
    parser.add_argument("-o", default=FOLDER, metavar="FOLDER")
    arguments = parser.parse_args()
    rows, device = rows_of(arguments.files)
    known = [experiment for experiment in FIGURES if rows.get(experiment)]
    if not known:
        sys.exit("plot.py: none of the files holds an experiment's rows")
    for experiment in known:
        name, draw = FIGURES[experiment]
        picture = draw(rows[experiment])
        picture.suptitle("%s: %s" % (name.replace("fig0", "Fig. ").replace("fig", "Fig. "), device), fontsize=9)
        picture.tight_layout()
        path = os.path.join(arguments.o, name + ".png")
        save(picture, path)
        print(path)


if __name__ == "__main__":
    main()
