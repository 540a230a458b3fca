"""
A mesh of your own
==================

Folds that no preset has: a quarter of them as tetrahedra in a file, mirrored, blown open.
"""

# %%
# Any mesher will do whose format meshio reads; here NumPy bends a block into the front half of the right
# fold. Each tetrahedron has the label of a layer, each triangle that of a surface.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import meshio
import numpy as np

import plica

DEPTH, HALF_LENGTH, HEIGHT, HALF_GAP, COVER = 8.0, 8.0, 9.0, 0.15, 1.5  # mm
folder = Path(tempfile.mkdtemp())

block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(4, 5, 9)))
u, v, w = np.asarray(block.points).T
medial = HALF_GAP + np.tan(np.radians(40)) * np.maximum(6.0 - HEIGHT * w, 0.0)  # vertical above 6 mm
x = medial + np.where(u < 0.5, COVER * 2 * u, COVER + (2 * u - 1) * (DEPTH - medial - COVER))
points = np.column_stack((x, HALF_LENGTH * v, HEIGHT * w))

cells = np.asarray(block.cells)
layer = np.where(u[cells].mean(axis=1) < 0.5, 1, 2)
sides = {11: block.surfaces["x_min"], 12: block.surfaces["x_max"], 13: block.surfaces["y_max"]}
labels = [layer, *(np.full(len(faces), label) for label, faces in sides.items())]
meshio.Mesh(
    points,
    [("tetra", cells), *(("triangle", faces) for faces in sides.values())],
    cell_data={"gmsh:physical": labels, "gmsh:geometrical": [np.ones(len(part), int) for part in labels]},
).write(folder / "quarter.msh", file_format="gmsh22")

# %%
# The scene says what the labels are. ``mirror="quarter"`` makes both folds of it; ``symmetry`` lets only a
# quarter be solved for (:doc:`/own_mesh`).

scene = plica.Scene(
    plica.MeshFile(
        file=str(folder / "quarter.msh"),
        unit="mm",
        mirror="quarter",
        order=2,
        layers={"cover": 1, "body": 2},
        surfaces={"airway": 11, "wall": 12, "front": 13},
    ),
    {
        "cover": plica.Tissue(
            E="12 kPa", nu=0.45, E_fibre="60 kPa", nu_fibre=0.3, mu_fibre="20 kPa", viscosity="0.1 Pa s"
        ),
        "body": plica.Tissue(E="20 kPa", nu=0.45, viscosity="0.2 Pa s"),
    },
    supports=plica.Supports(fixed=["wall", "front"]),
    airflow=plica.Airflow(subglottal_pressure="0.8 kPa"),
    contact=plica.Multipliers(),
    symmetry="quarter",
    initial=plica.Initial(opening_velocity="0.1 m/s"),
    time=plica.Stepping(step="50 us", duration="60 ms"),
)
run = plica.run(scene, folder / "run", progress=False)
for caution in run.cautions:
    print(caution)

# %%
# The mesh, seen from the side, and what it does.

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5))
front = np.asarray(block.surfaces["y_min"])
for sign in (-1, 1):
    left.triplot(sign * points[:, 0], points[:, 2], front, lw=0.6)
left.set_aspect("equal")
left.set_xlabel("lateral (mm)")
left.set_ylabel("height (mm)")
right.plot(1e3 * run.time, 1e6 * run["minimum_area"])
right.set_xlabel("time (ms)")
right.set_ylabel("least area (mm²)")
figure.tight_layout()
