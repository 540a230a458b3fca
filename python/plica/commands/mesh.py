"""``plica mesh``: show or write the mesh of a scene."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command
from plica.commands.output import print_cautions

__all__ = ["add_commands"]

_HELP = """\
Builds or reads the mesh of SCENE, checks it, and prints its counts, quality and the volume of each layer.

examples:
  plica mesh scene.toml
  plica mesh scene.toml --picture glottis.svg   the middle plane, and the glottis from above
  plica mesh scene.toml -o mesh.vtu             any format that meshio writes, by the suffix

-o writes nodes and tetrahedra, with the number of the layer (from 0, in the order printed) and of the side
(1 left, 2 right) of each tetrahedron; no surfaces, node sets or names of layers.
"""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(commands, "mesh", _mesh, "show or write the mesh of a scene", _HELP)
    part.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    part.add_argument("-o", "--output", metavar="FILE", type=Path, help="write the mesh, e.g. mesh.vtu")
    part.add_argument(
        "--picture", metavar="FILE", type=Path, help="draw the larynx before it moves: .svg, .png or .pdf"
    )


def _mesh(options: argparse.Namespace) -> int:
    import plica
    from plica.runs.lesions import lesion_cells, lesion_text
    from plica.scene.mesh.summary import mesh_summary, write_mesh
    from plica.scene.plausibility import scene_cautions

    scene = plica.Scene.load(options.scene)
    mesh = plica.scene_mesh(scene)
    print(mesh_summary(mesh) + lesion_text(scene, mesh))
    print_cautions(scene_cautions(scene, mesh))
    if options.picture is not None:
        from plica.report.glottis import draw_glottis

        draw_glottis(mesh, options.picture, lesion_cells(scene, mesh))
        print(f"drawn: {options.picture}")
    if options.output is not None:
        write_mesh(mesh, options.output)
        print(f"written: {options.output} (without surfaces, node sets and names of layers)")
    return 0
