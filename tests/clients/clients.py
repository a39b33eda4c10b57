#!/usr/bin/python3
"""clients.py PROGRAM [--out DIR] [--only REGEX]: writes the sample in every format with PROGRAM and opens each file in
every program of Debian's and npm's that is here. Prints what each makes of each file, and names what it skipped.

A picture "shows colours" where what differs from its ground is coloured as the sample is; all pictures are in
DIR/pictures, to be looked at. Exits with 1 where a program that is here does not show the colours of relief.glb,
or of relief-emissive.glb if it does not know the unlit material.

A picture of relief-whole.glb that a program takes with the file's camera is compared with the photograph: dB of all pixels,
without the outermost 2, where the program's antialiasing mixes in its ground, and of the median pixel.

Debian's packages: blender, python3-open3d, assimp-utils, f3d, python3-vtk9, chromium, xvfb, xauth, python3-pil, python3-numpy,
nodejs, npm.
"""
import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageChops, ImageStat

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parent.parent / "samples"
PYTHON = "/usr/bin/python3"  # Debian's, which has Debian's modules
FILES = {  # name -> settings
    "relief.glb": [],
    "relief-whole.glb": ["density.background.method=none"],  # without ground: the photograph itself
    "relief-lit.glb": ["export.material=lit"],
    "relief-emissive.glb": ["export.material=emissive"],
    "relief-draco.glb": ["export.compression=draco"],
    "relief-meshopt.glb": ["export.compression=meshopt"],
    "relief-quantized.glb": ["export.compression=quantized"],
    "relief-webp.glb": ["export.texture=webp"],
    "relief-lod-inside.glb": ["export.lod=3", "export.lod_storage=inside"],
    "relief.gltf": [],
    "relief.drc": [],
    "relief.obj": [],
    "relief.ply": [],
    "relief.stl": [],
    "relief.usdz": [],
}
PICTURED = {  # program -> formats, Debian's package, command
    "Blender": (r"glb|gltf|obj|ply|stl|usdz", "blender",
                ["blender", "-b", "--factory-startup", "-P", HERE / "blender_client.py", "--", "FILE", "PICTURE"]),
    "Open3D": (r"glb|gltf|obj|ply|stl", "python3-open3d", [PYTHON, HERE / "open3d_client.py", "FILE", "PICTURE"]),
    "f3d": (r"glb|gltf|obj|ply|stl", "f3d", ["f3d", "FILE", "--output", "PICTURE", "--resolution", "400,300"]),
    "VTK": (r"glb|gltf|obj|ply|stl", "python3-vtk9", [PYTHON, HERE / "vtk_client.py", "FILE", "PICTURE"]),
}
LEAST_COVERED, LEAST_CHROMA = 0.02, 20  # share of the picture; of 255
WITH_FILES_CAMERA = ("three.js", "model-viewer", "Cesium", "Babylon.js", "Blender")  # model-viewer: given it by the page


def colours(picture):
    """What a picture shows: nothing, a shape, or colours."""
    if not picture.exists():
        return "no picture"
    image = Image.open(picture).convert("RGB")
    ground = Image.new("RGB", image.size, image.getpixel((image.width - 2, 8)))
    red, green, blue = ImageChops.difference(image, ground).split()
    covered = ImageChops.lighter(ImageChops.lighter(red, green), blue).point(lambda v: 255 if v > 12 else 0)
    share = ImageStat.Stat(covered).mean[0] / 255
    if share < LEAST_COVERED:
        return "shows nothing"
    red, green, blue = image.split()
    chroma = ImageChops.subtract(ImageChops.lighter(ImageChops.lighter(red, green), blue),
                                 ImageChops.darker(ImageChops.darker(red, green), blue))
    mean = ImageStat.Stat(chroma, covered).mean[0]
    return "shows colours" if mean > LEAST_CHROMA else "shows a shape without colours"


def shown(name, file, picture):
    """What colours() says of a picture, and how close it is to the photograph if it is meant to be that."""
    said = colours(picture)
    if file != "relief-whole.glb" or name not in WITH_FILES_CAMERA or not picture.exists():
        return said
    taken, photograph = (np.asarray(Image.open(path).convert("RGB"), float) for path in (picture, SAMPLES / "left.png"))
    if taken.shape != photograph.shape:
        return said
    errors = ((taken - photograph) ** 2).mean(axis=2)
    whole, inside, median = (10 * np.log10(255**2 / e) for e in (errors.mean(), errors[2:-2, 2:-2].mean(), np.median(errors)))
    return f"{said}, {whole:.1f} dB ({inside:.1f} inside, {median:.1f} median)"


def debian_version(package):
    known = subprocess.run(["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", package], capture_output=True, text=True)
    status, _, version = known.stdout.partition(" ")
    return version if status == "installed" else None


def write_files(program, folder):
    folder.mkdir(parents=True, exist_ok=True)
    pair = ["--left", SAMPLES / "left.png", "--right", SAMPLES / "right.png", "--calib", SAMPLES / "calib.txt"]
    for name, settings in FILES.items():
        wished = [word for setting in settings for word in ("--set", setting)]
        subprocess.run([program, "run", "--quiet", *pair, "-o", folder / name, *wished], check=True)


def told(output):
    """The client's own line, else the last one of its output."""
    lines = [line for line in output.splitlines() if line.strip()]
    results = [line[7:] for line in lines if line.startswith("RESULT ")]
    return (results or lines or ["ok"])[-1].strip()[:200]


def pictured(files, pictures, wanted):
    for name, (formats, package, command) in PICTURED.items():
        if not wanted(name):
            continue
        version = debian_version(package)
        if not version or not shutil.which("xvfb-run"):
            yield name, "", "", f"SKIPPED: needs the packages {package}, xvfb and xauth"
            continue
        for file in files:
            if not re.fullmatch(formats, file.suffix[1:]):
                continue
            picture = pictures / f"{name}--{file.name}.png"
            picture.unlink(missing_ok=True)
            words = [{"FILE": file, "PICTURE": picture}.get(word, word) for word in command]
            try:
                run = subprocess.run(["xvfb-run", "-a", *words], capture_output=True, text=True, timeout=120)
                said = told(run.stdout) if run.returncode == 0 else f"exit code {run.returncode}: " + told(run.stderr)
            except subprocess.TimeoutExpired:
                said = "took longer than 120 s"
            yield name, version, file.name, f"{shown(name, file.name, picture)}; {said}"


def assimp(files, wanted):
    if not wanted("assimp"):
        return
    version = debian_version("assimp-utils")
    if not version:
        yield "assimp", "", "", "SKIPPED: needs the package assimp-utils"
        return
    for file in files:
        if file.suffix in (".drc", ".usdz"):
            continue
        run = subprocess.run(["assimp", "info", file], capture_output=True, text=True)
        faces = re.search(r"Faces:\s+(\d+)", run.stdout)
        textures = len(re.findall(r"^ +\d+ \(\$tex\.file\)", run.stdout, re.M))
        is_read = faces and faces[1] != "0"
        yield ("assimp", version, file.name,
               f"ok: {faces[1]} triangles, {textures} textures named" if is_read else told(run.stdout + run.stderr))


def npm_programs(out, files_folder, pictures, wanted):
    if not any(map(wanted, ("gltf-validator", "glTF-Transform", "three.js", "model-viewer", "Cesium", "Babylon.js"))):
        return
    modules = out / "npm"
    if not shutil.which("npm"):
        yield "npm's programs", "", "", "SKIPPED: needs nodejs and npm"
        return
    modules.mkdir(exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(HERE / name, modules / name)
    if subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"], cwd=modules).returncode:
        yield "npm's programs", "", "", "SKIPPED: npm ci failed"
        return
    runs = [["node", HERE / "gltf.mjs", modules, files_folder]]
    browser = shutil.which("chromium")
    if browser:
        runs.append(["node", HERE / "web.mjs", modules, files_folder, pictures, browser])
    else:
        yield "three.js, model-viewer, Cesium, Babylon.js", "", "", "SKIPPED: needs the package chromium"
    for command in runs:
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            yield Path(command[1]).name, "", "", f"exit code {run.returncode}: " + told(run.stderr)
        for line in run.stdout.splitlines():
            name, version, file, said = line.split("\t")
            picture = pictures / f"{name}--{file}.png"
            yield name, version, file, f"{shown(name, file, picture)}; {said}" if picture.exists() else said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--out", type=Path, default=Path("out/clients"))
    parser.add_argument("--only", default="", help="programs whose name matches")
    options = parser.parse_args()
    out = options.out.resolve()
    files_folder, pictures = out / "files", out / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    write_files(options.program.resolve(), files_folder)
    files = [files_folder / name for name in FILES]

    def wanted(name):
        return re.search(options.only, name) is not None

    failed = skipped = 0
    for results in (npm_programs(out, files_folder, pictures, wanted), pictured(files, pictures, wanted), assimp(files, wanted)):
        for name, version, file, said in results:
            print(f"{name:15} {version:28} {file:22} {said}", flush=True)
            skipped += said.startswith("SKIPPED")
            told_unlit = name not in ("f3d", "VTK")  # Debian's do not know the unlit material
            judged = file == ("relief.glb" if told_unlit else "relief-emissive.glb") and (
                name in PICTURED or name in ("three.js", "model-viewer", "Cesium", "Babylon.js"))
            failed += judged and not said.startswith("shows colours")
    print(f"{failed} programs do not show relief.glb, {skipped} skipped")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
