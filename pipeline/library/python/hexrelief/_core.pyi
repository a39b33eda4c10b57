from typing import Any, Callable, Optional

import numpy as np
from numpy.typing import NDArray

Progress = Optional[Callable[[str, float], Any]]

version: str

class Error(RuntimeError):
    kind: str
    exit_code: int

class Camera:
    def __init__(
        self, file: str, focal_px: float, baseline_m: float, cx: float, cy: float, doffs_px: float
    ) -> None: ...

class Mesh:
    def vertices(self) -> NDArray[np.float32]: ...
    def faces(self) -> NDArray[np.uint32]: ...
    def uv(self) -> NDArray[np.float32]: ...
    def lattice(self) -> NDArray[np.float32]: ...
    def disparity(self) -> NDArray[np.float32]: ...
    def is_metric(self) -> bool: ...
    def report(self) -> str: ...
    def save(
        self, path: str, settings: list[tuple[str, str]], warn: Callable[[str], Any], progress: Progress
    ) -> list[str]: ...

def compute_disparity(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    camera: Camera,
    config: list[str],
    settings: list[tuple[str, str]],
    warn: Callable[[str], Any],
    progress: Progress,
) -> NDArray[np.float32]: ...
def mesh(
    arrays: dict[str, Optional[NDArray[Any]]],
    camera: Camera,
    config: list[str],
    settings: list[tuple[str, str]],
    warn: Callable[[str], Any],
    progress: Progress,
) -> Mesh: ...
def key_of(flag: str) -> str: ...
def from_device(address: int, bytes: int) -> NDArray[np.uint8]: ...
def read_picture(path: str) -> NDArray[np.uint8]: ...
def read_disparity(path: str, settings: list[tuple[str, str]]) -> NDArray[np.float32]: ...
def evaluate(
    disparity: NDArray[np.float32],
    truth: NDArray[np.float32],
    right_truth: Optional[NDArray[np.float32]],
    discontinuity_px: float,
) -> str: ...
def measure_surface(
    points: NDArray[np.float32],
    faces: NDArray[np.uint32],
    truth: NDArray[np.float32],
    config: list[str],
    settings: list[tuple[str, str]],
) -> str: ...
