#!/usr/bin/python3
"""Plots what `match.py --json` wrote: one panel a figure, the scenes side by side, a bar a matcher.

usage: plot_match.py MATCH.json OUT.png
Needs Debian's python3-matplotlib."""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

PANELS = [("bad-2, %", lambda r: r["bad_2_percent"]),
          ("bad-2 of the pixels that both views see, %", lambda r: r["bad_2_nonoccluded_percent"]),
          ("near discontinuities: wrong side or unknown, %",
           lambda r: r["edge_wrong_percent"] + r["edge_unknown_percent"]),
          ("roughness of planes, px", lambda r: r["roughness_px"]),
          ("disparity stage, s", lambda r: r["seconds"]["median"])]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as f:
        rows = json.load(f)["rows"]
    if not rows:
        sys.exit("plot_match: %s holds no rows" % sys.argv[1])
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    methods = list(dict.fromkeys((r["method"], r["backend"]) for r in rows))
    by_name = {(r["scene"], r["method"], r["backend"]): r for r in rows}
    width = 0.8 / len(methods)
    picture, axes = plt.subplots(len(PANELS), 1, figsize=(max(6, 0.9 * len(scenes) + 2), 2.3 * len(PANELS)),
                                 sharex=True)
    for axis, (title, figure) in zip(axes, PANELS):
        for i, method in enumerate(methods):
            bars = [(s, by_name[(scene, *method)]) for s, scene in enumerate(scenes) if (scene, *method) in by_name]
            axis.bar([s + (i - (len(methods) - 1) / 2) * width for s, _ in bars], [figure(r) for _, r in bars],
                     width, color="C%d" % (i % 10), label=" on ".join(method))
        axis.set_title(title, fontsize=9, loc="left")
        axis.grid(True, axis="y", alpha=0.25)
    axes[-1].set_yscale("log")
    axes[-1].set_xticks(range(len(scenes)), scenes, rotation=30, ha="right", fontsize=8)
    handles, labels = axes[0].get_legend_handles_labels()
    picture.legend(handles, labels, loc="upper right", ncol=len(methods), frameon=False, fontsize=9)
    picture.tight_layout()
    picture.savefig(sys.argv[2], dpi=80, metadata={"Software": "hexrelief"})


if __name__ == "__main__":
    main()
