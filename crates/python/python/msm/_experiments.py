"""Advice, errors of techniques on a scene, and recorded runs."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _msm
from ._technique import Technique

Table = dict[str, NDArray[Any]]


def _column(texts: list[str]) -> NDArray[Any]:
    """Whole numbers, floats with NaN for what is empty, truths, or texts."""
    filled = [text for text in texts if text]
    if filled and all(text in ("true", "false") for text in filled) and len(filled) == len(texts):
        return np.array([text == "true" for text in texts])
    for kind in (int, float):
        try:
            values = [kind(text) for text in filled]
        except ValueError:
            continue
        if kind is int and len(filled) == len(texts):
            return np.array(values, dtype=np.int64)
        if kind is float and filled:
            return np.array([float(text) if text else np.nan for text in texts])
    return np.array(texts, dtype=np.str_)


def _table(text: str) -> Table:
    rows = list(csv.reader(io.StringIO(text)))
    if not rows:
        return {}
    return {name: _column([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])}


def read_run(directory: str | os.PathLike[str]) -> dict[str, Any]:
    """A recorded run: each ``NAME.csv`` as ``run["NAME"]``, a column an array, and ``run["provenance"]``.

    ``pandas.DataFrame(run["records"])`` is a data frame.
    """
    run: dict[str, Any] = {}
    for name, text in _msm.run_files(os.fspath(directory)):
        if name == "provenance.json":
            run["provenance"] = json.loads(text)
        else:
            run[name.removesuffix(".csv")] = _table(text)
    return run


def advise(
    scene: str | os.PathLike[str],
    *,
    tolerance: float | None = None,
    relative: float = 0.5,
    views: Sequence[str] = (),
    light: str | None = None,
    size: int | None = None,
    seed: int | None = None,
    candidates: str | os.PathLike[str] | None = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """The cheapest filterable shadow map that is good enough for a scene: the object that ``msm advise --format json`` prints.

    ``views`` are names or directions ``x,y,z``, ``light`` is ``--light`` of the command line (``sun:2``); ``tolerance`` is the
    largest mean distance from percentage-closer filtering that is accepted, without it what suits the scene.
    """
    text = _msm.advise(
        os.fspath(scene),
        list(views),
        light,
        None if tolerance is None else float(tolerance),
        float(relative),
        size,
        seed,
        None if candidates is None else os.fspath(candidates),
        threads,
    )
    return json.loads(text)


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(inner) for inner in value) + "]"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, str):
        # Escapes of JSON are escapes of TOML.
        return json.dumps(value)
    raise TypeError(f"{value!r} is neither number nor text")


def error(
    scene: str | os.PathLike[str],
    techniques: Mapping[str, Technique | Mapping[str, Any]],
    *,
    views: Sequence[str] = (),
    size: int = 512,
    fragments: int = 20000,
    reference_bias: tuple[float, float] = (1.0, 0.0),
    technique_bias: tuple[float, float] = (1.0, 2.0),
    seed: int = 1,
    threads: int | None = None,
) -> Table:
    """Distances of techniques from percentage-closer filtering on a scene, as ``msm run`` of kind ``filterable`` records them.

    ``techniques`` maps names to :class:`Technique` or its keys, of those of storage ``format`` and ``alpha`` alone. The reference is a Gaussian of 9 x 9 texels with the receiver's
    plane; biases are texel depths and slopes. ``fragments`` is the sample of each view, 0 for all. Columns ``scene``, ``view``,
    ``technique``, ``class``, ``l1_error``, ``standard_error``, ``leak`` and so on; rows of view ``all`` pool the views.
    """
    keys = {
        "kind": "filterable",
        "question": "How far are these techniques from percentage-closer filtering?",
        "expectation": "None.",
        "seed": seed,
        "size": size,
        "scenes": [os.fspath(scene) if os.sep not in os.fspath(scene) else os.path.abspath(scene)],
        "views": list(views),
        "fragments": fragments,
        "certified_fragments": min(fragments, 100) if fragments else 100,
        "kernel": {"shape": "gaussian", "size": 9, "sigma": 2.4},
        "plane_limit": 0.05,
        "surface_gap": 0.004,
        "timing": {"repetitions": 1},
    }
    text = "".join(f"{key} = {_toml(value)}\n" for key, value in keys.items())
    biases = {"reference": reference_bias, "technique": technique_bias}
    text += "[[bias]]\n"
    for name, (texels, slopes) in biases.items():
        text += f"{name} = {_toml({'texels': float(texels), 'slopes': float(slopes)})}\n"
    for name, technique in techniques.items():
        method = technique.keys if isinstance(technique, Technique) else technique
        text += f"[[technique]]\nname = {_toml(name)}\nmethod = {_toml(method)}\n"
    with tempfile.TemporaryDirectory(prefix="msm-") as folder:
        return _table(_msm.error(text, folder, threads))
