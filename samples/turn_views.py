#!/usr/bin/python3
"""Draws what `hexrelief run -o NAME.obj` wrote, with its texture, from cameras beside the left one, a row for each file.

usage: turn_views.py OUT.jpg BASELINE A.obj [B.obj ...]
From half a baseline left of the left camera, from that camera, from the right one, and from half a baseline right of it; what is as
deep as the nearest quarter of the vertices stays in place. Needs what side_views.py needs."""
import sys

import numpy as np
from PIL import Image

from side_views import BACKDROP, draw, project, read_obj

PLACES = (-0.5, 0, 1, 1.5)  # baselines right of the left camera


def moved(obj, right, depth):
    """The mesh as a camera `right` of its own sees it, with what is so deep in its place."""
    positions = obj[0].copy()
    positions[:, 0] += right * (-positions[:, 2] / depth - 1)
    return (positions, *obj[1:])


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    out, baseline, paths = sys.argv[1], float(sys.argv[2]), sys.argv[3:]
    objs = [read_obj(path) for path in paths]
    depth = np.percentile(-objs[0][0][:, 2], 25)
    pivot = np.array([0, 0, -depth])
    u, v, _ = project(objs[0][0], pivot, 0)
    frame = (u.min(), v.min(), u.max(), v.max(), pivot)
    gap = ((0, 6), (0, 6), (0, 0))
    rows = []
    for obj in objs:
        pictures = [draw(moved(obj, place * baseline, depth), 0, frame) for place in PLACES]
        rows.append(np.hstack([np.pad(picture, gap, constant_values=BACKDROP) for picture in pictures]))
    Image.fromarray(np.vstack(rows)).save(out, quality=85, optimize=True)


if __name__ == "__main__":
    main()
