"""Stereo pairs and disparity maps to compact, textured, metric 3D meshes.

    import hexrelief
    disparity = hexrelief.compute_disparity(left, right, camera="calib.txt")
    mesh = hexrelief.mesh(disparity, color=left, camera="calib.txt")
    mesh.save("relief.glb")

Keys, checks, messages and bytes are those of the command ``hexrelief run``. Pictures are (H, W, 3) or (H, W)
uint8, red green blue, rows from the top; with a fourth channel, alpha, what is transparent is unknown. Arrays of
NumPy, and of all that speaks DLPack or ``__cuda_array_interface__``, are taken.
"""

from __future__ import annotations

import dataclasses
import html
import json
import math
import os
import tempfile
import warnings
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import map_array, picture_array
from ._core import Error
from ._words import in_python

__version__ = _core.version
__all__ = [
    "Camera", "Error", "Mesh", "compute_disparity", "evaluate", "measure_surface", "mesh", "read_disparity", "read_picture"
]

PathLike = Union[str, "os.PathLike[str]"]
Progress = Optional[Callable[[str, float], Any]]


@dataclasses.dataclass
class Camera:
    """The rectified left camera and its distance from the right one.

    Lengths are metres, the rest px of the left picture, whose first pixel's centre is (0.5, 0.5). What is not
    given is taken from ``file`` (whatever ``--calib`` reads), or from the picture's size; without a focal length
    and a baseline the mesh is right up to scale alone. Z = focal_px * baseline_m / (disparity + doffs_px).
    """

    focal_px: Optional[float] = None
    baseline_m: Optional[float] = None
    cx: Optional[float] = None
    cy: Optional[float] = None
    doffs_px: Optional[float] = None
    file: Optional[PathLike] = None

    @classmethod
    def from_matrix(cls, matrix: Any, baseline_m: Optional[float] = None) -> "Camera":
        """By a 3x3 camera matrix, as OpenCV has it: the first pixel's centre is (0, 0) there."""
        k = np.asarray(matrix, dtype=float)
        if k.shape != (3, 3):
            raise ValueError(f"a camera matrix has the shape (3, 3), not {k.shape}")
        return cls(float(k[0, 0] + k[1, 1]) / 2, baseline_m, float(k[0, 2]) + 0.5, float(k[1, 2]) + 0.5)


CameraLike = Union[None, Camera, PathLike, Mapping[str, Any]]
Config = Union[None, PathLike, Sequence[PathLike], Mapping[str, Any]]


class Mesh:
    """A mesh, with all that it was made from. The arrays are read-only views of its memory."""

    def __init__(self, core: _core.Mesh) -> None:
        self._core = core

    @property
    def vertices(self) -> NDArray[np.float32]:
        """(N, 3) float32, metres where ``is_metric``: camera at the origin, +X right, +Y up, looking along -Z."""
        return self._core.vertices()

    @property
    def faces(self) -> NDArray[np.uint32]:
        """(M, 3) uint32: the vertices of each triangle, counter-clockwise seen from the camera."""
        return self._core.faces()

    @property
    def uv(self) -> NDArray[np.float32]:
        """(N, 2) float32: (0, 0) is the left picture's top left corner, (1, 1) its bottom right one."""
        return self._core.uv()

    @property
    def lattice(self) -> NDArray[np.float32]:
        """(rows, columns, 2) float32, px of the left view: the flat mesh before it was cut and lifted."""
        return self._core.lattice()

    @property
    def disparity(self) -> NDArray[np.float32]:
        """(H, W) float32, px: the map that was meshed, filled where it was sparse, steps smoothed; unknown is +inf."""
        return self._core.disparity()

    @property
    def is_metric(self) -> bool:
        """False where focal length or baseline are not known."""
        return self._core.is_metric()

    @property
    def report(self) -> dict[str, Any]:
        """What ``--report`` writes. The measures are taken anew each time."""
        return json.loads(self._core.report())

    def save(self, path: PathLike, *, progress: Progress = None, **options: Any) -> list[str]:
        """Writes the mesh; the extension gives the format. Returns the paths of all files written.

        Options are keys of ``export``: ``mesh.save("relief.glb", compression="draco", tolerance_px=0.2)``.
        """
        return self._core.save(os.fspath(path), _settings({"export": options}), _warn, progress)

    def to_bytes(self, format: str = "glb", **options: Any) -> bytes:
        """The bytes that ``save("relief." + format, **options)`` writes; ValueError if these are several files."""
        with tempfile.TemporaryDirectory() as folder:
            settings, path = _settings({"export": options}), os.path.join(folder, "relief." + format)
            try:
                files = self._core.save(path, settings, _warn, None)
            except Error as error:
                error.args = (str(error).replace(path, format),)  # no caller knows the folder
                raise
            if len(files) > 1:
                raise ValueError(f"{format}: the mesh would be {len(files)} files; save() writes them")
            with open(files[0], "rb") as file:
                return file.read()

    def __repr__(self) -> str:
        unit = "m" if self.is_metric else "relative units"
        return f"<hexrelief.Mesh: {len(self.vertices)} vertices, {len(self.faces)} triangles, {unit}>"

    def _repr_html_(self) -> str:
        """The viewer page, in a frame that may run its script and nothing else."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                text = html.escape(self.to_bytes("html").decode(), quote=True)
        except Error as error:
            return f"<pre>{html.escape(repr(self))}\n{html.escape(str(error))}</pre>"
        return (
            f'<iframe title="{html.escape(repr(self))}" sandbox="allow-scripts" srcdoc="{text}"'
            ' style="width:100%;height:480px;border:0"></iframe>'
        )


def compute_disparity(
    left: Any,
    right: Any,
    *,
    camera: CameraLike = None,
    config: Config = None,
    backend: str = "auto",
    progress: Progress = None,
    **options: Any,
) -> NDArray[np.float32]:
    """The disparities of the left picture of a rectified pair: (H, W) float32 in px, unknown is +inf.

    left, right: (H, W, 3) or (H, W) uint8 of one size. Options are keys of ``disparity``, as in
    ``num_disparities_px=64``. camera's file may say the range to search (Middlebury's ndisp); without it and
    without ``num_disparities_px`` the pair does. progress: as for ``mesh()``.
    """
    for role, picture in (("left", left), ("right", right)):
        if picture is None:
            raise TypeError(f"{role}: a picture is needed, not None")
    names, settings = _configured(config, backend, {"disparity": options})
    return _core.compute_disparity(
        picture_array(left, "left"), picture_array(right, "right"), _camera(camera), names, settings, _warn, progress
    )


def mesh(
    disparity: Any = None,
    *,
    depth: Any = None,
    color: Any = None,
    mask: Any = None,
    confidence: Any = None,
    camera: CameraLike = None,
    config: Config = None,
    backend: str = "auto",
    progress: Progress = None,
    **sections: Any,
) -> Mesh:
    """A mesh of a disparity map, or of a depth map.

    disparity: (H, W) floats, px of the left view; what is not above 0 or not finite is unknown. uint16 and uint8
        are read as such files are (``input={"disparity": {"scale": ...}}``).
    depth: (H, W) instead: floats are metres along the optical axis, uint16 millimetres, where
        ``input={"depth": {"unit": ..., "kind": ...}}`` does not say otherwise.
    mask: (H, W) or (H, W, 3) uint8 or bool; where it is 0 the view is unknown.
    confidence: (H, W) floats or integers; below ``input={"confidence": {"threshold": ...}}`` the map is unknown.
    color: the left picture, (H, W, 3) or (H, W) uint8, for the texture; of the same aspect.
    camera: a calibration file, a Camera, or its values as a mapping.
    config: a preset ("compact", "quality", ...), a YAML file, a list of these of which later ones win, or keys and
        values: {"mesh.spacing_px": 4}.
    backend: "auto", "cpu" or "cuda".
    progress: called with the stage's name and the share of it that is done, from 0 to 1; what it raises ends the work.
    sections: keys on top of config: ``mesh={"spacing_px": 4}, export={"compression": "draco"}``.
        ``budget={"max_bytes": 100000}`` is of a .glb, whatever the format that is saved later.

    Warnings of the command line are Python's warnings. Ctrl-C ends the work at its next step.
    """
    names, settings = _configured(config, backend, sections)
    arrays = {
        "disparity": map_array(disparity, "disparity"),
        "depth": map_array(depth, "depth"),
        "color": picture_array(color, "color"),
        "mask": picture_array(mask, "mask"),
        "confidence": map_array(confidence, "confidence"),
    }
    return Mesh(_core.mesh(arrays, _camera(camera), names, settings, _warn, progress))


def read_picture(path: PathLike) -> NDArray[np.uint8]:
    """(H, W, 3) or (H, W, 1) uint8, with alpha (H, W, 4) or (H, W, 2), of a PNG, JPEG, TIFF, WebP, BMP, HEIC, PPM
    or PGM; pixels are as stored, not turned by EXIF data."""
    return _core.read_picture(os.fspath(path))


def read_disparity(path: PathLike, **options: Any) -> NDArray[np.float32]:
    """(H, W) float32, px, of a PFM, PNG, PGM, TIFF, NPY, NPZ or EXR. Options are keys of ``input.disparity``."""
    return _core.read_disparity(os.fspath(path), _settings({"input.disparity": options}))


def evaluate(
    disparity: Any, truth: Any, *, right_truth: Any = None, discontinuity_px: float = 1
) -> dict[str, float]:
    """A map's errors against the truth, (H, W) floats in px, by the names of ``hexrelief evaluate --json``.

    What is not above 0 or not finite is unknown. right_truth: of the right view, to tell what it does not see.
    """
    right = None if right_truth is None else _floats(right_truth)
    return json.loads(_core.evaluate(_floats(disparity), _floats(truth), right, discontinuity_px))


def measure_surface(
    points: Any, faces: Any, truth: Any, *, config: Config = None, **sections: Any
) -> dict[str, float]:
    """The errors and holes of any mesh against a true map (H, W), by the names of the report's ``surface``.

    points: (N, 3), x and y in px of the left picture (the first pixel's centre is 0.5) and disparity in px. faces:
    (M, 3). The keys of ``density`` say what is background.
    """
    names, settings = _configured(config, "auto", sections)
    triangles = np.ascontiguousarray(faces, dtype=np.uint32)
    return json.loads(_core.measure_surface(_floats(points), triangles, _floats(truth), names, settings))


def _floats(values: Any) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, dtype=np.float32)


def _warn(text: str) -> None:
    # To the caller of that function here which called _core: _core itself is no level of Python's stack.
    warnings.warn(in_python(text), UserWarning, stacklevel=3)


def _camera(camera: CameraLike) -> _core.Camera:
    if camera is None:
        camera = Camera()
    elif isinstance(camera, Mapping):
        camera = Camera(**camera)
    elif not isinstance(camera, Camera):
        camera = Camera(file=camera)
    values = (camera.focal_px, camera.baseline_m, camera.cx, camera.cy, camera.doffs_px)
    file = "" if camera.file is None else os.fspath(camera.file)
    return _core.Camera(file, *(math.nan if value is None else float(value) for value in values))


def _configured(config: Config, backend: str, sections: Mapping[str, Any]) -> tuple[list[str], list[tuple[str, str]]]:
    settings: list[tuple[str, str]] = []
    names: list[str] = []
    if isinstance(config, Mapping):
        settings += _settings(config)
    elif isinstance(config, (str, os.PathLike)):
        names = [os.fspath(config)]
    elif config is not None:
        names = [os.fspath(name) for name in config]
    settings += _settings(sections)
    if backend != "auto":
        settings.append(("run.backend", backend))
    return names, settings


def _settings(values: Mapping[str, Any], above: str = "") -> list[tuple[str, str]]:
    """{"mesh": {"spacing_px": 4}} and {"mesh.spacing_px": 4} to [("mesh.spacing_px", "4")]."""
    settings: list[tuple[str, str]] = []
    for key, value in values.items():
        if isinstance(value, Mapping):
            settings += _settings(value, f"{above}{key}.")
        else:
            settings.append((above + key, _text(value)))
    return settings


def _text(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
