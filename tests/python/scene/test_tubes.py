"""Trachea and vocal tract of a scene: shapes, files, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.runs.tubes import tract_response, tubes_of
from plica.scene.plausibility import scene_cautions
from plica.scene.tubes import Supply, TractEnd

UNIFORM = {"uniform": {"length": "17 cm", "area": "3 cm^2"}}
SECTIONS = {"sections": {"length": ["8 cm", "9 cm"], "area": ["1 cm^2", "7 cm^2"]}}


def test_a_scene_with_tubes_is_the_same_when_read_again(phonating: plica.Scene) -> None:
    for tract in (UNIFORM, SECTIONS, {"vowel": {"name": "i"}, "wall": "rigid", "end": "closed"}):
        scene = phonating.replace(
            {
                "airflow.rise": "5 ms",
                "tract": {**tract, "friction_frequency": "500 Hz"},
                "trachea": {
                    **UNIFORM,
                    "wall": {"yielding": {"mass": "20 kg/m^2"}},
                    "supply": {"pressure": {"reflection": 0.8, "volume": "2 l"}},
                },
            }
        )
        assert plica.Scene.from_text(scene.text()) == scene
        assert scene.digest() != phonating.digest()


def test_each_far_end_is_another_one_in_the_engine(phonating: plica.Scene) -> None:
    rising = phonating.replace({"airflow.rise": "5 ms"})
    ends = [rising.replace({"tract": {**UNIFORM, "end": name}}) for name in TractEnd.kinds]
    assert len({type(tubes_of(scene)["tract"].end) for scene in ends}) == len(TractEnd.kinds)
    for scene in ends:
        assert scene.tract is not None
        assert scene.airflow is not None
        (gain,) = tract_response(scene.tract, scene.airflow).gain(np.array([200.0]))
        assert gain == -np.inf if scene.tract.end.closed is not None else np.isfinite(gain)
    given = [{"pressure": {}}, {"flow": {"flow": "0.2 l/s"}}]
    assert {name for one in given for name in one} == Supply.kinds.keys()
    supplied = [rising.replace({"trachea": {**UNIFORM, "supply": one}}) for one in given]
    assert len({type(tubes_of(scene)["trachea"].end) for scene in supplied}) == len(given)


def test_units_of_tubes() -> None:
    tract = plica.Tract(**UNIFORM)
    assert tract.profile == ((0.17,), (3e-4,))
    supply = plica.Trachea(**UNIFORM, supply={"flow": {"flow": "200 ml/s", "volume": "2 l"}}).supply
    assert supply.flow is not None
    assert (supply.flow.flow, supply.flow.volume) == (2e-4, 2e-3)


def test_a_file_is_kept_as_its_sections(phonating: plica.Scene, tmp_path: Path) -> None:
    path = tmp_path / "tract.csv"
    path.write_text("# a cone\nx,distance (cm),area (mm^2)\n\n0,0,100\n1,8,100\n2,16,500\n")
    scene = phonating.replace({"tract": {"file": str(path)}})
    path.unlink()
    assert plica.Scene.from_text(scene.text()) == scene
    assert scene.tract is not None
    length, area = (np.array(one) for one in scene.tract.profile)
    middle = np.cumsum(length) - length / 2
    assert length.sum() == pytest.approx(0.16)
    np.testing.assert_allclose(area, np.interp(middle, [0, 0.08, 0.16], [1e-4, 1e-4, 5e-4]), rtol=1e-12)


def test_a_file_lies_beside_the_scene(phonating: plica.Scene, tmp_path: Path) -> None:
    (tmp_path / "tube.csv").write_text("distance (m),area (m^2)\n0,2e-4\n0.15,2e-4\n")
    scene = tmp_path / "scene.toml"
    scene.write_text(phonating.text() + '\n[trachea]\nfile = "tube.csv"\n')
    trachea = plica.Scene.load(scene).trachea
    assert trachea is not None
    assert sum(trachea.profile[0]) == pytest.approx(0.15)


BAD: list[tuple[dict[str, Any], str]] = [
    ({"tract": {"uniform": {"length": "17 cm"}}}, r"tract\.uniform\.area is missing"),
    ({"tract": {"uniform": {"length": "17 m", "area": "3 cm^2"}}}, r"tract\.uniform\.length = .*10"),
    ({"tract": {"uniform": {"length": "17 cm", "area": "0 cm^2"}}}, r"tract\.uniform\.area = .*> 0"),
    ({"tract": {"uniform": {"length": "17 cm", "area": 3}}}, r"tract\.uniform\.area = 3"),
    ({"tract": {"uniform": {"length": "17 cm", "area": "3 cm"}}}, "another dimension"),
    ({"tract": {"uniform": {"length": "-17 cm", "area": "3 cm^2"}}}, r"tract\.uniform\.length = .*> 0"),
    ({"tract": {**UNIFORM, **SECTIONS}}, "exactly one of uniform, sections, vowel"),
    ({"tract": {"end": "open"}}, "exactly one of uniform, sections, vowel"),
    ({"tract": {**UNIFORM, "wall": "soft"}}, r'tract\.wall = "soft"; must be one of rigid'),
    ({"tract": {**UNIFORM, "end": "lips"}}, r'tract\.end = "lips"'),
    ({"tract": {"vowel": {"name": "e"}}}, r'tract\.vowel\.name = "e"'),
    (
        {"tract": {"sections": {"length": ["1 cm"], "area": ["1 cm^2", "2 cm^2"]}}},
        "one area for each of the 1",
    ),
    ({"tract": {"sections": {"length": [], "area": []}}}, r"tract\.sections\.length"),
    ({"tract": {"sections": {"length": [6, 6], "area": [1e-4, 1e-4]}}}, r"add up to at most 10 m"),
    ({"tract": {**UNIFORM, "friction_frequency": "-1 Hz"}}, "friction_frequency = .*>= 0"),
    ({"tract": {**UNIFORM, "wall": {"yielding": {"mass": 0}}}}, r"wall\.yielding\.mass = .*> 0"),
    ({"tract": {**UNIFORM, "wall": {"yielding": {"stiffness": 0}}}}, r"wall\.yielding\.stiffness = .*> 0"),
    ({"tract": {**UNIFORM, "end": {"reflecting": {"reflection": 1.2}}}}, "reflection = 1.2"),
    ({"tract": {**UNIFORM, "supply": "pressure"}}, "supply"),
    ({"trachea": {"vowel": {"name": "a"}}}, "vowel"),
    ({"trachea": {**UNIFORM, "supply": {"pressure": {"reflection": -0.1}}}}, "reflection = -0.1"),
    ({"trachea": {**UNIFORM, "supply": {"pressure": {"volume": "-1 l"}}}}, "volume = .*>= 0"),
    ({"trachea": {**UNIFORM, "supply": {"flow": {}}}}, r"supply\.flow\.flow is missing"),
    ({"trachea": {**UNIFORM, "supply": {"flow": {"flow": 0}}}}, r"supply\.flow\.flow = .*> 0"),
    ({"trachea": {**UNIFORM, "supply": {"flow": {"flow": "2 kPa"}}}}, "another dimension"),
    (
        {"trachea": {**UNIFORM, "supply": {"flow": {"flow": "0.2 l/s"}}}, "airflow.rise": 0},
        "airflow.rise = 0",
    ),
    ({"trachea": {**UNIFORM, "end": "open"}}, "end"),
    ({"tract": {**UNIFORM, "end": "closed"}}, "airflow.rise = 0"),
    ({"tract": UNIFORM, "airflow.coupling": "lagged"}, r'airflow\.coupling = "lagged"; must be "iterated"'),
    ({"trachea": {**UNIFORM, "supply": {"pressure": {"volume": "1 l"}}}}, "volume = .*nothing is behind"),
    ({"tract": UNIFORM, "airflow": None}, "tract: must be left out with no airflow.*Nothing flows there"),
    ({"airflow.sound_speed": 0}, "sound_speed = .*> 0"),
    ({"tract": {"file": "a.csv", **SECTIONS}}, "beside sections"),
    ({"tract": {"file": 3}}, r"tract\.file = 3; must be the path"),
    ({"tract": {"file": "no/such.csv"}}, r"such\.csv"),
]


@pytest.mark.parametrize(("changes", "said"), BAD, ids=[said for _, said in BAD])
def test_bad_tubes_are_refused_by_name(phonating: plica.Scene, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(plica.SceneError, match=said):
        phonating.replace(changes)


BAD_FILES = {
    "": "is empty",
    "0,1\n1,2\n": r'header must have "distance \(UNIT\)"',
    "distance,area\n0,1\n": r'header must have "distance \(UNIT\)"',
    "distance (cm),area (cm)\n0,1\n1,2\n": "another dimension",
    "distance (cm),area (foo)\n0,1\n1,2\n": "is not known",
    "distance (cm),area (cm^2)\n0,1\n": "has 1 rows",
    "distance (cm),area (cm^2)\n1,1\n2,1\n": "first distance is 0.01 m; must be 0",
    "distance (cm),area (cm^2)\n0,1\n2,1\n1,1\n": "distance 3 of 3 is 0.01 m; must be >",
    "distance (cm),area (cm^2)\n0,1\n2,0\n": "area 2 of 2 is 0 m",
    "distance (cm),area (cm^2)\n0,1\n2,wide\n": 'line 3: area is "wide"',
    "distance (cm),area (cm^2)\n0,1\n2\n": "line 3: area is missing",
    "distance (cm),area (cm^2)\n0,1\ninf,1\n": "line 3: distance is inf",
    "distance (m),area (cm^2)\n0,1\n170,1\n": "last distance is 170 m; must be <= 10 m",
    "distance (cm),area (m^2)\n0,3\n17,3\n": "area 1 of 2 is 3 m",
}


@pytest.mark.parametrize("text", BAD_FILES, ids=list(BAD_FILES.values()))
def test_bad_files_are_refused(phonating: plica.Scene, tmp_path: Path, text: str) -> None:
    path = tmp_path / "tract.csv"
    path.write_text(text)
    with pytest.raises(plica.SceneError, match=BAD_FILES[text]):
        phonating.replace({"tract": {"file": str(path)}})


@pytest.mark.parametrize(
    ("tubes", "said"),
    [
        ({"tract": {"uniform": {"length": "17 mm", "area": "3 cm^2"}}}, "tract"),
        ({"tract": {"uniform": {"length": "17 cm", "area": "3 mm^2"}}}, "tract"),
        ({"trachea": {"uniform": {"length": "15 cm", "area": "250 cm^2"}}}, "trachea"),
        ({"tract": {"sections": {"length": [0.1, 0.1], "area": ["3 mm^2", "3 cm^2"]}}}, "area of the tract"),
        ({"trachea": {"sections": {"length": [1.5, 1.5], "area": [3e-4, 3e-4]}}}, "length of the trachea"),
    ],
)
def test_tubes_that_no_person_has_are_cautioned_of(
    phonating: plica.Scene, tubes: dict[str, Any], said: str
) -> None:
    plain = [str(one) for one in scene_cautions(phonating, plica.build_mesh(phonating.mesh))]
    scene = phonating.replace(tubes)
    found = [str(one) for one in scene_cautions(scene, plica.build_mesh(scene.mesh))]
    (new,) = [one for one in found if one not in plain]
    assert said in new
