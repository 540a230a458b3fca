"""What ``plica identify`` refuses, each in one sentence that says what must be and what to do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_files import PAIRS, SETTINGS, SHAPE, block_scene, flow_file
from plica.commands.main import main
from plica.identify import Settings, identify, open_motion
from plica.identify.observation.recording_warnings import recording_warnings

Made = Callable[..., Any]


@pytest.fixture
def refused(tmp_path: Path) -> Made:
    """The text with which input is refused; nothing is left of it."""

    def run(
        recording: Path | None = None,
        scene: plica.Scene | None = None,
        settings: dict[str, Any] | None = None,
        **file: Any,
    ) -> str:
        source = flow_file(tmp_path / "flow.h5", **file) if recording is None else recording
        with pytest.raises(plica.InvalidInput) as found:
            identify(
                source,
                scene or block_scene(),
                tmp_path / "out",
                Settings(**SETTINGS | (settings or {})),
                progress=False,
            )
        assert not (tmp_path / "out" / "posterior.h5").exists()
        text = str(found.value)
        assert "\n" not in text
        assert text.endswith((".", "?"))
        return text

    return run


# ---- The recording -----------------------------------------------------------------------------


def test_a_recording_must_be_there(refused: Made, tmp_path: Path) -> None:
    assert "there is no such file" in refused(tmp_path / "nothing.h5")


def test_images_must_be_analysed_by_plica_video_first(refused: Made, tmp_path: Path) -> None:
    (tmp_path / "clip.avi").write_bytes(b"RIFF")
    assert "Run plica video first to analyse images" in refused(tmp_path / "clip.avi")


def test_a_directory_must_be_an_analysis(refused: Made, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    assert "must be the directory of an analysis" in refused(tmp_path / "folder")


def test_a_damaged_file_is_named(refused: Made, tmp_path: Path) -> None:
    (tmp_path / "flow.hdf5").write_bytes(b"no HDF5 at all")
    assert "is not an HDF5 file" in refused(tmp_path / "flow.hdf5")
    (tmp_path / "flow.npz").write_bytes(b"no NPZ at all")
    assert "cannot be read as NPZ" in refused(tmp_path / "flow.npz")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"flow": None}, 'has no "flow"'),
        ({"flow": np.zeros((4, 8, 8, 3))}, r"flow has shape (4, 8, 8, 3); must be (frames - 1"),
        ({"flow": np.zeros((8, 8))}, "flow has shape (8, 8)"),
        ({"visible": np.ones((PAIRS, 5, 5))}, "visible has shape (10, 5, 5); must be (10, 48, 40)"),
        ({"sd": np.ones((PAIRS, 2))}, "sd has shape (10, 2)"),
        ({"glottal_area": np.ones(PAIRS)}, "glottal_area has shape (10,); must be (11,)"),
        ({"glottis": np.ones((PAIRS, *SHAPE))}, "glottis has shape"),
        ({"projection": np.eye(4)}, "projection has shape (4, 4); must be (3, 4)"),
        ({"projection": np.arange(12.0).reshape(3, 4)}, "projection must be orthographic"),
        ({"fps": -4000.0}, "fps = -4000.0; must be one number > 0"),
        ({"fps": "fast"}, "must be one number > 0"),
        ({"fps": None}, "the frame rate is not in flow.h5; must be known"),
        ({"projection": None}, "the size of a pixel is not in flow.h5; must be known"),
        ({"projection": None, "mm_per_px": 0.15}, "the position of the image on the mesh is unknown"),
        (
            {"visible": np.zeros((PAIRS, *SHAPE), dtype=bool)},
            "number of points visible in 50% of the frames = 0",
        ),
        ({"flow": np.full((PAIRS, *SHAPE, 2), np.nan)}, "number of points visible in 50% of the frames = 0"),
        ({"flow": np.zeros((PAIRS, *SHAPE, 2))}, "flow is zero everywhere; must show motion"),
        ({"flow": np.ones((PAIRS, *SHAPE, 2), complex)}, "flow has type complex128; must be real"),
        (
            {"sd": np.zeros((PAIRS, *SHAPE))},
            "flow.h5: sd[0, 4, 4] = 0 px; must be > 0 and finite, or nan where unknown",
        ),
        ({"sd": -np.ones((PAIRS, *SHAPE))}, "sd[0, 4, 4] = -1 px; must be > 0"),
        ({"flow": np.full((PAIRS, *SHAPE, 2), 1e4)}, "a reliable flow in px per frame"),
        (
            {"flow": np.ones((1, *SHAPE, 2)), "visible": None},
            "frames 0 to 1; must be three or more in [0, 1]",
        ),
        ({"fps": 3000.0}, "frame interval / step = 2.66667; must be a whole number"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(refused: Made, changes: dict[str, Any], message: str) -> None:
    assert message in refused(**changes)


# ---- Frames, points, camera --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"first": 4, "last": 11}, "frames 4 to 11; must be three or more in [0, 10]"),
        ({"first": 9}, "frames 9 to 10; must be three or more in [0, 10]"),
        (
            {"points": ((10.0, 10.0), (41.0, 10.0))},
            "points[1] = [41, 10] px; must be in the image of 40 x 48",
        ),
        ({"points": ((1.0, 1.0),)}, 'points[0] = [1, 1] px; must show the surface "z_max"'),
        ({"mm_per_px": 0.1}, "mm_per_px = 0.1; must be left out: flow.h5 contains the pose of its camera"),
        (
            {"centre": (0.3, 0, 0), "roll": 0.0, "mm_per_px": 0.1},
            'number of points that show the surface "z_max" = 0; must be >= 1',
        ),
        ({"tilt": 5.0}, "tilt = 5; must be left out: flow.h5 contains the pose of its camera. To override"),
        ({"spacing": 1000.0}, "spacing = 1000 px; must be <= 40 px, the shorter side of the image"),
        ({"seen": "z_mux"}, 'seen = "z_mux"; must be one of x_max'),
        ({"surface": "x_mxa"}, 'Did you mean "x_max"?'),
        (
            {"surface": "z_max"},
            "the surface of the pressures is at one height, z = 0.003 m; must have an extent in z",
        ),
        ({"heights": (0.1, 0.2)}, "heights[0] = 0.1 m; must be where a pressure acts on the surface"),
    ],
)
def test_a_view_that_does_not_fit_is_refused(refused: Made, settings: dict[str, Any], message: str) -> None:
    assert message in refused(settings=settings)


# ---- The scene ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"contact": plica.Contact(first="x_min", second="x_max", multipliers={})},
            "contact is given; must be",
        ),
        ({"loads": (plica.Load(surface="x_max", traction=(1, 0, 0)),)}, "loads is given; must be left out"),
        ({"gravity": (0, 0, -9.81)}, "gravity is given; must be left out"),
        ({"initial": plica.Initial(velocity={"body": (1, 0, 0)})}, "initial is given; must be left out"),
        (
            {"time": plica.Stepping(step=125e-6, duration=125e-6, scheme="newmark")},
            "time.scheme must be hht",
        ),
    ],
)
def test_a_scene_that_is_not_linear_from_rest_is_refused(
    refused: Made, changes: dict[str, Any], message: str
) -> None:
    assert message in refused(scene=block_scene(**changes))


def test_the_reason_why_contact_is_refused_is_reported(refused: Made) -> None:
    contact = plica.Contact(first="x_min", second="x_max", multipliers={})
    message = refused(scene=block_scene(contact=contact))
    assert "not linear in the pressures" in message
    assert "forces on the medial surface replace the contact" in message


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (("bdy.E",), 'layer = "bdy"; must be one of body. Did you mean "body"?'),
        (("body.e_fibre",), 'Did you mean "body.E_fibre"?'),
        (("body.mu_fibre",), '"body.mu_fibre" is not set in the scene'),
        (("body.E", {"targets": "body.E", "name": "again"}), '"body.E" is set by "body.E" and by "again"'),
        (({"targets": ("body.E",), "name": "a"}, {"targets": "body.viscosity", "name": "a"}), "given twice"),
        (("body",), 'target = "body"; must be a layer and a field'),
        (("body.density",), "changes no motion, so it cannot be estimated"),
    ],
)
def test_a_parameter_that_the_scene_does_not_have_is_refused(
    refused: Made, parameters: tuple[Any, ...], message: str
) -> None:
    assert message in refused(settings={"parameters": parameters})


def test_a_parameter_that_nothing_depends_on_is_named(refused: Made) -> None:
    tissue = {name: plica.Tissue(E=5e3, nu=0.4, viscosity=0.3) for name in ("near", "far")}
    blocks = {
        "near": plica.Block(size=(4e-3, 6e-3, 3e-3), divisions=(1, 2, 1)),
        "far": plica.Block(corner=(0, 0, -9e-3), size=(4e-3, 6e-3, 3e-3), divisions=(1, 2, 1)),
    }
    scene = plica.Scene(
        plica.Blocks(blocks=blocks, order=2),
        tissue,
        time=plica.Stepping(step=125e-6, duration=125e-6),
        supports=plica.Supports(fixed=("near.z_min", "far.z_min")),
    )
    chosen = {"parameters": ("near.E", "far.E"), "surface": "near.x_max", "seen": "near.z_max"}
    assert 'the data do not depend on "far.E"' in refused(scene=scene, settings=chosen)


# ---- Settings ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"log_sd": 0}, "log_sd = 0; must be > 0"),
        ({"log_sd": 1000}, "log_sd = 1000; must be <= 10"),
        (
            {"parameters": ({"targets": "body.E", "median": "-1 kPa"},)},
            "must be > 0: its logarithm is estimated",
        ),
        ({"parameters": ({"targets": "body.E", "median": "1 mm"},)}, '"mm" has another dimension'),
        ({"parameters": ({"targets": "body.E", "log_sd": -0.5},)}, "log_sd = -0.5; must be > 0"),
        ({"parameters": ({"targets": ()},)}, "targets"),
        ({"trust_facter": 3}, 'Did you mean "trust_factor"?'),
        ({"heights": (0.002, 0.001)}, "must increase: heights are given upward"),
        ({"first": 4, "last": 5}, "last = 5; must be >= first + 2 = 6"),
        ({"spacing": 0.2}, "spacing = 0.2; must be >= 1"),
        ({"sd": -1}, "sd = -1; must be > 0"),
        ({"trust_factor": 0.5}, "trust_factor = 0.5; must be >= 1"),
        ({"mm_per_px": 0}, "mm_per_px = 0; must be > 0"),
        ({"most_points": 4000}, "most_points = 4000; must be <= 400"),
        ({"tilt": 90}, "tilt = 90; must be < 90"),
        ({"centre": (0, 0, 0)}, "centre: must come with roll"),
        ({"gain_sd": -0.1}, "gain_sd = -0.1; must be >= 0"),
    ],
)
def test_a_setting_out_of_range_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(plica.InvalidInput) as found:
        Settings(**wrong)
    assert message in str(found.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[identify", "not TOML"),
        ("log_sd = 1", "must have the table [identify], and nothing else"),
        ("[identify]\nlog_sd = '1 kPa'", "identify.log_sd"),
        ("[identify]\npressure = 1", "identify.pressure"),
    ],
)
def test_a_settings_file_that_does_not_fit_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "set.toml").write_text(text)
    with pytest.raises(plica.InvalidInput) as found:
        Settings.load(tmp_path / "set.toml")
    assert message in str(found.value)
    assert "set.toml" in str(found.value)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, "cannot be read"),
        ("t,a,b,c\n0,1,1\n1,2,2\n", "has 3 lines, the last with 3 columns; must have 4"),
        ("t,a,b,c\n0,1,1,x\n1,2,2,2\n", "all cells below the heading must be numbers"),
        ("0,1,1,1\n1e-3,2,2,2\n2e-3,1,1,1\n", "has no heading; the first line must name the columns"),
        ("t,a,b,c\n1,1,1,1\n0,2,2,2\n", "times must increase"),
        ("t,a,b,c\n0,1,1,1\n1e-4,2,2,2\n", "must cover the recording, 0 to 0.0025 s"),
        (
            "t,a,b,c\n0,1,1,1\n0.1,2,2,2\n0.2,1,1,1\n",
            "has 1 rows from 0 to 0.0025 s, the time of the recording",
        ),
        ("t,a,b,c\n0,0,0,0\n1e-3,0,0,0\n2e-3,0,0,0\n3e-3,0,0,0\n", "drive = 0 Pa throughout; must have"),
    ],
)
def test_a_drive_that_does_not_fit_is_refused(
    refused: Made, tmp_path: Path, table: str | None, message: str
) -> None:
    path = tmp_path / "drive.csv"
    if table is not None:
        path.write_text(table)
    assert message in refused(settings={"drive": path})


def test_a_coarser_scene_may_differ_in_its_mesh_alone(refused: Made, tmp_path: Path) -> None:
    block_scene().replace({"tissue.body.E": 4e3}).save(tmp_path / "soft.toml")
    assert "tissue differs" in refused(settings={"coarser": str(tmp_path / "soft.toml")})
    block_scene().save(tmp_path / "same.toml")
    assert "has edges 1 times as long as the scene's" in refused(
        settings={"coarser": str(tmp_path / "same.toml")}
    )


def test_what_contradicts_the_recording_is_reported(tmp_path: Path) -> None:
    flow_file(tmp_path / "flow.h5", glottal_area=np.zeros(PAIRS + 1))
    motion = open_motion(tmp_path / "flow.h5")
    warnings = recording_warnings(motion, Settings(fps=2000.0))
    assert warnings[0] == "flow.h5 has fps = 4000 Hz; the settings have 2000 Hz, which is used."
    assert "no frame with a known glottal area > 0, so no frame is treated as closed" in warnings[1]
    assert recording_warnings(motion, Settings(fps=4000.0, closed_below=0.0)) == ()
    flow_file(tmp_path / "nan.h5", glottal_area=np.full(PAIRS + 1, np.nan))
    assert len(recording_warnings(open_motion(tmp_path / "nan.h5"), Settings())) == 1


@pytest.mark.parametrize(("preset", "smooth"), [("video", True), ("gradient", True), ("robust", False)])
def test_flow_that_was_smoothed_is_reported_with_what_to_do(
    tmp_path: Path, preset: str, smooth: bool
) -> None:
    motion = replace(open_motion(flow_file(tmp_path / "flow.h5")), preset=preset)
    warnings = recording_warnings(motion, Settings())
    assert any(f'preset "{preset}"' in text and "--preset robust" in text for text in warnings) == smooth


def test_the_command_says_what_is_wrong_and_returns_two(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    block_scene().save(tmp_path / "scene.toml")
    arguments = ["identify", str(tmp_path / "no.h5"), "--scene", str(tmp_path / "scene.toml")]
    assert main([*arguments, "-o", str(tmp_path / "out")]) == 2
    assert "no.h5: there is no such file" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main([*arguments, "-o", str(tmp_path / "out"), "--log-sd", "-1"]) == 2
    assert "plica: --log-sd = -1" in capsys.readouterr().err
    assert main([*arguments, "-o", str(tmp_path / "out"), "--parameters", "body.E,"]) == 2
    assert '--parameters = "body.E,"; must be names separated by single commas' in capsys.readouterr().err
    assert main([*arguments, "-o", str(tmp_path / "out"), "--from", "5", "--to", "6"]) == 2
    assert "plica: --to = 6; must be >= first + 2 = 7" in capsys.readouterr().err


def test_parameters_are_refused_before_a_flow_is_read(refused: Made, tmp_path: Path) -> None:
    missing = tmp_path / "nothing.h5"  # would be refused as soon as it is opened
    for asked in ("mu_transvers", "mu"):
        said = refused(missing, settings={"parameters": (f"body.{asked}",)})
        assert 'Did you mean "body.mu_transverse"' in said
    assert 'Did you mean "body"?' in refused(missing, settings={"parameters": ("bodi.E",)})


def test_that_there_is_one_mesh_only_is_reported_at_the_start(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = block_scene().replace({"mesh.divisions": (1, 1, 1)})
    with pytest.raises(plica.InvalidInput, match="there is no such file"):
        identify(tmp_path / "nothing.h5", scene, tmp_path / "out", Settings(**SETTINGS | {"coarser": "auto"}))
    assert "Caution: estimating on one mesh only. A coarser mesh cannot" in capsys.readouterr().err
