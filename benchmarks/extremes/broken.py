"""Broken files of every kind, and random scenes: read, or refused in one sentence."""

from __future__ import annotations

import re
import tempfile
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.extremes.good_files import SCENE, mesh_file, picture_file, scene_file
from benchmarks.extremes.probe import LONGEST, Found, Probe, Wrong
from plica.errors import InvalidInput, SolveFailed
from plica.runs.build import build_simulation
from plica.scene.scene import Scene

__all__ = ["PROBES"]

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_ODD = (
    b"nan",
    b"inf",
    b"-1",
    b"0",
    b"99999999999",
    b"1e400",
    b"-2147483649",
    b"5e-324",
    b"4294967296",
    b"0.5",
    b"''",
    b"[]",
)


def broken(text: bytes, rng: np.random.Generator) -> bytes:
    """One to three faults: bytes changed, lost or added, lines lost or doubled, numbers that nobody means."""
    for _ in range(int(rng.integers(1, 4))):
        if not text:
            break
        kind, at = rng.integers(0, 7), int(rng.integers(0, len(text)))
        lines = text.split(b"\n")
        line = int(rng.integers(0, len(lines)))
        numbers = list(_NUMBER.finditer(text))
        if kind <= 2 and numbers:
            found = numbers[int(rng.integers(0, len(numbers)))]
            text = text[: found.start()] + _ODD[int(rng.integers(0, len(_ODD)))] + text[found.end() :]
        elif kind == 3:
            text = b"\n".join(lines[:line] + lines[line + 1 :])
        elif kind == 4:
            text = b"\n".join([*lines[:line], lines[line], *lines[line:]])
        elif kind == 5:
            text = text[:at] + bytes(rng.integers(0, 256, 4, dtype=np.uint8)) + text[at + 4 :]
        else:
            text = text[:at]
    return text


def fuzzed(write: Callable[[Path], Path], read: Callable[[Path], object], count: int) -> Found:
    """So many broken copies of a good file; `read` must take it and refuse or read every copy."""
    rng = np.random.default_rng(7)
    refused = 0
    with tempfile.TemporaryDirectory() as directory:
        path = write(Path(directory))
        good = path.read_bytes()
        read(path)
        for _ in range(count):
            path.write_bytes(broken(good, rng))
            try:
                read(path)
            except (InvalidInput, SolveFailed) as refusal:
                refused += 1
                if len(str(refusal)) > LONGEST:
                    raise Wrong(
                        f"refused in {len(str(refusal))} characters: {str(refusal)[:200]} ..."
                    ) from None
    if refused == 0:
        raise Wrong("no copy was refused: nothing was tried.")
    return Found(0.0, 0.0, note=f"{refused} of {count} refused, the rest read")


def stepped(scene: Scene) -> None:
    """Ten steps; raises Wrong for a waveform that is not finite."""
    if scene.time.steps > 10_000:
        return
    waves = build_simulation(scene).advance(min(scene.time.steps, 10))
    for name, wave in waves.items():
        if np.asarray(wave).dtype.kind == "f" and not np.isfinite(wave).all():
            raise Wrong(f"{name} is not finite")


def _step_mesh(path: Path) -> None:
    labels = "medit:ref" if path.suffix == ".mesh" else "gmsh:physical"
    stepped(
        Scene.model_validate(
            {
                "mesh": {
                    "file": str(path),
                    "labels": labels,
                    "layers": {"a": [1]},
                    "surfaces": {"end": [10]},
                },
                "tissue": {"a": {"E": 1e3, "nu": 0.3}},
                "supports": {"fixed": ["end"]},
                "gravity": [0, 0, -9.81],
                "time": {"step": 1e-4, "duration": 2e-4},
            }
        )
    )


def _read_frames(path: Path) -> None:
    from plica.video.files.sources import open_source

    source = open_source(path)
    if source.count > 10_000:
        return
    for _, pixels in source.pixels(0, source.count):
        np.asarray(pixels).sum()


def _read_picture(path: Path) -> None:
    from plica.video.files.image_file import read_pixels

    np.asarray(read_pixels(path)).sum()


def _random_scene(rng: np.random.Generator) -> dict[str, Any]:
    """Valid by the reference of scenes: every number within its bounds, over decades."""

    def decades(low: float, high: float) -> float:
        return float(10 ** rng.uniform(low, high))

    def tissue() -> dict[str, Any]:
        E = decades(0, 8)
        made: dict[str, Any] = {"E": E, "nu": float(rng.uniform(-0.9, 0.4999)), "density": decades(0, 5)}
        made["viscosity"] = float(rng.choice([0.0, decades(-4, 4)]))
        if rng.random() < 0.3:
            made |= {"nu": 0.3, "E_fibre": E * decades(0, 2), "nu_fibre": 0.2, "mu_fibre": E * decades(-2, 1)}
        return made

    scene: dict[str, Any] = tomllib.loads(SCENE)
    scene["tissue"] = {"a": tissue(), "b": tissue()}
    scene["loads"][0]["traction"] = list(rng.normal(size=3) * decades(-3, 3))
    scene["initial"]["velocity"]["a"] = [decades(-6, 0), 0, 0]
    method = str(rng.choice(["multipliers", "augmented", "nitsche", "penalty"]))
    contact = {key: scene["contact"][key] for key in ("first", "second")} | {method: {}}
    if method == "multipliers" and rng.random() < 0.5:
        contact["friction"] = decades(-3, 0)
    scene["contact"] = contact
    scene["mesh"]["order"] = int(rng.integers(1, 3))
    step = decades(-7, -2)
    scene["time"] = {"step": step, "duration": 8 * step, "scheme": str(rng.choice(["hht", "newmark"]))}
    return scene


def random_scenes(count: int, seed: int) -> Found:
    """So many random scenes: each keeps its energy balance or, at most half of them, is refused."""
    rng, worst, refused = np.random.default_rng(seed), 0.0, 0
    for k in range(count):
        scene = Scene.model_validate(_random_scene(rng))
        try:
            waves = build_simulation(scene).advance(scene.time.steps)
        except (InvalidInput, SolveFailed):
            refused += 1
            continue
        terms = [
            np.asarray(waves[n], float)
            for n in ("kinetic_energy", "elastic_energy", "load_work", "viscous_loss")
        ]
        terms += [np.asarray(waves[n], float) for n in ("numerical_loss", "contact_work")]
        size = float(np.abs(terms).max())
        error = float(np.abs(waves["energy_balance_error"]).max()) / size
        if not np.isfinite(error):
            raise Wrong(f"scene {k} of seed {seed}: the energy balance is not finite")
        worst = max(worst, error)
    if 2 * refused > count:
        raise Wrong(f"{refused} of {count} scenes were refused: next to nothing was tried.")
    return Found(worst, 1e-5, note=f"{count} scenes, {refused} refused")


def _probes() -> list[Probe]:
    known = "read, or refused with InvalidInput in one sentence"
    probes = [
        Probe(
            "broken scene files", known, partial(fuzzed, scene_file, lambda p: stepped(Scene.load(p)), 150)
        ),
        Probe(
            "broken scene files, few",
            known,
            partial(fuzzed, scene_file, lambda p: stepped(Scene.load(p)), 15),
            True,
        ),
        Probe("random scenes", "the energy balance", partial(random_scenes, 60, 1)),
        Probe("random scenes, few", "the energy balance", partial(random_scenes, 6, 2), True),
    ]
    meshes: dict[str, dict[str, Any]] = {
        ".msh": {"file_format": "gmsh22", "binary": False},
        ".vtk": {"binary": False},
        ".vtu": {"binary": True},
        ".mesh": {},
    }
    for suffix, options in meshes.items():
        write = partial(mesh_file, suffix, **options)
        probes.append(Probe(f"broken mesh files, {suffix}", known, partial(fuzzed, write, _step_mesh, 100)))
    for suffix in (".png", ".jpg", ".bmp"):
        write = partial(picture_file, suffix)
        probes.append(Probe(f"broken pictures, {suffix}", known, partial(fuzzed, write, _read_picture, 150)))
    for suffix in (".avi", ".tif", ".npy", ".h5"):
        write = partial(picture_file, suffix)
        probes.append(Probe(f"broken recordings, {suffix}", known, partial(fuzzed, write, _read_frames, 80)))
    return probes


PROBES = _probes()
