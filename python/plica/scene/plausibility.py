"""Plausible ranges of the quantities of a larynx, for scenes with an airflow.

Values outside these bounds are not refused: a caution shows the value, the range of a larynx, and the unit
that may have been meant. A scene without airflow need not be a larynx, and is only asked for the unit of a
mesh file, how its bodies are held and where they are (`body_cautions`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plica._engine import DEEPEST_LAYER
from plica.measures.caution import Caution
from plica.scene.body_cautions import body_cautions
from plica.scene.held import MeshArrays, places_at_rest
from plica.scene.mesh.parts import Larynx, MeshFile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from plica.scene.scene import Scene

__all__ = ["BOUNDS", "Bound", "scene_cautions", "tube_cautions"]

_PREFIXES = {-3: "n", -2: "u", -1: "m", 0: "", 1: "k", 2: "M"}


@dataclass(frozen=True)
class Bound:
    """The range of one kind of quantity in a larynx.

    Attributes
    ----------
    low, high : float
        In `unit`; a quantity of exactly zero is treated as absent.
    unit : str
        SI.
    whose : str
        Subject of the sentence, e.g. "Vocal folds have".
    reason : str
        Source of the bounds.
    others : dict of str to float
        Units that may have been meant, each in `unit`; the first that fits is suggested.
    """

    low: float
    high: float
    unit: str
    whose: str
    reason: str
    others: Mapping[str, float]

    def holds(self, value: float) -> bool:
        """Whether the magnitude of a value is within the bounds."""
        return value == 0 or self.low <= abs(value) <= self.high

    def span(self) -> str:
        """The bounds as text."""
        return f"{_shown(self.low, self.unit)} to {_shown(self.high, self.unit)}"

    def question(self, value: float) -> str:
        """A question about the unit that may have been meant."""
        for unit, size in self.others.items():
            if _PLAUSIBLE_NUMBERS[0] <= abs(value) <= _PLAUSIBLE_NUMBERS[1] and self.holds(value * size):
                return f"Is it {value:g} {unit}?"
        return "Is the unit right?"


_PLAUSIBLE_NUMBERS = (1e-3, 1e5)  # numbers that people write; others are not a wrong unit
_ADULT_LENGTH = 15e-3  # m, length of adult vocal folds, to guess a unit
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}

BOUNDS: dict[str, Bound] = {
    "subglottal_pressure": Bound(
        200.0,
        4e3,
        "Pa",
        "Speech has",
        "Threshold of phonation at low pitch (Titze, J. Acoust. Soc. Am. 91, 1992) to loud speech (0.3 to "
        "4 kPa; shouting reaches 10 kPa: Snelleman, Versnel and Dejonckere, PEVOC 7, 2007).",
        {"kPa": 1e3, "cmH2O": 98.0665, "dyn/cm^2": 0.1},
    ),
    "air_density": Bound(
        0.15,
        7.0,
        "kg/m^3",
        "Breathing gas has",
        "Helium (0.16 at body temperature) to sulphur hexafluoride (6), by the ideal-gas law; air has 1.1 "
        "to 1.3.",
        {"g/cm^3": 1e3, "g/m^3": 1e-3},
    ),
    "air_viscosity": Bound(
        0.7e-5,
        4e-5,
        "Pa s",
        "Breathing gas has",
        "Butane (0.75e-5) to neon (3.2e-5), with a margin; air has 1.8e-5 to 1.9e-5, helium 2.0e-5, sulphur "
        "hexafluoride 1.5e-5.",
        {"poise": 0.1, "mPa s": 1e-3, "uPa s": 1e-6},
    ),
    "sound_speed": Bound(
        130.0,
        1.05e3,
        "m/s",
        "Sound in breathing gas has",
        "Sulphur hexafluoride (135) to helium at body temperature (1030); air has 343 to 353.",
        {"cm/s": 1e-2},
    ),
    "tube_length": Bound(
        0.02,
        2.0,
        "m",
        "Tracheas and vocal tracts have",
        "A third of a newborn child's vocal tract (7 cm) to twice the longest tube of experiments (1.1 m).",
        _LENGTHS,
    ),
    "tube_area": Bound(
        5e-6,
        0.01,
        "m^2",
        "Tracheas and vocal tracts have",
        "Half the constriction of a fricative (10 mm^2) to a trumpet's bell (100 cm^2); a tract has 0.3 to "
        "15, a trachea 2 to 3 cm^2.",
        {"cm^2": 1e-4, "mm^2": 1e-6},
    ),
    "supply_volume": Bound(
        1e-6,
        0.02,
        "m^3",
        "Lungs and the vessels of rigs have",
        "A millilitre (below that the volume changes nothing) to three times the lungs of an adult (6 l).",
        {"l": 1e-3, "ml": 1e-6},
    ),
    "supplied_flow": Bound(
        5e-6,
        5e-3,
        "m^3/s",
        "Phonation has",
        "A tenth of a soft voice's flow (50 ml/s) to a forced breath (5 l/s).",
        {"ml/s": 1e-6, "l/s": 1e-3},
    ),
    "stiffness": Bound(
        100.0,
        2e6,
        "Pa",
        "Tissue of the larynx has",
        "Lamina propria has 1 kPa across the fibre, 30 kPa along it, and 10 to 15 times that where it is "
        "stretched (Alipour and Vigmostad, J. Voice 26, 2012); subjects differ by ten times (Chan and Titze, "
        "J. Acoust. Soc. Am. 106, 1999). Above 2 MPa there is cartilage, which does not vibrate.",
        {"kPa": 1e3, "MPa": 1e6, "dyn/cm^2": 0.1},
    ),
    "tissue_density": Bound(
        800.0,
        1.4e3,
        "kg/m^3",
        "Tissue has",
        "Fat (920) to cartilage (1100), silicone of models included, with a margin of a fifth.",
        {"g/cm^3": 1e3, "g/m^3": 1e-3},
    ),
    "viscosity": Bound(
        0.002,
        5.0,
        "Pa s",
        "Tissue that vibrates has",
        "Twice that of water (0.001) to five times the thesis's largest (0.4 to 1). Mucosa has more only at "
        "motions much slower than a voice (Chan and Titze, J. Acoust. Soc. Am. 106, 1999).",
        {"poise": 0.1, "mPa s": 1e-3},
    ),
    "fold_length": Bound(
        0.5e-3,
        0.12,
        "m",
        "Vocal folds have",
        "About 1 mm in a mouse, 3 mm in a newborn child (Sundberg, The Science of the Singing Voice, 1987), "
        "104 mm in an elephant (Herbst and others, Science 337, 2012).",
        _LENGTHS,
    ),
    "layer_thickness": Bound(
        1e-5,
        7e-3,
        "m",
        "A layer of a fold has",
        "About 1 mm in adults, scaled by the length of the folds from a mouse to an elephant. A parametric "
        "larynx limits it to 0.3 of the tissue's depth, with a caution too.",
        _LENGTHS,
    ),
    "mesh_size": Bound(
        1e-3,
        0.5,
        "m",
        "A larynx has",
        "Twice to four times the length of its folds, from a mouse to an elephant.",
        _LENGTHS,
    ),
    "time_step": Bound(
        1e-7,
        0.2e-3,
        "s",
        "A time step of phonation has",
        "At 100 Hz the longest gives 50 steps per period, the shortest 100,000. At 0.4 ms the flow of a "
        "larynx was off by 11 % within 16 ms (docs/extremes.md).",
        {"ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    ),
    "duration": Bound(
        0.01,
        60.0,
        "s",
        "A run of phonation has",
        "One period at 100 Hz (measures need three) to more than a person phonates in one breath.",
        {"ms": 1e-3, "us": 1e-6},
    ),
    "initial_velocity": Bound(
        1e-6,
        5.0,
        "m/s",
        "Folds have",
        "2 pi f A of 1 mm at 800 Hz is 5 m/s, and waves in tissue are as fast (root of E over density); "
        "below 1e-6 m/s the folds move by less than an atom in a step of 50 us.",
        {"cm/s": 1e-2, "mm/s": 1e-3},
    ),
    "initial_displacement": Bound(
        1e-9,
        5e-3,
        "m",
        "Folds are displaced by",
        "A third of a fold of 15 mm; below 1 nm the displacement is negligible.",
        {"mm": 1e-3, "um": 1e-6},
    ),
    "gravity": Bound(
        1.5,
        15.0,
        "m/s^2",
        "Free fall has",
        "The Moon (1.62) to a climb in an aircraft (15); the Earth has 9.81.",
        {"cm/s^2": 1e-2, "mm/s^2": 1e-3, "g_0": 9.80665},
    ),
    "load": Bound(
        1.0,
        1e5,
        "Pa",
        "Loads on tissue have",
        "A thousandth of the pressure of speech to the stress of a contracted muscle (100 kPa and more tear "
        "mucosa).",
        {"kPa": 1e3, "MPa": 1e6, "dyn/cm^2": 0.1},
    ),
    "load_frequency": Bound(
        1.0,
        1e4,
        "Hz",
        "Periodic loads have",
        "Breathing is slower than the lower bound, a voice has no energy above the upper one; zero is a "
        "constant load.",
        {"kHz": 1e3},
    ),
}


def scene_cautions(scene: Scene, mesh: MeshArrays) -> tuple[Caution, ...]:
    """Cautions on a scene, one per kind: with an airflow on quantities that no larynx has; on its bodies.

    Parameters
    ----------
    scene : Scene
    mesh : TetMesh or RunMesh
        The scene's mesh, built.

    Returns
    -------
    tuple of Caution
    """
    bodies = body_cautions(scene, mesh)
    if scene.airflow is None:
        return (*_file_caution(scene, mesh), *_beyond_the_end(scene), *bodies)
    return (
        *_implausible(list(_quantities(scene))),
        *_gravity_caution(scene),
        *_layer_caution(scene, mesh),
        *_posture_caution(scene),
        *_beyond_the_end(scene),
        *_mesh_caution(scene, scene.airflow.surface, mesh),
        *bodies,
    )


def tube_cautions(scene: Scene) -> tuple[Caution, ...]:
    """Those of `scene_cautions` on trachea and tract."""
    return tuple(_implausible(list(_tube_quantities(scene))))


def _implausible(quantities: list[tuple[str, str, float]]) -> Iterator[Caution]:
    """One for each kind, of kind, path and value."""
    for name, bound in BOUNDS.items():
        beyond = [
            (path, value) for kind, path, value in quantities if kind == name and not bound.holds(value)
        ]
        if beyond:
            path, value = beyond[0]
            rest = f" (and {', '.join(path for path, _ in beyond[1:])})" if beyond[1:] else ""
            seen = f"{path} = {value:g} {bound.unit}{rest}. {bound.whose} {bound.span()}."
            yield Caution(name, seen, bound.question(value))


def _gravity_caution(scene: Scene) -> Iterator[Caution]:
    if scene.gravity is not None and scene.gravity[2] > 0:
        x, y, z = scene.gravity
        seen = f"gravity = [{x:g}, {y:g}, {z:g}] m/s^2 points upward, from the lungs to the mouth."
        yield Caution("gravity", seen, "Is the sign of z right?")


def _layer_caution(scene: Scene, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution if a layer of a parametric larynx is thinner than in the scene."""
    given = dict(_layer_thicknesses(scene.mesh)) if isinstance(scene.mesh, Larynx) else {}
    most = DEEPEST_LAYER * 0.5 * float(np.ptp(places_at_rest(mesh)[:, 0]))
    deep = {key: value for key, value in given.items() if most < value <= BOUNDS["layer_thickness"].high}
    if deep:
        key, value = next(iter(deep.items()))
        seen = (
            f"{key} = {_shown(value, 'm')}. The tissue is so thin that cover and "
            f"ligament are limited to {DEEPEST_LAYER:g} of its depth, {_shown(most, 'm')} or less."
        )
        size = "mesh.folds.depth" if key.startswith("mesh.folds") else "mesh.options.radius"
        yield Caution("layer_thickness", seen, f"Use thinner layers, or a larger {size}.")


def _layer_thicknesses(larynx: Larynx) -> Iterator[tuple[str, float]]:
    """Key and value, m, of those that are given."""
    if larynx.folds is not None:
        yield "mesh.folds.cover", larynx.folds.cover
        yield "mesh.folds.ligament", larynx.folds.ligament
    for name in ("layer_thickness", "ligament_thickness"):
        value = getattr(larynx.options, name)
        if value is not None:
            yield f"mesh.options.{name}", value


def _beyond_the_end(scene: Scene) -> Iterator[Caution]:
    """A caution if the run ends before the pressure has risen, or before fields are stored."""
    duration, output = scene.time.duration, scene.output
    seen, advice = [], []
    if scene.airflow is not None and scene.airflow.rise > duration:
        seen.append(f"airflow.rise = {scene.airflow.rise:g} s; the run ends before that, with less pressure.")
        advice.append("let the pressure rise faster")
    course = None if scene.airflow is None else scene.airflow.course
    if course is not None and course.time[-1] > duration * (1 + 1e-9):
        seen.append(f"airflow.course goes on to {course.time[-1]:g} s; the run ends before that.")
        advice.append("let the pressure change faster")
    if output.every is not None and output.start > duration * (1 + 1e-9):
        seen.append(f"output.start = {output.start:g} s; the run ends before that, and no field is stored.")
        advice.append("store fields from an earlier time on")
    if seen:
        text = f"time.duration = {duration:g} s. {' '.join(seen)}"
        yield Caution("duration", text, f"Run longer, or {' and '.join(advice)}.")


def _posture_caution(scene: Scene) -> Iterator[Caution]:
    """A caution if the folds of a parametric larynx are longer or higher than its preset's, or less so.

    Both are of tissue at rest: nothing is stretched or contracted, as in another posture of one larynx. Folds
    of given sizes (`mesh.folds`) are a larynx of their own.
    """
    if not isinstance(scene.mesh, Larynx) or scene.posture is not None or scene.mesh.folds is not None:
        return
    own, preset = (_fold_sizes(larynx) for larynx in (scene.mesh, Larynx(larynx=scene.mesh.larynx)))
    if not BOUNDS["fold_length"].holds(2 * own["mesh.options.major"]):
        return  # which is said already
    changed = [
        f"{key} = {_shown(size, 'm')}, {100 * (size / preset[key] - 1):+.3g} % of the preset's"
        for key, size in own.items()
        if not math.isclose(size, preset[key], rel_tol=1e-9)
    ]
    if changed:
        seen = (
            f"{'; '.join(changed)}. This is tissue at rest: a longer or thinner fold is not a stretched one. "
            "It has no tension, and its pitch falls with length, where that of a stretched one rises."
        )
        yield Caution(
            "fold_length", seen, "Another posture of one larynx is posture.elongation, of a mesh at rest."
        )


def _fold_sizes(larynx: Larynx) -> dict[str, float]:
    """m, by key: half the length of the folds, and the height of their layers, unless sections are others."""
    fields = larynx.all_options()
    usual = Larynx(larynx=larynx.larynx).all_options()
    z = [section[0] for section in fields["sections"]]
    found = {"mesh.options.major": float(fields["major"])}
    if len(z) == len(usual["sections"]):
        height = z[fields["layers_to_section"]] - z[fields["layers_from_section"]]
        found["height of the folds (mesh.options.sections)"] = height
    return found


def _tube_quantities(scene: Scene) -> Iterator[tuple[str, str, float]]:
    assert scene.airflow is not None
    if scene.trachea is not None or scene.tract is not None:
        yield "sound_speed", "airflow.sound_speed", scene.airflow.sound_speed
    for name, tube in (("trachea", scene.trachea), ("tract", scene.tract)):
        if tube is None:
            continue
        length, area = tube.profile
        yield "tube_length", f"length of the {name}", sum(length)
        for extreme in {min(area), max(area)}:
            yield "tube_area", f"area of the {name}", extreme
    if scene.trachea is None:
        return
    supply = scene.trachea.supply
    if supply.flow is not None:
        yield "supplied_flow", "trachea.supply.flow.flow", supply.flow.flow
        yield "supply_volume", "trachea.supply.flow.volume", supply.flow.volume
    if supply.pressure is not None:
        yield "supply_volume", "trachea.supply.pressure.volume", supply.pressure.volume


def _quantities(scene: Scene) -> Iterator[tuple[str, str, float]]:
    """Kind, path and value of the quantities of the scene, without its mesh."""
    assert scene.airflow is not None
    yield "subglottal_pressure", "airflow.subglottal_pressure", scene.airflow.subglottal_pressure
    yield "air_density", "airflow.air_density", scene.airflow.air_density
    yield from _tube_quantities(scene)
    if scene.airflow.model.viscous_slit is not None:
        viscosity = scene.airflow.model.viscous_slit.air_viscosity
        yield "air_viscosity", "airflow.model.viscous_slit.air_viscosity", viscosity
    kinds = dict.fromkeys(("E", "E_fibre", "mu_fibre", "mu_transverse"), "stiffness")
    kinds |= {"density": "tissue_density", "viscosity": "viscosity"}
    for layer, tissue in scene.tissue.items():
        for path, part in (
            (f"tissue.{layer}", tissue),
            (f"tissue.{layer}.left", tissue.left),
            (f"tissue.{layer}.right", tissue.right),
        ):
            for field, kind in kinds.items():
                value = getattr(part, field, None)
                if value is not None:
                    yield kind, f"{path}.{field}", value
    yield "time_step", "time.step", scene.time.step
    yield "duration", "time.duration", scene.time.duration
    if isinstance(scene.mesh, Larynx):
        for key, value in _layer_thicknesses(scene.mesh):
            yield "layer_thickness", key, value
    if scene.gravity is not None:
        yield "gravity", "gravity", math.hypot(*scene.gravity)
    for k, load in enumerate(scene.loads):
        yield "load", f"loads[{k}].traction", math.hypot(*load.traction)
        yield "load_frequency", f"loads[{k}].frequency", load.frequency
    if scene.initial is not None:
        for name in ("velocity", "displacement"):
            size = getattr(scene.initial, f"opening_{name}")
            if size is not None:
                yield f"initial_{name}", f"initial.opening_{name}", size
            for layer, vector in getattr(scene.initial, name).items():
                yield f"initial_{name}", f"initial.{name}.{layer}", math.hypot(*vector)


def _mesh_caution(scene: Scene, surface: str, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution on the length of the folds or, if that is plausible, on the size of the mesh."""
    points, faces = np.asarray(mesh.points), mesh.surfaces.get(surface)
    across = float(np.ptp(points, axis=0).max())
    length = across if faces is None else float(np.ptp(points[np.unique(faces), 1]))
    for name, size, what in (
        ("fold_length", length, "The airway is {:.3g} m from front to back."),
        ("mesh_size", across, "The mesh is {:.3g} m from end to end."),
    ):
        bound = BOUNDS[name]
        if not bound.holds(size):
            seen = f"{what.format(size)} {bound.whose} {bound.span()}."
            yield Caution(name, seen, _about_lengths(scene, length, across))
            return


def _file_caution(scene: Scene, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution on a mesh file larger than any larynx whose unit is 1 m, as if the scene has none."""
    if not isinstance(scene.mesh, MeshFile) or scene.mesh.unit != 1.0:
        return
    across = float(np.ptp(np.asarray(mesh.points), axis=0).max())
    bound = BOUNDS["mesh_size"]
    if across > bound.high:
        seen = (
            f"mesh.unit = 1 m, and the mesh is {across:.3g} m from end to end. {bound.whose} {bound.span()}."
        )
        yield Caution("mesh_size", seen, _about_lengths(scene, across / 3, across))


def _about_lengths(scene: Scene, length: float, across: float) -> str:
    if isinstance(scene.mesh, Larynx):
        return "Are the lengths in mesh.options right?"
    if not isinstance(scene.mesh, MeshFile):
        return "Are the lengths in mesh right?"
    fits = {
        abs(math.log(length * size / scene.mesh.unit / _ADULT_LENGTH)): unit
        for unit, size in _LENGTHS.items()
        if BOUNDS["fold_length"].holds(length * size / scene.mesh.unit)
        and BOUNDS["mesh_size"].holds(across * size / scene.mesh.unit)
    }
    if fits:
        unit = fits[min(fits)]
        return f'Is one unit of the file 1 {unit}? Then set mesh.unit = "1 {unit}".'
    return f"Is mesh.unit = {scene.mesh.unit:g} m right?"


def _shown(value: float, unit: str) -> str:
    """The value with a suitable unit prefix."""
    if unit not in {"Pa", "s", "m", "Hz"}:
        return f"{value:g} {unit}"
    thousands = math.floor(math.log10(value) / 3 + 1e-9)
    return f"{value / 1000.0**thousands:.4g} {_PREFIXES[thousands]}{unit}"
