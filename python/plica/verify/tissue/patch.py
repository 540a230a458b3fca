"""Patch tests and rigid motion (R9, R10)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from plica import _engine as engine
from plica.scene.mesh.changed import changed_mesh
from plica.verify.bodies.body import Body
from plica.verify.case import Case, Check, worst, zero

__all__ = ["CASES"]

Array = NDArray[np.float64]

E, NU = 20e3, 0.3  # Pa, -
E_FIBRE, NU_FIBRE, MU_FIBRE = 40e3, 0.35, 15e3  # Pa, -, Pa
FIBRE = np.array([1.0, 2.0, 2.0]) / 3
SIDE, ANGLE = 0.01, 0.2  # m, rad


def distorted(order: int) -> Any:
    """A cube of 10 mm whose inner corners are out of place by up to a fifth of an edge."""
    cells = 3
    cube = engine.block_mesh(size=(SIDE,) * 3, divisions=(cells,) * 3)
    points = np.array(cube.points)
    inner = np.all((points > 1e-9) & (points < SIDE - 1e-9), axis=1)
    points[inner] += 0.2 * SIDE / cells * np.random.default_rng(1).uniform(-1, 1, points.shape)[inner]
    mesh = changed_mesh(cube, points=points)
    return engine.to_quadratic(mesh) if order == 2 else mesh


def unit_strains() -> list[Array]:
    """The six symmetric matrices that are one in a component."""
    strains = []
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)):
        strain = np.zeros((3, 3))
        strain[i, j] = strain[j, i] = 1.0
        strains.append(strain)
    return strains


def isotropic_stress(strain: Array) -> Array:
    """Hooke's law, 2 mu eps + lambda tr(eps) I."""
    mu, lame = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    return np.asarray(2 * mu * strain + lame * np.trace(strain) * np.eye(3))


def fibre_stress(strain: Array) -> Array:
    """The textbook's compliance of a fibre along its third axis, inverted, and turned to FIBRE as tensors."""
    compliance = np.zeros((6, 6))
    compliance[:3, :3] = [
        [1 / E, -NU / E, -NU_FIBRE / E_FIBRE],
        [-NU / E, 1 / E, -NU_FIBRE / E_FIBRE],
        [-NU_FIBRE / E_FIBRE, -NU_FIBRE / E_FIBRE, 1 / E_FIBRE],
    ]
    compliance[3, 3] = compliance[4, 4] = 1 / MU_FIBRE
    compliance[5, 5] = 2 * (1 + NU) / E
    across = np.cross(FIBRE, (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    R = np.stack([across, np.cross(FIBRE, across), FIBRE])  # rows: the axes of the law
    e = R @ strain @ R.T
    s = np.linalg.solve(
        compliance, np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])
    )
    return np.asarray(R.T @ np.array([[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]]) @ R)


def patch(order: int, fibres: bool) -> Iterator[Check]:
    """The hull is put where a constant strain puts it; what is inside finds its place."""
    law = (
        engine.TransverselyIsotropic(E, NU, E_FIBRE, NU_FIBRE, MU_FIBRE, fibre=FIBRE.tolist())
        if fibres
        else engine.Isotropic(E, NU)
    )
    mesh = distorted(order)
    x = np.asarray(mesh.points)
    hull = np.asarray(np.any((x < 1e-9) | (x > SIDE - 1e-9), axis=1))
    body = Body(mesh, engine.Material(law, 1040.0), np.stack([hull] * 3, axis=1))
    K = body.whole(body.assembly.stiffness())
    held, free = np.flatnonzero(body.fixed.ravel()), body.free
    off, energies, exact_energies, tractions, exact_tractions = 0.0, [], [], [], []
    for strain in unit_strains():
        exact = (x @ strain).ravel()
        u = exact.copy()
        u[free] = spsolve(K[free][:, free].tocsc(), -K[free][:, held] @ exact[held])
        off = max(off, float(np.abs(u - exact).max() / np.abs(exact).max()))
        stress = (fibre_stress if fibres else isotropic_stress)(strain)
        energies.append(0.5 * u @ (K @ u))
        exact_energies.append(0.5 * float((stress * strain).sum()) * SIDE**3)
        # The hull's nodes on an edge or corner carry the tractions of more than one face, so each stress
        # is read from the virial, sum of X f = integral of the stress.
        tractions.append(np.linalg.norm(x.T @ (K @ u).reshape(-1, 3)))
        exact_tractions.append(np.linalg.norm(stress) * SIDE**3)
    rounding = "round-off of a solve with a condition number below 1e4"
    value, reference = worst(energies, exact_energies)
    yield Check(
        name="energy",
        quantity="strain energy of the worst of six unit strains",
        unit="J",
        value=value,
        reference=reference,
        tolerance=1e-11,
        because=rounding,
    )
    value, reference = worst(tractions, exact_tractions)
    yield Check(
        name="stress",
        quantity="volume integral of the stress, the worst of six",
        unit="N m",
        value=value,
        reference=reference,
        tolerance=1e-11,
        because=rounding,
    )
    yield zero(
        name="displacement",
        quantity="largest error inside, over the largest displacement",
        value=off,
        tolerance=1e-11,
        because=rounding,
    )


def rigid() -> Iterator[Check]:
    """Six infinitesimal rigid motions, the null space, and the energy of a rotation that is finite."""
    mesh = distorted(2)
    x = np.asarray(mesh.points) - 0.5 * SIDE
    body = Body(mesh, engine.Material(engine.Isotropic(E, NU), 1040.0, 0.5), np.zeros(x.shape, bool))
    K, C = (body.whole(m) for m in (body.assembly.stiffness(), body.assembly.viscosity()))
    motions = [np.tile(np.eye(3)[k], (len(x), 1)) for k in range(3)]
    motions += [np.cross(np.eye(3)[k], x) / SIDE for k in range(3)]
    stretched = (x * [1, 0, 0] / SIDE).ravel()
    forces, viscous = (
        max(float(np.abs(A @ u.ravel()).max()) for u in motions) / float(np.abs(A @ stretched).max())
        for A in (K, C)
    )
    for name, force in (("elastic", forces), ("viscous", viscous)):
        yield zero(
            name=name,
            quantity=f"largest {name} force of a rigid motion, over that of a stretch as large",
            value=force,
            tolerance=1e-12,
            because="round-off of a row of some hundred terms",
        )
    small = Body(distorted(1), body.material, np.zeros((64, 3), bool))
    values = np.linalg.eigvalsh(small.whole(small.assembly.stiffness()).toarray())
    yield Check(
        name="null-space",
        quantity="eigenvalues of the free body's K below 1e-9 of the largest",
        value=float((np.abs(values) < 1e-9 * values[-1]).sum()),
        reference=6.0,
        tolerance=0.0,
        because="a count",
    )
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    turned = (x @ (np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T - np.eye(3))).ravel()
    mu, lame = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    yield Check(
        name="finite-rotation",
        quantity="energy density that linear tissue gives a rotation by 0.2 rad",
        unit="J/m^3",
        value=0.5 * float(turned @ (K @ turned)) / SIDE**3,
        reference=2 * (mu + lame) * (1 - c) ** 2,
        tolerance=1e-11,
        because="round-off of a sum over the cells",
    )


CASES = (
    Case(
        "patch-linear",
        "Distorted linear tetrahedra take up each of the six constant strains exactly.",
        "patch test R9; Hooke's law in closed form",
        partial(patch, 1, False),
    ),
    Case(
        "patch-quadratic",
        "Distorted quadratic tetrahedra take up each of the six constant strains exactly.",
        "patch test R9; Hooke's law in closed form",
        partial(patch, 2, False),
    ),
    Case(
        "patch-fibre",
        "Quadratic tetrahedra of tissue with fibres askew to the axes take up each of the six "
        "constant strains exactly.",
        "patch test R9; inverse of the compliance of transverse isotropy, turned as a tensor",
        partial(patch, 2, True),
    ),
    Case(
        "rigid-motion",
        "Infinitesimal rigid motion costs neither force nor energy, and linear tissue charges a "
        "finite rotation "
        "what its small strain, cos(angle) - 1 twice, costs.",
        "R10; 2 (mu + lambda) (1 - cos(angle))^2",
        rigid,
    ),
)
