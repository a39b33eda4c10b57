#!/usr/bin/python3
"""Prints the table of holes in BENCHMARKS.md: Middlebury's pairs at the defaults, the left view alone and whole.

usage: hole_table.py DIR [PROGRAM]
DIR holds Middlebury's sets as BENCHMARKS.md lists them, with images, and middlebury2014-quarter/Piano. PROGRAM is
build/hexrelief by default. Needs what side_views.py needs."""
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from side_views import draw_with_depth, read_obj  # noqa: E402

PAIRS = {
    "tsukuba": "middlebury2001/tsukuba/left.png",
    "venus": "middlebury2001/venus/left.ppm",
    "cones": "middlebury2003/cones-quarter/left.png",
    "teddy": "middlebury2003/teddy-quarter/left.png",
    "aloe, half size": "middlebury2006/aloe-half/left.png",
    "rocks1, half size": "middlebury2006/rocks1-half/left.png",
    "Piano, quarter size": "middlebury2014-quarter/Piano/left.png",
    "Aloe 1282x1110": "middlebury2006/aloe-full/left_color.jpg",
}


def psnr_from_right(path, calibration, photo):
    """Of the mesh from the right camera, in dB: in each row from the first to the last pixel with a triangle; holes have the
    photograph's mean colour."""
    c, (height, width) = calibration, photo.shape[:2]
    positions, *rest = read_obj(path)
    depths = -positions[:, 2]
    # x - d, with d = focal * baseline / depth - doffs
    positions[:, 0] += c["baseline_m"] * (c["doffs_px"] * depths / (c["focal_px"] * c["baseline_m"]) - 1)
    frame = (-c["cx"] / c["focal_px"], -c["cy"] / c["focal_px"], (width - c["cx"]) / c["focal_px"],
             (height - c["cy"]) / c["focal_px"], np.zeros(3))
    picture, nearest = draw_with_depth((positions, *rest), 0, frame, height)
    covered = nearest > 0
    inside = np.maximum.accumulate(covered, 1) & np.maximum.accumulate(covered[:, ::-1], 1)[:, ::-1]
    drawn = np.where(covered[..., None], picture, photo[inside].mean(0))
    return 10 * math.log10(255**2 / np.mean((drawn - photo)[inside]**2))


def measure(program, left, folder, views):
    right = left.replace("left", "right")
    mesh, glb, report = (os.path.join(folder, f"mesh.{ending}") for ending in ("obj", "glb", "json"))
    subprocess.run([program, "run", "--quiet", "--left", left, "--right", right, "--set", f"surface.views={views}", "-o", mesh,
                    "-o", glb, "--report", report], check=True)
    found = json.load(open(report))
    surface = found["surface"]
    photo = np.asarray(Image.open(right).convert("RGB")).astype(float)
    return {"right": 100 * surface["hole_share"], "above": 100 * surface["hole_share_above"],
            "psnr": psnr_from_right(mesh, found["input"]["calibration"], photo), "triangles": surface["triangles"],
            "bytes": os.path.getsize(glb)}


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    data, program = sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else "build/hexrelief"
    print("| pair | right camera, % | one above, % | PSNR, dB | triangles | bytes |\n| --- | --- | --- | --- | --- | --- |")
    for name, left in PAIRS.items():
        with tempfile.TemporaryDirectory() as folder:
            alone, both = (measure(program, os.path.join(data, left), folder, views) for views in ("left", "both"))
        figures = [f"{alone[key]:.{digits}f} -> {both[key]:.{digits}f}"
                   for key, digits in (("right", 2), ("above", 2), ("psnr", 1))]
        figures += [f"{both[key] / alone[key]:.2f}" for key in ("triangles", "bytes")]
        print(f"| {name} | {' | '.join(figures)} |", flush=True)


if __name__ == "__main__":
    main()
