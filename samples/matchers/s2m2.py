#!/usr/bin/env python3
"""S2M2 (https://github.com/junhong-3dv/s2m2), which also tells what is hidden and how sure it is. Not run by this project.

python3 s2m2.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp} {confidence}]
WEIGHTS is the folder of CH384NTR3.pth and the like. Code and weights: CC-BY-NC-4.0, not for commercial use.
"""
import sys

from matching import serve_torch


def load(repository, weights):
    sys.path.insert(0, f"{repository}/src")
    import torch
    from s2m2.core.utils.model_utils import load_model

    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    model = load_model(weights, "XL", True, 3, device).to(device).eval()  # True: no disparities below 0

    def network(left, right, _):
        with torch.amp.autocast(enabled=device.type == "cuda", device_type=device.type, dtype=torch.float16):
            disparities, visible, confidence = model(left, right)
        return disparities, visible * confidence
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
