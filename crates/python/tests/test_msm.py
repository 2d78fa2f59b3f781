"""The package on arrays: shapes, types, errors with the binary's words, and the binary's numbers to the last bit."""

from __future__ import annotations

import json
import os
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import msm

ROOT = Path(__file__).resolve().parents[3]
RUNS = ROOT / "results" / "speed-accuracy"

ATOMS = np.array([[0.2, 0.5], [0.45, 0.2], [0.7, 0.3]])


def binary() -> Path | None:
    """``MSM_BINARY``, or what ``cargo build --release`` has left."""
    given = os.environ.get("MSM_BINARY")
    path = Path(given) if given else ROOT / "target" / "release" / "msm"
    return path if path.is_file() else None


needs_binary = pytest.mark.skipif(binary() is None, reason="the command msm is not built")


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(binary()), *arguments], capture_output=True, text=True, check=False)


def power_moments(depths: np.ndarray, weights: np.ndarray, order: int) -> np.ndarray:
    return np.array([(weights * depths**k).sum() for k in range(1, order + 1)])


def kernels(count: int, order: int, dtype: type, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Moments of kernels of three random depths, and depths of fragments."""
    random = np.random.default_rng(seed)
    depths = random.random((count, 3))
    weights = random.dirichlet(np.ones(3), count)
    moments = np.stack([(weights * depths**k).sum(axis=1) for k in range(1, order + 1)], axis=-1)
    return moments.astype(dtype), random.random(count).astype(dtype)


@needs_binary
def test_bounds_are_those_of_the_binary_to_the_last_bit() -> None:
    atoms = ",".join(f"{depth}:{weight}" for depth, weight in ATOMS)
    for basis in ("power:4", "trig:2", "z, z^2, exp(4z), exp(-4z)"):
        answer = command("bound", "--basis", basis, "--atoms", atoms, "--depth", "0.6", "--format", "json")
        expected = json.loads(answer.stdout)
        found = msm.bounds(basis, ATOMS, 0.6)
        for name in ("lower", "upper", "lower_proved", "upper_proved", "support", "weights", "solver"):
            assert getattr(found, name) == expected[name], name


def test_bounds_hold() -> None:
    found = msm.bounds("power:4", ATOMS, 0.6)
    assert found.lower_proved <= 0.7 <= found.upper_proved
    lower, upper = msm.hausdorff4(power_moments(*ATOMS.T, 4), 0.6)
    assert abs(lower - found.lower) < 1e-9 and abs(upper - found.upper) < 1e-9


@needs_binary
@pytest.mark.parametrize(
    ("arguments", "call"),
    [
        (["--basis", "sinh(z)", "--moments", "0.5"], lambda: msm.bounds("sinh(z)", [0.5], 0.6)),
        (["--basis", "power:2", "--moments", "0.5,0.01"], lambda: msm.bounds("power:2", [0.5, 0.01], 0.6)),
        (["--basis", "power:4", "--moments", "0.5,0.3"], lambda: msm.bounds("power:4", [0.5, 0.3], 0.6)),
    ],
)
def test_errors_carry_the_words_of_the_binary(arguments: list[str], call: object) -> None:
    said = command("bound", *arguments, "--depth", "0.6").stderr
    with pytest.raises(ValueError) as raised:
        call()  # type: ignore[operator]
    words = str(raised.value)
    assert words and words.split(";")[0] in said, said


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", ["hamburger2", "hamburger4", "hamburger6", "hamburger8", "hausdorff4"])
def test_closed_forms_bound_their_kernels(name: str, dtype: type) -> None:
    order = int(name[-1])
    moments, z_f = kernels(1000, order, np.float64)
    lower, upper = getattr(msm, name)(moments.astype(dtype), z_f.astype(dtype), alpha=1e-3)
    assert lower.dtype == dtype and lower.shape == (1000,)
    assert np.all((lower >= 0) & (lower <= upper) & (upper <= 1))


def test_shapes_are_kept_and_broadcast() -> None:
    moments, _ = kernels(24, 4, np.float32)
    image = moments.reshape(4, 6, 4)
    lower, upper = msm.hamburger4(image, 0.5)
    assert lower.shape == upper.shape == (4, 6)
    rows = msm.hamburger4(image, np.full(6, 0.5, np.float32))[0]
    assert np.array_equal(lower, rows)
    assert msm.hamburger4(image[0, 0], 0.5)[0].shape == ()
    assert msm.hamburger4(np.zeros((0, 4)), np.zeros(0))[0].shape == (0,)


def test_arrays_need_not_be_contiguous() -> None:
    moments, z_f = kernels(64, 4, np.float64)
    expected = msm.hamburger4(moments, z_f)[0]
    wide = np.zeros((64, 8))
    wide[:, ::2] = moments
    assert np.array_equal(msm.hamburger4(wide[:, ::2], z_f)[0], expected)
    assert np.array_equal(msm.hamburger4(np.asfortranarray(moments), z_f)[0], expected)
    assert np.array_equal(msm.hamburger4(moments[::-1], z_f[::-1])[0], expected[::-1])
    frozen = moments.copy()
    frozen.flags.writeable = False
    assert np.array_equal(msm.hamburger4(frozen, z_f)[0], expected)


def test_wrong_shapes_and_types_are_named() -> None:
    moments, z_f = kernels(8, 4, np.float32)
    with pytest.raises(ValueError, match=r"moments has shape \(8, 3\); the last axis must hold 4"):
        msm.hamburger4(moments[:, :3], z_f)
    with pytest.raises(ValueError, match=r"z_f has shape \(5,\), which does not fit \(8,\)"):
        msm.hamburger4(moments, z_f[:5])
    with pytest.raises(TypeError, match="moments has dtype float16"):
        msm.hamburger4(moments.astype(np.float16), z_f)
    with pytest.raises(TypeError, match="moments has dtype complex128"):
        msm.hamburger4(moments.astype(complex), z_f)
    with pytest.raises(TypeError, match="z_f has dtype float64, float32 is needed"):
        msm.hamburger4(moments, z_f.astype(np.float64))
    with pytest.raises(ValueError, match="alpha = 2"):
        msm.hamburger4(moments, z_f, alpha=2)
    with pytest.raises(ValueError, match=r"\(3, 3\)"):
        msm.bounds("power:4", np.zeros((3, 3)), 0.5)


def test_nan_is_answered_as_in_rust() -> None:
    lower, upper = msm.hamburger4(np.full((1, 4), np.nan, np.float32), 0.5)
    assert not np.isnan(lower[0]) and not np.isnan(upper[0])
    with pytest.raises(ValueError, match="NaN"):
        msm.bounds("power:2", [0.5, float("nan")], 0.6)
    technique = msm.Technique(bound="hamburger4")
    assert not np.isnan(technique.shade(np.zeros((2, 4)), np.array([np.nan, 0.5]))).any()


def test_certified_bounds_enclose_the_closed_form() -> None:
    moments, z_f = kernels(50, 4, np.float64)
    lower, upper = msm.certified("power:4", moments, z_f)
    closed_lower, closed_upper = msm.hausdorff4(moments, z_f)
    assert np.all(lower <= closed_lower + 1e-7) and np.all(closed_upper <= upper + 1e-7)
    moments[7] = [0.5, 0.01, 0.5, 0.5]
    with pytest.raises(ValueError, match="vector 7: "):
        msm.certified("power:4", moments, z_f)
    with pytest.raises(ValueError, match="3 moments given, the basis has 4"):
        msm.certified("power:4", moments[:, :3], z_f)


def test_quantize_finds_the_published_gain() -> None:
    found = msm.quantize(2)
    assert abs(found.gain_bits - 2.0) < 1e-6 and found.matrix.shape == (2, 2)
    assert np.allclose(found.matrix @ found.inverse, np.eye(2))
    with pytest.raises(ValueError):
        msm.quantize(0)


def test_techniques_encode_filter_and_shade() -> None:
    technique = msm.Technique(bound="hamburger4", transform="GDC16 four moments", format="unorm16", alpha=6e-5)
    assert (technique.channels, technique.bits_per_texel, technique.is_lower_bound) == (4, 64, True)
    depths = np.where(np.arange(32) < 16, 0.3, 0.8).astype(np.float32)
    depth_map = np.tile(depths, (32, 1))
    assert technique.encode(depth_map).shape == (32, 32, 4)
    filtered = technique.filter(depth_map)
    shadow = technique.shade(filtered, np.float32(0.79))
    assert shadow.shape == (32, 32) and shadow.dtype == np.float32
    assert shadow[16, 4] > 0.95 and shadow[16, 28] < 0.05
    exact = technique.filter(depth_map, dtype=np.float64)
    assert exact.dtype == np.float64 and np.abs(exact - filtered).max() < 1e-3
    with pytest.raises(ValueError, match=r"depth_map has shape \(32,\)"):
        technique.filter(depths)
    with pytest.raises(ValueError, match="unknown"):
        msm.Technique(bound="mhamburger4")
    with pytest.raises(ValueError, match="alpha"):
        msm.Technique(bound="vsm", alpha=0.1)
    with pytest.raises(ValueError, match="unknown field `bond`"):
        msm.Technique(bond="vsm")


@needs_binary
def test_a_stack_is_that_of_the_binary(tmp_path: Path) -> None:
    scene = msm.load_scene("stairs")
    assert scene.triangles.shape[1] == 3 and "oblique" in [name for name, _ in scene.views]
    stack = msm.render_stack(scene, "oblique", size=64)
    done = command("render", "stairs", "--view", "oblique", "--size", "64", "--backend", "cpu", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    recorded = np.load(next(tmp_path.glob("*.npz")))
    for name in ("offsets", "depths", "gradients"):
        assert np.array_equal(getattr(stack, name), recorded[name]), name
    assert stack.depths is stack.depths and stack.light_facing.shape == stack.depths.shape
    with pytest.raises(ValueError, match="has no view `noon`"):
        msm.render_stack(scene, "noon")
    with pytest.raises(ValueError):
        msm.render_stack(scene, size=0)
    with pytest.raises(ValueError, match="nowhere.glb"):
        msm.load_scene("nowhere.glb")


def test_errors_of_techniques_are_a_table() -> None:
    table = msm.error(
        "stairs", {"four": msm.Technique(bound="hamburger4"), "two": {"bound": "vsm"}}, views=["oblique"], size=96, fragments=400
    )
    rows = (table["view"] == "oblique") & (table["class"] == "all")
    errors = dict(zip(table["technique"][rows], table["l1_error"][rows]))
    assert 0 < errors["four"] < errors["two"] < 0.5
    with pytest.raises(ValueError, match="nowhere"):
        msm.error("nowhere", {"four": {"bound": "hamburger4"}})


def test_advice_is_an_object() -> None:
    advice = msm.advise("stairs", views=["oblique"], tolerance=0.2, relative=0.9, size=128)
    assert advice["scene"] == "stairs" and advice["recommendation"]["cost"] > 0
    with pytest.raises(ValueError, match="tolerance 2"):
        msm.advise("stairs", tolerance=2.0)


def test_runs_are_read() -> None:
    run = msm.read_run(max(path for path in RUNS.iterdir() if path.is_dir()))
    records = run["records"]
    assert len({len(column) for column in records.values()}) == 1
    assert records["l1_error"].dtype == np.float64 and records["fragments"].dtype == np.int64
    assert records["best"].dtype == bool and np.isnan(records["alpha"]).any()
    assert "seed" in json.dumps(run["provenance"])
    with pytest.raises(ValueError, match="is not a run directory"):
        msm.read_run(RUNS)


def test_other_threads_run_meanwhile() -> None:
    moments, z_f = kernels(2_000_000, 4, np.float32)
    ticks, done = [], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    start = time.perf_counter()
    msm.hamburger6(np.concatenate([moments, moments[:, :2]], axis=1), z_f, alpha=1e-3)
    end = time.perf_counter()
    done.set()
    ticker.join()
    # Without the interpreter's lock released there is no tick between the first and the last moment.
    assert sum(start < moment < end for moment in ticks) >= 3
