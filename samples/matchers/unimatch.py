#!/usr/bin/env python3
"""UniMatch's GMStereo (https://github.com/autonomousvision/unimatch). Not run by this project.

python3 unimatch.py REPOSITORY WEIGHTS [{left} {right} {out} {ndisp}]
WEIGHTS is gmstereo-scale2-regrefine3-*.pth. Code and weights: MIT.
"""
import sys

from matching import serve_torch


def load(repository, weights):
    sys.path.insert(0, repository)
    import torch
    from unimatch.unimatch import UniMatch

    device = "cuda" if torch.cuda.is_available() else "cpu"
    model = UniMatch(feature_channels=128, num_scales=2, upsample_factor=4, num_head=1, ffn_dim_expansion=4,
                     num_transformer_layers=6, reg_refine=True, task="stereo").to(device)
    model.load_state_dict(torch.load(weights, map_location=device)["model"])
    model.eval()
    mean, std = (torch.tensor(values, device=device).view(1, 3, 1, 1)
                 for values in ([0.485, 0.456, 0.406], [0.229, 0.224, 0.225]))

    def network(left, right, _):
        left, right = ((picture / 255 - mean) / std for picture in (left, right))
        return model(left, right, attn_type="self_swin2d_cross_swin1d", attn_splits_list=[2, 8], corr_radius_list=[-1, 4],
                     prop_radius_list=[-1, 1], num_reg_refine=3, task="stereo")["flow_preds"][-1]
    return network


if __name__ == "__main__":
    serve_torch(load(*sys.argv[1:3]), sys.argv[3:])
