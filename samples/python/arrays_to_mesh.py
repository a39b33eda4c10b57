#!/usr/bin/env python3
"""arrays_to_mesh.py [OUT]: from two pictures as NumPy arrays to a mesh, or to a page (relief.html)."""
import pathlib
import sys

import hexrelief

samples = pathlib.Path(__file__).parent.parent
left, right = (hexrelief.read_picture(samples / f"{side}.png") for side in ("left", "right"))
camera = hexrelief.Camera(focal_px=320, baseline_m=0.16)
disparity = hexrelief.compute_disparity(left, right, num_disparities_px=48)  # (H, W) float32, px
mesh = hexrelief.mesh(disparity, color=left, camera=camera)
print(mesh, "nearest", -mesh.vertices[:, 2].max(), "m, %cost", mesh.report["mesh"]["percent_cost"])
mesh.save(sys.argv[1] if len(sys.argv) > 1 else "relief.html")
