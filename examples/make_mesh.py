"""Makes two_layers.msh: a block of 20 x 10 x 6 mm, muscle below and mucosa above, labelled as Gmsh would."""

from pathlib import Path

import meshio
import numpy as np

import plica

block = plica.build_mesh(plica.Block(size=(20.0, 10.0, 6.0), divisions=(8, 4, 6)))
cells = np.asarray(block.cells)
height = np.asarray(block.points)[cells].mean(axis=1)[:, 2]
bottom, top = block.surfaces["z_min"], block.surfaces["z_max"]
mesh = meshio.Mesh(
    np.asarray(block.points),
    [("tetra", cells), ("triangle", bottom), ("triangle", top)],
    cell_data={
        "gmsh:physical": [
            np.where(height < 4.0, 1, 2),
            np.full(len(bottom), 11),
            np.full(len(top), 12),
        ],
        "gmsh:geometrical": [np.ones(len(faces), dtype=int) for faces in (cells, bottom, top)],
    },
    field_data={"muscle": np.array([1, 3]), "mucosa": np.array([2, 3]), "top": np.array([12, 2])},
)
path = Path(__file__).with_name("two_layers.msh")
mesh.write(path, file_format="gmsh22")
print(path)
