"""The Python module against the command line: the same bytes, messages and exit codes; arrays; Ctrl-C."""

import ctypes
import gc
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import warnings

import numpy as np
import pytest

import hexrelief
from hexrelief import _arrays

SAMPLES = pathlib.Path(os.environ["HEXRELIEF_SOURCES"]) / "samples"
PROGRAM = pathlib.Path(os.environ["HEXRELIEF_BUILD"]) / "hexrelief"
CALIB = SAMPLES / "calib.txt"


def run(*arguments):
    return subprocess.run([PROGRAM, "run", *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def left():
    return hexrelief.read_picture(SAMPLES / "left.png")


@pytest.fixture(scope="module")
def disparity():
    return hexrelief.read_disparity(SAMPLES / "disparity.pfm")


@pytest.fixture(scope="module")
def relief(disparity, left):
    return hexrelief.mesh(disparity, color=left, camera=CALIB)


def test_pair_gives_the_bytes_of_the_command_line(left, tmp_path):
    right = hexrelief.read_picture(SAMPLES / "right.png")
    disparity = hexrelief.compute_disparity(left, right, camera=CALIB, num_disparities_px=48)
    assert disparity.shape == left.shape[:2] and disparity.dtype == np.float32
    config = {"disparity.num_disparities_px": 48, "surface.views": "left", "surface.behind": 1}
    made = hexrelief.mesh(disparity, color=left, camera=CALIB, config=config)
    made.save(tmp_path / "python.glb")
    run("--left", SAMPLES / "left.png", "--right", SAMPLES / "right.png", "--calib", CALIB, "-o", tmp_path / "line.glb",
        "--set", "disparity.num_disparities_px=48", "--set", "surface.views=left", "--set", "surface.behind=1")
    assert (tmp_path / "python.glb").read_bytes() == (tmp_path / "line.glb").read_bytes()


def test_map_gives_the_bytes_of_the_command_line(relief, tmp_path):
    files = relief.save(tmp_path / "python.gltf", compression="draco", **{"draco.level": 3})
    assert sorted(pathlib.Path(file).suffix for file in files) == [".bin", ".gltf", ".jpg"]
    run("--disparity", SAMPLES / "disparity.pfm", "--color", SAMPLES / "left.png", "--calib", CALIB,
        "-o", tmp_path / "line.gltf", "--set", "export.compression=draco", "--set", "export.draco.level=3")
    assert (tmp_path / "python.bin").read_bytes() == (tmp_path / "line.bin").read_bytes()


def test_arrays_have_their_shapes_and_stay(disparity):
    made = hexrelief.mesh(disparity, camera=hexrelief.Camera(focal_px=320, baseline_m=0.16), mesh={"spacing_px": 12})
    vertices, faces = made.vertices, made.faces
    assert made.is_metric and made.uv.shape == (len(vertices), 2)
    assert vertices.dtype == np.float32 and faces.dtype == np.uint32 and faces.shape[1] == 3
    assert made.lattice.ndim == 3 and made.lattice.shape[2] == 2
    assert np.shares_memory(vertices, made.vertices), "no copy"
    assert not vertices.flags.writeable
    before = vertices.copy()
    del made
    gc.collect()
    assert (vertices == before).all(), "the array keeps the mesh"
    assert faces.max() < len(vertices) and (vertices[:, 2] < 0).all()


def test_report_and_representation(relief):
    report = relief.report
    assert report["surface"]["vertices"] == len(relief.vertices)
    assert report["hexrelief"]["version"] == hexrelief.__version__
    assert "triangles, m>" in repr(relief)
    assert relief._repr_html_().startswith(("<iframe", "<pre>"))


def test_refusals_are_those_of_the_command_line(disparity, left, tmp_path):
    def refusal(call):
        with pytest.raises(hexrelief.Error) as caught:
            call()
        return caught.value

    key = refusal(lambda: hexrelief.mesh(disparity, camera=CALIB, config={"mesh.spacing": 4}))
    line = run("--disparity", SAMPLES / "disparity.pfm", "--set", "mesh.spacing=4", "-o", tmp_path / "a.glb")
    assert (key.exit_code, f"hexrelief: --set {key}\n") == (line.returncode, line.stderr)
    assert key.kind == "usage"
    assert refusal(lambda: hexrelief.mesh(np.zeros((50, 50)))).kind == "input"
    assert refusal(lambda: hexrelief.mesh(np.ones((50, 50), np.uint8))).exit_code == 3, "8 bits have no scale"
    assert refusal(lambda: hexrelief.compute_disparity(left, left[:-1])).kind == "input"
    assert refusal(lambda: hexrelief.read_picture(tmp_path / "missing.png")).kind == "input"
    with pytest.raises(TypeError):
        hexrelief.mesh(disparity, color=left.astype(float))
    with pytest.raises(ValueError):
        hexrelief.mesh(disparity[0])
    with pytest.raises(TypeError):
        hexrelief.mesh(object())


def test_messages_are_in_pythons_words(disparity):
    with pytest.raises(hexrelief.Error) as scale:
        hexrelief.mesh(np.ones((50, 50), np.uint8))
    assert "input.disparity.scale" in str(scale.value) and "--" not in str(scale.value)
    with pytest.warns(UserWarning) as told:
        hexrelief.mesh(disparity, mesh={"spacing_px": 16})
    assert "give camera" in str(told[0].message) and "--" not in str(told[0].message)
    with pytest.raises(TypeError, match=r"astype\(np.float32\) / 16"):
        hexrelief.mesh((disparity * 16).astype(np.int16))


def test_progress_is_told_and_may_end_the_work(disparity, relief, tmp_path):
    told = []
    hexrelief.mesh(disparity, camera=CALIB, progress=lambda stage, share: told.append((stage, share)))
    assert {"mesh", "surface"} <= {stage for stage, _ in told} and all(0 <= share <= 1 for _, share in told)
    with pytest.raises(ZeroDivisionError):
        relief.save(tmp_path / "relief.glb", progress=lambda stage, share: 1 / 0)
    assert not list(tmp_path.iterdir())


def test_bytes_are_those_of_the_file(relief, tmp_path):
    relief.save(tmp_path / "relief.ply", texcoords=False)
    assert relief.to_bytes("ply", texcoords=False) == (tmp_path / "relief.ply").read_bytes()
    assert relief.to_bytes().startswith(b"glTF")
    with pytest.raises(ValueError, match="files"):
        relief.to_bytes("gltf")
    with pytest.raises(hexrelief.Error, match="format of 'xyz'"):
        relief.to_bytes("xyz")


def test_warnings_are_warnings(disparity):
    with pytest.warns(UserWarning, match="focal|calib"):
        hexrelief.mesh(disparity, mesh={"spacing_px": 16})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning):
            hexrelief.mesh(disparity, mesh={"spacing_px": 16})


def test_warnings_are_of_the_callers_line(disparity):
    with pytest.warns(UserWarning) as told:
        hexrelief.mesh(disparity, mesh={"spacing_px": 16})
    assert told and {warning.filename for warning in told} == {__file__}


def test_disparities_need_no_camera(left):
    right = hexrelief.read_picture(SAMPLES / "right.png")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = hexrelief.compute_disparity(left, right)
    assert found.shape == left.shape[:2]


@pytest.mark.parametrize("pair", [(None, 1), (1, None)])
def test_pictures_that_are_none_are_refused(pair, left):
    with pytest.raises(TypeError) as caught:
        hexrelief.compute_disparity(*(side and left for side in pair))
    assert str(caught.value) == f"{'left' if pair[0] is None else 'right'}: a picture is needed, not None"


def test_any_layout_gives_the_same_mesh(disparity, left):
    def vertices(values, picture):
        return hexrelief.mesh(values, color=picture, camera=CALIB, mesh={"spacing_px": 12}).vertices

    expected = vertices(disparity, left)
    padded = np.full((disparity.shape[0], disparity.shape[1] + 7), 9, np.float32)
    padded[:, :-7] = disparity
    alpha = np.dstack([left, np.full(left.shape[:2], 255, np.uint8)])
    for values, picture in [
        (padded[:, :-7], alpha),
        (np.asfortranarray(disparity), left[::-1][::-1]),
        (disparity.astype(">f8"), np.asfortranarray(left)),
        (disparity.astype(np.float64), memoryview(np.ascontiguousarray(left))),
    ]:
        assert (vertices(values, picture) == expected).all()


def test_what_is_transparent_is_unknown(disparity, left, tmp_path):
    alpha = np.full(left.shape[:2], 255, np.uint8)
    alpha[:, 160:] = 0
    made = hexrelief.mesh(disparity, color=np.dstack([left, alpha]), camera=CALIB)
    assert made.uv[:, 0].max() < 0.51
    hidden = np.where(alpha > 0, disparity, np.inf)
    assert (made.vertices == hexrelief.mesh(hidden, color=left, camera=CALIB).vertices).all()


def test_depths_masks_and_confidences(disparity, left):
    depth = np.where(np.isfinite(disparity), 100 / np.where(np.isfinite(disparity), disparity, 1), 0)
    mask = np.ones(disparity.shape, bool)
    mask[:, :40] = False
    options = {"mesh": {"spacing_px": 16}, "camera": CALIB}
    whole = hexrelief.mesh(depth=depth.astype(np.float32), color=left, **options)
    part = hexrelief.mesh(depth=depth.astype(np.float32), color=left, mask=mask, **options)
    sure = hexrelief.mesh(disparity, confidence=mask.astype(np.float32), **options)
    assert part.uv[:, 0].min() > 30 / disparity.shape[1] > whole.uv[:, 0].min()
    assert sure.uv[:, 0].min() > 30 / disparity.shape[1]
    with pytest.raises(hexrelief.Error, match="not both"):
        hexrelief.mesh(disparity, depth=depth, **options)
    with pytest.raises(hexrelief.Error, match="leaves no pixel"):
        hexrelief.mesh(disparity, mask=np.zeros(disparity.shape, np.uint8), **options)


def test_dlpack_of_the_host_is_not_copied(disparity):
    class Speaks:
        def __dlpack__(self, stream=None):
            return disparity.__dlpack__()

        def __dlpack_device__(self):
            return disparity.__dlpack_device__()

    assert np.shares_memory(_arrays.map_array(Speaks(), "disparity"), disparity)


def test_dlpack_capsules_are_read(disparity):
    view = disparity[3:, 1::2]
    address, shape, strides, dtype = _arrays.tensor_of(view.__dlpack__())
    assert (address, shape, strides, dtype) == (view.ctypes.data, view.shape, view.strides, view.dtype)


class DeviceArray:
    """In the memory of the first CUDA device, with nothing but its driver."""

    def __init__(self, array):
        self.cuda = ctypes.CDLL("libcuda.so.1")
        self.address, context = ctypes.c_void_p(), ctypes.c_void_p()
        self.call("cuInit", 0)
        self.call("cuDevicePrimaryCtxRetain", ctypes.byref(context), 0)
        self.call("cuCtxSetCurrent", context)
        self.call("cuMemAlloc_v2", ctypes.byref(self.address), ctypes.c_size_t(array.nbytes))
        source = np.ascontiguousarray(array)
        self.call("cuMemcpyHtoD_v2", self.address, ctypes.c_void_p(source.ctypes.data), ctypes.c_size_t(array.nbytes))
        self.__cuda_array_interface__ = {
            "shape": array.shape, "typestr": array.dtype.str, "data": (self.address.value, False), "version": 3,
        }

    def call(self, name, *arguments):
        if getattr(self.cuda, name)(*arguments) != 0:
            raise OSError(name)


def test_device_arrays_are_taken(disparity):
    try:
        there = DeviceArray(disparity)
    except OSError as error:
        pytest.skip(f"no CUDA device here: {error}")
    try:
        assert (_arrays.map_array(there, "disparity") == disparity).all()
    except hexrelief.Error as error:
        assert "without CUDA" in str(error)


def test_control_c_ends_the_work(disparity):
    def interrupt(*_):
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            for _ in range(100):
                hexrelief.mesh(disparity, camera=CALIB)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    assert len(hexrelief.mesh(disparity, camera=CALIB, mesh={"spacing_px": 16}).faces) > 0, "and goes on working"


def test_other_threads_go_on(disparity):
    turns, done = [0], threading.Event()

    def turn():
        while not done.wait(0.001):
            turns[0] += 1

    other = threading.Thread(target=turn)
    other.start()
    hexrelief.mesh(disparity, camera=CALIB, config={"mesh": {"spacing_px": 4, "t_max": 60}})
    done.set()
    other.join()
    assert turns[0] > 3


def test_camera_matrix():
    camera = hexrelief.Camera.from_matrix([[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]], 0.1)
    assert (camera.focal_px, camera.baseline_m, camera.cx, camera.cy) == (500, 0.1, 320, 240)


def test_stubs_name_what_there_is():
    stub = (pathlib.Path(hexrelief.__file__).parent / "_core.pyi").read_text()
    for name in (name for name in dir(hexrelief._core) if not name.startswith("_")):
        assert re.search(rf"\b{name}\b", stub), name


def test_sample_script(tmp_path):
    script = SAMPLES / "python" / "arrays_to_mesh.py"
    done = subprocess.run([sys.executable, script, tmp_path / "relief.glb"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "relief.glb").stat().st_size > 10000
