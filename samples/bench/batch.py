#!/usr/bin/env python3
"""Jobs a second: pairs in memory to GLB in memory, one after the other on all threads: the library's calls take turns.

--files: of `hexrelief batch`, from files to files: one worker against --workers, a thread each; both twice, the better one
counts. The program is that of HEXRELIEF_BUILD.
"""
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import common
import hexrelief


def job(pair, config, backend):
    """Seconds from a pair to its GLB, and the GLB's bytes."""
    begun = time.perf_counter()
    disparity = hexrelief.compute_disparity(*pair, config=config, backend=backend)
    mesh = hexrelief.mesh(disparity, color=pair[0], config=config, backend=backend)
    size = len(mesh.to_bytes())
    return time.perf_counter() - begun, size


def in_memory(options, scenes):
    table = common.Table(
        "scene <20, size <11, on <5, threads >7, jobs >6, jobs/s >9.2f, median ms >10.2f, most ms >10.2f, " "bytes >10"
    )
    for scene in scenes:
        pair = scene.pictures()
        height, width = pair[0].shape[:2]
        for backend in common.backends():
            job(pair, common.settings(options), backend)  # starts all that is kept
            begun = time.perf_counter()
            done = [job(pair, common.settings(options), backend) for _ in range(options.jobs)]
            rate = options.jobs / (time.perf_counter() - begun)
            if len({size for _, size in done}) > 1:
                sys.exit(f"{scene.name}: two jobs gave different files")
            seconds = [one for one, _ in done]
            row = {"scene": scene.name, "width": width, "height": height, "backend": backend, "jobs": options.jobs}
            row |= {"jobs_per_second": rate, "job_seconds": common.times(seconds)}
            times_ms = (1e3 * statistics.median(seconds), 1e3 * max(seconds))
            size = f"{width}x{height}"
            table.add((scene.name, size, backend, options.threads, options.jobs, rate, *times_ms, done[0][1]), row)
    return table.rows


def batch_seconds(scene, jobs, workers, options):
    """Wall and CPU seconds of `hexrelief batch`, reports included."""
    program = pathlib.Path(os.environ.get("HEXRELIEF_BUILD", "build"), "hexrelief")
    with tempfile.TemporaryDirectory() as folder:
        manifest = pathlib.Path(folder, "jobs.jsonl")
        rows = (
            {"name": str(job), "left": str(scene.left.resolve()), "right": str(scene.right.resolve())} for job in range(jobs)
        )
        manifest.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
        sets = [word for setting in options.settings for word in ("--set", setting)]
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        words = [program, "batch", manifest, "-o", pathlib.Path(folder, "out"), "--quiet", *sets]
        words += ["--jobs", str(workers), "--threads", str(workers)]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def from_files(options, scenes):
    workers = options.workers or len(os.sched_getaffinity(0))
    table = common.Table(
        "scene <20, jobs >6, one jobs/s >10.2f, all jobs/s >10.2f, times >6.2f, one CPU ms >10.1f, " "all CPU ms >10.1f"
    )
    for scene in scenes:
        runs = [[batch_seconds(scene, options.jobs, count, options) for count in (1, workers)] for _ in range(2)]
        (one_s, one_cpu_s), (all_s, all_cpu_s) = (map(min, zip(*run)) for run in zip(*runs))
        cpu_ms = (1e3 * one_cpu_s / options.jobs, 1e3 * all_cpu_s / options.jobs)
        row = {"scene": scene.name, "jobs": options.jobs, "workers": workers, "times": one_s / all_s}
        row |= {"one": {"seconds": one_s, "cpu_seconds": one_cpu_s}, "all": {"seconds": all_s, "cpu_seconds": all_cpu_s}}
        table.add((scene.name, options.jobs, options.jobs / one_s, options.jobs / all_s, one_s / all_s, *cpu_ms), row)
    return table.rows


def main():
    parser = common.arguments(__doc__, with_scenes=True)
    parser.add_argument("--jobs", type=int, default=100, help="timed jobs of each scene")
    parser.add_argument("--workers", type=int, default=0, help="of --files: jobs at a time; 0 = one for each thread")
    parser.add_argument("--files", action="store_true", help="from files to files")
    options = parser.parse_args()
    measure = from_files if options.files else in_memory
    common.write_json(options, rows=measure(options, common.scenes(options)))


if __name__ == "__main__":
    main()
