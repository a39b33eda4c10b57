#!/usr/bin/env python3
"""RAFT-Stereo (https://github.com/princeton-vl/RAFT-Stereo). Not run by this project.

python3 raft_stereo.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is raftstereo-middlebury.pth or another with the same architecture. Code and weights: MIT.
"""
import sys
from argparse import Namespace

from matching import serve_torch


def load(repository, weights):
    sys.path[:0] = [f"{repository}/core", repository]
    import torch
    from raft_stereo import RAFTStereo

    model = RAFTStereo(Namespace(
        hidden_dims=[128] * 3, corr_implementation="reg", shared_backbone=False, corr_levels=4, corr_radius=4,
        n_downsample=2, slow_fast_gru=False, n_gru_layers=3, mixed_precision=False))
    state = torch.load(weights, map_location="cpu")
    model.load_state_dict({name.removeprefix("module."): value for name, value in state.items()})
    model.to("cuda" if torch.cuda.is_available() else "cpu").eval()

    def network(left, right, _):
        return -model(left, right, iters=32, test_mode=True)[1]  # a flow to the left
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
