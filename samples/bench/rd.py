#!/usr/bin/env python3
"""Rate and distortion: bytes against error of presets, uniform grids, simplification and other programs' meshes.

Positions alone (x, y, disparity in px), compressed by Draco at level 7 and measured as decoded: presets to their
tolerance, others at 12 bits, peers' files at 10 and at 12. Errors are the report's (pipeline/job/REPORT.md): left view,
both, left away from discontinuities; hidden: sheet_share; covered: slack_coverage; open, above: hole shares.
plot_rd.py draws the JSON.
"""
import math
import pathlib
import sys
import time

import numpy as np

import common
import hexrelief
import meshes

PRESETS = ("default", "quality", "compact", "paper")
OTHERS = ("uniform", "meshopt", "meshopt+cut")
COMPARED_PX = (10, 6, 4)  # spacings of the uniform grids at whose bytes all are compared
STEP_PX = 4  # triangles across larger steps are cut before simplification
LEAST_TOLERANCE_PX = 0.01  # pipeline/job/surfaces.cpp
IRREGULAR_BITS = 21  # that Draco needs for a vertex of a simplified mesh at 12 bits
ERRORS = ("rmse_near_px", "duo_rmse_near_px", "flat_rmse_px")
FIGURES = (*ERRORS, "sheet_share", "slack_coverage", "hole_share", "hole_share_above")


class Bench:
    """One map, and the points measured so far."""

    def __init__(self, name, disparity, options, table):
        self.name, self.disparity, self.options, self.table = name, disparity, options, table
        self.points = []

    def add(self, method, spacing_px, seconds, mesh, bits):
        size, points, faces = meshes.through_draco(*mesh, bits)
        figures = hexrelief.measure_surface(points, faces, self.disparity, **common.settings(self.options))
        row = {"map": self.name, "method": method, "spacing_px": spacing_px, "position_bits": bits}
        row |= {"vertices": len(points), "triangles": len(faces), "bytes": size, "bits_per_vertex": 8 * size / len(points)}
        row |= {**figures, "seconds": seconds}
        cells = [figures[figure] * (100 if "_px" not in figure else 1) for figure in FIGURES]
        self.table.add((self.name, method, spacing_px, bits, len(points), size, row["bits_per_vertex"], *cells, seconds), row)
        self.points.append(row)

    def add_preset(self, preset):
        for spacing_px in self.options.spacings:
            mesh = hexrelief.mesh(
                self.disparity,
                config=preset,
                camera=common.camera_of(self.disparity),
                **common.LEFT_ALONE,
                **common.settings(self.options),
                **{"mesh.spacing_px": spacing_px},
            )
            report, points = mesh.report, common.points_of(mesh)
            export, flat_px = report["config"]["export"], report["surface"]["flat_rmse_px"]
            tolerance_px = export["tolerance_px"]
            if export["tolerance_share"] > 0:
                tolerance_px = min(
                    tolerance_px, max(math.floor(1e3 * export["tolerance_share"] * flat_px) / 1e3, LEAST_TOLERANCE_PX)
                )
            bits = math.ceil(math.log2(np.ptp(points, axis=0).max() / (2 * tolerance_px) + 1))
            seconds = common.stage_seconds(report, "density", "mesh", "surface")
            self.add(preset, spacing_px, seconds, (points, mesh.faces), bits)

    def add_uniform(self, background_px):
        for spacing_px in dict.fromkeys([*COMPARED_PX, *self.options.spacings]):
            begun = time.perf_counter()
            mesh = meshes.uniform(self.disparity, background_px, spacing_px)
            self.add("uniform", spacing_px, time.perf_counter() - begun, mesh, 12)

    def add_simplified(self, method, background_px):
        """From a third of the smallest grid's bytes on, as small triangulations come out larger than aimed at."""
        full = meshes.uniform(self.disparity, background_px, 1)
        if method == "meshopt+cut":
            full = meshes.without_steps(*full, STEP_PX)
        sizes = [point["bytes"] for point in self.compared()]
        size = 0.3 * min(sizes)
        while size < 1.4 * max(sizes):
            begun = time.perf_counter()
            mesh = meshes.simplified(*full, int(2 * 8 * size / IRREGULAR_BITS))
            self.add(method, None, time.perf_counter() - begun, mesh, 12)
            size *= 1.5

    def add_peer(self, name, folder):
        for file in peer_files(folder, self.name):
            for bits in (10, 12):
                self.add(name, None, 0, meshes.read_obj(file), bits)

    def compared(self):
        return [point for point in self.points if point["method"] == "uniform" and point["spacing_px"] in COMPARED_PX]


def peer_files(folder, name):
    return sorted(file for file in folder.glob("*.obj") if file.stem == name or file.stem.startswith(name + "_"))


def unbeaten(points):
    """Those that no other beats in both bytes and error."""
    return [
        point
        for point in points
        if not any(
            other["bytes"] <= point["bytes"] and other["duo_rmse_near_px"] < point["duo_rmse_near_px"] for other in points
        )
    ]


def at_bytes(points, size, figure):
    """The figure at so many bytes, between the two nearest points on logarithmic scales; None outside of all."""
    below = max((p for p in points if p["bytes"] <= size), key=lambda p: p["bytes"], default=None)
    above = min((p for p in points if p["bytes"] >= size), key=lambda p: p["bytes"], default=None)
    if below is None or above is None:
        return None
    if below["bytes"] == above["bytes"] or min(below[figure], above[figure]) <= 0:
        return below[figure]
    return float(
        np.exp(np.interp(math.log(size), np.log([below["bytes"], above["bytes"]]), np.log([below[figure], above[figure]])))
    )


def comparison(points, grid, methods, peers):
    """All methods at one grid's bytes."""
    errors = {}
    for method in methods:
        own = [point for point in points if point["method"] == method]
        if method in peers:
            own = unbeaten(own)
        errors[method] = {figure: at_bytes(own, grid["bytes"], figure) for figure in ERRORS}
    rivals = {method: errors[method]["duo_rmse_near_px"] for method in methods if method not in PRESETS}
    best = min((method for method in rivals if rivals[method] is not None), key=rivals.get)
    print(
        f"{grid['map']} at the {grid['bytes']} bytes of the uniform grid of {grid['spacing_px']:g} px, error of both views, px:",
        "  ".join(
            f"{method} {'-' if error is None else format(error, '.3f')}"
            + (f" ({error / rivals[best]:.2f})" if error is not None and method in PRESETS else "")
            for method, error in ((method, errors[method]["duo_rmse_near_px"]) for method in methods)
        ),
    )
    row = {"map": grid["map"], "uniform_spacing_px": grid["spacing_px"], "bytes": grid["bytes"]}
    return row | {"methods": errors, "best_peer": best}


def means(comparisons, presets):
    """Geometric means over the maps of each preset's error in multiples of the best other mesher's."""
    for preset in presets:
        for spacing_px in COMPARED_PX:
            ratios = []
            for one in comparisons:
                own, best = (one["methods"][method]["duo_rmse_near_px"] for method in (preset, one["best_peer"]))
                if one["uniform_spacing_px"] == spacing_px and own is not None:
                    ratios.append(own / best)
            if ratios:
                mean, below = math.exp(sum(map(math.log, ratios)) / len(ratios)), sum(ratio < 1 for ratio in ratios)
                print(
                    f"{preset:13} at the bytes of uniform grids of {spacing_px} px: error of both views {mean:.3f} of the best "
                    f"other mesher's (geometric mean of {len(ratios)} maps), below it on {below}"
                )
                row = {"method": preset, "uniform_spacing_px": spacing_px, "maps": len(ratios)}
                yield row | {"maps_below_best_peer": below, "duo_share_of_best_peer": mean}


def peer(text):
    name, equals, folder = text.partition("=")
    if not (name and equals and pathlib.Path(folder).is_dir()) or name in PRESETS + OTHERS:
        sys.exit(f"--peer {text}: give a new name and a folder of .obj files, such as mine=meshes")
    return name, pathlib.Path(folder)


def main():
    parser = common.arguments(__doc__, with_scenes=False)
    parser.add_argument(
        "--methods", type=common.names, default=[], help="of " + ", ".join(PRESETS + OTHERS) + "; uniform is always there"
    )
    parser.add_argument(
        "--peer",
        type=peer,
        action="append",
        default=[],
        metavar="NAME=DIR",
        help="another program's meshes: DIR/MAP_*.obj, vertices x y disparity in px",
    )
    parser.add_argument(
        "--spacings",
        type=lambda text: [float(word) for word in text.split(",")],
        metavar="PX",
        default=[4, 5, 6, 7.5, 9, 10, 12, 15, 18],
        help="of lattices and grids",
    )
    options = parser.parse_args()
    known = PRESETS + (OTHERS if meshes.meshoptimizer() else OTHERS[:1])
    methods = [
        method for method in known if method == "uniform" or method in common.chosen(known, options.methods, "--methods")
    ]
    peers = dict(options.peer)
    table = common.Table(
        "map <8, method <13, spacing >7, bits >4, vertices >8, bytes >8, bits/v. >7.2f, left px >7.3f, "
        "both px >7.3f, away px >7.3f, hidden % >8.2f, covered % >9.2f, open % >6.2f, above % >7.2f, s >7.3f"
    )
    comparisons = []
    for paper, disparity in common.paper_maps(options, ("first", "L")):
        bench = Bench(paper.name, disparity, options, table)
        background_px = hexrelief.mesh(disparity, **common.settings(options)).report["background_px"]
        bench.add_uniform(background_px)
        for method in methods:
            if method in PRESETS:
                bench.add_preset(method)
            elif method != "uniform":
                bench.add_simplified(method, background_px)
        for name, folder in peers.items():
            bench.add_peer(name, folder)
        comparisons += [comparison(bench.points, grid, [*methods, *peers], peers) for grid in bench.compared()]
    presets = [method for method in methods if method in PRESETS]
    common.write_json(
        options,
        peers=[*(method for method in methods if method not in PRESETS), *peers],
        points=table.rows,
        at_equal_bytes=comparisons,
        means=list(means(comparisons, presets)),
    )


if __name__ == "__main__":
    main()
