#!/usr/bin/env python3
"""Matches a rectified pair by OpenCV's QuasiDenseStereo, which grows matches from points that both pictures show.

Once a view, by disparity.command:  python3 quasi_dense.py {left} {right} {out} {ndisp}
Pair after pair, by disparity.worker: python3 quasi_dense.py

Needs python3-opencv with its contributed modules (Apache-2.0).
"""
import sys

import cv2
import numpy

from matching import serve


def match(left, right, ndisp):
    matcher = cv2.stereo.QuasiDenseStereo_create(left.shape[1::-1])
    matcher.process(left, right)
    disparity = matcher.getDisparity()
    disparity[~((disparity > 0) & (disparity <= ndisp))] = numpy.inf
    return disparity


if __name__ == "__main__":
    serve(match, sys.argv[1:])
