"""Faults planted in the engine, or in what a case of `plica verify` hands to it: the case must see each."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from plica import _engine
from plica.identify import MarginalLikelihood, Noise
from plica.verify.bodies.body import SCHEMES

__all__ = ["FAULTS"]


def law(patch: pytest.MonkeyPatch, **factors: float) -> None:
    """Material laws whose parameters are multiplied."""
    for name in ("Isotropic", "TransverselyIsotropic"):
        real = getattr(_engine, name)
        keys = list(real._defaults)

        def made(*values: Any, _real: Any = real, _keys: Any = keys, **named: Any) -> Any:
            given = dict(zip(_keys, values, strict=False)) | named
            off = {key: value * factors.get(key, 1.0) for key, value in given.items() if key in factors}
            if "nu" in factors and given.get("nu") == 0.0:
                off["nu"] = 0.05
            return _real(**given | off)

        patch.setattr(_engine, name, made)


def scaled(name: str, key: str, factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    """A keyword of an engine's class multiplied."""

    def fault(patch: pytest.MonkeyPatch) -> None:
        real = getattr(_engine, name)
        keys = list(real._defaults) if hasattr(real, "_defaults") else []

        def made(*values: Any, **named: Any) -> Any:
            if name == "Material":
                named = dict(zip(("elasticity", "density", "viscosity"), values, strict=False)) | named
                values = ()
            given = named.get(key, real._defaults[key] if key in keys else None)
            if given is None:
                return real(*values, **named)
            product = tuple(factor * np.asarray(given)) if isinstance(given, tuple) else factor * given
            return real(*values, **named | {key: product})

        patch.setattr(_engine, name, made)

    return fault


def lumped(patch: pytest.MonkeyPatch) -> None:
    """The mass matrix is that of half the density at every other unknown."""
    real = _engine.Assembly.mass

    def mass(self: Any) -> Any:
        data, columns, starts = real(self)
        return np.where(columns % 6 < 3, 1.3, 1.0) * data, columns, starts

    patch.setattr(_engine.Assembly, "mass", mass)


def other_scheme(name: str, scheme: Any) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setitem(SCHEMES, name, scheme)


def booked(patch: pytest.MonkeyPatch) -> None:
    """Works and losses of the energy balance are off by a thousandth of the energy."""
    real = _engine.Simulation

    class Simulation(real):  # type: ignore[misc,valid-type]
        def advance(self, steps: int) -> dict[str, Any]:
            found = super().advance(steps)
            off = 1e-3 * found["kinetic_energy"].max()
            return found | {key: found[key] + off * self.step_count for key in WORKS if key in found}

    patch.setattr(_engine, "Simulation", Simulation)


WORKS = ("load_work", "viscous_loss", "numerical_loss", "flow_work")


def started(patch: pytest.MonkeyPatch) -> None:
    """One side starts a hundredth faster."""
    real = _engine.Simulation

    def made(mesh: Any, *parts: Any, **named: Any) -> Any:
        velocity = named.get("velocity")
        if velocity is not None:
            named["velocity"] = velocity * np.where(np.asarray(mesh.points)[:, :1] > 0, 1.01, 1.0)
        return real(mesh, *parts, **named)

    patch.setattr(_engine, "Simulation", made)


def nudged(patch: pytest.MonkeyPatch) -> None:
    """A state is restored with one number off in its last bit."""
    real = _engine.Simulation.restore

    def restore(self: Any, state: dict[str, Any]) -> None:
        moved = np.array(state["displacement"])
        moved[100] = np.nextafter(moved[100], 1)
        real(self, state | {"displacement": moved})

    patch.setattr(_engine.Simulation, "restore", restore)


def drifting(patch: pytest.MonkeyPatch) -> None:
    """Every second simulation starts a millionth faster, as if threads mattered."""
    bits = importlib.import_module("plica.verify.dynamics.bits")
    count = iter(range(9))

    def made(scene: Any) -> Any:
        opening = -1.0 - 1e-6 * next(count)
        return larynx(scene.replace({"initial.opening_velocity": opening}))

    larynx = bits.larynx_simulation
    patch.setattr(bits, "larynx_simulation", made)


def leaking(patch: pytest.MonkeyPatch) -> None:
    """Contact surfaces keep their mass under the trapezoidal rule: impacts make energy."""
    laws = importlib.import_module("plica.verify.contact.laws")
    real = laws.blocks

    def blocks(combination: Any, *parts: Any) -> Any:
        return real(replace(combination, scheme="trapezoidal", mass="kept"), *parts)

    patch.setattr(laws, "blocks", blocks)


def patterns(patch: pytest.MonkeyPatch) -> None:
    """A pressure loads the nodes of one half a thousandth more."""
    real = _engine.pressure_patterns

    def made(mesh: Any, *parts: Any) -> Any:
        weights = np.where(np.asarray(mesh.points)[:, 0] > 0.01, 1.001, 1.0)
        return real(mesh, *parts) * np.repeat(weights, 3)[:, None]

    patch.setattr(_engine, "pressure_patterns", made)


def wrong(module: str, name: str, change: Callable[[Any], Any]) -> Callable[[pytest.MonkeyPatch], None]:
    """A function that a module calls gives back something else."""

    def fault(patch: pytest.MonkeyPatch) -> None:
        where = importlib.import_module(module)
        real = getattr(where, name)
        patch.setattr(where, name, lambda *parts, **named: change(real(*parts, **named)))

    return fault


def of_model(patch: pytest.MonkeyPatch) -> None:
    """The filter and the smoother take an evolution that is off by a thousandth."""
    where = importlib.import_module("plica.verify.identification.gaussian")
    for name in ("kalman_filter", "smooth"):
        real = getattr(where, name)

        def made(model: Any, *parts: Any, _real: Any = real) -> Any:
            return _real(replace(model, G=1.001 * model.G), *parts)

        patch.setattr(where, name, made)


def other_noise(patch: pytest.MonkeyPatch) -> None:
    """The likelihood takes unknown pressures for a hundredth larger."""
    where = importlib.import_module("plica.verify.identification.estimator")
    patch.setattr(
        where,
        "MarginalLikelihood",
        lambda model, n: MarginalLikelihood(model, Noise(1.01 * n.pressure, n.flow)),
    )


def other_gradient(patch: pytest.MonkeyPatch) -> None:
    """The gradient is a thousandth too large."""
    real = MarginalLikelihood.evaluate

    def evaluate(self: Any, x: Any) -> Any:
        found = real(self, x)
        return replace(found, gradient=1.001 * found.gradient)

    patch.setattr(MarginalLikelihood, "evaluate", evaluate)


def other_tissue(patch: pytest.MonkeyPatch) -> None:
    """The engine steps with a cover that is half as stiff again."""
    where = importlib.import_module("plica.verify.identification.recorded")
    real = where.build_simulation
    change = {"tissue.cover.E": 1.5e3, "tissue.cover.viscosity": 0.8}
    patch.setattr(where, "build_simulation", lambda scene, mesh: real(scene.replace(change), mesh))


def quicker(measures: Any) -> Any:
    """Found cycles a tenth too many."""
    found, cycles = measures
    return {
        name: replace(m, value=None if m.value is None else 1.1 * m.value) for name, m in found.items()
    }, cycles


def other_rule(patch: pytest.MonkeyPatch) -> None:
    """The trapezoidal rule damps a little."""
    real = _engine.Newmark
    patch.setattr(_engine, "Newmark", lambda: real(beta=0.26, gamma=0.51))


_VIDEO, _FOUND = "plica.verify.video.glottis", "plica.verify.identification"
FAULTS: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "patch-linear": lambda patch: law(patch, nu=1.01),
    "patch-quadratic": lambda patch: law(patch, nu=1.01),
    "patch-fibre": lambda patch: law(patch, nu=1.01),
    "rigid-motion": lambda patch: law(patch, nu=1.01),
    "moduli": lambda patch: law(patch, nu=1.01),
    "creep-0": scaled("Material", "viscosity", 1.01),
    "creep-0.45": lambda patch: law(patch, nu=1.01),
    "cantilever": lambda patch: law(patch, E=1.01),
    "shear-mode": lambda patch: law(patch, mu_fibre=1.01),
    "shear-order-linear": lumped,
    "shear-order-quadratic": lumped,
    "shear-damping": scaled("Material", "viscosity", 2.0),
    "block-isotropic": scaled("Material", "density", 0.95),
    "block-fibre": scaled("Material", "density", 0.95),
    "block-stiff-fibre": scaled("Material", "density", 0.95),
    "spectral-radius": scaled("HilberHughesTaylor", "alpha", 0.9),
    "free-vibration": other_rule,
    "order-trapezoidal": other_scheme("trapezoidal", _engine.Newmark(beta=0.3, gamma=0.6)),
    "order-hht": other_scheme("HHT(-0.3)", _engine.Newmark(beta=0.3, gamma=0.6)),
    "order-newmark": other_scheme("Newmark(1, 3/2)", _engine.Newmark()),
    "energy-trapezoidal": booked,
    "energy-hht": booked,
    "energy-newmark": booked,
    "free-motion": scaled("Load", "traction", 1.001),
    "threads": drifting,
    "restore": nudged,
    "bernoulli": scaled("Airflow", "air_density", 1.001),
    "poiseuille": scaled("ViscousSlit", "air_viscosity", 1.01),
    "converging-slit": scaled("ViscousSlit", "air_viscosity", 1.1),
    "throat": scaled("ViscousSlit", "separation_ratio", 1.001),
    "closed-surface": patterns,
    "pressure-work": patterns,
    "flow-work": booked,
    "periodic-bar": lambda patch: law(patch, E=1.2),
    "bouncing-bar": lambda patch: law(patch, E=1.2),
    "equal-bars": lambda patch: law(patch, E=1.2),
    "stiff-bars": lambda patch: law(patch, E=1.2),
    "stiff-bars-0.3": lambda patch: law(patch, nu=1.2),
    "unequal-bars": lambda patch: law(patch, E=1.2),
    "contact-patch-matched": lambda patch: law(patch, nu=1.01),
    "contact-patch-linear": lambda patch: law(patch, nu=1.01),
    "contact-patch-mortar": lambda patch: law(patch, nu=1.01),
    "hertz": lambda patch: law(patch, E=1.1),
    "askew": leaking,
    "mirror": started,
    "friction": scaled("Contact", "friction", 1.2),
    "shift": wrong("plica.video.motion.flow", "flow", lambda found: replace(found, flow=found.flow + 0.02)),
    "affine": wrong("plica.video.motion.flow", "flow", lambda found: replace(found, flow=1.05 * found.flow)),
    "ellipse": wrong(_VIDEO, "segment", lambda g: replace(g, mask=ndimage.binary_dilation(g.mask))),
    "filmed": wrong(_VIDEO, "measures", quicker),
    "pulses": wrong(_VIDEO, "find_cycles", lambda cycles: replace(cycles, starts=1.01 * cycles.starts)),
    "sides": wrong(_VIDEO, "side_measures", lambda found: [replace(m, value=1.01 * m.value) for m in found]),
    "filter": of_model,
    "smoother": of_model,
    "evolution": wrong(f"{_FOUND}.evolution", "hht_evolution", lambda e: replace(e, G=e.G * (1 + 1e-9))),
    "evolution-engine": wrong(
        f"{_FOUND}.evolution",
        "scene_evolution",
        lambda made: (replace(made[0], G=made[0].G * (1 + 1e-8)), made[1]),
    ),
    "affine-form": wrong(
        "plica._engine", "stiffness_coefficients", lambda values: 1.001 * np.asarray(values)
    ),
    "responses": other_tissue,
    "likelihood": other_noise,
    "gradient": other_gradient,
    "planted-tissue": other_tissue,
}
