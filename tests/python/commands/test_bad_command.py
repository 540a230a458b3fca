"""Every kind of bad command line is one clear sentence, and nothing on the disk."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica
from complaints import refused
from plica.commands.main import main


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
    assert f"Use the directory that contains it, {tmp_path}" in refused(
        ["film", str(tmp_path / "results.h5"), "-o", "c.avi"], capsys
    )
    (tmp_path / "results.h5").unlink()
    assert "there is no run in it" in refused(["measures", str(tmp_path)], capsys)
    assert "is a directory; must be a scene file (TOML)" in refused(["run", str(tmp_path), "-o", run], capsys)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    assert "must be text in UTF-8" in refused(["mesh", str(tmp_path / "binary.toml")], capsys)
    assert not Path(run).exists()


def test_a_mesh_format_that_does_not_exist_is_refused(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    bar.save(tmp_path / "s.toml")
    assert main(["mesh", str(tmp_path / "s.toml"), "-o", str(tmp_path / "mesh.foo")]) == 2
    assert "mesh.foo: must have the suffix of a mesh format, e.g. .vtu" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run"], "the following arguments are required: SCENE"),
        (["run", "s.toml"], "required: -o/--output"),
        (["run", "s.toml", "-o", "x", "--threads", "0"], "0; must be a whole number from 1 to 1024."),
        (["run", "s.toml", "-o", "x", "--threads", "two"], "two; must be a whole number from 1 to 1024."),
        (["run", "s.toml", "-o", "x", "--threads", "99999999999"], "must be a whole number from 1 to 1024."),
        (["rnu"], "rnu; must be one of run, "),
        (["rnu"], 'Did you mean "run"? See plica --help.'),
        (["run", "s.toml", "-o", "x", "--resum3"], "unrecognized arguments: --resum3. See plica run --help"),
        (["video", "x.avi", "-o", "x", "--nonsense"], "usage: plica video "),
        (["video", "x.avi", "-o", "x", "--fps", "x"], "--fps: x; must be a number. See plica video --help"),
        (["film", "x", "-o", "x", "--size", "10.5,3"], "10.5,3; must be 2 whole numbers separated by commas"),
        (["--nonsense", "info"], "unrecognized arguments: --nonsense. See plica --help."),
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
    message = refused(
        ["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"], capsys, code=1
    )
    assert "Traceback" not in message


@pytest.mark.parametrize(
    ("changes", "hint"),
    [
        ({"contact": "multiplier"}, 'Did you mean "multipliers"?'),
        ({"mesh.larynx": "corse"}, 'must be one of coarse, demo, fine, finest, .* Did you mean "coarse"?'),
    ],
)
def test_the_name_of_a_choice_is_answered_with_the_nearest(changes: dict[str, str], hint: str) -> None:
    scene = plica.Scene(
        plica.Larynx(larynx="coarse"), "thesis_corrected", time=plica.Stepping(step="50 us", duration="1 ms")
    )
    with pytest.raises(plica.InvalidInput, match=hint.replace("?", r"\?")):
        scene.replace(changes)


def test_the_mark_at_the_head_of_a_file_is_no_key(tmp_path: Path, bar: plica.Scene) -> None:
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + bar.text().encode())
    assert plica.Scene.load(path) == bar
