"""The command line's messages in Python's words: keys and arguments in place of options."""

import re

from . import _core

_ARGUMENTS = {
    "--left": "left",
    "--right": "right",
    "--disparity": "disparity",
    "--depth": "depth",
    "--color": "color",
    "--mask": "mask",
    "--confidence": "confidence",
    "--calib": "camera",
    "--backend": "backend",
}


def in_python(text: str) -> str:
    """"give --depth-unit mm (input.depth.unit)" to "give input.depth.unit mm": what Python has no word for stays."""
    text = text.replace("--set ", "")
    text = re.sub(r"--[a-z]+(?:-[a-z]+)*", lambda flag: _ARGUMENTS.get(flag[0]) or _core.key_of(flag[0]) or flag[0], text)
    return re.sub(r"([a-z_]+\.[a-z_.]+)( [^ ()]+)? \(\1\)", r"\1\2", text)
