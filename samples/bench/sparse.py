#!/usr/bin/env python3
"""True maps thinned as a laser's are, and filled again: what that costs the surface.

Errors are of the surface against the whole true map. ratio: duo as a multiple of that of the whole map's own surface.
wrong: of the true map's pixels, filled more than 1 px off; unknown: not filled.
"""
import math

import numpy as np

import common
import hexrelief


def percent_at(x, y):
    """0 .. 99, a hash of the pixel (Wellons' lowbias32)."""
    h = (y * 65536 + x).astype(np.uint32)
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        h = (h ^ (h >> np.uint32(shift))) * np.uint32(factor)
    return (h ^ (h >> np.uint32(16))) % 100


def on_scan_lines(x, y):
    """Lines 8 px apart that wave a little, with drop-outs."""
    phase = x % 128
    wave = np.where(phase < 64, phase, 128 - phase) * 4 // 128
    line = y - wave - (percent_at(x, np.full_like(y, 1 << 14)) % 2).astype(int)
    return ((line + 8) % 8 == 4) & (percent_at(x, y) < 60)


PATTERNS = {
    "random-20": lambda x, y: percent_at(x, y) < 20,
    "random-5": lambda x, y: percent_at(x, y) < 5,
    "rows-20": lambda x, y: y % 5 == 2,
    "rows-5": lambda x, y: y % 20 == 10,
    "laser": on_scan_lines,
}


def thinned(truth, pattern):
    y, x = np.indices(truth.shape)
    return np.where(PATTERNS[pattern](x, y), truth, np.inf).astype(np.float32)


def measure(scene, pattern, truth, picture, options):
    disparity = truth if pattern == "whole" else thinned(truth, pattern)
    settings = common.LEFT_ALONE | common.settings(options)
    mesh = hexrelief.mesh(disparity, color=picture, config=options.preset, camera=common.camera_of(truth), **settings)
    figures = hexrelief.measure_surface(common.points_of(mesh), mesh.faces, truth, config=options.preset)
    known = np.isfinite(truth)
    filled = mesh.disparity[known]
    with np.errstate(invalid="ignore"):
        wrong = np.isfinite(filled) & (np.abs(filled - truth[known]) > 1)
    row = {"scene": scene.name, "pattern": pattern, "known_share": float(np.isfinite(disparity).mean())}
    row |= {"wrong_share": float(wrong.mean()), "unknown_share": float(1 - np.isfinite(filled).mean())}
    row |= {figure: figures[figure] for figure in ("duo_rmse_near_px", "flat_rmse_px")}
    return row | {"seconds": common.stage_seconds(mesh.report, "densify")}


def main():
    parser = common.arguments(__doc__, with_scenes=True)
    parser.add_argument("--patterns", type=common.names, default=[], help="of " + ", ".join(PATTERNS))
    parser.add_argument("--preset", default="default", help="default, quality, compact, paper, or a YAML file")
    parser.add_argument("--without-picture", action="store_true", help="fill the maps without the left picture")
    options = parser.parse_args()
    patterns = common.chosen(list(PATTERNS), options.patterns, "--patterns")
    scenes = common.scenes(options)
    table = common.Table(
        "scene <16, pattern <10, known % >7.1f, wrong % >7.2f, unknown % >9.2f, duo px >7.3f, flat px >7.3f, "
        "ratio >6.2f, s >7.3f"
    )
    for scene in scenes:
        truth = scene.disparity()
        picture = None if options.without_picture else hexrelief.read_picture(scene.left)
        for pattern in ["whole", *patterns]:
            row = measure(scene, pattern, truth, picture, options)
            if pattern == "whole":
                whole_px = row["duo_rmse_near_px"]
            row["ratio"] = row["duo_rmse_near_px"] / whole_px
            shares = (100 * row[share] for share in ("known_share", "wrong_share", "unknown_share"))
            table.add(
                (scene.name, pattern, *shares, row["duo_rmse_near_px"], row["flat_rmse_px"], row["ratio"], row["seconds"]), row
            )
    for pattern in patterns:
        ratios = [row["ratio"] for row in table.rows if row["pattern"] == pattern]
        mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
        print(f"{pattern:27} geometric mean of {len(ratios)} ratios {mean:.2f}, largest {max(ratios):.2f}")
    common.write_json(options, with_picture=not options.without_picture, rows=table.rows)


if __name__ == "__main__":
    main()
