#!/usr/bin/python3
"""Writes one small example of each kind of input into a folder, made from the sample pair.

usage: make_inputs.py SAMPLES OUT           write them
       make_inputs.py --check SAMPLES OUT   exit with 1 unless OUT holds what would be written
SAMPLES holds left.png, right.png and disparity.pfm. Needs Debian's python3-numpy, python3-pil and
libheif-examples."""
import io
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, TiffImagePlugin

from spatial_heic import write_spatial

FOCAL_PX, BASELINE_M = 320.0, 0.16  # of the sample pair, 320x240
SHRINK = 4


def read_pfm(path):
    with open(path, "rb") as f:
        assert f.readline().strip() == b"Pf"
        width, height = map(int, f.readline().split())
        assert float(f.readline()) < 0
        return np.flipud(np.frombuffer(f.read(), "<f4").reshape(height, width))


def write_pfm(path, values):
    with open(path, "wb") as f:
        f.write(b"Pf\n%d %d\n-1.0\n" % values.shape[::-1])
        f.write(np.flipud(values).astype("<f4").tobytes())


def write_exr(path, channel, values):
    """OpenEXR 2, one float channel, scan lines without compression."""
    height, width = values.shape
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", channel.encode() + b"\0" + struct.pack("<iBBBBii", 2, 0, 0, 0, 0, 1, 1) + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    head = struct.pack("<2i", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    line = 8 + 4 * width
    first = len(head) + 8 * height
    with open(path, "wb") as f:
        f.write(head)
        f.write(struct.pack("<%dQ" % height, *(first + y * line for y in range(height))))
        for y in range(height):
            f.write(struct.pack("<2i", y, 4 * width) + values[y].astype("<f4").tobytes())


def write_mpo(path, left, right):
    """CIPA DC-007: two JPEG files in one, the first with an index of both."""
    def jpeg(image):
        out = io.BytesIO()
        image.save(out, "JPEG", quality=85)
        return out.getvalue()

    first, second = jpeg(left), jpeg(right)
    entries = 3  # version, number of pictures, their list

    def index(size, offset):
        ifd = struct.pack("<2sHI", b"II", 42, 8) + struct.pack("<H", entries)
        ifd += struct.pack("<HHI4s", 0xB000, 7, 4, b"0100") + struct.pack("<HHII", 0xB001, 4, 1, 2)
        ifd += struct.pack("<HHII", 0xB002, 7, 32, 8 + 2 + 12 * entries + 4) + struct.pack("<I", 0)
        ifd += struct.pack("<IIIHH", 0x20020002, size, 0, 0, 0)
        ifd += struct.pack("<IIIHH", 0x00020002, len(second), offset, 0, 0)
        return b"\xff\xe2" + struct.pack(">H", 2 + 4 + len(ifd)) + b"MPF\0" + ifd

    at = 2 + 2 + struct.unpack(">H", first[4:6])[0]  # behind the JFIF segment
    size = len(first) + len(index(0, 0))
    origin = at + 8  # offsets count from the index's own header
    path.write_bytes(first[:at] + index(size, size - origin) + first[at:] + second)


def shrink(image):
    return image.resize((image.width // SHRINK, image.height // SHRINK), Image.BOX)


def write_stereo(out, left, right):
    pair = Image.fromarray(np.hstack([left, right]))
    pair.save(out / "side_by_side.jpg", quality=90)
    pair.resize((left.width, left.height), Image.BOX).save(out / "side_by_side_half.jpg", quality=90)
    Image.fromarray(np.vstack([left, right])).save(out / "top_bottom.jpg", quality=90)
    write_mpo(out / "pair.mpo", left, right)


def write_photographs(out, left, right):
    """As phones and stereo cameras write them."""
    write_spatial(out / "spatial.heic", left, right, (2, 4), FOCAL_PX / SHRINK, BASELINE_M)
    Image.fromarray(np.hstack([right, left])).save(out / "pair.jps", "JPEG", quality=90)  # for crossed eyes
    exif = Image.Exif()
    exif[0x112] = 6  # to be turned clockwise
    left.transpose(Image.ROTATE_90).save(out / "turned.jpg", quality=90, exif=exif)
    left.quantize(64).save(out / "left.bmp")
    right.quantize(64).save(out / "right.bmp")


def rotation(axis, degrees):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + s * cross + (1 - c) * cross @ cross


def seen_by(image, camera, distortion, turn, source_camera):
    """The picture that a camera with this lens, turned about its own centre, takes of a rectified picture's scene."""
    height, width = image.shape[:2]
    y, x = np.mgrid[0:height, 0:width].astype(float)
    xd, yd = (x - camera[0, 2]) / camera[0, 0], (y - camera[1, 2]) / camera[1, 1]
    xu, yu = xd.copy(), yd.copy()
    k1, k2 = distortion
    for _ in range(30):
        r = xu * xu + yu * yu
        xu, yu = xd / (1 + k1 * r + k2 * r * r), yd / (1 + k1 * r + k2 * r * r)
    rays = np.stack([xu, yu, np.ones_like(xu)], -1) @ turn  # turn: rectified axes to the camera's
    u = source_camera[0, 0] * rays[..., 0] / rays[..., 2] + source_camera[0, 2]
    v = source_camera[1, 1] * rays[..., 1] / rays[..., 2] + source_camera[1, 2]
    inside = (u >= 0) & (v >= 0) & (u <= width - 1) & (v <= height - 1)
    u, v = np.clip(u, 0, width - 1.001), np.clip(v, 0, height - 1.001)
    i, j = v.astype(int), u.astype(int)
    a, b = (u - j)[..., None], (v - i)[..., None]
    i1, j1 = np.minimum(i + 1, height - 1), np.minimum(j + 1, width - 1)
    mixed = (image[i, j] * (1 - a) * (1 - b) + image[i, j1] * a * (1 - b)
             + image[i1, j] * (1 - a) * b + image[i1, j1] * a * b)
    return np.where(inside[..., None], mixed, 0).round().astype(np.uint8)


def opencv_matrix(name, values):
    values = np.atleast_2d(values)
    data = ", ".join("%.17g" % v for v in values.ravel())
    return "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ %s ]\n" % (name, *values.shape, data)


def write_unrectified(out, left, right):
    """A pair as two real cameras take it: lenses that bend, axes that differ; and its calibration as OpenCV writes it."""
    focal, size = FOCAL_PX / SHRINK, (left.width, left.height)
    rectified = np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1]])
    turns = [rotation((0.3, 1, 0.2), 0.8), rotation((1, -0.4, 0.6), -1.0)]
    cameras = [np.array([[focal * 1.02, 0, size[0] / 2 - 2], [0, focal * 1.02, size[1] / 2 + 1], [0, 0, 1.0]]),
               np.array([[focal * 1.01, 0, size[0] / 2 + 1], [0, focal * 1.01, size[1] / 2 - 2], [0, 0, 1.0]])]
    lenses = [(-0.12, 0.02), (-0.10, 0.01)]
    for name, image, camera, lens, turn in zip(("left", "right"), (left, right), cameras, lenses, turns):
        seen = seen_by(np.asarray(image, float), camera, lens, turn, rectified)
        Image.fromarray(seen).save(out / ("raw_%s.png" % name))
    turn = turns[1] @ turns[0].T
    shift = turns[1] @ np.array([-BASELINE_M, 0, 0])
    text = "%YAML:1.0\n---\n" + "image_width: %d\nimage_height: %d\n" % size
    for i in range(2):
        text += opencv_matrix("K%d" % (i + 1), cameras[i])
        text += opencv_matrix("D%d" % (i + 1), np.array([*lenses[i], 0, 0, 0]))
    (out / "stereo.yml").write_text(text + opencv_matrix("R", turn) + opencv_matrix("T", shift.reshape(3, 1)))


def write_depths(out, disparity, left):
    focal = FOCAL_PX / SHRINK
    depth = (focal * BASELINE_M / disparity).astype(np.float32)  # m
    height, width = depth.shape
    y, x = np.mgrid[0:height, 0:width]
    ray = depth * np.sqrt(1 + ((x - (width - 1) / 2) / focal) ** 2 + ((y - (height - 1) / 2) / focal) ** 2)
    millimetres = (1000 * depth).round().astype(np.uint16)
    millimetres[:, :4] = 0  # what a sensor does not see
    Image.fromarray(millimetres).save(out / "depth_mm.png")
    np.save(out / "depth.npy", depth.astype(np.float16))
    np.save(out / "inverse.npy", (0.9 / depth + 0.05).astype(np.float16))  # as monocular networks give it
    np.savez_compressed(out / "depth.npz", depth=depth.astype(np.float16), focal_px=np.float32(focal))
    write_exr(out / "ray.exr", "Z", ray)
    write_pfm(out / "depth.pfm", depth)
    nodata = depth.copy()
    nodata[depth > 6] = -9999
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[42113] = "-9999"
    Image.fromarray(nodata).save(out / "depth.tif", tiffinfo=tags, compression="tiff_deflate")

    mask = np.where(depth < 6, 255, 0).astype(np.uint8)
    Image.fromarray(mask).save(out / "mask.png")
    Image.merge("RGBA", (*left.split(), Image.fromarray(mask))).save(out / "cut_out.png")
    confidence = np.clip(2.5 - depth / 4, 0, 2).round().astype(np.uint8)
    Image.fromarray(confidence).save(out / "confidence.png")


def write_maps(out, disparity, depth):
    """Maps whose samples have to be known: StereoSGBM's, of the other sign, without a unit, packed into colours."""
    sgbm = (16 * disparity).round().astype(np.int16)
    sgbm[:, :4] = -16  # what it did not find
    np.save(out / "sgbm.npy", sgbm)
    Image.fromarray(sgbm.astype(np.uint16)).save(out / "sgbm.png")
    np.save(out / "negative.npy", -disparity.astype(np.float16))
    np.save(out / "affine.npy", ((depth - depth.min()) / np.ptp(depth)).astype(np.float16))  # Marigold's
    packed = (depth / 1000 * (2 ** 24 - 1)).round().astype(np.uint32)
    Image.fromarray(np.dstack([packed >> shift & 255 for shift in (0, 8, 16)]).astype(np.uint8)).save(out / "carla.png")
    sintel = np.dstack([np.floor(disparity * scale) % 256 for scale in (1 / 4, 64, 16384)])  # red green blue
    Image.fromarray(sintel.astype(np.uint8)).save(out / "sintel.png")
    tenths = (10000 * np.where(depth < 6.5, depth, 0)).round().astype(np.uint16)
    Image.fromarray(tenths).save(out / "000003.png")
    (out / "colmap.bin").write_bytes(b"%d&%d&1&" % depth.shape[::-1] + depth.astype("<f4").tobytes())


def camera_info(name, width, height, shift):
    """ROS's calibration of one camera, whose projection is that of a rectified pair's."""
    focal, cx, cy = FOCAL_PX / SHRINK, (width - 1) / 2, (height - 1) / 2
    return ("image_width: %d\nimage_height: %d\ncamera_name: %s\n" % (width, height, name) +
            "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [%g, 0, %g, 0, %g, %g, 0, 0, 1]\n" % (focal, cx, focal, cy) +
            "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n" +
            "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n" +
            "projection_matrix:\n  rows: 3\n  cols: 4\n" +
            "  data: [%g, 0, %g, %g, 0, %g, %g, 0, 0, 0, 1, 0]\n" % (focal, cx, shift, focal, cy))


def write_rigs(out, width, height):
    """Calibrations of stereo cameras, by other programs."""
    focal, cx, cy = FOCAL_PX / SHRINK, (width - 1) / 2, (height - 1) / 2
    camera = ("  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
              "  intrinsics: [%g, %g, %g, %g]\n  resolution: [%d, %d]\n" % (focal, focal, cx, cy, width, height))
    (out / "camchain.yaml").write_text(
        "cam0:\n" + camera + "cam1:\n" + camera + "  T_cn_cnm1:\n  - [1, 0, 0, %g]\n" % -BASELINE_M +
        "  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n")
    (out / "transforms.json").write_text(json.dumps(
        {"w": width, "h": height, "fl_x": focal, "fl_y": focal, "cx": cx + 0.5, "cy": cy + 0.5, "frames": []}) + "\n")
    k = np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1]])
    np.savez(out / "rig.npz", K=k, baseline=BASELINE_M)
    (out / "scene_camera.json").write_text(json.dumps(
        {str(i): {"cam_K": (k * [[s], [s], [1]]).ravel().tolist(), "depth_scale": 0.1} for i, s in ((0, 0.5), (3, 1))}) + "\n")
    eye = np.eye(3).tolist()

    def oak(socket, other, centimetres):
        return [socket, {"cameraType": 0, "width": width, "height": height, "intrinsicMatrix": k.tolist(),
                         "distortionCoeff": [0] * 14, "extrinsics": {"rotationMatrix": eye, "toCameraSocket": other,
                         "translation": {"x": centimetres, "y": 0, "z": 0}}}]

    (out / "oak.json").write_text(json.dumps(
        {"cameraData": [oak(1, 2, -100 * BASELINE_M), oak(2, -1, 0)],
         "stereoRectificationData": {"leftCameraSocket": 1, "rightCameraSocket": 2}}) + "\n")
    for name, shift in (("left", 0), ("right", -focal * BASELINE_M)):
        (out / (name + ".yaml")).write_text(camera_info(name, width, height, shift))


def write_laser(out, disparity):
    """A KITTI truth: 16 bits, 256 to the pixel, one row in five."""
    kitti = np.zeros(disparity.shape, np.uint16)
    kitti[::5] = (256 * disparity[::5]).round()
    Image.fromarray(kitti).save(out / "laser.png")


def write_cameras(out, width, height):
    focal, cx, cy = FOCAL_PX / SHRINK, (width - 1) / 2, (height - 1) / 2  # the first pixel's centre is 0
    k = np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1]])
    rows = "\n".join(" ".join("%g" % v for v in row) for row in k) + "\n"
    (out / "K.txt").write_text(rows)
    np.save(out / "K.npy", k)
    (out / "K.json").write_text(json.dumps(k.tolist()) + "\n")
    (out / "open3d.json").write_text(json.dumps(
        {"width": width, "height": height, "intrinsic_matrix": k.T.ravel().tolist()}, indent=1) + "\n")
    (out / "realsense.json").write_text(json.dumps(
        {"width": width, "height": height, "ppx": cx, "ppy": cy, "fx": focal, "fy": focal,
         "model": "distortion.none", "coeffs": [0, 0, 0, 0, 0]}, indent=1) + "\n")
    (out / "camera_info.yaml").write_text(camera_info("rgb", width, height, 0))
    (out / "cameras.txt").write_text(
        "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        "1 PINHOLE %d %d %g %g %g %g\n" % (width, height, focal, focal, cx + 0.5, cy + 0.5))
    (out / "foundation.txt").write_text(" ".join("%g" % v for v in k.ravel()) + "\n%g\n" % BASELINE_M)
    (out / "focal.yaml").write_text("focal_px: %g\n" % focal)


def make_inputs(samples, out):
    left, right = (shrink(Image.open(samples / name).convert("RGB")) for name in ("left.png", "right.png"))
    disparity = read_pfm(samples / "disparity.pfm")[::SHRINK, ::SHRINK] / SHRINK
    left.save(out / "left.png")
    right.save(out / "right.png")
    write_stereo(out, left, right)
    write_photographs(out, left, right)
    write_unrectified(out, left, right)
    write_depths(out, disparity, left)
    write_laser(out, disparity)
    write_maps(out, disparity, FOCAL_PX / SHRINK * BASELINE_M / disparity)
    write_rigs(out, left.width, left.height)
    write_cameras(out, left.width, left.height)


def heic_pictures(path):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["heif-convert", path, Path(folder) / "picture.png"], check=True, stdout=subprocess.DEVNULL)
        return [np.asarray(Image.open(file), float) for file in sorted(Path(folder).iterdir())]


def same(a, b):
    """Bytes, but of pictures and archives what they hold: other versions of the libraries compress otherwise."""
    if a.suffix == ".heic":
        a, b = (heic_pictures(file) for file in (a, b))
        return len(a) == len(b) and all(np.abs(x - y).max() <= 2 for x, y in zip(a, b))
    if a.suffix in (".png", ".jpg", ".jps", ".mpo", ".tif", ".bmp"):
        a, b = (np.asarray(Image.open(file), float) for file in (a, b))
        return a.shape == b.shape and np.abs(a - b).max() <= 2
    if a.suffix == ".npz":
        a, b = np.load(a), np.load(b)
        return a.files == b.files and all(np.array_equal(a[name], b[name]) for name in a.files)
    return a.read_bytes() == b.read_bytes()


def check_inputs(samples, out):
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder)
        make_inputs(samples, made)
        names = {file.name for file in made.iterdir()}
        wrong = names ^ {file.name for file in out.iterdir() if file.is_file() and file.suffix not in (".md", ".py")}
        wrong |= {name for name in names - wrong if not same(made / name, out / name)}
    if wrong:
        sys.exit("make_inputs.py would write otherwise: " + ", ".join(sorted(wrong)))


def main():
    check = sys.argv[1:2] == ["--check"]
    folders = [Path(folder) for folder in sys.argv[1 + check:]]
    if len(folders) != 2:
        sys.exit(__doc__)
    if check:
        return check_inputs(*folders)
    folders[1].mkdir(parents=True, exist_ok=True)
    make_inputs(*folders)


if __name__ == "__main__":
    main()
