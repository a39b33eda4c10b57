#!/usr/bin/env python3
"""True maps with the faults that networks' maps have, and what the program makes of them.

given: the map as it came; left: beside the left picture; picture: beside both; both: both views' maps, as of a matcher.
Unknown pixels of the truth are filled from the farther side first, as networks fill them. duo, sheet: of a mesh of the map.
"""
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import common
import hexrelief
import meshes

FORMS = ("given", "left", "picture", "both")
FIGURES = ("bad_2_percent", "edge_percent", "duo_rmse_near_px", "sheet_share")


def smoothed(values, sigma_px):
    """By a Gaussian, the border repeated."""
    reach = int(3 * sigma_px + 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma_px) ** 2)
    for axis in (0, 1):
        padded = np.pad(values, [(reach, reach) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=axis)
        values = windows @ (weights / weights.sum())
    return values


def spread(values, take, reach_px):
    """The least or largest of the values within reach_px."""
    for axis in (0, 1):
        padded = np.pad(values, [(reach_px, reach_px) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
        values = take(np.lib.stride_tricks.sliding_window_view(padded, 2 * reach_px + 1, axis=axis), axis=2)
    return values


def waves(shape, size_px, seed):
    """Smooth noise, -1 to 1, always the same."""
    noise = smoothed(np.random.default_rng(seed).normal(size=shape), size_px)
    return np.clip(noise / (1.5 * noise.std()), -1, 1)


def of_a_quarter(values):
    """Made a quarter as large, and enlarged without steps."""
    height, width = values.shape
    small = np.pad(values, ((0, -height % 4), (0, -width % 4)), mode="edge")
    small = small.reshape(small.shape[0] // 4, 4, -1, 4).mean(axis=(1, 3))
    for axis, length in ((0, height), (1, width)):
        at = np.clip((np.arange(length) - 1.5) / 4, 0, small.shape[axis] - 1)
        first = np.minimum(at.astype(int), small.shape[axis] - 2)
        share = (at - first).reshape((-1, 1) if axis == 0 else (1, -1))
        small = np.take(small, first, axis) * (1 - share) + np.take(small, first + 1, axis) * share
    return small


def here_and_there(faulty, values):
    """A fault in half of the picture, in patches."""
    return np.where(waves(values.shape, 15, 3) > 0, faulty, values)


def waving_sky(values):
    """Waves of 8 px where it is farthest."""
    return values + 8 * waves(values.shape, 12, 1) * (values < np.percentile(values, 30))


FAULTS = {
    "none": lambda d: d,
    "blur-1": lambda d: smoothed(d, 1),
    "blur-2.5": lambda d: smoothed(d, 2.5),
    "blur-4": lambda d: smoothed(d, 4),
    "blur-part": lambda d: here_and_there(smoothed(d, 2.5), d),
    "quarter": of_a_quarter,
    "larger": lambda d: spread(d, np.max, 3),
    "smaller": lambda d: spread(d, np.min, 3),
    "larger-blur": lambda d: smoothed(spread(d, np.max, 2), 1.5),
    "sky": waving_sky,
    "offsets": lambda d: d + 1.5 * waves(d.shape, 40, 2),
    "all": lambda d: smoothed(spread(waving_sky(d) + waves(d.shape, 40, 2), np.max, 1), 1.5),
}


def filled(disparity):
    """Known everywhere: from the nearest known pixels of the row, the farther one, then of the column."""
    for _ in range(2):
        disparity = meshes.filled(disparity).T
    return np.where(disparity > 0, disparity, np.inf).astype(np.float32)


def seen_from_right(truth):
    """The right view's map that the left view's implies, for scenes without one."""
    right = np.zeros_like(truth)
    rows, columns = np.nonzero(np.isfinite(truth))
    there = np.rint(columns - truth[rows, columns]).astype(int)
    inside = there >= 0
    np.maximum.at(right, (rows[inside], there[inside]), truth[rows[inside], columns[inside]])
    return np.where(right > 0, right, np.inf)


def write_pfm(path, values):
    path.write_bytes(b"Pf\n%d %d\n-1\n" % values.shape[::-1] + np.ascontiguousarray(values[::-1], "<f4").tobytes())


def refined(folder, scene, form, options):
    """The map that the program meshes, of the folder's maps."""
    words = ["--disparity", folder / "left.pfm", "--color", scene.left]
    if form == "picture":
        words += ["--color-right", scene.right]
    if form == "both":
        giver = f"{sys.executable} {__file__} {folder / 'left.pfm'} {folder / 'right_in_mirror.pfm'} {{out}}"
        words = ["--left", scene.left, "--right", scene.right, "--set", "disparity.method=command"]
        words += ["--set", f"disparity.command={giver}"]
    for key, value in common.settings(options).items():
        words += ["--set", f"{key}={value}"]
    program = pathlib.Path(os.environ.get("HEXRELIEF_BUILD", "build"), "hexrelief")
    stages = folder / "stages"
    subprocess.run(
        [program, "run", *words, "--quiet", "-o", folder / "mesh.ply", "--save-stages", stages],
        check=True,
        stdin=subprocess.DEVNULL,
    )
    return hexrelief.read_disparity(stages / "disparity.pfm")


def measure(scene, disparity, truth):
    figures = hexrelief.evaluate(
        disparity, truth, right_truth=scene.disparity("disp_right"), discontinuity_px=scene.discontinuity_px
    )
    mesh = hexrelief.mesh(disparity, camera=common.camera_of(truth), **common.LEFT_ALONE)
    figures |= hexrelief.measure_surface(common.points_of(mesh), mesh.faces, truth)
    figures["edge_percent"] = figures["edge_wrong_percent"] + figures["edge_unknown_percent"]
    return {name: figures[name] for name in FIGURES}


def give(left, right_in_mirror, out):
    """As disparity.command: the left view's map, and when asked again the right view's, seen in a mirror as the pair is."""
    asked = pathlib.Path(left + ".asked")
    shutil.copyfile(right_in_mirror if asked.exists() else left, out)
    asked.unlink() if asked.exists() else asked.touch()


def main():
    parser = common.arguments(__doc__, with_scenes=True)
    parser.add_argument("--faults", type=common.names, default=[], help="of " + ", ".join(FAULTS))
    parser.add_argument("--forms", type=common.names, default=[], help="of " + ", ".join(FORMS))
    options = parser.parse_args()
    faults, forms = common.chosen(list(FAULTS), options.faults, "--faults"), common.chosen(FORMS, options.forms, "--forms")
    table = common.Table("scene <16, fault <12, map <8, bad-2 % >8.2f, edge % >7.2f, duo px >7.3f, sheet >7.3f")
    for scene in common.scenes(options):
        truth, right_truth = scene.disparity(), scene.disparity("disp_right")
        views = [filled(truth), filled(seen_from_right(truth) if right_truth is None else right_truth)]
        for fault in faults:
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                left, right = map(FAULTS[fault], views)
                write_pfm(folder / "left.pfm", left)
                write_pfm(folder / "right_in_mirror.pfm", right[:, ::-1])
                for form in forms:
                    given = hexrelief.read_disparity(folder / "left.pfm")
                    disparity = given if form == "given" else refined(folder, scene, form, options)
                    row = {"scene": scene.name, "fault": fault, "map": form} | measure(scene, disparity, truth)
                    table.add(row.values(), row)
    rows = list(table.rows)
    for fault in faults:
        for form in forms:
            same = [row for row in rows if (row["fault"], row["map"]) == (fault, form)]
            mean = {"scene": f"mean of {len(same)}", "fault": fault, "map": form}
            mean |= {figure: statistics.mean(row[figure] for row in same) for figure in FIGURES}
            table.add(mean.values(), mean)
    common.write_json(options, rows=rows, means=table.rows[len(rows) :])


if __name__ == "__main__":
    give(*sys.argv[1:]) if len(sys.argv) == 4 and not sys.argv[1].startswith("-") else main()
