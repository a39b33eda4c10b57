#!/usr/bin/env python3
"""The matchers on pairs with ground truth: quality by `hexrelief evaluate`, and time of the whole disparity stage.

sgm, sgbm: this program's methods; opencv: StereoSGBM's own answer where both views agree, without speckles, neither filled
nor refined.
edge: near true discontinuities, on the wrong side or unknown. Non-occluded: by mask0nocc.png where the scene has one.
plot_match.py draws the JSON. Below MiddEval3's pairs at quarter size: what others published of that set.
"""
import statistics
import time

import numpy as np

import common
import hexrelief
import public_figures

METHODS = ("sgm", "sgbm", "opencv")
BLOCK_PX, P1, P2, CAP, UNIQUENESS_PERCENT = 3, 16, 64, 31, 5  # of StereoSGBM, as sgbm has them; penalties per sample of a block
SPECKLE_PX = 100
BAD = ("bad_1_percent", "bad_2_percent", "bad_1_nonoccluded_percent", "bad_2_nonoccluded_percent")
FIGURES = (*BAD, "edge_percent", "coverage_percent", "average_error_px", "roughness_px")


def match_by_opencv(left, right, count_px):
    """(H, W) float32, unknown +inf, by StereoSGBM on both views and their agreement within a pixel."""
    import cv2

    area = left.shape[2] * BLOCK_PX * BLOCK_PX
    matcher = cv2.StereoSGBM_create(
        0, count_px, BLOCK_PX, P1 * area, P2 * area, 1 << 14, CAP, UNIQUENESS_PERCENT, 0, 0, cv2.StereoSGBM_MODE_SGBM_3WAY
    )

    def disparities(base, other):
        """StereoSGBM says nothing where the range leaves the picture, so both are widened."""
        wide = [cv2.copyMakeBorder(picture, 0, 0, count_px, 0, cv2.BORDER_REPLICATE) for picture in (base, other)]
        raw = matcher.compute(*wide)[:, count_px:]
        return np.where(raw < 0, np.inf, raw / 16).astype(np.float32)

    of_left = disparities(left, right)
    of_right = disparities(right[:, ::-1], left[:, ::-1])[:, ::-1]
    rows, columns = np.indices(of_left.shape)
    there = np.clip(np.where(np.isfinite(of_left), columns - of_left, 0).round().astype(int), 0, None)
    agrees = np.abs(of_left - of_right[rows, there]) <= 1
    raw = np.where(agrees, 16 * of_left, -16).astype(np.int16)
    cv2.filterSpeckles(raw, -16, SPECKLE_PX, 32)
    return np.where(raw < 0, np.inf, raw / 16).astype(np.float32)


def disturbed(left, right, options):
    """Noise on both pictures, another light on the right one; always the same."""
    random = np.random.default_rng(1)
    lit = 255 * options.gain * (right / 255.0) ** options.gamma
    return [
        np.clip(np.rint(picture + random.normal(0, 2.55 * options.noise, picture.shape)), 0, 255).astype(np.uint8)
        for picture in (left, lit)
    ]


def occlusion_mask(scene):
    """What the right camera sees too, as MiddEval3 has it, or None."""
    return common.first_file(scene.folder, ["mask0nocc"], (".png",))


def evaluate(scene, disparity, truth):
    right_truth = scene.disparity("disp_right")
    result = hexrelief.evaluate(disparity, truth, right_truth=right_truth, discontinuity_px=scene.discontinuity_px)
    mask = occlusion_mask(scene)
    if mask:
        seen = hexrelief.read_picture(mask)[:, :, 0] == 255
        of_seen = hexrelief.evaluate(disparity, np.where(seen, truth, np.inf))
        result |= {f"bad_{t}_nonoccluded_percent": of_seen[f"bad_{t}_percent"] for t in (1, 2)}
    return result | {"edge_percent": result["edge_wrong_percent"] + result["edge_unknown_percent"]}


def measure(scene, pair, truth, method, backend, options):
    seconds = []
    for _ in range(options.runs):
        begun = time.perf_counter()
        if method == "opencv":
            disparity = match_by_opencv(*pair, 16 * -(-int(truth[np.isfinite(truth)].max() + 1) // 16))
        else:
            config = common.settings(options) | {"disparity.method": method}
            disparity = hexrelief.compute_disparity(*pair, config=config, backend=backend)
        seconds.append(time.perf_counter() - begun)
    row = {"scene": scene.name, "size": scene.size, "width": truth.shape[1], "height": truth.shape[0]}
    row |= {"method": method, "backend": backend, "seconds": common.times(seconds)}
    return row | evaluate(scene, disparity, truth)


def add_means(table):
    """A row for each size, method and backend."""
    rows = list(table.rows)
    for group in dict.fromkeys((row["size"], row["method"], row["backend"]) for row in rows):
        same = [row for row in rows if (row["size"], row["method"], row["backend"]) == group]
        mean = dict(zip(("size", "method", "backend"), group)) | {"scenes": len(same)}
        mean["seconds"] = statistics.mean(row["seconds"]["median"] for row in same)
        mean |= {figure: statistics.mean(row[figure] for row in same) for figure in FIGURES}
        table.add((f"mean of {len(same)}, {group[0]}", *group[1:], mean["seconds"], *map(mean.get, FIGURES)), mean)


def main():
    parser = common.arguments(__doc__, with_scenes=True)
    parser.add_argument("--methods", type=common.names, default=[], help="of " + ", ".join(METHODS))
    parser.add_argument("--runs", type=int, default=3, help="timed runs of each method")
    parser.add_argument("--noise", type=float, default=0, metavar="PERCENT", help="standard deviation, of 255")
    parser.add_argument("--gamma", type=float, default=1, help="exponent of another light on the right picture")
    parser.add_argument("--gain", type=float, default=1, help="factor of another light on the right picture")
    options = parser.parse_args()
    methods = common.chosen(METHODS, options.methods, "--methods")
    scenes, backends = common.scenes(options), common.backends()
    table = common.Table(
        "scene <30, method <7, on <5, s >8.4f, bad-1 % >8.3f, bad-2 % >8.3f, 1 nonocc. >9.3f, 2 nonocc. >9.3f, "
        "edge % >8.3f, coverage >8.3f, average px >10.4f, roughness px >12.4f"
    )
    for scene in scenes:
        pair, truth = disturbed(*scene.pictures(), options), scene.disparity()
        for method in methods:
            for backend in backends if method == "sgm" else backends[:1]:
                row = measure(scene, pair, truth, method, backend, options)
                label = f"{scene.name} {row['width']}x{row['height']}"
                table.add((label, method, backend, row["seconds"]["median"], *map(row.get, FIGURES)), row)
    add_means(table)
    rows = [row for row in table.rows if "scene" in row]
    evaluated = [scene.name for scene in scenes if scene.size == "small" and occlusion_mask(scene)]
    public = evaluated and public_figures.add_public(common.Table, [row for row in rows if row["scene"] in evaluated])
    common.write_json(options, rows=rows, means=[row for row in table.rows if "scenes" in row], public=public)


if __name__ == "__main__":
    main()
