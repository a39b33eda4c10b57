#!/usr/bin/env python3
"""Matches a rectified pair by OpenCV's StereoSGBM.

Once a view, by disparity.command:  python3 sgbm.py {left} {right} {out} {ndisp}
Pair after pair, by disparity.worker: python3 sgbm.py

Needs python3-opencv (Apache-2.0).
"""
import sys

import cv2
import numpy

from matching import serve


def match(left, right, ndisp):
    ndisp = (ndisp + 15) // 16 * 16
    # Left of the picture there is room for the matches of its left band.
    pictures = [cv2.copyMakeBorder(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), 0, 0, ndisp, 0, cv2.BORDER_REPLICATE)
                for picture in (left, right)]
    matcher = cv2.StereoSGBM_create(0, ndisp, 3, P1=72, P2=288, uniquenessRatio=5, mode=cv2.STEREO_SGBM_MODE_HH)
    disparity = matcher.compute(*pictures)[:, ndisp:].astype(numpy.float32) / 16
    disparity[disparity < 0] = numpy.inf
    return disparity


if __name__ == "__main__":
    serve(match, sys.argv[1:])
