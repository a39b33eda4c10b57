#!/usr/bin/env python3
"""Matches a rectified pair by OpenCV's StereoSGBM, as an example of a program for `disparity.method: command`.

Once a view, by disparity.command:  python3 sgbm.py LEFT RIGHT OUT NDISP
Pair after pair, by disparity.worker: python3 sgbm.py

Needs python3-opencv and python3-numpy.
"""
import json
import sys

import cv2
import numpy


def match(left, right, out, ndisp):
    """Writes the left view's disparities in px as PFM; infinity is unknown."""
    pictures = [cv2.imread(name, cv2.IMREAD_GRAYSCALE) for name in (left, right)]
    if any(picture is None for picture in pictures):
        raise ValueError(f"cannot read {left} or {right}")
    ndisp = (int(ndisp) + 15) // 16 * 16
    # Left of the picture there is room for the matches of its left band.
    pictures = [cv2.copyMakeBorder(picture, 0, 0, ndisp, 0, cv2.BORDER_REPLICATE) for picture in pictures]
    matcher = cv2.StereoSGBM_create(0, ndisp, 3, P1=72, P2=288, uniquenessRatio=5, mode=cv2.STEREO_SGBM_MODE_HH)
    disparity = matcher.compute(*pictures)[:, ndisp:].astype(numpy.float32) / 16
    disparity[disparity < 0] = numpy.inf
    cv2.imwrite(out, disparity)


def main():
    if len(sys.argv) == 5:
        match(*sys.argv[1:])
        return
    for line in sys.stdin:
        request = json.loads(line)
        try:
            match(request["left"], request["right"], request["out"], request["ndisp"])
            answer = {"ok": True}
        except (ValueError, cv2.error) as error:
            answer = {"error": str(error)}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
