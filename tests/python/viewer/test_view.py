"""``plica view``: what is in its page, read back by a second decoder, and what it refuses."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from analytic_run import Phonation
from complaints import refused
from filmed_folds import folds
from interrupted_runs import killed
from plica.commands.main import main
from plica.films.surface import skin
from plica.measures.run.strain import NodalStrain
from plica.viewer import page as pages
from plica.viewer.fields import quantities
from plica.viewer.phases import phases_of
from stored_files import rewrite_row
from typed_commands import python_blocks

VENDOR = Path(pages.__file__).parent / "vendor"


@pytest.fixture(scope="module")
def voice(phonating: plica.Scene, tmp_path_factory: pytest.TempPathFactory) -> plica.Run:
    scene = phonating.replace({"output": plica.Output(every="0.25 ms")})
    return plica.run(scene, tmp_path_factory.mktemp("voice") / "run", progress=False)


def content(path: Path) -> dict[str, Any]:
    """The data of a page."""
    found = re.search(r"^const page = (.*);$", path.read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    read: dict[str, Any] = json.loads(found[1])
    return read


def unpacked(text: str, kind: str) -> Any:
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind)


def test_a_page_has_the_positions_of_all_phases_to_half_a_level(voice: plica.Run, tmp_path: Path) -> None:
    page = content(plica.write_view(voice, tmp_path / "view.html"))
    points = np.asarray(voice.mesh.points)
    nodes = np.unique(skin(points, np.asarray(voice.mesh.cells)))
    assert page["nodes"] == nodes.size
    assert page["time"] == pytest.approx(1e3 * voice.fields["time"])
    np.testing.assert_allclose(unpacked(page["points"], "<f4").reshape(-1, 3), 1e3 * points[nodes], rtol=1e-6)
    low, high = unpacked(page["motion"], "u1").astype(np.uint16).reshape(2, len(page["time"]), -1)
    levels = np.cumsum(low + (high << 8), axis=0, dtype=np.uint16).view(np.int16)
    wanted = 1e3 * np.asarray(voice.displacement)[:, nodes].reshape(len(page["time"]), -1)
    assert np.abs(wanted).max() > 0.05
    assert np.abs(page["level"] * levels - wanted).max() <= 0.5001 * page["level"]
    assert page["level"] == pytest.approx(np.abs(wanted).max() / 32767)


def test_the_triangles_are_the_whole_skin_and_face_outwards(voice: plica.Run, tmp_path: Path) -> None:
    page = content(plica.write_view(voice, tmp_path / "view.html"))
    points = 1e-3 * unpacked(page["points"], "<f4").reshape(-1, 3).astype(float)
    corners = points[unpacked(page["triangles"], "<u4").reshape(-1, 3)]
    enclosed = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volume = NodalStrain(voice.mesh, green=False).volumes.sum()
    assert enclosed == pytest.approx(volume, rel=1e-3)  # of divergence; curved faces are flat here


def test_a_curved_face_is_shown_by_four_triangles_of_its_nodes(tmp_path: Path) -> None:
    run = _moving(folds(order=2), [0.0, 1e-3, 2e-3])
    page = content(plica.write_view(run, tmp_path / "view.html"))
    faces = skin(np.asarray(run.mesh.points), np.asarray(run.mesh.cells))
    assert len(unpacked(page["triangles"], "<u4")) == 12 * len(faces)
    corners = unpacked(page["points"], "<f4").reshape(-1, 3)[
        unpacked(page["triangles"], "<u4").reshape(-1, 3)
    ]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    whole = 1e3 * np.asarray(run.mesh.points)[faces]
    flat = 0.5 * np.linalg.norm(np.cross(whole[:, 1] - whole[:, 0], whole[:, 2] - whole[:, 0]), axis=1)
    assert area.sum() == pytest.approx(flat.sum(), rel=0.02)


def test_colours_are_the_run_s_own_fields_to_half_a_level(voice: plica.Run, tmp_path: Path) -> None:
    page = content(plica.write_view(voice, tmp_path / "view.html"))
    frames = list(range(voice.frames))
    nodes = np.unique(skin(np.asarray(voice.mesh.points), np.asarray(voice.mesh.cells)))
    assert [quantity["name"] for quantity in page["quantities"]] == ["contact pressure", "speed", "strain"]
    pressure = 1e-3 * np.asarray(voice.fields["contact_pressure"])[:, nodes]
    assert pressure.max() > 0
    own = {quantity.name: quantity.values for quantity in quantities(voice, frames, nodes.tolist())}
    np.testing.assert_allclose(own["contact pressure"], pressure, rtol=1e-6)
    for quantity in page["quantities"]:
        steps = unpacked(quantity["levels"], "u1").reshape(len(frames), -1)
        values = quantity["largest"] / 255 * np.cumsum(steps, axis=0, dtype=np.uint8)
        wanted = own[quantity["name"]]
        assert quantity["largest"] == pytest.approx(wanted.max())
        assert np.abs(values - wanted).max() <= 0.5001 * quantity["largest"] / 255


def _moving(mesh: Any, times: list[float], *, square: float = 0.0) -> Any:
    """A mesh that moves as 0.3 t + square t^2 in x, and as 0.4 t in y, m."""
    points = np.asarray(mesh.points)
    t = np.asarray(times)
    motion = np.stack((0.3 * t + square * t**2, 0.4 * t, 0 * t), axis=1)
    fields = {"time": t, "displacement": np.broadcast_to(motion[:, None], (t.size, *points.shape))}
    return replace(
        Phonation(impulse=0.0).run(), mesh=mesh, fields=fields, waveforms={}, section_height=np.empty(0)
    )


def test_speed_is_exact_where_it_is_constant_and_central_where_it_rises() -> None:
    nodes = [0, 5]
    steady = _moving(folds(order=1), [0.0, 1e-3, 2e-3, 4e-3])
    speed, strain = quantities(steady, [0, 1, 2, 3], nodes)
    assert (speed.name, strain.name) == ("speed", "strain")
    np.testing.assert_allclose(speed.values, 0.5, rtol=1e-9)
    np.testing.assert_allclose(strain.values, 0.0, atol=1e-9)
    rising = _moving(folds(order=1), [0.0, 1e-3, 2e-3], square=50.0)
    found = quantities(rising, [0, 1, 2], nodes)[0].values[:, 0]
    # 0.3 + 100 t in the middle of what is differenced: exact within, half a step off at the ends.
    np.testing.assert_allclose(
        found, [np.hypot(0.3 + 100 * t, 0.4) for t in (0.5e-3, 1e-3, 1.5e-3)], rtol=1e-9
    )


def test_the_last_period_is_shown_and_a_part_whole() -> None:
    run = Phonation(frequency=200.0, frame_every=2).run()
    shown = phases_of(run)
    start, end = run.cycles.starts[-2:]
    assert shown.cycle == (start, end)
    assert end - start == pytest.approx(5e-3, rel=1e-2)
    assert len(shown.frames) == 50
    assert start <= shown.time[0] < start + 1e-4
    assert end - 1e-4 <= shown.time[-1] < end
    np.testing.assert_array_equal(run.fields["time"][shown.frames], shown.time)


def test_a_period_without_fields_is_no_period_to_show() -> None:
    run = Phonation(frequency=200.0, frame_every=2).run()
    first, second = run.cycles.starts[-3:-1]

    def kept(wanted: Any) -> Any:
        return replace(run, fields={name: values[wanted] for name, values in run.fields.items()})

    time = run.fields["time"]
    assert phases_of(kept(time < second)).cycle == (first, second)
    late = phases_of(kept(time >= run.cycles.starts[-1]))
    assert late.cycle is None
    assert len(late.frames) == int((time >= run.cycles.starts[-1]).sum()) > 2


def test_thinned_phases_are_even_and_keep_the_ends() -> None:
    shown = phases_of(Phonation(frequency=200.0, frame_every=2).run())
    fewer = shown.thinned(8)
    assert fewer.frames[0] == shown.frames[0]
    assert fewer.frames[-1] == shown.frames[-1]
    assert set(np.diff(fewer.frames)) == {7}
    assert fewer.stored == 50
    assert shown.thinned(50) is shown


def test_fewer_phases_are_shown_where_the_page_would_be_too_large(
    voice: plica.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = plica.write_view(voice, tmp_path / "whole.html")
    assert whole.stat().st_size < 1_000_000
    monkeypatch.setattr(pages, "largest_page", whole.stat().st_size - 1)
    fewer = plica.write_view(voice, tmp_path / "fewer.html")
    assert fewer.stat().st_size < whole.stat().st_size
    assert 2 <= len(content(fewer)["time"]) < voice.frames
    count = len(content(fewer)["time"])
    assert f"{count} of {voice.frames} stored fields" in fewer.read_text(encoding="utf-8")
    asked = plica.write_view(voice, tmp_path / "asked.html", phases=voice.frames)
    assert len(content(asked)["time"]) == voice.frames


def test_waveforms_are_those_of_the_run_between_the_first_and_the_last_phase(
    voice: plica.Run, tmp_path: Path
) -> None:
    part = voice.between("0.5 ms", "1.5 ms")
    waves = content(plica.write_view(part, tmp_path / "view.html"))["waves"]
    curves = {curve["name"]: curve for curve in waves["curves"]}
    steps = np.flatnonzero((voice.time > 0.74e-3) & (voice.time < 1.51e-3))
    np.testing.assert_allclose(waves["time"], 1e3 * voice.time[steps])
    np.testing.assert_allclose(curves["flow"]["values"], 1e6 * voice["flow"][steps], rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(
        curves["glottal area"]["values"],
        1e6 * np.maximum(voice["minimum_area"][steps], 0),
        rtol=1e-4,
        atol=1e-9,
    )
    assert curves["largest contact pressure"]["unit"] == "kPa"


def test_a_page_loads_nothing_and_has_the_licences(voice: plica.Run, tmp_path: Path) -> None:
    text = plica.write_view(voice, tmp_path / "view.html").read_text(encoding="utf-8")
    assert set(re.findall(r"https?://[^\s\"'`)<]+", text)) <= {"http://www.w3.org/1999/xhtml"}
    assert re.findall(r"<(?:link|img|iframe|script[^>]+src)", text) == []
    assert text.count("</script>") == 2
    assert f"{len(voice.cautions)} caution" in text
    assert all(one.seen in unescape(text) for one in voice.cautions)
    assert "Copyright © 2010-2026 three.js authors" in text
    assert "Copyright (c) 2022 Leon Sorokin" in text


def test_what_was_made_by_others_is_what_was_committed() -> None:
    sums = {}
    for line in (VENDOR / "SHA256SUMS").read_text(encoding="ascii").splitlines():
        wanted, name = line.split()
        sums[name] = wanted
    assert {"vendor.min.js", "uPlot.min.css", "licences.txt", "package-lock.json", "entry.js"} == sums.keys()
    for name, wanted in sums.items():
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == wanted, name


def test_the_versions_are_the_same_wherever_they_stand() -> None:
    asked = json.loads((VENDOR / "package.json").read_text())["devDependencies"]
    locked = json.loads((VENDOR / "package-lock.json").read_text())["packages"]
    for name in ("three", "uplot", "esbuild"):
        assert locked[f"node_modules/{name}"]["version"] == asked[name]
        assert locked[f"node_modules/{name}"]["integrity"].startswith("sha512-")
    for text in ((VENDOR / "README.md").read_text(), (VENDOR / "licences.txt").read_text(encoding="utf-8")):
        assert f"three.js {asked['three']}" in text
        assert f"uPlot {asked['uplot']}" in text


def test_the_licences_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--licences"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"In the pages of plica view\nthree\.js +MIT\nuPlot +MIT\n", said)


def test_a_run_s_page_lies_beside_its_report_which_links_to_it(
    voice: plica.Run, capsys: pytest.CaptureFixture[str]
) -> None:
    directory = str(voice.directory)
    assert main(["report", directory]) == 0
    assert "view.html" not in (voice.directory / "report.html").read_text(encoding="utf-8")
    capsys.readouterr()  # of figures that take their time
    for _ in range(2):  # anew
        assert main(["view", directory]) == 0
    said = capsys.readouterr()
    assert re.search(r"view\.html: 0\.\d+ MB\n$", said.out)
    assert said.err == ""
    assert main(["report", directory]) == 0
    assert '<a href="view.html">' in (voice.directory / "report.html").read_text(encoding="utf-8")
    (voice.directory / "view.html").unlink()


def test_the_python_of_docs_view_md_runs(
    voice: plica.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    Path("runs/first").symlink_to(voice.directory)
    (text,) = python_blocks("docs/view.md")
    exec(compile(text.replace("20 ms", "1 ms"), "view.md", "exec"), {})
    assert len(content(Path("larynx.html"))["time"]) == voice.frames
    assert content(Path("start.html"))["time"] == pytest.approx([0.25, 0.5, 0.75, 1.0])


def test_the_left_fold_comes_first(voice: plica.Run, tmp_path: Path) -> None:
    page = content(plica.write_view(voice, tmp_path / "view.html"))
    triangles = unpacked(page["triangles"], "<u4").reshape(-1, 3)
    x = unpacked(page["points"], "<f4").reshape(-1, 3)[triangles, 0].mean(axis=1)
    assert 2 * page["left"] == len(triangles)  # the mesh is symmetric
    assert x[: page["left"]].max() <= 0 <= x[page["left"] :].min()


def test_without_airflow_and_contact_what_is_of_them_is_left_out(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    page = content(plica.write_view(run, tmp_path / "view.html"))
    assert [quantity["name"] for quantity in page["quantities"]] == ["speed", "strain"]
    assert [curve["name"] for curve in page["waves"]["curves"]] == ["strain, 0.1 % of the volume has more"]
    assert (page["sides"], page["canal"]) == (0, None)


def test_the_canal_is_that_of_the_larynx_and_right_is_right(voice: plica.Run, tmp_path: Path) -> None:
    page = content(plica.write_view(voice, tmp_path / "view.html"))
    low, high = page["canal"]
    assert -5 < low < high < 1
    assert page["sides"] == 1
    right = np.asarray(voice.mesh.cells)[np.asarray(voice.mesh.cell_side) == 2]
    assert np.asarray(voice.mesh.points)[right[:, :4]].mean(axis=(0, 1))[0] > 0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["none"], "none: there is no such directory; must be the directory of a run."),
        (["run", "-o", "view.pdf"], "view.pdf; must end in .html."),
        (["run", "-o", "dir.html"], "dir.html is a directory; must be a file in an existing directory."),
        (
            ["run", "-o", "none/view.html"],
            "none is not a directory; must be a file in an existing directory.",
        ),
        (["run", "-o", "mine.html"], "mine.html would be overwritten; must not exist."),
        (["run", "-o", "v.html", "--phases", "1"], "--phases = 1; must be a whole number >= 2."),
        (["run", "-o", "v.html", "--from", "1.95 ms"], "--to = 0.002 s; must be two steps or more"),
        (["run", "-o", "v.html", "--from", "1.5 ms", "--to", "1.8 ms"], "stored fields = 1; must be >= 2."),
        (["run", "-o", "v.html", "--from", "-1"], "--from = -1 s; must be in [0, 0.002] s"),
        (["run", "-o", "v.html", "--to", "2 kg"], '--to = "2 kg"; must be a number in s'),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_no_file(
    options: list[str],
    sentence: str,
    voice: plica.Run,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("run").symlink_to(voice.directory)
    Path("dir.html").mkdir()
    Path("mine.html").write_text("mine")
    assert sentence in refused(["view", *options], capsys)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["dir.html", "mine.html", "run"]
    assert Path("mine.html").read_text() == "mine"


def test_a_run_without_fields_says_which_key_stores_them(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plica.run(bar.replace({"output": plica.Output()}), tmp_path / "run", progress=False)
    for command in (["view"], ["film", "-o", str(tmp_path / "clip.npy")]):
        message = refused([*command, str(tmp_path / "run")], capsys)
        assert "stored fields = 0; must be >= 2. Set output.every, or an earlier output.start," in message


def test_a_directory_that_may_not_be_written_to_is_named(
    voice: plica.Run, capsys: pytest.CaptureFixture[str]
) -> None:
    message = refused(["view", str(voice.directory), "-o", "/proc/view.html"], capsys, code=1)
    assert "/proc/view.html: cannot be written: " in message


def test_a_damaged_field_is_named_and_one_that_is_not_finite_too(
    phonating: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    field = np.asarray(run.displacement[3])
    field[7, 1] = np.nan
    rewrite_row(run.path, "fields/displacement", 3, field)
    message = refused(["view", str(tmp_path / "run")], capsys)
    assert "the stored field at 0.0006 s is not finite; must be." in message
    data = run.path.read_bytes()
    good = np.asarray(run.displacement[5]).tobytes()
    at = data.index(good[:64])
    run.path.write_bytes(data[:at] + b"\x01\x02\x03\x04" + data[at + 4 :])
    message = refused(["view", str(tmp_path / "run"), "--from", "0.9 ms"], capsys)
    assert "results.h5: fields/displacement" in message
    assert not (tmp_path / "run/view.html").exists()


@pytest.mark.slow
def test_of_a_killed_run_the_computed_part_is_shown(
    tmp_path: Path, phonating: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    steps = killed(phonating, tmp_path, 40)
    assert main(["view", str(tmp_path / "run")]) == 0
    assert f"killed; shown {steps} of 1200 steps." in capsys.readouterr().err
    text = (tmp_path / "run/view.html").read_text(encoding="utf-8")
    assert f"This run is not complete: it has {steps} of 1200 steps." in text
