"""Spatial photographs, as phones and headsets write them. Needs Debian's libheif-examples."""
import struct
import subprocess
import tempfile
from pathlib import Path


def box(kind, content):
    return struct.pack(">I4s", 8 + len(content), kind) + content


def full_box(kind, flags, content):
    return box(kind, struct.pack(">I", flags) + content)


def boxes(content):
    """ISO/IEC 14496-12: a list of [kind, content]."""
    found = []
    while content:
        size, kind = struct.unpack(">I4s", content[:8])
        found.append([kind, content[8:size]])
        content = content[size:]
    return found


def moved(iloc, by):
    """The places of a file's items, version 1 with numbers of four bytes and one extent each, further behind."""
    out, count = bytearray(iloc), struct.unpack(">H", iloc[6:8])[0]
    for at in range(8, 8 + 20 * count, 20):
        _, method, _, _, _, offset = struct.unpack(">HHHIHI", iloc[at:at + 16])
        if method == 0:  # counted from the file's beginning
            out[at + 12:at + 16] = struct.pack(">I", offset + by)
    return bytes(out)


def write_spatial(path, left, right, views, focal_px, baseline_m):
    """A spatial photograph: heif-enc's file of two pictures, with a stereo pair group (ISO/IEC 23008-12) and the cameras.
    views: the numbers that heif-enc gives the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        names = [str(Path(folder) / name) for name in ("left.png", "right.png", "pair.heic")]
        left.save(names[0])
        right.save(names[1])
        subprocess.run(["heif-enc", "-q", "80", "-o", names[2], *names[:2]], check=True, stdout=subprocess.DEVNULL)
        head, meta, *rest = boxes(Path(names[2]).read_bytes())
    inside = dict(boxes(meta[1][4:]))
    properties = boxes(inside[b"iprp"])
    count = len(boxes(properties[0][1]))
    associations = properties[1][1]
    length = 0x10 << 8  # shares of the picture's sides are whole numbers of 1 / 2^16
    unit = 1 << 16
    for i, item in enumerate(views):
        numbers = (focal_px / left.width, 0.5, 0.5)
        properties[0][1] += full_box(b"cmin", length, struct.pack(">3i", *(round(unit * n) for n in numbers)))
        properties[0][1] += full_box(b"cmex", 1, struct.pack(">i", round(1e6 * baseline_m * i)))
        at = associations.index(struct.pack(">H", item), 8) + 2
        associations = (associations[:at] + bytes([associations[at] + 2]) + associations[at + 1:at + 1 + associations[at]]
                        + bytes([count + 2 * i + 1, count + 2 * i + 2]) + associations[at + 1 + associations[at]:])
    properties[1][1] = associations
    group = full_box(b"ster", 0, struct.pack(">4I", 99, 2, *views))
    before = len(meta[1])

    def with_places(by):
        inside[b"iprp"] = b"".join(box(*one) for one in properties)
        return b"".join(box(kind, moved(content, by) if kind == b"iloc" else content)
                        for kind, content in inside.items()) + box(b"grpl", group)

    meta[1] = meta[1][:4] + with_places(4 + len(with_places(0)) - before)
    path.write_bytes(b"".join(box(*one) for one in (head, meta, *rest)))
