"""Makes quarter.msh: the front half of the right one of two folds beside a slit, labelled as Gmsh would."""

from pathlib import Path

import meshio
import numpy as np

import plica

DEPTH, HALF_LENGTH, HEIGHT = 8.0, 8.0, 9.0  # mm: x to the wall, y to the front, z up
HALF_GAP, COVER, EDGE = 0.15, 1.5, 6.0  # mm; the medial surface is vertical above the height EDGE

block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(4, 5, 9)))
u, v, w = np.asarray(block.points).T
z = HEIGHT * w
medial = HALF_GAP + np.tan(np.radians(40)) * np.maximum(EDGE - z, 0.0)
depth = np.where(u < 0.5, COVER * 2 * u, COVER + (2 * u - 1) * (DEPTH - medial - COVER))
points = np.column_stack((medial + depth, HALF_LENGTH * v, z))

cells = np.asarray(block.cells)
layer = np.where(u[cells].mean(axis=1) < 0.5, 1, 2)
surfaces = {11: block.surfaces["x_min"], 12: block.surfaces["x_max"], 13: block.surfaces["y_max"]}
names = {"cover": (1, 3), "body": (2, 3), "airway": (11, 2), "wall": (12, 2), "front": (13, 2)}
labels = [layer, *(np.full(len(faces), label) for label, faces in surfaces.items())]
mesh = meshio.Mesh(
    points,
    [("tetra", cells), *(("triangle", faces) for faces in surfaces.values())],
    cell_data={"gmsh:physical": labels, "gmsh:geometrical": [np.ones(len(part), int) for part in labels]},
    field_data={name: np.array(label) for name, label in names.items()},
)
path = Path(__file__).with_name("quarter.msh")
mesh.write(path, file_format="gmsh22")
print(path)
