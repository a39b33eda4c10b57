#!/usr/bin/env python3
"""golden.py PROGRAM [--data DIR] [--update] [--backend cpu|cuda] [--threads 1,2] [--scenes REGEX] [--presets a,b]

Runs PROGRAM on the project's own sample pair and map, with --data on Middlebury's maps and pairs as well, with every
preset and number of threads, and compares the SHA-256 of every output with those in sums/ beside this script.
--update writes what differs or is new instead; every number of threads must still give the same bytes.

A GLB is hashed without its `asset` object, which names the version and the configuration's keys: a release or a
renamed key is not another mesh. All other files are hashed as they are.

The sums hold for Debian 12's packages on x86-64 and arm64 (image decoders, StereoSGBM and Draco are theirs). Exits with
77, which ctest shows as skipped, on any other system; with 1 where a sum differs.
"""
import argparse
import hashlib
import json
import platform
import re
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parent.parent / "samples"
PRESETS = ("default", "compact", "paper", "quality")
STAGE_FILES = ("mesh2d.obj", "density.pfm", "disparity.pfm")
PAPER_MAPS = (  # folder, map, left image or None, px = sample / scale
    ("middlebury2001/tsukuba", "disp.pgm", "left.png", 16),
    ("middlebury2001/venus", "disp.pgm", "left.ppm", 8),
    ("middlebury2003/teddy-quarter", "disp.png", "left.png", 4),
    ("middlebury2003/cones-quarter", "disp.png", "left.png", 4),
    ("middlebury2006/rocks1-third", "disp.png", "left.png", 3),
    ("middlebury2006/aloe-third", "disp.png", "left.png", 3),
    ("middlebury2003/teddy-half", "disp.pgm", "left.ppm", 2),
    ("middlebury2003/cones-half", "disp.pgm", "left.ppm", 2),
    ("middlebury2006/rocks1-half", "disp.png", "left.png", 2),
    ("middlebury2006/aloe-half", "disp.png", "left.png", 2),
    ("middlebury2006/aloe-full", "disp.png", "left_color.jpg", 1),
    ("middlebury2003/teddy-full", "disp.pgm", None, 1),
    ("middlebury2003/cones-full", "disp.pgm", "left.pgm", 1),
)
PAIRS = (  # folder, file ending, calibration or None
    ("middlebury2001/tsukuba", "png", None),
    ("middlebury2003/cones-quarter", "png", None),
    ("middlebury2003/teddy-half", "ppm", None),
    ("middlebury2006/aloe-half", "png", None),
    ("middlebury2014-quarter/Piano", "png", "calib.txt"),
)


def scenes(data):
    """Name -> arguments of `hexrelief run`, in a fixed order."""
    found = {
        "samples-map": ["--disparity", SAMPLES / "disparity.pfm", "--color", SAMPLES / "left.png",
                        "--calib", SAMPLES / "calib.txt"],
        "samples-pair": ["--left", SAMPLES / "left.png", "--right", SAMPLES / "right.png",
                         "--calib", SAMPLES / "calib.txt"],
    }
    if data is None:
        return found
    for folder, name, left, scale in PAPER_MAPS:
        arguments = ["--disparity", data / folder / name, "--disparity-scale", str(scale), "--unknown", "0"]
        found[Path(folder).name + "-map"] = arguments + (["--color", data / folder / left] if left else [])
    for folder, ending, calibration in PAIRS:
        arguments = ["--left", data / folder / f"left.{ending}", "--right", data / folder / f"right.{ending}"]
        found[Path(folder).name + "-pair"] = arguments + (["--calib", data / folder / calibration] if calibration else [])
    return found


def without_asset(glb):
    """The bytes of a GLB whose JSON chunk has lost `asset`."""
    length = struct.unpack_from("<I", glb, 12)[0]
    document = json.loads(glb[20:20 + length])
    del document["asset"]
    return json.dumps(document, sort_keys=True).encode() + glb[20 + length:]


def sums_of(program, arguments, preset, threads, backend):
    """File name -> SHA-256 of everything that one scene gives with one preset."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        base = [program, "run", *arguments, "--config", preset, "--threads", str(threads), "--backend", backend, "--quiet"]
        for extra in (["-o", folder / "relief.glb", "-o", folder / "relief.obj", "-o", folder / "relief.ply",
                       "--save-stages", folder / "stages"],
                      ["-o", folder / "relief-draco.glb", "--set", "export.compression=draco"]):
            subprocess.run([str(part) for part in base + extra], check=True)
        files = sorted(folder.glob("relief*")) + [folder / "stages" / name for name in STAGE_FILES]
        contents = ((file.name, without_asset(file.read_bytes()) if file.suffix == ".glb" else file.read_bytes())
                    for file in files)
        return {name: hashlib.sha256(content).hexdigest() for name, content in contents}


def is_reference_system():
    release = Path("/etc/os-release")
    text = release.read_text() if release.exists() else ""
    return platform.machine() in ("x86_64", "aarch64") and "ID=debian" in text and 'VERSION_ID="12"' in text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--data", type=Path, default=None)
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--scenes", default="")
    parser.add_argument("--presets", default=",".join(PRESETS))
    parser.add_argument("--any-system", action="store_true", help="compare on other systems than Debian 12, too")
    options = parser.parse_args()
    if not (options.any_system or is_reference_system()):
        print("SKIPPED: the sums hold for Debian 12's packages on x86-64 and arm64; --any-system compares all the same")
        return 77
    if options.data is None:
        print("NOTE: without --data (or HEXRELIEF_DATA) only the project's own samples are compared")
    runs = compared = differing = 0
    for scene, arguments in scenes(options.data).items():
        if not re.search(options.scenes, scene):
            continue
        path = HERE / "sums" / f"{scene}.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        for preset in options.presets.split(","):
            # --update takes the first number of threads as the truth, so the others are still compared with it.
            learn = options.update
            for threads in options.threads.split(","):
                found = sums_of(options.program.resolve(), arguments, preset, threads, options.backend)
                runs += 1
                if learn:
                    known[preset] = found
                    learn = False
                    continue
                for name in sorted(found.keys() | known.get(preset, {}).keys()):
                    compared += 1
                    if found.get(name) != known.get(preset, {}).get(name):
                        differing += 1
                        print(f"DIFFERS: {scene}, {preset}, {threads} threads: {name}")
        if options.update:
            path.parent.mkdir(exist_ok=True)
            path.write_text(json.dumps(known, indent=1) + "\n")
    print(f"{runs} runs, {compared} files compared, {differing} differ")
    if runs == 0 or (compared == 0 and not options.update):
        print("nothing was compared")
        return 1
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
