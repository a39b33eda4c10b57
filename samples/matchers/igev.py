#!/usr/bin/env python3
"""IGEV-Stereo (https://github.com/gangweiX/IGEV). Not run by this project.

python3 igev.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is sceneflow.pth or middlebury.pth of IGEV-Stereo. Code and weights: MIT. It finds disparities of up to 192 px.
"""
import sys
from argparse import Namespace

from matching import serve_torch


def load(repository, weights):
    sys.path[:0] = [f"{repository}/IGEV-Stereo", f"{repository}/IGEV-Stereo/core"]
    import torch
    from igev_stereo import IGEVStereo

    model = IGEVStereo(Namespace(
        hidden_dims=[128] * 3, corr_implementation="reg", shared_backbone=False, corr_levels=2, corr_radius=4,
        n_downsample=2, slow_fast_gru=False, n_gru_layers=3, max_disp=192, mixed_precision=False))
    state = torch.load(weights, map_location="cpu")
    model.load_state_dict({name.removeprefix("module."): value for name, value in state.items()})
    model.to("cuda" if torch.cuda.is_available() else "cpu").eval()

    def network(left, right, _):
        return model(left, right, iters=32, test_mode=True)
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
