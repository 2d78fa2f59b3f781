"""What is compiled; arrays here are flat and contiguous. Use the functions of ``msm``."""

from typing import final

import numpy as np
from numpy.typing import NDArray

__version__: str

@final
class Bounds:
    lower: float
    """Least possible mass strictly before z_f."""
    upper: float
    """Largest possible mass up to and including z_f."""
    lower_proved: float
    """Proved: no distribution has less mass strictly before z_f."""
    upper_proved: float
    """Proved: none has more mass up to and including z_f."""
    support: list[float]
    """Depths of a distribution that attains the lower bound."""
    weights: list[float]
    """Its weights."""
    solver: str
    """What computed it."""
    worst_slack: float
    """Largest proved excess of a dual function over its step."""

@final
class Scene:
    @property
    def name(self) -> str: ...
    @property
    def views(self) -> list[tuple[str, list[float]]]:
        """Names with the directions in which the lights travel."""
    @property
    def warnings(self) -> list[str]: ...
    @property
    def positions(self) -> NDArray[np.float32]:
        """World positions of corners, shape (n, 3)."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Corners of triangles, shape (n, 3)."""

@final
class Stack:
    width: int
    height: int
    offsets: NDArray[np.uint32]
    """First fragment of each texel, row by row, and the number of fragments: shape (width height + 1,)."""
    depths: NDArray[np.float32]
    """In [0, 1], ascending within a texel: shape (fragments,)."""
    gradients: NDArray[np.float32]
    """Change of depth from texel to texel along x and y: shape (fragments, 2)."""
    light_facing: NDArray[np.bool_]
    """Whether the front side points to the light: shape (fragments,)."""

@final
class Technique:
    def __init__(self, keys: str) -> None: ...
    name: str
    channels: int
    bits_per_texel: int
    is_lower_bound: bool
    def encode_single(self, depths: NDArray[np.float32]) -> NDArray[np.float32]: ...
    def encode_double(self, depths: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def filter_single(
        self, depths: NDArray[np.float32], size: tuple[int, int], kernel: tuple[int, float]
    ) -> NDArray[np.float32]: ...
    def filter_double(
        self, depths: NDArray[np.float32], size: tuple[int, int], kernel: tuple[int, float]
    ) -> NDArray[np.float64]: ...
    def shade_single(self, filtered: NDArray[np.float32], z_f: NDArray[np.float32]) -> NDArray[np.float32]: ...
    def shade_double(self, filtered: NDArray[np.float64], z_f: NDArray[np.float64]) -> NDArray[np.float64]: ...

@final
class Quantization:
    order: int
    gain_bits: float
    bound_bits: float
    range_min: float
    range_max: float
    depths: tuple[float, float]
    matrix: list[float]
    inverse: list[float]
    offset: list[float]

def order(name: str) -> int: ...
def basis_length(basis: str) -> int: ...
def closed_form_single(
    name: str, moments: NDArray[np.float32], z_f: NDArray[np.float32], alpha: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
def closed_form_double(
    name: str, moments: NDArray[np.float64], z_f: NDArray[np.float64], alpha: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def bounds(
    basis: str, values: list[float], weights: list[float] | None, z_f: float, interval: str, solver: str | None
) -> Bounds: ...
def certified(
    basis: str, moments: NDArray[np.float64], z_f: NDArray[np.float64], interval: str, solver: str | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def quantize(basis: str, signed: bool, parity: bool, starts: int | None, seed: int) -> Quantization: ...
def load_scene(name: str) -> Scene: ...
def render_stack(
    scene: Scene,
    view: str | None,
    direction: tuple[float, ...] | None,
    size: tuple[int, ...],
    backend_name: str,
) -> Stack: ...
def advise(
    scene: str,
    views: list[str],
    light: str | None,
    tolerance: float | None,
    relative: float,
    size: int | None,
    seed: int | None,
    candidates: str | None,
    threads: int | None,
) -> str: ...
def error(text: str, folder: str, threads: int | None) -> str: ...
def run_files(path: str) -> list[tuple[str, str]]: ...
