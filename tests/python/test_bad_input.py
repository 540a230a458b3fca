"""Every kind of bad input is one clear sentence, exit code 2, no traceback, and nothing on the disk."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

import plica
from plica.cli import main

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
    "wrong sign": (*pressure("-800"), "airflow.subglottal_pressure = -800; must be > 0. Is the sign"),
    "wrong dimension": (*pressure('"8 kHz"'), "must be a number in Pa or a text with a unit of that"),
    "unknown unit": (
        *pressure('"1 kpa"'),
        '"kpa" is not known. Upper and lower case differ. Did you mean "kPa"?',
    ),
    "a million": ('"1 ms"', '"1 Ms"', '"Ms" has the prefix of a million. Did you mean "ms"?'),
    "capitals of another unit": ('"1 ms"', '"1 MS"', '"MS" is of another kind. Did you mean "ms"?'),
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
    "an equilibrium and a displacement": (
        *added('[initial]\nequilibrium = true\nopening_displacement = "1 mm"'),
        "initial.opening_displacement: must be left out: initial.equilibrium finds it.",
    ),
    "an equilibrium of a body without support": (
        *added("[supports]\nfixed = []\n[initial]\nequilibrium = true"),
        "without strain; must be held for an equilibrium. Hold more of its nodes",
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
        "contact.penalty.stiffness = 0; must be > 0.",
    ),
    "contact surface": (
        "[contact.multipliers]",
        '[contact]\nmultipliers = {}\nfirst = "left"',
        'contact.first = "left"; must',
    ),
    "contact unmatched": (
        "[contact.multipliers]",
        "[contact]\nmultipliers = {}\ndirection = [0, 0, 1]",
        "s.toml: contact: ",
    ),
    "direction of a triangulated airway": (
        "[contact.multipliers]",
        '[contact]\nmultipliers = {}\nairway = "triangulated"\ndirection = [0, 0, 1]',
        "contact.direction = [0.0, 0.0, 1.0]; must be left out. A triangulated airway has no direction.",
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


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str], code: int = 2) -> str:
    """The command's complaint; its exit code is `code` and it has no traceback."""
    assert main(arguments) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert all(line.startswith("plica: ") for line in said.err.splitlines())
    return said.err


def refused_scene(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The complaint about a scene that is not run; it names the file, and nothing is left."""
    (folder / "s.toml").write_text(text)
    said = refused(["run", str(folder / "s.toml"), "-o", str(folder / "run")], capsys)
    assert said.startswith("plica: s.toml: ")
    assert not (folder / "run").exists()
    return said


def test_the_scene_that_is_made_bad_is_good(tmp_path: Path) -> None:
    plica.build_simulation(plica.Scene.from_text(LARYNX))
    assert len(SCENES) >= 20


@pytest.mark.parametrize("kind", SCENES)
def test_a_bad_scene_is_one_sentence(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad, sentence = SCENES[kind]
    assert good in LARYNX
    said = refused_scene(LARYNX.replace(good, bad, 1), tmp_path, capsys)
    assert sentence in said
    assert len(said.splitlines()) == 1


BLOCK = """
[mesh]
file = "m.vtu"
layers = { body = 1 }
[tissue.body]
E = 1e4
nu = 0.3
[time]
step = 1e-4
duration = 1e-3
"""


def block_mesh() -> meshio.Mesh:
    block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(2, 1, 1)))
    cells = np.array(block.cells)
    return meshio.Mesh(
        np.array(block.points), [("tetra", cells)], cell_data={"label": [np.ones(len(cells), dtype=int)]}
    )


def invert(mesh: meshio.Mesh) -> None:
    mesh.cells[0].data[3] = mesh.cells[0].data[3][[1, 0, 2, 3]]


def repeat(mesh: meshio.Mesh) -> None:
    mesh.cells[0].data[5] = mesh.cells[0].data[4]


def flatten(mesh: meshio.Mesh) -> None:
    mesh.points[:, 2] = 0.0


def add_point(mesh: meshio.Mesh) -> None:
    mesh.points = np.vstack([mesh.points, [[5.0, 5.0, 5.0]]])


def change_label(mesh: meshio.Mesh) -> None:
    mesh.cell_data["label"][0][2] = 7


def two_labels(mesh: meshio.Mesh) -> None:
    mesh.cell_data["other"] = [mesh.cell_data["label"][0]]


def only_triangles(mesh: meshio.Mesh) -> None:
    mesh.cells = [meshio.CellBlock("triangle", mesh.cells[0].data[:, :3])]


def nothing(mesh: meshio.Mesh) -> None:
    """The mesh is good; the scene is not."""


MESHES: dict[str, tuple[Callable[[meshio.Mesh], None], tuple[str, str], str]] = {
    "inverted": (invert, ("", ""), "cell 3"),
    "duplicate": (repeat, ("", ""), "cell"),
    "flat": (flatten, ("", ""), "cell"),
    "unreferenced node": (add_point, ("", ""), "node 12"),
    "unmapped label": (
        change_label,
        ("", ""),
        "mesh.layers leaves out tetrahedra with the labels [7] of m.vtu.",
    ),
    "unknown label": (
        nothing,
        ("body = 1", "body = 3"),
        "mesh.layers.body = 3; must be a label of tetrahedra in m.vtu",
    ),
    "unknown name": (
        nothing,
        ("body = 1", 'body = "muscle"'),
        'mesh.layers.body = "muscle"; must be a label of',
    ),
    "several label data": (
        two_labels,
        ("layers", 'labels = "labl"\nlayers'),
        'mesh.labels = "labl"; must be one of',
    ),
    "no tetrahedra": (only_triangles, ("", ""), "m.vtu has no tetrahedra; it has one of triangle."),
    "no triangles": (
        nothing,
        ("[tissue", "surfaces = { skin = 1 }\n[tissue"),
        "must be a label of triangles in m.vtu",
    ),
    "unknown side": (
        nothing,
        ("[tissue", "sides = { left = 1, right = 2 }\n[tissue"),
        "mesh.sides.right = 2; must be",
    ),
    "side without sides": (
        nothing,
        ("[time]", "[tissue.body.left]\nE = 2e4\n[time]"),
        "tissue.body.left has no",
    ),
    "larynx pattern": (
        nothing,
        ("[time]", "[initial]\nopening_velocity = 1\n[time]"),
        "initial.opening_velocity: must be",
    ),
    "unit": (nothing, ("layers", 'unit = "1 s"\nlayers'), 'mesh.unit = "1 s"; must be a number in m'),
}


@pytest.mark.parametrize("kind", MESHES)
def test_a_bad_mesh_file_is_one_sentence(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil, (good, bad), sentence = MESHES[kind]
    mesh = block_mesh()
    spoil(mesh)
    mesh.write(tmp_path / "m.vtu")
    assert sentence in refused_scene(BLOCK.replace(good, bad, 1), tmp_path, capsys)


@pytest.mark.parametrize(("name", "content"), [("m.vtu", "not a mesh"), ("m.xyz", "1 2 3"), ("m.msh", "")])
def test_what_is_not_a_mesh_is_refused(
    name: str, content: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(content)
    (tmp_path / "s.toml").write_text(BLOCK.replace("m.vtu", name))
    said = refused(["mesh", str(tmp_path / "s.toml")], capsys)
    assert f"s.toml: mesh.file: {name} cannot be read as a mesh" in said


def test_what_the_command_line_cannot_mean_is_refused(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "s.toml"
    bar.save(scene)
    run = str(tmp_path / "run")
    assert "there is no such file" in refused(["run", str(tmp_path / "no.toml"), "-o", run], capsys)
    assert "there is no run to continue" in refused(["run", str(scene), "-o", run, "--resume"], capsys)
    assert "must be a directory; it is a file" in refused(["run", str(scene), "-o", str(scene)], capsys)
    assert "there is no such directory" in refused(["report", run], capsys)
    (tmp_path / "results.h5").touch()
    assert f"Take the directory it is in, {tmp_path}" in refused(
        ["film", str(tmp_path / "results.h5"), "-o", "c.avi"], capsys
    )
    (tmp_path / "results.h5").unlink()
    assert "there is no run in it" in refused(["measures", str(tmp_path)], capsys)
    assert "cannot be read" in refused(["run", str(tmp_path), "-o", run], capsys)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    assert "must be text in UTF-8" in refused(["mesh", str(tmp_path / "binary.toml")], capsys)
    assert not Path(run).exists()


def test_a_mesh_format_that_does_not_exist_is_refused(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    bar.save(tmp_path / "s.toml")
    assert main(["mesh", str(tmp_path / "s.toml"), "-o", str(tmp_path / "mesh.xyz")]) == 2
    assert "cannot be written as a mesh" in capsys.readouterr().err


def test_an_occupied_directory_is_refused_with_a_way_out(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    bar.save(tmp_path / "s.toml")
    plica.run(bar, tmp_path / "run", progress=False)
    said = refused(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run")], capsys)
    assert "holds a run already. Continue it with --resume (resume=True), or take another directory." in said


def test_a_broken_result_file_is_refused(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "results.h5").write_text("nothing of the kind")
    said = refused(["measures", str(tmp_path / "run")], capsys)
    assert "results.h5: not a result file of plica: it is no HDF5 file. Nothing in it can be gone on" in said


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run"], "the following arguments are required: SCENE"),
        (["run", "s.toml"], "required: -o/--output"),
        (["run", "s.toml", "-o", "x", "--threads", "0"], "0; must be a whole number from 1 to 1024."),
        (["run", "s.toml", "-o", "x", "--threads", "two"], "two; must be a whole number from 1 to 1024."),
        (["run", "s.toml", "-o", "x", "--threads", "99999999999"], "must be a whole number from 1 to 1024."),
        (["rnu"], 'Did you mean "run"? plica --help says more.'),
        (["run", "s.toml", "-o", "x", "--resum3"], "unrecognized arguments: --resum3"),
        ([], "required: COMMAND"),
    ],
)
def test_a_bad_command_line_is_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert sentence in capsys.readouterr().err


def test_a_solve_that_fails_is_exit_code_one(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    starved = {"solver.method": plica.ConjugateGradients(max_iterations=1)}
    bar.replace(starved).save(tmp_path / "s.toml")
    said = refused(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"], capsys, code=1)
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("changes", "hint"),
    [
        ({"contact": "multiplier"}, 'Did you mean "multipliers"?'),
        ({"mesh.larynx": "corse"}, 'must be one of coarse, demo, fine, finest, .* Did you mean "coarse"?'),
    ],
)
def test_the_name_of_a_choice_is_answered_with_the_nearest(changes: dict[str, str], hint: str) -> None:
    scene = plica.Scene(
        plica.Larynx(larynx="coarse"), "normal", time=plica.Stepping(step="50 us", duration="1 ms")
    )
    with pytest.raises(plica.InvalidInput, match=hint.replace("?", r"\?")):
        scene.replace(changes)


def test_the_mark_at_the_head_of_a_file_is_no_key(tmp_path: Path, bar: plica.Scene) -> None:
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + bar.text().encode())
    assert plica.Scene.load(path) == bar


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rum"], 'rum; must be one of run, .* Did you mean "run"\\? plica --help'),
        (["video", "x.avi", "-o", "x", "--fps", "abc"], "--fps: abc; must be a number. plica video --help"),
        (["film", "x", "-o", "x", "--size", "10.5,3"], "10.5,3; must be 2 whole numbers with commas"),
    ],
)
def test_what_no_option_can_mean_says_what_it_must_be(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(arguments)
    assert re.search(said, capsys.readouterr().err)
