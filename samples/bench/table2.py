#!/usr/bin/env python3
"""The paper's Table 2: time and quality of the mesh stage, beside the paper's figures.

sequential, paper: the paper's schedule, on one CPU thread and cellular; default: this program's own, on its own density;
som: that without balancing. All but default are on the paper's density. Figures are the report's (pipeline/job/REPORT.md).
"""
import statistics

import common
import hexrelief

METHODS = {"sequential": ["paper"], "paper": ["paper"], "som": ["som"], "default": []}
SMALL_PX = 250000  # the sequential method takes seconds for more

# config/paper.yaml has the schedule of section 6.4, but for SSR, which Table 2 gives map by map.


def keys(method, paper):
    if method in ("sequential", "paper"):
        return {"mesh.ssr": paper.ssr, "mesh.method": "sequential" if method == "sequential" else "cellular"}
    return {}


def measure(method, paper, disparity, backend, runs, options):
    """Report of the first run, and the stages' seconds of all; every run gives the same mesh."""
    config = common.settings(options) if method == "default" else {"run.threads": options.threads}
    config |= keys(method, paper) | common.LEFT_ALONE | {"disparity.dequantize": "none", "run.backend": backend}
    reports = []
    for _ in range(runs):
        reports.append(hexrelief.mesh(disparity, config=METHODS[method], **config).report)
    return reports[0], *([common.stage_seconds(report, stage) for report in reports] for stage in ("mesh", "surface"))


def row_of(paper, method, backend, report, mesh_s, surface_s):
    mesh, config = report["mesh"], report["config"]["mesh"]
    row = {"set": paper.set, "map": paper.name, "width": report["input"]["width"], "height": report["input"]["height"]}
    row |= {"method": method, "backend": backend, "ssr": config["ssr"], "crr": config["crr"]}
    row |= {"seconds": common.times(mesh_s), "surface_seconds": common.times(surface_s), **mesh}
    names = ("gpu_seconds", "cpu_seconds", "gpu_percent_cost", "cpu_percent_cost")
    return row | {"paper": dict(zip(names, (paper.gpu_s, paper.cpu_s, paper.gpu_cost, paper.cpu_cost)))}


def cells_of(row):
    mesh = (f"{row['columns']}x{row['rows']}", row["ssr"], row["crr"], row["iterations"], row["method"], row["backend"])
    times = (row["seconds"]["median"], row["seconds"]["spread"], row["surface_seconds"]["median"])
    quality = (row["percent_cost"], row["max_deviation_percent"], row["inverted_triangles"])
    angles = (row["angles_deg"]["p1"], row["angles_deg"]["median"])
    return (row["map"], f"{row['width']}x{row['height']}", *mesh, *times, *quality, *angles, *row["paper"].values())


def add_means(table, name):
    """A row for each method and backend: the mean of a set's maps."""
    rows = [row for row in table.rows if row["set"] == name and "maps" not in row]
    for method, backend in dict.fromkeys((row["method"], row["backend"]) for row in rows):
        same = [row for row in rows if (row["method"], row["backend"]) == (method, backend)]
        mean = {"set": name, "maps": len(same), "method": method, "backend": backend}
        for key in ("seconds", "surface_seconds"):
            mean[key] = statistics.mean(row[key]["median"] for row in same)
        mean["percent_cost"] = statistics.mean(row["percent_cost"] for row in same)
        mean["inverted_triangles"] = sum(row["inverted_triangles"] for row in same)
        mean["paper"] = {key: statistics.mean(row["paper"][key] for row in same) for key in same[0]["paper"]}
        times = (mean["seconds"], None, mean["surface_seconds"])
        quality = (mean["percent_cost"], None, mean["inverted_triangles"], None, None)
        mesh = (None, None, None, None, method, backend)
        table.add(("mean", f"{len(same)} maps", *mesh, *times, *quality, *mean["paper"].values()), mean)


def main():
    parser = common.arguments(__doc__, with_scenes=False)
    parser.add_argument("--runs", type=int, default=3, help="timed runs of each method")
    parser.add_argument(
        "--sequential-runs", type=int, help="of the sequential method; else --runs on small maps, one on others"
    )
    parser.add_argument("--methods", type=common.names, default=[], help="of " + ", ".join(METHODS))
    options = parser.parse_args()
    methods = common.chosen(list(METHODS), options.methods, "--methods")
    backends = common.backends()
    table = common.Table(
        "map <8, image <10, grid >8, SSR >3, CRR >3, iter. >6, method <11, on <5, mesh s >8.3f, spread >7.3f, "
        "surface s >9.3f, %cost >7.2f, max dev. >8.1f, inverted >8, angle p1 >8.2f, median >7.2f, "
        "| paper: GPU s >14.2f, CPU s >7.2f, GPU %cost >9.2f, CPU %cost >9.2f"
    )
    last = None
    for paper, disparity in common.paper_maps(options, ("first", "S", "M", "L")):
        if last not in (None, paper.set):
            add_means(table, last)
        last = paper.set
        for method in methods:
            runs = options.runs
            if method == "sequential":
                runs = options.sequential_runs or (runs if disparity.size <= SMALL_PX else 1)
            for backend in backends[:1] if method == "sequential" else backends:
                row = row_of(paper, method, backend, *measure(method, paper, disparity, backend, runs, options))
                table.add(cells_of(row), row)
    add_means(table, last)
    common.write_json(options, rows=table.rows)


if __name__ == "__main__":
    main()
