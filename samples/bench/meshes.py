"""Meshes in px (points: x, y, disparity) for rd.py: grids, simplification, other programs' files, Draco."""
import ctypes
import ctypes.util
import pathlib
import subprocess
import tempfile

import numpy as np

LEVEL = 7  # of Draco's compression


def used(points, faces):
    """The mesh without points that no face uses."""
    kept, faces = np.unique(faces, return_inverse=True)
    return points[kept], faces.reshape(-1, 3).astype(np.uint32)


def filled(disparity):
    """Unknown pixels at the farther one of their row's nearest known ones, so that no grid spends bytes on holes."""
    known = np.where(np.isfinite(disparity) & (disparity > 0), disparity, 0)
    columns = np.arange(known.shape[1])
    before = np.maximum.accumulate(np.where(known > 0, columns, 0), axis=1)
    after = np.flip(np.minimum.accumulate(np.flip(np.where(known > 0, columns, len(columns) - 1), 1), axis=1), 1)
    sides = [np.take_along_axis(known, side, axis=1) for side in (before, after)]
    return np.where((sides[0] > 0) & (sides[1] > 0), np.minimum(*sides), np.maximum(*sides))


def grid_lines(size, spacing_px):
    """Pixels from 0 to size - 1, both included, about spacing_px apart."""
    steps = max(1, round((size - 1) / spacing_px))
    return np.floor((size - 1) * np.arange(steps + 1) / steps + 0.5).astype(int)


def uniform(disparity, background_px, spacing_px):
    """A grid; triangles with no corner in the foreground are left out."""
    columns, rows = (grid_lines(size, spacing_px) for size in disparity.shape[::-1])
    values = filled(disparity)[np.ix_(rows, columns)]
    x, y = np.meshgrid(columns + 0.5, rows + 0.5)
    points = np.stack([x, y, values], axis=-1).reshape(-1, 3).astype(np.float32)
    index = np.arange(values.size).reshape(values.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    faces = np.stack([a, c, b, b, c, d], axis=-1).reshape(-1, 3)
    kept = (values > 0) & (values >= background_px)
    return used(points, faces[kept.ravel()[faces].any(axis=1)])


def without_steps(points, faces, step_px):
    """The mesh without triangles across steps."""
    depths = points[:, 2][faces]
    return used(points, faces[depths.max(axis=1) - depths.min(axis=1) <= step_px])


def meshoptimizer():
    """The library, or None where there is none."""
    name = ctypes.util.find_library("meshoptimizer")
    if name is None:
        return None
    library = ctypes.CDLL(name)
    array, size, number, flags = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_float, ctypes.c_uint
    library.meshopt_simplify.restype = size
    library.meshopt_simplify.argtypes = [array, array, size, array, size, size, size, number, flags, array]
    return library


def simplified(points, faces, triangles):
    """About so many triangles, whatever the error."""
    points, faces = np.ascontiguousarray(points, np.float32), np.ascontiguousarray(faces, np.uint32)
    result = np.empty_like(faces)
    count = meshoptimizer().meshopt_simplify(
        result.ctypes.data, faces.ctypes.data, faces.size, points.ctypes.data, len(points), 12, 3 * triangles, 1e9, 0, None
    )
    return used(points, result.reshape(-1)[:count].reshape(-1, 3))


def read_obj(path):
    """A file whose vertices are x, y and disparity in px; faces may have more than three corners."""
    points, faces = [], []
    for number, line in enumerate(pathlib.Path(path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                points.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) for word in words[1:]]
                corners = [corner - 1 if corner > 0 else len(points) + corner for corner in corners]
                faces += [[corners[0], b, c] for b, c in zip(corners[1:], corners[2:])]
        except ValueError as error:
            raise SystemExit(f"{path}: line {number}: {error}") from error
    if not faces or np.max(faces) >= len(points) or np.min(faces) < 0 or set(map(len, points)) != {3}:
        raise SystemExit(f"{path}: it holds no triangles of its own vertices x y disparity")
    return used(np.array(points, np.float32), np.array(faces))


def through_draco(points, faces, bits):
    """Bytes of the positions by Draco, and the mesh as decoded. Needs Debian's package draco."""
    with tempfile.TemporaryDirectory() as folder:
        ply, drc = pathlib.Path(folder, "mesh.ply"), pathlib.Path(folder, "mesh.drc")
        write_ply(ply, points, faces)
        for command in (
            ["draco_encoder", "-i", ply, "-o", drc, "-qp", str(bits), "-cl", str(LEVEL)],
            ["draco_decoder", "-i", drc, "-o", ply],
        ):
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return drc.stat().st_size, *read_ply(ply)


FACE = np.dtype([("count", "u1"), ("corners", "<u4", 3)])


def write_ply(path, points, faces):
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), FACE)
    records["count"], records["corners"] = 3, faces
    path.write_bytes(head.encode() + np.ascontiguousarray(points, "<f4").tobytes() + records.tobytes())


def read_ply(path):
    """What draco_decoder writes: x, y, z and lists of three."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")]
    points = np.frombuffer(body, "<f4", 3 * counts[0]).reshape(-1, 3)
    faces = np.frombuffer(body[points.nbytes :], FACE, counts[1])
    return points, faces["corners"].astype(np.uint32)
