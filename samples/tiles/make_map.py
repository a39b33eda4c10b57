#!/usr/bin/env python3
"""make_map.py WIDTHxHEIGHT MAP.pfm [SEED]: a made-up disparity map of any size to try tiles with, written row by row.

Hills (value noise of nine octaves), cliffs along curved lines, buildings with flat roofs and straight walls of any direction,
lakes and single pixels without a disparity; 20 to 256 px. The same size and seed make the same bytes.
"""

import functools
import sys

import numpy

PLOT_px = 96  # a plot has one building or none
CLIFF_OCTAVE, LAKE_OCTAVE, PLOTS, SINGLES = range(9, 13)  # after the hills' octaves; seeds of what is drawn


def ramp(cell):
    t = numpy.arange(cell, dtype=numpy.float32) / numpy.float32(cell)
    return t * t * (3 - 2 * t)


@functools.lru_cache(maxsize=64)
def corners(seed, octave, row, columns):
    return numpy.random.default_rng([seed, octave, row]).random(columns, dtype=numpy.float32)


def noise(seed, octave, cell, y, width):
    """Returns a row of value noise of 0 to 1 between the corners of square cells."""
    columns = width // cell + 2
    above, below = (corners(seed, octave, y // cell + k, columns) for k in (0, 1))
    edges = above + (below - above) * ramp(cell)[y % cell]
    return (edges[:-1, None] + numpy.diff(edges)[:, None] * ramp(cell)).ravel()[:width]


@functools.lru_cache(maxsize=2)
def ground(seed, y, width):
    """Returns a row without buildings and lakes."""
    row = 20 + sum(80 / 2**k * noise(seed, k, 2048 >> k, y, width) for k in range(9))
    return row + numpy.float32(25) * (noise(seed, CLIFF_OCTAVE, 640, y, width) > 0.55)


@functools.lru_cache(maxsize=2)
def buildings(seed, plot_row, width):
    """Returns (cosine, sine, half width, half height, roof) of a row of plots, a column each; roof 0 is no building."""
    plots = width // PLOT_px + 1
    draw = numpy.random.default_rng([seed, PLOTS, plot_row])
    turn = numpy.array([(1, 0), (0.8, 0.6), (0.6, 0.8), (12 / 13, 5 / 13)], numpy.float32)[draw.integers(0, 4, plots)].T
    centre = numpy.minimum(numpy.arange(plots) * PLOT_px + PLOT_px // 2, width - 1)
    height = ground(seed, plot_row * PLOT_px + PLOT_px // 2, width)[centre] + draw.integers(12, 52, plots)
    roof = numpy.where(draw.random(plots) < 1 / 3, height, 0)
    return *turn, draw.integers(10, 34, plots), draw.integers(10, 28, plots), roof


def row_of(seed, y, width):
    cosine, sine, half_width, half_height, roof = (
        numpy.repeat(values, PLOT_px)[:width] for values in buildings(seed, y // PLOT_px, width)
    )
    u, v = numpy.arange(width) % PLOT_px - PLOT_px // 2, y % PLOT_px - PLOT_px // 2
    is_roof = (roof > 0) & (abs(cosine * u + sine * v) <= half_width) & (abs(cosine * v - sine * u) <= half_height)
    row = numpy.where(is_roof, roof, ground(seed, y, width))
    singles = numpy.random.default_rng([seed, SINGLES, y]).random(width) < 1 / 4096
    row[singles | (noise(seed, LAKE_OCTAVE, 1024, y, width) > 0.85)] = numpy.inf
    return row.astype("<f4")


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    width, height = map(int, sys.argv[1].split("x"))
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    with open(sys.argv[2], "wb") as file:
        file.write(f"Pf\n{width} {height}\n-1.0\n".encode())
        for y in reversed(range(height)):
            file.write(row_of(seed, y, width).tobytes())


if __name__ == "__main__":
    main()
