"""The benchmarks of samples/bench on the samples' scene, in Middlebury's layout."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest

import hexrelief

SAMPLES = pathlib.Path(os.environ["HEXRELIEF_SOURCES"]) / "samples"
sys.path.insert(0, str(SAMPLES / "bench"))

import meshes  # noqa: E402
import rd  # noqa: E402
import sparse  # noqa: E402


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sets")
    scene = folder / "middlebury2014-quarter" / "rendered"
    scene.mkdir(parents=True)
    for name in ("left.png", "right.png"):
        shutil.copy(SAMPLES / name, scene / name)
    shutil.copy(SAMPLES / "disparity.pfm", scene / "disp.pfm")
    raw = hexrelief.read_disparity(SAMPLES / "disparity.pfm")[:120, :160]
    tsukuba = folder / "middlebury2001" / "tsukuba"
    tsukuba.mkdir(parents=True)
    raw = np.where(np.isfinite(raw), np.clip(4 * raw, 1, 255), 0).astype(np.uint8)
    (tsukuba / "disp.pgm").write_bytes(b"P5\n160 120\n255\n" + raw.tobytes())
    return folder


def run(name, data, *arguments):
    return subprocess.run(
        [sys.executable, SAMPLES / "bench" / f"{name}.py", "--data", data, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


def bench(name, data, *arguments):
    """Printed table and JSON."""
    file = data / f"{name}.json"
    done = run(name, data, "--threads", 2, "--json", file, *arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads(file.read_text())


def test_table2_stands_beside_the_papers_figures(data):
    text, table = bench("table2", data, "--runs", 2, "--methods", "som,default", "--set", "mesh.spacing_px=5")
    assert "not there, left out: venus" in text
    rows = {row["method"]: row for row in table["rows"] if "map" in row and row["backend"] == "cpu"}
    assert list(rows) == ["som", "default"]
    assert rows["default"]["percent_cost"] < 0.5 * rows["som"]["percent_cost"]
    assert rows["default"]["columns"] > rows["som"]["columns"]  # --set is the default's alone
    assert rows["default"]["paper"]["gpu_seconds"] == 0.32 and len(rows["default"]["seconds"]["runs"]) == 2
    mean = next(row for row in table["rows"] if "maps" in row and row["method"] == "default")
    assert mean["percent_cost"] == rows["default"]["percent_cost"]
    assert run("table2", data, "--maps", "conez").stderr.startswith("--maps: unknown name 'conez'")
    assert "none of the maps" in run("table2", data, "--maps", "cones").stderr


def test_the_papers_figures_have_its_means():
    import common

    small = [one for one in common.PAPER_MAPS if one.set == "first"]
    assert round(sum(one.gpu_cost for one in small) / 6, 2) == 21.37
    assert round(sum(one.cpu_s for one in small) / 6, 2) == 2.32


def test_rd_compares_at_equal_bytes(data):
    obj = data / "tsukuba_plane.obj"
    obj.write_text("v 0 0 9\nv 160 0 9\nv 160 120 9\nv 0 120 9\nf 1 2 3 4\n")
    text, table = bench("rd", data, "--methods", "default,meshopt", "--spacings", "2,4,8", "--peer", f"plane={data}")
    methods = {point["method"] for point in table["points"]}
    assert {"uniform", "default", "plane"} <= methods
    assert all(point["bytes"] > 50 and point["duo_rmse_near_px"] > 0 for point in table["points"])
    by_spacing = {point["spacing_px"]: point for point in table["points"] if point["method"] == "default"}
    assert by_spacing[2]["duo_rmse_near_px"] < by_spacing[8]["duo_rmse_near_px"]
    assert by_spacing[2]["bytes"] > by_spacing[8]["bytes"]
    assert "at the" in text and all(row["methods"]["uniform"]["duo_rmse_near_px"] > 0 for row in table["at_equal_bytes"])
    obj.write_text("v 0 0 9\nf 1 2 3\n")
    assert "triangles of its own" in run("rd", data, "--methods", "uniform", "--peer", f"plane={data}").stderr


def test_rd_between_points_and_without_beaten_ones():
    points = [{"bytes": size, "duo_rmse_near_px": error} for size, error in ((100, 4), (400, 1), (500, 2))]
    assert rd.at_bytes(points[:2], 200, "duo_rmse_near_px") == pytest.approx(2)
    assert rd.at_bytes(points[:2], 99, "duo_rmse_near_px") is None
    assert rd.unbeaten(points) == points[:2]


def test_grids_cut_and_simplified():
    slope = np.tile(np.arange(40, dtype=np.float32), (30, 1)) + 1
    points, faces = meshes.uniform(slope, 0, 1)
    assert len(points) == 1200 and len(faces) == 2 * 39 * 29
    assert points[1].tolist() == [1.5, 0.5, 2]
    stepped = points + [0, 0, 9] * (points[:, :1] > 20)
    assert len(meshes.without_steps(stepped, faces, 4)[1]) == len(faces) - 2 * 29
    if meshes.meshoptimizer():
        few, fewer = meshes.simplified(points, faces, 10)
        assert len(fewer) <= 10 and np.allclose(few[:, 2], few[:, 0] + 0.5)


def test_match_evaluates_all_methods(data):
    _, table = bench("match", data, "--runs", 1, "--noise", 1, "--gain", 0.95)
    rows = {row["method"]: row for row in table["rows"] if row["backend"] == "cpu"}
    assert list(rows) == ["sgm", "sgbm", "opencv"] and rows["sgm"]["scene"] == "rendered"
    assert 0 < rows["sgm"]["bad_2_percent"] < rows["opencv"]["bad_2_percent"] < 60
    assert rows["sgm"]["coverage_percent"] > rows["opencv"]["coverage_percent"] > 40
    assert [mean["scenes"] for mean in table["means"]][:3] == [1, 1, 1]
    assert "unknown name 'sgmm'" in run("match", data, "--methods", "sgmm").stderr


def test_sparse_maps_cost_something(data):
    _, table = bench("sparse", data, "--patterns", "random-5,laser")
    rows = {row["pattern"]: row for row in table["rows"]}
    assert rows["whole"]["ratio"] == 1 and 1 < rows["random-5"]["ratio"] < 9
    assert rows["random-5"]["known_share"] == pytest.approx(0.05, abs=0.01)
    assert rows["random-5"]["unknown_share"] < 0.05 < rows["whole"]["known_share"]


@pytest.mark.parametrize("pattern, share", [("random-20", 0.2), ("rows-20", 0.2), ("rows-5", 0.05), ("laser", 0.075)])
def test_patterns_keep_what_they_promise(pattern, share):
    kept = np.isfinite(sparse.thinned(np.ones((300, 400), np.float32), pattern))
    assert kept.mean() == pytest.approx(share, abs=0.006)


def test_batch_counts_jobs(data):
    _, table = bench("batch", data, "--jobs", 2)
    assert table["rows"][0]["jobs_per_second"] > 0 and len(table["rows"][0]["job_seconds"]["runs"]) == 2
    _, table = bench("batch", data, "--files", "--jobs", 2, "--workers", 2)
    assert table["rows"][0]["all"]["seconds"] > 0 and table["rows"][0]["workers"] == 2
