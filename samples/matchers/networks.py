#!/usr/bin/env python3
"""Adapters for published networks, written by their repositories' own examples. None was run by this project.

python3 networks.py NETWORK REPOSITORY WEIGHTS [{left} {right} {out} {ndisp} [{confidence}]]
NETWORK is the name of a function here, which says what WEIGHTS is and what the code's and the weights' licence is;
REPOSITORY is a clone of the network's.
"""
import sys
from argparse import Namespace
from pathlib import Path

from matching import serve_torch


def fast_foundation_stereo(torch, repository, weights):
    """https://github.com/NVlabs/Fast-FoundationStereo: model_best_bp2_serialize.pth, a whole pickled model: load it only if you
    trust it. NVIDIA Open Model Agreement for weights on Hugging Face, else the repository's licence. Disparities up to 192 px."""
    sys.path.insert(0, repository)
    model = torch.load(weights, map_location="cpu", weights_only=False).cuda().eval()
    model.args.max_disp = 192

    def network(left, right, _):
        with torch.amp.autocast("cuda", dtype=torch.float16):
            return model.forward(left, right, iters=8, test_mode=True, optimize_build_volume="pytorch1")
    return network


def foundation_stereo(torch, repository, weights):
    """https://github.com/NVlabs/FoundationStereo: model_best_bp2.pth with cfg.yaml beside it. NVIDIA, not commercial."""
    sys.path.insert(0, repository)
    from core.foundation_stereo import FoundationStereo
    from omegaconf import OmegaConf

    config = OmegaConf.load(Path(weights).parent / "cfg.yaml")
    config.setdefault("vit_size", "vitl")
    model = FoundationStereo(config)
    model.load_state_dict(torch.load(weights, weights_only=False)["model"])
    model.cuda().eval()

    def network(left, right, _):
        with torch.cuda.amp.autocast(True):
            return model.forward(left, right, iters=32, test_mode=True)
    return network


def load_sceneflow(torch, kind, weights, **options):
    """Of RAFT-Stereo and IGEV-Stereo, which have their architecture's options alike."""
    model = kind(Namespace(hidden_dims=[128] * 3, corr_implementation="reg", shared_backbone=False, corr_radius=4,
                           n_downsample=2, slow_fast_gru=False, n_gru_layers=3, mixed_precision=False, **options))
    state = torch.load(weights, map_location="cpu")
    model.load_state_dict({name.removeprefix("module."): value for name, value in state.items()})
    return model.to("cuda" if torch.cuda.is_available() else "cpu").eval()


def igev(torch, repository, weights):
    """https://github.com/gangweiX/IGEV: sceneflow.pth or middlebury.pth of IGEV-Stereo. MIT. Disparities up to 192 px."""
    sys.path[:0] = [f"{repository}/IGEV-Stereo", f"{repository}/IGEV-Stereo/core"]
    from igev_stereo import IGEVStereo

    model = load_sceneflow(torch, IGEVStereo, weights, corr_levels=2, max_disp=192)
    return lambda left, right, _: model(left, right, iters=32, test_mode=True)


def raft_stereo(torch, repository, weights):
    """https://github.com/princeton-vl/RAFT-Stereo: raftstereo-middlebury.pth or another of the same architecture. MIT."""
    sys.path[:0] = [f"{repository}/core", repository]
    from raft_stereo import RAFTStereo

    model = load_sceneflow(torch, RAFTStereo, weights, corr_levels=4)
    return lambda left, right, _: -model(left, right, iters=32, test_mode=True)[1]  # a flow to the left


def lite_any_stereo(torch, repository, weights):
    """https://github.com/TomTomTommi/LiteAnyStereo, V2: LAS2_M.pth; the letter before the dot is the model's size. MIT. Its
    export_onnx.py makes a file for disparity.model. Disparities up to 192 px."""
    sys.path.insert(0, repository)
    from core.models import build_model, load_model_weights

    model = build_model("las2", model_size=Path(weights).stem[-1].lower(), max_disp=192)
    load_model_weights(model, torch.load(weights, map_location="cpu"), strict=True)
    model.to("cuda" if torch.cuda.is_available() else "cpu").eval()
    return lambda left, right, _: model(left, right, max_disp=192, test_mode=True)


def s2m2(torch, repository, weights):
    """https://github.com/junhong-3dv/s2m2, with confidences: the folder of CH384NTR3.pth and the like. CC-BY-NC-4.0."""
    sys.path.insert(0, f"{repository}/src")
    from s2m2.core.utils.model_utils import load_model

    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    model = load_model(weights, "XL", True, 3, device).to(device).eval()  # True: no disparities below 0

    def network(left, right, _):
        with torch.amp.autocast(enabled=device.type == "cuda", device_type=device.type, dtype=torch.float16):
            disparities, visible, confidence = model(left, right)
        return disparities, visible * confidence
    return network


def unimatch(torch, repository, weights):
    """https://github.com/autonomousvision/unimatch, GMStereo: gmstereo-scale2-regrefine3-*.pth. MIT."""
    sys.path.insert(0, repository)
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


def main():
    import torch

    name, repository, weights, *words = sys.argv[1:]
    serve_torch(globals()[name](torch, repository, weights), words)


if __name__ == "__main__":
    main()
