"""What the benchmarks share: arguments, scenes in a folder, backends, tables."""
import argparse
import json
import pathlib
import statistics
import sys
import typing
import warnings

import numpy as np

import hexrelief


warnings.simplefilter("ignore")  # such as that depths are relative


def arguments(text, with_scenes):
    """A parser with the options that all benchmarks have."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, required=True, metavar="DIR", help="folder with Middlebury's sets")
    parser.add_argument(
        "--scenes" if with_scenes else "--maps",
        type=names,
        default=[],
        metavar="NAMES",
        dest="names",
        help="of folders, such as cones-quarter,Piano" if with_scenes else "the paper's, such as cones,conesL",
    )
    parser.add_argument("--threads", type=int, default=0, help="0 = all")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="settings",
        help="one key of the configuration; may be given several times",
    )
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the rows as JSON, too")
    return parser


def names(text):
    return text.split(",")


def settings(options):
    """Threads and all --set, as hexrelief takes them; of one key the last wins."""
    for setting in options.settings:
        if "=" not in setting:
            sys.exit(f"--set {setting}: give KEY=VALUE")
    return {"run.threads": options.threads} | dict(setting.split("=", 1) for setting in options.settings)


def chosen(known, wanted, option):
    """Those of `known` that are wanted, or all. An unknown name ends the program."""
    for name in wanted:
        if name not in known:
            sys.exit(f"{option}: unknown name '{name}'; choose among {', '.join(known)}")
    return [name for name in known if name in wanted or not wanted]


class PaperMap(typing.NamedTuple):
    """A row of the paper's Table 2. Times (s) and %cost are means of ten runs on hardware of 2012."""

    set: str
    name: str
    folder: str
    scale: int  # raw value / scale = px
    ssr: int
    gpu_s: float
    cpu_s: float
    gpu_cost: float
    cpu_cost: float


PAPER_MAPS = [
    PaperMap(*row)
    for row in (
        ("first", "tsukuba", "middlebury2001/tsukuba", 16, 3, 0.32, 1.87, 25.89, 25.02),
        ("first", "rocks1", "middlebury2006/rocks1-third", 3, 3, 0.34, 2.28, 17.94, 18.73),
        ("first", "aloe", "middlebury2006/aloe-third", 3, 3, 0.30, 2.50, 27.15, 28.70),
        ("first", "venus", "middlebury2001/venus", 8, 3, 0.32, 2.40, 21.55, 19.62),
        ("first", "teddy", "middlebury2003/teddy-quarter", 4, 3, 0.36, 2.41, 18.45, 20.04),
        ("first", "cones", "middlebury2003/cones-quarter", 4, 3, 0.35, 2.45, 17.24, 16.69),
        ("S", "rocks1S", "middlebury2006/rocks1-third", 3, 4, 0.66, 3.32, 20.03, 18.91),
        ("S", "aloeS", "middlebury2006/aloe-third", 3, 4, 0.51, 3.56, 27.45, 28.02),
        ("S", "conesS", "middlebury2003/cones-quarter", 4, 4, 0.67, 3.52, 18.95, 16.59),
        ("S", "teddyS", "middlebury2003/teddy-quarter", 4, 4, 0.69, 3.45, 18.19, 19.91),
        ("M", "rocks1M", "middlebury2006/rocks1-half", 2, 4, 1.05, 8.33, 21.65, 18.37),
        ("M", "aloeM", "middlebury2006/aloe-half", 2, 4, 0.57, 9.36, 26.39, 26.90),
        ("M", "conesM", "middlebury2003/cones-half", 2, 4, 1.36, 18.52, 18.75, 17.82),
        ("M", "teddyM", "middlebury2003/teddy-half", 2, 4, 1.35, 18.53, 21.07, 19.26),
        ("L", "rocks1L", "middlebury2006/rocks1-full", 1, 4, 2.18, 47.36, 21.73, 19.53),
        ("L", "aloeL", "middlebury2006/aloe-full", 1, 4, 0.95, 53.19, 25.64, 24.72),
        ("L", "conesL", "middlebury2003/cones-full", 1, 4, 2.74, 107.10, 17.27, 25.93),
        ("L", "teddyL", "middlebury2003/teddy-full", 1, 4, 2.13, 110.25, 25.98, 23.63),
    )
]


def paper_maps(options, sets):
    """(PaperMap, disparities in px) of the chosen maps that --data holds; says which it lacks."""
    known = [one for one in PAPER_MAPS if one.set in sets]
    wanted = chosen([one.name for one in known], options.names, "--maps")
    found = []
    for one in known:
        if one.name not in wanted:
            continue
        files = [options.data / one.folder / file for file in ("disp.png", "disp.pgm")]
        file = next((file for file in files if file.is_file()), None)
        if file is None:
            print(f"not there, left out: {one.name} ({one.folder}/disp.png or .pgm)")
        else:
            found.append((one, file))
    if not found:
        sys.exit(f"--data {options.data}: none of the maps asked for is there")
    for one, file in found:
        yield one, hexrelief.read_disparity(file, scale=one.scale)


class Scene(typing.NamedTuple):
    """A rectified pair with the left view's truth."""

    name: str
    folder: pathlib.Path
    size: str  # small, half or full
    left: pathlib.Path
    right: pathlib.Path
    truth: pathlib.Path
    scale: float

    @property
    def discontinuity_px(self):
        return 2 if self.size == "full" else 1

    def pictures(self):
        return hexrelief.read_picture(self.left), hexrelief.read_picture(self.right)

    def disparity(self, stem=None):
        """The true disparities, or None if there is no file `stem`."""
        file = self.truth if stem is None else first_file(self.folder, [stem], (".pfm", ".pgm", ".png"))
        return file and hexrelief.read_disparity(file, scale=self.scale)


def first_file(folder, stems, extensions):
    files = (folder / (stem + extension) for stem in stems for extension in extensions)
    return next((file for file in files if file.is_file()), None)


def scale_of(name, folder, truth):
    """Raw value / scale = px, by the names that Middlebury's folders have; None where they do not say it."""
    if truth.suffix == ".pfm":
        return 1
    if folder.parent.name == "middlebury2001":
        return 16 if name == "tsukuba" else 8
    endings = {"-quarter": 4, "-third": 3, "-half": 2, "-full": 1}
    return next((scale for ending, scale in endings.items() if name.endswith(ending)), None)


def scenes(options):
    """The chosen scenes at any depth below --data: left.*, right.* and disp.*, or MiddEval3's im0, im1, disp0GT. Colour
    pictures beside grey ones, left_color.*, are a scene of their own, NAME-color."""
    found = []
    for folder in sorted([options.data, *(path for path in options.data.rglob("*") if path.is_dir())]):
        name = folder.name
        truth = first_file(folder, ["disp", "disp0GT"], (".pfm", ".pgm", ".png"))
        size = next((size for size in ("half", "full") if name.endswith("-" + size)), "small")
        for ending, left, right in (("", ["left", "im0"], ["right", "im1"]), ("-color", ["left_color"], ["right_color"])):
            pictures = [first_file(folder, stems, (".png", ".ppm", ".pgm", ".jpg")) for stems in (left, right)]
            if truth is None or None in pictures:
                continue
            scale = scale_of(name, folder, truth)
            if scale is None:
                print(f"left out: {folder} (no scale is known for its name)")
            else:
                found.append(Scene(name + ending, folder, size, *pictures, truth, scale))
    if not found:
        sys.exit(f"--data {options.data}: no folder below it holds left.*, right.* and disp.*")
    wanted = chosen([scene.name for scene in found], options.names, "--scenes")
    return [scene for scene in found if scene.name in wanted]


def backends():
    """The usable ones, the CPU first. Trying the device also starts it, which must count for no scene."""
    picture = hexrelief.read_picture(pathlib.Path(__file__).parent.parent / "left.png")
    try:
        hexrelief.compute_disparity(picture, picture, backend="cuda", num_disparities_px=16)
    except hexrelief.Error as error:
        if error.kind != "device":
            raise
        return ["cpu"]
    return ["cpu", "cuda"]


def stage_seconds(report, *stages):
    return sum(stage["seconds"] for stage in report["stages"] if stage["name"] in stages)


LEFT_ALONE = {"surface.views": "left", "disparity.fill": "none"}  # what the map says, and no more


def camera_of(disparity):
    """Any camera does where errors are measured in the picture: this one has its width as focal length."""
    return {"focal_px": disparity.shape[1], "baseline_m": 1}


def points_of(mesh):
    """(N, 3): x and y in px of the left picture and disparity in px, of a mesh by camera_of() its map."""
    height, width = mesh.disparity.shape
    x, y, z = mesh.vertices.T.astype(float)
    disparity = -width / z
    return np.column_stack([width / 2 + x * disparity, height / 2 - y * disparity, disparity]).astype(np.float32)


def times(runs):
    return {"median": statistics.median(runs), "spread": max(runs) - min(runs), "runs": runs}


class Table:
    """Prints rows as they are measured, and keeps their figures for --json.

    columns: "heading format, heading format": format as of a number or a text, such as >8.3f; all have a width.
    """

    def __init__(self, columns):
        headings, self.formats = zip(*(column.rsplit(" ", 1) for column in columns.split(", ")))
        self.widths = [form.split(".")[0] for form in self.formats]
        self.rows = []
        print(" ".join(map(format, headings, self.widths)).rstrip())

    def add(self, cells, row):
        """cells: as in the table, None = nothing; row: a dictionary for JSON."""
        columns = zip(cells, self.formats, self.widths)
        texts = (format("-", width) if cell is None else format(cell, form) for cell, form, width in columns)
        print(" ".join(texts).rstrip(), flush=True)
        self.rows.append(row)


def write_json(options, **content):
    if options.json:
        text = json.dumps({"schema": 1, "version": hexrelief.__version__, "threads": options.threads} | content, indent=1)
        options.json.write_text(text + "\n", encoding="utf-8")
