"""Scenes and stacks of shadow maps."""

from __future__ import annotations

import os
from collections.abc import Sequence

from . import _msm


def load_scene(name: str | os.PathLike[str]) -> _msm.Scene:
    """A procedural scene (``stairs``, ``village``, ``grove``, ``hall``), or a .glb, .gltf or .obj file."""
    return _msm.load_scene(os.fspath(name))


def render_stack(
    scene: _msm.Scene | str | os.PathLike[str],
    view: str | Sequence[float] | None = None,
    size: int | tuple[int, int] = 1024,
    backend: str = "cpu",
) -> _msm.Stack:
    """Every surface that the light rays of a view cross, in order and without a limit on layers.

    ``view`` is a name, or the direction (x, y, z) in which the light travels; without it the scene's first. ``size`` is a side in
    texels or (width, height). Texel t, row by row, owns the fragments ``offsets[t]`` to ``offsets[t + 1]``; arrays of the result
    are those of the rendering itself, not copies.
    """
    if not isinstance(scene, _msm.Scene):
        scene = load_scene(scene)
    sides = (size, size) if isinstance(size, int) else tuple(size)
    if len(sides) != 2 or any(not 0 < side < 2**32 for side in sides):
        raise ValueError(f"size {size!r}: a side or (width, height) in texels is needed")
    if view is None or isinstance(view, str):
        return _msm.render_stack(scene, view, None, sides, backend)
    direction = tuple(float(value) for value in view)
    if len(direction) != 3:
        raise ValueError(f"view {view!r}: a name or a direction (x, y, z) is needed")
    return _msm.render_stack(scene, None, direction, sides, backend)
