"""make_pairs.py FOLDER COUNT: tiny pairs of random dots, NAME_left.ppm and NAME_right.ppm, a square in front of a background."""
import random
import sys
from pathlib import Path

WIDTH, HEIGHT, BEHIND, IN_FRONT = 72, 54, 4, 9


def write(path, rows):
    samples = bytes(sample for row in rows for pixel in row for sample in pixel)
    path.write_bytes(b"P6 %d %d 255\n" % (WIDTH, HEIGHT) + samples)


def dots(draw, columns):
    return [tuple(draw.randrange(256) for _ in range(3)) for _ in range(columns)]


def pair(draw):
    left, right = [], []
    for y in range(HEIGHT):
        behind, front = dots(draw, WIDTH + BEHIND), dots(draw, WIDTH)
        square = range(24, 52) if 14 <= y < 42 else range(0)
        left.append([front[x] if x in square else behind[x] for x in range(WIDTH)])
        right.append([front[x + IN_FRONT] if x + IN_FRONT in square else behind[x + BEHIND] for x in range(WIDTH)])
    return left, right


folder, count = Path(sys.argv[1]), int(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
for number in range(count):
    for side, rows in zip(("left", "right"), pair(random.Random(number))):
        write(folder / f"p{number:03}_{side}.ppm", rows)
