"""What of a scene cannot be combined, and why: the one table that refusals and documentation come from."""

from __future__ import annotations

from typing import Any

from plica.scene import composition_faults as faults
from plica.scene.combination import Combination
from plica.scene.part import problem

__all__ = ["COMBINATIONS", "require_combinable"]


def require_combinable(part: Any) -> None:
    """Raise for the first combination of a part that is refused."""
    for combination in COMBINATIONS:
        if combination.of == type(part).__name__ and (fault := combination.found(part)) is not None:
            path, value = fault
            raise problem(combination.relation, *path, **({} if value is None else {"value": value}))


COMBINATIONS = (
    Combination(
        "Scene",
        "contact.nitsche",
        "posture",
        "must be another method",
        "it sees the stress of tissue at rest. Use contact.multipliers.",
        "construction",
        lambda scene: (("contact", "nitsche"), None) if scene.posture and faults.has_nitsche(scene) else None,
    ),
    Combination(
        "Scene",
        'contact.surface_mass = "redistributed"',
        "posture",
        'must be "kept"',
        "where mass goes is chosen by the shape at rest.",
        "construction",
        faults.surface_mass_at_posture,
    ),
    Combination(
        "Scene",
        "tract, trachea",
        "no airflow",
        "must be left out",
        "nothing flows into them. Add [airflow].",
        "physics",
        faults.tube_without_airflow,
    ),
    Combination(
        "Scene",
        'initial.equilibrium = "flow"',
        "no airflow",
        "must be true or false",
        "there is no flow to be in equilibrium with. true is the one under gravity and loads.",
        "physics",
        lambda scene: (
            (("initial", "equilibrium"), "flow")
            if faults.in_the_flow(scene) and scene.airflow is None
            else None
        ),
    ),
    Combination(
        "Scene",
        "airflow.rise > 0",
        'initial.equilibrium = "flow"',
        "must be 0 s",
        "the equilibrium is the one under the whole pressure, which would not be there.",
        "physics",
        faults.rises_from_the_flow,
    ),
    Combination(
        "Scene",
        'trachea.supply.flow, tract.end = "closed"',
        'initial.equilibrium = "flow"',
        "must be a supply of pressure, an end that is not closed",
        "the equilibrium is the one under a pressure.",
        "physics",
        faults.shut_off_from_the_flow,
    ),
    Combination(
        "Scene",
        "loads.frequency > 0",
        'initial.equilibrium = "flow"',
        "must be 0 Hz",
        "nothing is at rest under a load that varies.",
        "physics",
        faults.swung_in_the_flow,
    ),
    Combination(
        "Scene",
        "airflow.course",
        'trachea.supply.flow, tract.end = "closed"',
        "must be left out",
        "a flow begins in still air. Let it rise (airflow.rise).",
        "physics",
        faults.course_of_a_flow,
    ),
    Combination(
        "Airflow",
        "airflow.rise > 0",
        "airflow.course",
        "must be 0 s",
        "the course says how the pressure rises.",
        "physics",
        lambda airflow: (
            (("rise",), airflow.rise) if airflow.course is not None and airflow.rise > 0 else None
        ),
    ),
    Combination(
        "Scene",
        "airflow.rise = 0",
        'trachea.supply.flow, tract.end = "closed"',
        "must be > 0 s",
        "a flow begins in still air. Give the time over which the pressure rises, such as 5 ms.",
        "physics",
        faults.begins_with_a_flow,
    ),
    Combination(
        "Scene",
        'airflow.coupling = "lagged" or "extrapolated"',
        "tract, trachea",
        'must be "iterated"',
        "pressures at the folds follow their motion within the step; with those foretold it is not stable.",
        "physics",
        faults.explicit_between_tubes,
    ),
    Combination(
        "Scene",
        "symmetry",
        "mesh.block or mesh.blocks",
        "must be left out",
        "all boxes are divided along the same diagonals. Use a larynx, or a symmetric mesh file.",
        "physics",
        lambda scene: (("symmetry",), scene.symmetry) if scene.symmetry and faults.boxes(scene) else None,
    ),
    Combination(
        "Scene",
        "symmetry",
        "mesh.folds.lesions, mesh.folds.left_gap, mesh.folds.right_gap",
        "must be left out",
        'left and right differ. With voice: without = ["symmetry"].',
        "physics",
        lambda scene: (("symmetry",), scene.symmetry) if scene.symmetry and faults.unlike(scene) else None,
    ),
    Combination(
        "Scene",
        'symmetry = "quarter"',
        "mesh.folds.posterior_chink",
        'must be "half", or left out',
        "front and back differ.",
        "physics",
        lambda scene: (
            (("symmetry",), "quarter") if scene.symmetry == "quarter" and faults.chink(scene) else None
        ),
    ),
    Combination(
        "Scene",
        'airflow.area = "elliptic"',
        "mesh.folds.posterior_chink, mesh.folds.lesions",
        'must be "cut"',
        "a glottis with a chink, or in which a lesion stands, is no ellipse.",
        "physics",
        faults.ellipse_with_a_chink,
    ),
    Combination(
        "Scene",
        "initial.opening_velocity, initial.opening_displacement",
        "mesh.block or mesh.blocks",
        "must be left out",
        "a block has no glottis.",
        "physics",
        faults.initial_of_glottis,
    ),
    Combination(
        "MeshFile",
        "mesh.sides",
        "mesh.mirror",
        "must be left out",
        "left is x < 0, right is x > 0.",
        "physics",
        faults.sides_of_mirrored,
    ),
    Combination(
        "MeshFile",
        "mesh.surfaces.NAME.side",
        "mesh.mirror",
        "must be left out",
        "the file has one fold, of which mirroring makes NAME_left and NAME_right.",
        "physics",
        faults.side_of_mirrored,
    ),
    Combination(
        "MeshFile",
        "mesh.surfaces.NAME_left, mesh.surfaces.NAME_right",
        "mesh.mirror",
        "must be named without the side",
        "mirroring makes NAME_left and NAME_right of the surface NAME.",
        "physics",
        faults.name_of_mirrored,
    ),
    Combination(
        "Stepping",
        'time.mass = "consistent"',
        "time.scheme.central_differences",
        'must be "lumped"',
        "an explicit step solves for nothing.",
        "physics",
        lambda stepping: (
            (("mass",), stepping.mass)
            if stepping.scheme.central_differences is not None and stepping.mass != "lumped"
            else None
        ),
    ),
    Combination(
        "Scene",
        "contact.multipliers, contact.augmented, contact.nitsche",
        "time.scheme.central_differences",
        "must be left out",
        "their forces close gaps at the end of the step, which an explicit step knows before any force. "
        "Use contact.penalty or contact.volume_penalty.",
        "physics",
        lambda scene: (
            (("contact", method), None)
            if faults.is_explicit(scene) and (method := faults.solved(scene)) is not None
            else None
        ),
    ),
    Combination(
        "Scene",
        'contact.surface_mass = "redistributed"',
        "time.scheme.central_differences",
        'must be "kept"',
        "an explicit step divides by the mass of every node.",
        "physics",
        lambda scene: (
            faults.contact(scene, "redistributed", "contact", "surface_mass")
            if faults.is_explicit(scene)
            else None
        ),
    ),
    Combination(
        "Scene",
        "reduction",
        "time.scheme.central_differences",
        "must be left out",
        "the implicit step of few coordinates costs no more and has no limit.",
        "physics",
        lambda scene: (
            (("reduction",), None) if faults.is_reduced(scene) and faults.is_explicit(scene) else None
        ),
    ),
    Combination(
        "Contact",
        'contact.faces = "mortar"',
        "contact.volume_penalty",
        'must be "nodes"',
        "its faces are those of the airway tetrahedra.",
        "physics",
        lambda contact: (
            (("faces",), contact.faces)
            if contact.faces == "mortar" and contact.volume_penalty is not None
            else None
        ),
    ),
    Combination(
        "Contact",
        "contact.direction",
        'contact.airway = "triangulated"',
        "must be left out",
        "a triangulated airway has no direction.",
        "physics",
        lambda contact: (
            (("direction",), list(contact.direction))
            if contact.airway == "triangulated"
            and contact.direction != type(contact).model_fields["direction"].default
            else None
        ),
    ),
    Combination(
        "Contact",
        'contact.faces = "mortar"',
        "contact.nitsche",
        'must be "nodes"',
        "it takes the tissue's stress at nodes.",
        "construction",
        lambda contact: (
            (("faces",), contact.faces) if contact.faces == "mortar" and contact.nitsche is not None else None
        ),
    ),
    Combination(
        "Contact",
        "contact.friction",
        "contact.penalty, contact.volume_penalty, contact.nitsche",
        "must be left out",
        "it is solved for with the normal forces: use contact.multipliers or contact.augmented.",
        "construction",
        lambda contact: (
            (("friction",), contact.friction)
            if contact.friction is not None and contact.multipliers is None and contact.augmented is None
            else None
        ),
    ),
    Combination(
        "Contact",
        "contact.friction",
        'contact.multipliers.solver = "saddle" or "gmres"',
        "must be left out",
        "it takes the compliance of the closed nodes, which only the condensed solver has.",
        "construction",
        lambda contact: (
            (("friction",), contact.friction)
            if contact.friction is not None
            and contact.multipliers is not None
            and contact.multipliers.solver in ("saddle", "gmres")
            else None
        ),
    ),
    Combination(
        "Scene",
        "symmetry",
        "contact.nitsche",
        "must be left out",
        "it takes the stress of all the tissue.",
        "construction",
        lambda scene: (
            (("symmetry",), scene.symmetry) if scene.symmetry and faults.has_nitsche(scene) else None
        ),
    ),
    Combination(
        "Scene",
        "reduction",
        "contact.nitsche",
        "must be left out",
        "it takes the stress of all the tissue.",
        "construction",
        lambda scene: (
            (("reduction",), None) if faults.is_reduced(scene) and faults.has_nitsche(scene) else None
        ),
    ),
    Combination(
        "Scene",
        'contact.faces = "mortar"',
        "reduction",
        'must be "nodes"',
        "contact in few coordinates is of nodes.",
        "construction",
        lambda scene: (
            faults.contact(scene, "mortar", "contact", "faces") if faults.is_reduced(scene) else None
        ),
    ),
    Combination(
        "Scene",
        'contact.airway = "triangulated"',
        "reduction",
        'must be "matched"',
        "where contact can be is known of an airway that does not change.",
        "construction",
        lambda scene: (
            faults.contact(scene, "triangulated", "contact", "airway") if faults.is_reduced(scene) else None
        ),
    ),
    Combination(
        "Scene",
        'contact.surface_mass = "redistributed"',
        "reduction",
        'must be "kept"',
        "a basis moves all nodes, those without mass too.",
        "construction",
        lambda scene: (
            faults.contact(scene, "redistributed", "contact", "surface_mass")
            if faults.is_reduced(scene)
            else None
        ),
    ),
    Combination(
        "Scene",
        'airflow.load_shape = "current"',
        "reduction",
        'must be "reference"',
        "a load that turns with the surface is not linear in the coordinates.",
        "construction",
        lambda scene: (
            (("airflow", "load_shape"), "current")
            if faults.is_reduced(scene)
            and scene.airflow is not None
            and scene.airflow.load_shape == "current"
            else None
        ),
    ),
    Combination(
        "Scene",
        'airflow.load_shape = "current"',
        'initial.equilibrium = "flow"',
        'must be "reference"',
        "the equilibrium is found with loads that are linear in the pressures.",
        "construction",
        lambda scene: (
            (("airflow", "load_shape"), "current")
            if faults.in_the_flow(scene)
            and scene.airflow is not None
            and scene.airflow.load_shape == "current"
            else None
        ),
    ),
    Combination(
        "Scene",
        "contact other than multipliers at the end of the step",
        "reduction and symmetry",
        "must be by multipliers, gaps closed at the end of the step",
        "mirror images meet in their plane, which needs no other.",
        "construction",
        faults.unlike_multipliers,
    ),
    Combination(
        "Scene",
        "contact.nitsche",
        "strain",
        "must be another method",
        "it sees the stress of linear tissue. Use contact.multipliers.",
        "construction",
        lambda scene: faults.of_linear_tissue(scene, "contact", "nitsche"),
    ),
    Combination(
        "Scene",
        'contact.surface_mass = "redistributed"',
        "strain",
        'must be "kept"',
        "nodes without mass start as those of linear tissue do.",
        "construction",
        lambda scene: (
            faults.contact(scene, "redistributed", "contact", "surface_mass") if scene.strain else None
        ),
    ),
    Combination(
        "Scene",
        "reduction",
        "strain",
        "must be left out",
        "a basis spans motion about one stiffness, and the tissue's force takes all nodes. "
        'With voice: without = ["strain"], softer tissue with another pitch.',
        "construction",
        lambda scene: faults.of_linear_tissue(scene, "reduction"),
    ),
    Combination(
        "Scene",
        "time.scheme.central_differences",
        "strain",
        "must be another scheme",
        "the largest step of an explicit one is known of one stiffness.",
        "construction",
        lambda scene: faults.of_linear_tissue(scene, "time", "scheme", "central_differences"),
    ),
    Combination(
        "Scene",
        'airflow.coupling = "lagged" or "extrapolated"',
        "strain",
        'must be "iterated"',
        "the tissue's force and the flow are found in turns.",
        "construction",
        faults.coupled_once,
    ),
    Combination(
        "Scene",
        "airflow.model.bernoulli",
        "strain",
        "must be another model",
        "its flow jumps with the section of separation, between which no round of a step finds a balance.",
        "construction",
        lambda scene: faults.of_linear_tissue(scene, "airflow", "model", "bernoulli"),
    ),
    Combination(
        "Scene",
        "initial.equilibrium",
        "strain",
        "must be false",
        "the equilibrium is found with one stiffness.",
        "construction",
        lambda scene: faults.of_linear_tissue(scene, "initial", "equilibrium"),
    ),
)
"""In the order of the documentation: what physics forbids, then what could be built."""
