"""What all matchers here share: how hexrelief asks them, and how torch's networks are given pictures.

Needs python3-numpy and python3-opencv.
"""
import json
import sys

import cv2
import numpy


def read_picture(name):
    """Returns the picture as height x width x 3 bytes, red green blue."""
    picture = cv2.imread(name, cv2.IMREAD_COLOR)
    if picture is None:
        raise ValueError(f"cannot read {name}")
    return cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)


def write_pfm(name, values):
    values = numpy.asarray(values, "<f4")
    with open(name, "wb") as file:
        file.write(b"Pf\n%d %d\n-1\n" % values.shape[::-1])
        file.write(values[::-1].tobytes())


def serve(match, words):
    """Matches a pair, LEFT RIGHT OUT NDISP [CONFIDENCE], or without words pair after pair, asked by lines of JSON.

    match(left, right, ndisp) returns the left view's disparities in px, infinite where they are not known, or these and
    confidences from 0 to 1.
    """
    def answer(left, right, out, ndisp, confidence=None):
        maps = match(read_picture(left), read_picture(right), int(ndisp))
        disparities, sure = maps if isinstance(maps, tuple) else (maps, None)
        write_pfm(out, disparities)
        if sure is not None and confidence:
            write_pfm(confidence, sure)

    if words:
        answer(*words)
        return
    answers, sys.stdout = sys.stdout, sys.stderr  # what a network prints is for people
    for line in sys.stdin:
        try:
            answer(**json.loads(line))
            result = {"ok": True}
        except Exception as error:  # whatever it is, the next pair may be matched
            result = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(result), file=answers, flush=True)


def serve_torch(network, words, multiple=32):
    """As serve(), for a network of torch. network(left, right, ndisp) takes two tensors of 1 x 3 x height x width on its
    device, levels 0 to 255, sides padded to the multiple; it returns one map or, as a list, a map and confidences.
    """
    import torch
    import torch.nn.functional

    device = "cuda" if torch.cuda.is_available() else "cpu"

    def match(left, right, ndisp):
        height, width = left.shape[:2]
        padding = (0, -width % multiple, 0, -height % multiple)
        tensors = [torch.nn.functional.pad(torch.from_numpy(picture).permute(2, 0, 1)[None].float().to(device), padding,
                                           mode="replicate") for picture in (left, right)]
        with torch.no_grad():
            maps = network(*tensors, ndisp)
        maps = maps if isinstance(maps, (list, tuple)) else [maps]
        arrays = [value.squeeze()[:height, :width].float().cpu().numpy() for value in maps]
        return arrays[0] if len(arrays) == 1 else (arrays[0], arrays[1])

    serve(match, words)
