#!/usr/bin/env python3
"""FoundationStereo (https://github.com/NVlabs/FoundationStereo). Not run by this project.

python3 foundation_stereo.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is model_best_bp2.pth with cfg.yaml beside it. Code and weights: NVIDIA's licence, not for commercial use.
"""
import os
import sys

from matching import serve_torch


def load(repository, weights):
    sys.path.insert(0, repository)
    import torch
    from core.foundation_stereo import FoundationStereo
    from omegaconf import OmegaConf

    config = OmegaConf.load(os.path.join(os.path.dirname(weights), "cfg.yaml"))
    config.setdefault("vit_size", "vitl")
    model = FoundationStereo(config)
    model.load_state_dict(torch.load(weights, weights_only=False)["model"])
    model.cuda().eval()

    def network(left, right, _):
        with torch.cuda.amp.autocast(True):
            return model.forward(left, right, iters=32, test_mode=True)
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
