"""The parts of a scene other than its mesh. Parts that a scene does not have are not constructed.

Every physical field takes a number in SI or a text with a unit: ``E="1 kPa"``. The unit in brackets is that
of the stored value.
"""

from __future__ import annotations

from plica.scene.airflow import (
    Airflow,
    Bernoulli,
    Coupling,
    Course,
    Cut,
    Elliptic,
    Extrapolated,
    FlowModel,
    Iterated,
    Lagged,
    SectionArea,
    ViscousSlit,
)
from plica.scene.conditions import Initial, Load, Supports
from plica.scene.contact import Augmented, Contact, Multipliers, Nitsche, Penalty, VolumePenalty
from plica.scene.output import Output
from plica.scene.reduction import Reduction
from plica.scene.solver import Automatic, Cholesky, ConjugateGradients, LinearMethod, Solver
from plica.scene.stepping import CentralDifferences, HilberHughesTaylor, Newmark, Scheme, Stepping
from plica.scene.strain import FiniteStrain, Strain

__all__ = [
    "Airflow",
    "Augmented",
    "Automatic",
    "Bernoulli",
    "CentralDifferences",
    "Cholesky",
    "ConjugateGradients",
    "Contact",
    "Coupling",
    "Course",
    "Cut",
    "Elliptic",
    "Extrapolated",
    "FiniteStrain",
    "FlowModel",
    "HilberHughesTaylor",
    "Initial",
    "Iterated",
    "Lagged",
    "LinearMethod",
    "Load",
    "Multipliers",
    "Newmark",
    "Nitsche",
    "Output",
    "Penalty",
    "Reduction",
    "Scheme",
    "SectionArea",
    "Solver",
    "Stepping",
    "Strain",
    "Supports",
    "ViscousSlit",
    "VolumePenalty",
]
