#!/usr/bin/env python3
"""Fast-FoundationStereo (https://github.com/NVlabs/Fast-FoundationStereo). Not run by this project.

python3 fast_foundation_stereo.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is model_best_bp2_serialize.pth, a whole pickled model: load it only if you trust it. Weights: NVIDIA Open Model
Agreement for those on Hugging Face; see the repository's licence for the others. It finds disparities of up to 192 px.
"""
import sys

from matching import serve_torch


def load(repository, weights):
    sys.path.insert(0, repository)
    import torch

    model = torch.load(weights, map_location="cpu", weights_only=False).cuda().eval()
    model.args.max_disp = 192

    def network(left, right, _):
        with torch.amp.autocast("cuda", dtype=torch.float16):
            return model.forward(left, right, iters=8, test_mode=True, optimize_build_volume="pytorch1")
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
