#!/usr/bin/python3
"""Draws what `hexrelief run -o NAME.obj` wrote, with its texture, from 20 degrees to the left and to the right.

usage: side_views.py OUT.jpg FILES_A_ROW [--angle=DEGREES] A.obj [B.obj ...]
Left view and right view of each file; the camera goes around a point as deep as the nearest quarter of the vertices. A file that
is no .obj is a picture, which stands there as it is. Needs Debian's python3-numpy and python3-pil (python3-matplotlib brings
both)."""
import math
import os
import re
import sys

import numpy as np
from PIL import Image

ANGLE_DEG = 20
HEIGHT_PX = 240
BACKDROP = 255


def read_obj(path):
    folder = os.path.dirname(path)
    positions, texcoords, triangles, texture = [], [], [], None
    vertices = {}  # (place, place in the texture) -> number, as only these two together make a vertex
    for line in open(path):
        kind, *rest = line.split() or [""]
        if kind == "v":
            positions.append([float(v) for v in rest[:3]])
        elif kind == "vt":
            texcoords.append([float(v) for v in rest[:2]])
        elif kind == "f":
            corners = [tuple(int(number) - 1 for number in corner.split("/")[:2]) for corner in rest]
            triangles.append([vertices.setdefault(corner, len(vertices)) for corner in corners])
        elif kind == "mtllib":
            found = re.search(r"map_Kd (.+)", open(os.path.join(folder, rest[0])).read())
            texture = found and Image.open(os.path.join(folder, found.group(1))).convert("RGB")
    if not triangles or texture is None:
        sys.exit(f"{path}: no triangles, or no texture; was the run given a colour image?")
    places, places_in_texture = np.array(list(vertices)).T
    return np.array(positions)[places], np.array(texcoords)[places_in_texture], np.array(triangles), np.asarray(texture)


# As the file's camera at the origin sees it (x right, y down, in focal lengths), after it went around `pivot`.
def project(positions, pivot, angle):
    c, s = math.cos(angle), math.sin(angle)
    offset = positions - pivot
    turned = np.stack([c * offset[:, 0] - s * offset[:, 2], offset[:, 1], s * offset[:, 0] + c * offset[:, 2]], 1) + pivot
    depth = -turned[:, 2]
    return turned[:, 0] / depth, -turned[:, 1] / depth, depth


# Mixes the texture's four pixels around each place (0 to 1, row 0 on top).
def bilinear(texture, across, down):
    high, wide = texture.shape[:2]
    x, y = np.clip(across * wide - 0.5, 0, wide - 1), np.clip(down * high - 0.5, 0, high - 1)
    left, top = x.astype(int), y.astype(int)
    right, bottom = np.minimum(left + 1, wide - 1), np.minimum(top + 1, high - 1)
    u, v = (x - left)[..., None], (y - top)[..., None]
    upper = texture[top, left] * (1 - u) + texture[top, right] * u
    return upper * (1 - v) + (texture[bottom, left] * (1 - u) + texture[bottom, right] * u) * v


# Returns the picture inside the frame, and the inverse depth of each of its pixels, 0 where there is no triangle.
def draw_with_depth(obj, angle, frame, height):
    positions, texcoords, triangles, texture = obj
    x0, y0, x1, y1, pivot = frame
    scale = height / (y1 - y0)
    width = round((x1 - x0) * scale)
    u, v, depth = project(positions, pivot, angle)
    px, py = (u - x0) * scale, (v - y0) * scale
    picture = np.full((height, width, 3), BACKDROP, np.uint8)
    nearest = np.zeros((height, width))
    for t in triangles[np.all(depth[triangles] > 0, axis=1)]:
        ax, bx, cx = px[t]
        ay, by, cy = py[t]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        left, right = max(0, math.ceil(min(ax, bx, cx) - 0.5)), min(width - 1, math.floor(max(ax, bx, cx) - 0.5))
        top, bottom = max(0, math.ceil(min(ay, by, cy) - 0.5)), min(height - 1, math.floor(max(ay, by, cy) - 0.5))
        if area == 0 or left > right or top > bottom:
            continue
        x = np.arange(left, right + 1)[None, :] + 0.5
        y = np.arange(top, bottom + 1)[:, None] + 0.5
        lb = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
        lc = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
        la = 1 - lb - lc
        inverse = la / depth[t[0]] + lb / depth[t[1]] + lc / depth[t[2]]
        here = nearest[top:bottom + 1, left:right + 1]
        seen = (la >= 0) & (lb >= 0) & (lc >= 0) & (inverse > here)
        weights = np.stack([la / depth[t[0]], lb / depth[t[1]], lc / depth[t[2]]], -1)[seen] / inverse[seen][:, None]
        at = weights @ texcoords[t]
        here[seen] = inverse[seen]
        picture[top:bottom + 1, left:right + 1][seen] = np.rint(bilinear(texture, at[:, 0], 1 - at[:, 1]))
    return picture, nearest


def draw(obj, angle, frame):
    return draw_with_depth(obj, angle, frame, HEIGHT_PX)[0]


def views(path, angle_deg):
    if not path.endswith(".obj"):
        picture = Image.open(path).convert("RGB")
        return np.asarray(picture.resize((round(picture.width * HEIGHT_PX / picture.height), HEIGHT_PX), Image.Resampling.LANCZOS))
    obj = read_obj(path)
    pivot = np.array([0, 0, -np.percentile(-obj[0][:, 2], 25)])
    u, v, _ = project(obj[0], pivot, 0)
    frame = (u.min(), v.min(), u.max(), v.max(), pivot)
    return np.hstack([draw(obj, math.radians(angle), frame) for angle in (-angle_deg, angle_deg)])


def main():
    if len(sys.argv) < 4 or not sys.argv[2].isdigit() or sys.argv[2] == "0":
        sys.exit(__doc__)
    out, in_row, paths = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    angle_deg = float(paths.pop(0).removeprefix("--angle=")) if paths[0].startswith("--angle=") else ANGLE_DEG
    pictures = [np.pad(views(path, angle_deg), ((0, 6), (0, 6), (0, 0)), constant_values=BACKDROP) for path in paths]
    rows = [np.hstack(pictures[i:i + in_row]) for i in range(0, len(pictures), in_row)]
    wide = max(row.shape[1] for row in rows)
    rows = [np.pad(row, ((0, 0), (0, wide - row.shape[1]), (0, 0)), constant_values=BACKDROP) for row in rows]
    Image.fromarray(np.vstack(rows)).save(out, quality=80, optimize=True)


if __name__ == "__main__":
    main()
