"""Figures that others published of MiddEval3's training set at quarter size, which match.py prints beside its own.

In % of the pixels: more than 1 and 2 px off, of those that the right camera sees too (nonocc.) and of all.
"""
import typing


class PublicFigures(typing.NamedTuple):
    method: str
    scenes: str
    bad_1_nonoccluded: typing.Optional[float]
    bad_1: typing.Optional[float]
    bad_2_nonoccluded: typing.Optional[float]
    bad_2: typing.Optional[float]
    source: str


FORMER_STEREO = "FormerStereo's README (ECCV 2024), reproduced results"

# Networks were trained on made-up scenes (SceneFlow) alone, so none has seen these.
QUARTER_SIZE = [
    PublicFigures(*row)
    for row in (
        ("SGM", "Piano", 13.03, None, None, None, "the evaluation's reference map against the quarter-size truth"),
        ("FormerPSMNet-DAM-L", "all 15", None, None, 5.73, None, FORMER_STEREO),
        ("FormerRAFT-DAM-L", "all 15", None, None, 5.60, None, FORMER_STEREO),
        ("FormerGwcNet-DINOv2-L", "all 15", None, None, 4.86, None, FORMER_STEREO),
    )
]


def add_public(table_of, rows):
    """Prints them below this program's rows of the same set. table_of: common.Table."""
    table = table_of("method <24, scenes <10, 1 nonocc. >9.2f, bad-1 % >8.2f, 2 nonocc. >9.2f, bad-2 % >8.2f, published <60")
    for row in rows:
        figures = (row[f"bad_{t}_{which}percent"] for t in (1, 2) for which in ("nonoccluded_", ""))
        table.add((f"hexrelief, {row['method']}", row["scene"], *figures, f"here, {row['backend']}"), row)
    for public in QUARTER_SIZE:
        table.add(public, public._asdict())
    return [public._asdict() for public in QUARTER_SIZE]
