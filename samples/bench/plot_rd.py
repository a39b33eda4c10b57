#!/usr/bin/python3
"""Plots what `rd.py --json` wrote: bytes against error, one panel a map.

usage: plot_rd.py RD.json OUT.png [FIGURE]
FIGURE is duo_rmse_near_px (default), rmse_near_px, flat_rmse_px or sheet_share. Needs Debian's python3-matplotlib."""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

TITLES = {"duo_rmse_near_px": "duo, px", "rmse_near_px": "near, px", "flat_rmse_px": "flat, px",
          "sheet_share": "share of rubber sheet"}


def curves(points, figure):
    by_method = {}
    for p in points:
        if p[figure] > 0:
            by_method.setdefault(p["method"], []).append((p["bytes"], p[figure]))
    return {method: sorted(curve) for method, curve in by_method.items()}


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    figure = sys.argv[3] if len(sys.argv) == 4 else "duo_rmse_near_px"
    if figure not in TITLES:
        sys.exit("plot_rd: unknown figure '%s'; choose among %s" % (figure, ", ".join(TITLES)))
    with open(sys.argv[1]) as f:
        table = json.load(f)
    maps = list(dict.fromkeys(p["map"] for p in table["points"]))
    methods = list(dict.fromkeys(p["method"] for p in table["points"]))
    colour = {method: "C%d" % (i % 10) for i, method in enumerate(methods)}
    columns = min(3, len(maps))
    rows = -(-len(maps) // columns)
    picture, axes = plt.subplots(rows, columns, figsize=(4.6 * columns, 3.6 * rows), squeeze=False)
    for axis in axes.flat[len(maps):]:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, maps):
        for method, curve in curves([p for p in table["points"] if p["map"] == name], figure).items():
            other = method in table["peers"]  # not a preset of this program
            axis.loglog(*zip(*curve), color=colour[method], marker=".", label=method,
                        linestyle="--" if other else "-", linewidth=1 if other else 1.6)
        axis.set_title(name, fontsize=10)
        axis.set_xlabel("bytes")
        axis.set_ylabel(TITLES[figure])
        axis.grid(True, which="both", alpha=0.25)
    handles = {}
    for axis in axes.flat:
        handles.update({label: handle for handle, label in zip(*axis.get_legend_handles_labels())})
    picture.legend(handles.values(), handles.keys(), loc="upper center", ncol=len(handles), frameon=False)
    picture.tight_layout(rect=(0, 0, 1, 1 - 0.35 / (3.6 * rows)))
    picture.savefig(sys.argv[2], dpi=80, metadata={"Software": "hexrelief"})


if __name__ == "__main__":
    main()
