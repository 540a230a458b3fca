"""Every kind of bad scene is one clear sentence, exit code 2, no traceback, and nothing on the disk."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica
from complaints import refused_scene

LARYNX = """
[mesh]
larynx = "thesis_coarse"
options = { around = 8, levels = [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], body_rings = 1 }
[tissue.body]
E = "20 kPa"
nu = 0.45
[tissue.ligament]
E = "3 kPa"
nu = 0.58
E_fibre = "20 kPa"
nu_fibre = 0.58
mu_fibre = "40 kPa"
[tissue.cover]
E = "1 kPa"
nu = 0.66
E_fibre = "10 kPa"
nu_fibre = 0.66
mu_fibre = "10 kPa"
[airflow]
subglottal_pressure = "0.8 kPa"
[contact.multipliers]
[time]
step = "50 us"
duration = "1 ms"
"""

PRESSURE = 'subglottal_pressure = "0.8 kPa"'
AROUND = "around = 8"


def pressure(value: str) -> tuple[str, str]:
    """Another subglottal pressure in place of the good one."""
    return PRESSURE, f"subglottal_pressure = {value}"


def added(table: str) -> tuple[str, str]:
    """A table that the good scene does not have."""
    return "[time]", f"{table}\n[time]"


SCENES: dict[str, tuple[str, str, str]] = {
    "syntax": (
        "[airflow]",
        "[airflow",
        "s.toml: not TOML: Expected ']' at the end of a table declaration (at line 20",
    ),
    "unknown table": ("[airflow]", "[airflo]", 's.toml: airflo is not known. Did you mean "airflow"?'),
    "unknown key": (
        "mu_fibre",
        "mu_fiber",
        'tissue.ligament.mu_fiber is not known. Did you mean "mu_fibre"?',
    ),
    "missing key": ('duration = "1 ms"', "", "s.toml: time.duration is missing."),
    "wrong sign": (*pressure("-800"), "airflow.subglottal_pressure = -800 Pa; must be > 0. Is the sign"),
    "wrong dimension": (*pressure('"8 kHz"'), "must be a number in Pa or a text with a unit of that"),
    "unknown unit": (
        *pressure('"1 kpa"'),
        '"kpa" is not known. Units are case-sensitive. Did you mean "kPa"?',
    ),
    "a million": ('"1 ms"', '"1 Ms"', '"Ms" has the prefix mega. Did you mean "ms"?'),
    "capitals of another unit": ('"1 ms"', '"1 MS"', '"MS" has another dimension. Did you mean "ms"?'),
    "no unit": (*pressure('"800"'), "the text has no unit."),
    "not a number": (*pressure("true"), "airflow.subglottal_pressure = true; must be a number in Pa"),
    "not finite": (*pressure("nan"), "airflow.subglottal_pressure = NaN; must be finite."),
    "a number for a table": (
        "[airflow]\n" + PRESSURE,
        "[airflow.coupling]\nextrapolated = 3",
        "must be a table.",
    ),
    "tissue without energy": (
        "nu = 0.66\nE_fibre",
        "nu = 0.95\nE_fibre",
        "tissue.cover.nu = 0.95; must be < 0.9129",
    ),
    "isotropic nu": ("nu = 0.45", "nu = 0.5", "tissue.body.nu = 0.5; must be < 0.5 in isotropic tissue."),
    "half a fibre": ("nu_fibre = 0.58", "", "tissue.ligament: nu_fibre is missing"),
    "fibre without stiffness": (
        "nu = 0.45",
        "nu = 0.4\nmu_fibre = 1",
        "tissue.body.mu_fibre = 1.0; must be left out",
    ),
    "unknown layer": (
        "[tissue.body]",
        "[tissue.bodi]",
        "tissue.bodi is not a layer of the mesh; must be one of body",
    ),
    "layer without tissue": ('[tissue.body]\nE = "20 kPa"\nnu = 0.45', "", "s.toml: tissue.body is missing:"),
    "two meshes": (
        'larynx = "thesis_coarse"',
        'larynx = "thesis_coarse"\nblock = {}',
        "must have exactly one of larynx, file, block",
    ),
    "no mesh": (
        'larynx = "thesis_coarse"',
        "",
        "mesh: must have exactly one of larynx, file, block, blocks.",
    ),
    "unknown preset": (
        '"thesis_coarse"',
        '"huge"',
        'mesh.larynx = "huge"; must be one of coarse, demo, fine, finest, thesis, thesis_coarse, '
        "thesis_demo, thesis_medium.",
    ),
    "a size in levels": (
        "options = { around = 8,",
        'options = { size = "1 mm", around = 8,',
        'mesh.options.size = 0.001; must be left out: the larynx "thesis_coarse" is meshed in levels.',
    ),
    "order": (
        'larynx = "thesis_coarse"',
        'larynx = "thesis_coarse"\norder = 3',
        "mesh.order = 3; must be 1 or 2.",
    ),
    "folds that overlap at the start": (
        *added('[initial]\nopening_displacement = "-1 mm"'),
        "m; must be >= 0 at t = 0. Reduce the initial displacement.",
    ),
    "an equilibrium of a body without support": (
        *added("[supports]\nfixed = []\n[initial]\nequilibrium = true"),
        "without strain; must be held for an equilibrium. Hold more of its nodes",
    ),
    "an equilibrium of another kind": (
        *added('[initial]\nequilibrium = "yes"'),
        's.toml: initial.equilibrium = "yes"; must be true, false or "flow".',
    ),
    "mesh lines": (AROUND, "around = 10", "mesh.options.around = 10; must be a multiple of 4."),
    "levels": ("levels = [1, 1,", "levels = [1,", "s.toml: mesh: Larynx: number of levels = 9; must be 10."),
    "larynx too narrow": (
        AROUND,
        'around = 8, radius = "6 mm"',
        "mesh: Larynx: major = 0.007 m; must be < radius",
    ),
    "two contacts": (
        "[contact.multipliers]",
        "[contact.multipliers]\n[contact.penalty]\nstiffness = 1",
        "exactly one of",
    ),
    "no contact": (
        "[contact.multipliers]",
        "[contact]",
        "contact: must have exactly one of multipliers, penalty",
    ),
    "penalty": (
        "[contact.multipliers]",
        "[contact.penalty]\nstiffness = 0",
        "contact.penalty.stiffness = 0 N/m; must be > 0.",
    ),
    "contact surface": (
        "[contact.multipliers]",
        '[contact]\nmultipliers = {}\nfirst = "left"',
        'contact.first = "left"; must',
    ),
    "contact unmatched": (
        "[contact.multipliers]",
        "[contact]\nmultipliers = {}\ndirection = [0, 0, 1]",
        "s.toml: contact.direction = (0, 0, 1): it is 90 degrees off the mean normals of the surfaces",
    ),
    "direction of a triangulated airway": (
        "[contact.multipliers]",
        '[contact]\nmultipliers = {}\nairway = "triangulated"\ndirection = [0, 0, 1]',
        "contact.direction = [0.0, 0.0, 1.0]; "
        'must be left out with contact.airway = "triangulated": it would act on nothing. '
        "A triangulated airway has no direction.",
    ),
    "another airway": (
        "[contact.multipliers]",
        '[contact]\nmultipliers = {}\nairway = "meshed"',
        'contact.airway = "meshed"; must be',
    ),
    "coupling": (
        "[airflow]",
        '[airflow]\ncoupling = "itrated"',
        "must be one of lagged, extrapolated, iterated.",
    ),
    "scheme": (
        "[time]",
        '[time]\nscheme = "euler"',
        'time.scheme = "euler"; must be one of hht, newmark, central_differences.',
    ),
    "alpha": (
        "[time]",
        "[time]\nscheme = { hht = { alpha = -1 } }",
        "time.scheme.hht.alpha = -1; must be >= -0.33",
    ),
    "Newmark below its stability": (
        "[time]",
        "[time]\nscheme = { newmark = { beta = 1.2, gamma = 2.5 } }",
        "time.scheme.newmark.beta = 1.2; must be >= gamma / 2 = 1.25, or the step is limited.",
    ),
    "Newmark that creates energy": (
        "[time]",
        "[time]\nscheme = { newmark = { gamma = 0.4 } }",
        "time.scheme.newmark.gamma = 0.4; must be >= 0.5.",
    ),
    "step": ('step = "50 us"', 'step = "0 us"', 'time.step = "0 us"; must be > 0.'),
    "duration": (
        '"1 ms"',
        '"1.01 ms"',
        "time.duration = 0.00101 s; must be a whole number of steps of 5e-05 s.",
    ),
    "output": (*added('[output]\nevery = "1 us"'), "output.every = 1e-06 s; must be >= time.step = 5e-05 s."),
    "node set": (
        *added('[supports]\nfixed = ["wal"]'),
        'supports.fixed[0] = "wal"; must be one of ends, wall. Did',
    ),
    "wall that is not held": (
        *added('[supports]\nwall_from_y = "3 mm"'),
        'supports.wall_from_y = 0.003; must be left out, or supports.fixed must have "wall".',
    ),
    "iterations": (
        *added("[solver]\nmethod.cholesky.max_iterations = 99999999999"),
        "solver.method.cholesky.max_iterations = 99999999999; must be <= 1e+09.",
    ),
    "passes": (
        "[contact.multipliers]",
        "[contact]\nmultipliers = {}\nmax_passes = 4294967297",
        "contact.max_passes = 4294967297; must be <= 1e+09.",
    ),
    "many lines": (AROUND, "around = 4294967304", "mesh.options.around = 4294967304; must be <= 1e+06."),
    "beyond a float": (*pressure("1" + 400 * "0"), "airflow.subglottal_pressure = 1000"),
    "thousands of digits": (*pressure("1" + 5000 * "0"), "s.toml: not TOML: Exceeds"),
    "steps without number": ('duration = "1 ms"', "duration = 1e305", "must be a whole number of steps"),
    "beyond a decimal": (*pressure('"1e9999999999999999999 kPa"'), "must be finite."),
    "frames between steps": (
        *added('[output]\nevery = "0.12 ms"'),
        "output.every = 0.00012 s; must be a whole number of steps of 5e-05 s.",
    ),
    "start between steps": (
        *added('[output]\nevery = "0.1 ms"\nstart = "0.12 ms"'),
        "output.start = 0.00012 s; must be a whole number of steps of 5e-05 s.",
    ),
    "probe in another unit": (
        *added("[output]\nprobes = [[0, 0, 0], [0, 3, 0]]"),
        "output.probes[1] = [0, 3, 0] m; must be in or near the mesh, which extends from [-0.0",
    ),
    "no wall left": (
        *added('[supports]\nfixed = ["wall"]\nwall_from_y = "2 cm"'),
        "must leave a node of the wall",
    ),
    "component": (
        *added('[supports]\ncomponents = { wall = "w" }'),
        'supports.components.wall = "w"; must be',
    ),
    "load surface": (
        *added('[[loads]]\nsurface = "x"\ntraction = [0, 0, 1]'),
        'loads[0].surface = "x"; must be',
    ),
    "load length": (
        *added('[[loads]]\nsurface = "airway"\ntraction = [1, 0]'),
        "loads[0].traction[2] is missing.",
    ),
    "no such mesh file": (
        'larynx = "thesis_coarse"\noptions = ',
        'file = "no.msh"\nlayers = { body = 1 } # ',
        "there is no such file.",
    ),
}


def test_the_scene_that_is_made_bad_is_good(tmp_path: Path) -> None:
    plica.build_simulation(plica.Scene.from_text(LARYNX))
    assert len(SCENES) >= 20


@pytest.mark.parametrize("kind", SCENES)
def test_a_bad_scene_is_one_sentence(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad, sentence = SCENES[kind]
    assert good in LARYNX
    message = refused_scene(LARYNX.replace(good, bad, 1), tmp_path, capsys)
    assert sentence in message
    assert len(message.splitlines()) == 1


def test_an_empty_supports_heading_is_refused_and_free_tissue_is_written_in_words() -> None:
    start = (
        'mesh = { larynx = "coarse" }\ntissue = "thesis_corrected"\ntime = { step = 5e-5, duration = 1e-3 }\n'
    )
    with pytest.raises(plica.SceneError, match=r"supports: is empty; must name what is fixed.*fixed = \[\]"):
        plica.Scene.from_text(start + "[supports]\n")
    with pytest.raises(plica.SceneError, match="is empty; must name what is fixed"):
        plica.Supports()
    held = plica.Scene.from_text(start)
    assert held.supports is not None
    assert held.supports.fixed == ("wall",)
    free = plica.Scene.from_text(start + "[supports]\nfixed = []\n")
    assert free.supports is not None
    assert free.supports.fixed == ()
    assert plica.Scene.from_text(free.text()) == free != held
