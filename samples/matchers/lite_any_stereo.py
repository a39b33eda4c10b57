#!/usr/bin/env python3
"""LiteAnyStereo V2 (https://github.com/TomTomTommi/LiteAnyStereo). Not run by this project.

python3 lite_any_stereo.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is LAS2_M.pth; the letter before the dot is the model's size. Code and weights: MIT. Its export_onnx.py makes a file for
disparity.model. It finds disparities of up to 192 px.
"""
import sys
from pathlib import Path

from matching import serve_torch


def load(repository, weights):
    sys.path.insert(0, repository)
    import torch
    from core.models import build_model, load_model_weights

    model = build_model("las2", model_size=Path(weights).stem[-1].lower(), max_disp=192)
    load_model_weights(model, torch.load(weights, map_location="cpu"), strict=True)
    model.to("cuda" if torch.cuda.is_available() else "cpu").eval()

    def network(left, right, _):
        return model(left, right, max_disp=192, test_mode=True)
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
