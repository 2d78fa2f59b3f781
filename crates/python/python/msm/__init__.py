"""Sharp bounds of shadow intensities from filtered moments, filterable shadow maps, and their errors on scenes.

Depths are fractions of the depth range, 0 at the light and 1 at the far plane. Shadow intensities are fractions of a
kernel's weight, 0 lit and 1 in shadow. Input that makes no sense raises ``ValueError`` or ``TypeError`` with the line that
the command ``msm`` would print; work that failed raises ``RuntimeError``. Other Python threads run while Rust computes.
"""

from __future__ import annotations

from . import _msm
from ._closed_forms import hamburger2, hamburger4, hamburger6, hamburger8, hausdorff4, trigonometric4
from ._experiments import advise, error, read_run
from ._msm import Bounds, Scene, Stack, __version__
from ._problem import Quantization, bounds, certified, quantize
from ._scenes import load_scene, render_stack
from ._technique import Technique

__all__ = [
    "Bounds",
    "Quantization",
    "Scene",
    "Stack",
    "Technique",
    "advise",
    "bounds",
    "certified",
    "error",
    "hamburger2",
    "hamburger4",
    "hamburger6",
    "hamburger8",
    "hausdorff4",
    "load_scene",
    "quantize",
    "read_run",
    "render_stack",
    "trigonometric4",
]
