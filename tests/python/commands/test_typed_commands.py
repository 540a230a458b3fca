"""Commands of README, docs and help texts, typed as they stand there."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import benchmarks.__main__ as benchmarks
import plica
from conftest import MOVIE
from flow_folds import folds
from picture_files import encoded
from plica.commands.main import _parser, main
from plica.synthetic.glottis import SyntheticGlottis
from typed_commands import FIRST_VOICE, ROOT, all_commands, help_commands, pages, python_blocks

FIRST_SESSION = (
    "plica examples scenes",
    "plica run scenes/first.toml -o runs/first",
    "plica uncertainty runs/first",
    "plica view runs/first",
    "plica film runs/first -o clip.avi",
    "plica sound runs/first -o voice.wav",
)
SCENE_SESSION = (
    "plica mesh scene.toml",
    "plica mesh scene.toml --picture glottis.svg",
    "plica mesh scene.toml -o mesh.vtu",
    "plica run scene.toml -o runs/one",
    "plica run scene.toml -o runs/one --resume",
    "plica measures runs/one",
    "plica measures runs/one --from 40ms --to 60ms",
    "plica measures runs/one --from 40ms",
    "plica report runs/one",
    "plica uncertainty runs/one --mesh none",
)
VIDEO_SESSION = (
    "plica glottis larynx.avi --fps 4000 -o analysis",
    "plica video larynx.avi --fps 4000 -o analysis",
    "plica report analysis --pdf",
    "plica masks analysis --page correct.html",
    "plica masks analysis -o drawn",
    "plica video larynx.avi --fps 4000 -o analysis --masks drawn",
    'plica video larynx.avi --fps 4000 -o before --label "patient 12, before" --recorded 2026-03-01 --pdf',
    "plica compare before after",
    "plica compare before after -o change",
)
PICTURES = (
    "plica flow frame10.png frame11.png -o ab.flo",
    "plica flow frame10.png frame11.png -o ab.flo --preset fast",
    "plica flow frame10.png frame11.png -o ab.flo --mask tissue.png",
)
FORMANTS = (
    "plica formants vowel.toml",
    "plica formants vowel.toml --to 4kHz -o formants.csv",
)
STABILITY = (
    "plica eigenmodes voice.toml",
    "plica eigenmodes voice.toml -o runs/modes --count 50",
    "plica onset voice.toml",
    'plica onset voice.toml --from "50 Pa" --to "2 kPa" -o runs/onset',
    'plica onset voice.toml --at "0.4 kPa"',
    "plica onset voice.toml --zeta 0.06",
)
QUESTIONS = (
    "plica examples",
    "plica keys",
    "plica keys airflow",
    "plica keys subglottal_pressure",
    "plica keys open_quotient",
    "plica keys measures",
    "plica keys combinations",
    "plica keys stiffness",
    "plica verify --list",
    "plica info",
    "plica info --licences",
    "python -m benchmarks list",
    "python -m benchmarks tables",
)
NOT_RUN = {
    r"make (demo|test|check|build|docs|wheel( WHEELS=.*)?)|\.ci/run|pip install .*": "builds or installs; "
    "CI runs them",
    r"plica sound runs/first -o first.wav": "the same under another name; the first session writes it",
    r"sudo apt-get .*|mkdir .*|cd .*|cp .*|cat > CMakeLists.txt.*|cmake .*|build/mine": "the program in "
    "C++: the consumer's section of CI builds and runs it",
    r"export PKG_CONFIG_PATH=.*|g\+\+ .*": "the same by pkg-config; a test of the consumer builds it",
    r"xdg-open .*|paraview .*|gimp .*": "a program with a window; the file that it opens is looked for",
    r"make bench-peers|\.venv-peers/.*": "installs other packages",
    r"python -m benchmarks (run|compare|page|impact|free|extremes|verification).*": "minutes to hours; "
    "benchmarks/test_bodies.py and benchmarks/test_extremes.py run each at small size",
    r"plica verify($| --subject| --json| -o).*": "half a minute each; verify/test_verify.py runs the cases",
    r"plica identify .*|plica video larynx.avi --preset robust .*": "minutes of identification; "
    "identify/test_command.py runs it",
    r"plica onset voice.toml --offset": "minutes of time steps; stability/test_offset.py has a reduced voice",
    r"plica larynx .*": "needs a frame of folds at rest; commands/test_larynx.py has one",
    r"plica uncertainty runs/(one|one --budget 8|own .*)|plica run .* --uncertainty": "the same again with "
    "other levels; uncertainty/test_meshes.py computes them",
    r"plica run (full|voice).toml .*|plica reduce (runs/(full|whole)|voice.toml) .*": "scenes of "
    "docs/reduction.md, such as "
    "runs/test_reduction_full_run.py runs",
    r"plica sound .* (--aspiration|--distance) .*": "the same sound otherwise; commands/test_sound.py has "
    "each option",
    r"plica view runs/first -o .*": "the same to another file; viewer/test_view.py has each option",
    r"plica film .* (--from|--size) .*": "films the same run otherwise; films/test_files.py has each option",
    r"plica video clip.avi .*": "a film of five cycles takes a minute; films/test_chain.py analyses one",
    r"plica video (frames/|larynx.cine|larynx.mp4|larynx.avi --fps 4000 --mm-per-px) .*": "the same on other "
    "files and settings; video/test_input.py reads each format, video/glottis/test_network.py has a "
    "segmenter",
    r"plica video (larynx.avi --from|day/\*.avi) .*": "a part, or many; video/test_tables.py has both",
    r"plica (masks analysis --frames|glottis larynx.avi -o analysis --masks|modes) .*": "need frame 120 and "
    "many cycles; video/glottis/test_frame_segmentation.py and video/motion/test_modes.py have them",
    r"plica video larynx.avi .*-o analysis --corrections corrections.json": "needs what a browser saves; "
    "video/test_corrections_browser.py has one",
    r"plica video larynx.avi .* --audio .*": "needs a sound; video/test_signals.py has one",
    r"plica flow .* --truth .*": "needs a known flow; video/motion/test_flow.py has one",
    r"plica run vowel.toml -o runs/.*|plica compare runs/bare runs/vowel -o change": "minutes of voice; "
    "commands/test_cli.py leaves a part out, commands/test_compare.py compares runs",
    r"plica sweep .*|dask .*": "many runs, and other machines; sweep/test_command.py types each option",
    r"plica exchange .*": "needs a run, and areas; exchange/test_driven_flow.py goes out and in",
    r"plica compare before after -o change --pdf": "as without --pdf; commands/test_compare.py has it",
}
"""What is not typed by these tests: a pattern of whole commands, and the reason."""

PYTHON = {
    "README.md": ("project/test_readme.py",),
    "docs/film.md": ("films/test_files.py",),
    "docs/identification.md": ("identify/test_docs.py", "identify/test_docs.py"),
    "docs/identification_filter.md": ("identify/test_docs.py",),
    "docs/image_mesh.md": ("here",),
    "docs/onset.md": ("here",),
    "docs/python.md": ("project/test_readme.py", "project/test_readme.py", "here"),
    "docs/recording_files.md": (
        "not run: needs a trained network; video/glottis/test_network.py has such files",
    ),
    "docs/sound.md": ("sound/test_docs.py",),
    "docs/sweeps.md": ("sweep/test_docs.py", "sweep/test_docs.py"),
    "docs/uncertainty.md": ("here",),
    "docs/view.md": ("viewer/test_view.py",),
}
"""Which tests run the Python blocks of each page."""

PROGRAMS = ("plica ", "python -m benchmarks ")
RUN = (*FIRST_SESSION, *SCENE_SESSION, *VIDEO_SESSION, *PICTURES, *FORMANTS, *STABILITY, *QUESTIONS)


def _typed(command: str) -> None:
    run, arguments = _program(command)
    assert run(arguments) == 0, command


def _program(command: str) -> tuple[Callable[[list[str]], int], list[str]]:
    """What runs a command, and its arguments."""
    words = shlex.split(command.split(" > ")[0])
    if words[:3] == ["python", "-m", "benchmarks"]:
        return benchmarks.main, words[3:]
    assert words[0] == "plica"
    return main, words[1:]


def test_every_command_shown_is_typed_here_or_left_out_with_a_reason() -> None:
    shown = all_commands()
    assert len(shown) > 80
    assert set(RUN) <= set(shown), sorted(set(RUN) - set(shown))
    for command in shown:
        reasons = [pattern for pattern in NOT_RUN if re.fullmatch(pattern, command)]
        assert (command in RUN) + bool(reasons) == 1, (command, reasons)
    for pattern in NOT_RUN:
        assert any(re.fullmatch(pattern, command) for command in shown), pattern


@pytest.mark.parametrize("command", [one for one in all_commands() if one.startswith(PROGRAMS)])
def test_every_command_shown_has_arguments_that_are_known(command: str) -> None:
    run, arguments = _program(command)
    parser = _parser() if run is main else benchmarks.parser()
    assert callable(parser.parse_args(arguments).command)


def test_the_first_session_begins_with_the_commands_that_are_typed_here() -> None:
    shown = [one for one in help_commands("plica") if one.startswith("plica ")]
    assert tuple(shown[: len(FIRST_SESSION)]) == FIRST_SESSION


def test_every_python_block_is_run_somewhere() -> None:
    shown = {str(page.relative_to(ROOT)): python_blocks(str(page.relative_to(ROOT))) for page in pages()}
    assert {page: len(blocks) for page, blocks in shown.items() if blocks} == {
        page: len(tests) for page, tests in PYTHON.items()
    }
    for page, tests in PYTHON.items():
        for test in {one for one in tests if one.endswith(".py")}:
            assert Path(page).name in (ROOT / "tests" / "python" / test).read_text(encoding="utf-8")


def test_python_that_fits_a_larynx_to_a_frame_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _typed("plica examples scenes")
    exec(compile(*python_blocks("docs/image_mesh.md"), "image_mesh.md", "exec"), {})


@pytest.mark.slow
def test_python_that_analyses_a_recording_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    encoded(Path("larynx.avi"), SyntheticGlottis(MOVIE).stack(), "rawvideo", "gray")
    names: dict[str, Any] = {}
    exec(compile(python_blocks("docs/python.md")[2], "python.md", "exec"), names)
    assert names["motion"].shape == (MOVIE.height, MOVIE.width, 2)


@pytest.mark.parametrize("page", ["onset", "reduction", "sweeps"])
def test_pages_that_name_a_scene_say_one(page: str) -> None:
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    assert "`voice.toml` is " in text
    lines = re.findall(r"`((?:voice|without|mesh\.larynx) = [^`]*)`", text)[:3]
    scene = plica.Scene.from_text("\n".join(lines), "voice.toml")
    assert scene.strain is None
    assert scene.mesh.larynx == "coarse"


@pytest.mark.parametrize("command", QUESTIONS)
def test_a_question_has_an_answer(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    _typed(command)
    assert len(capsys.readouterr().out) > 50


@pytest.mark.slow
def test_the_first_session_goes_as_it_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in FIRST_SESSION:
        _typed(command)
        if command == "plica examples scenes":
            small = FIRST_VOICE.format(duration="0.15 s", fields_from="0.148 s")
            (tmp_path / "scenes" / "first.toml").write_text(small)
    for name in (
        "runs/first/report.html",
        "runs/first/fields.xdmf",
        "runs/first/view.html",
        "clip.avi",
        "clip.truth.h5",
        "voice.wav",
    ):
        assert (tmp_path / name).is_file(), name


@pytest.mark.slow
def test_commands_on_a_scene_go_as_they_are_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(FIRST_VOICE.format(duration="0.3 s", fields_from="0.3 s"))
    for command in SCENE_SESSION:
        _typed(command)
    exec(compile(*python_blocks("docs/uncertainty.md"), "uncertainty.md", "exec"), {"plica": plica})


@pytest.mark.slow
def test_commands_on_a_voice_at_rest_go_as_they_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = folds(gap=1e-4)
    (tmp_path / "voice.toml").write_text(scene.text())
    for command in STABILITY:
        _typed(command)
    names = {"plica": plica, "scene": scene}
    exec(compile(*python_blocks("docs/onset.md"), "onset.md", "exec"), names)


def test_commands_on_a_tract_go_as_they_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("vowel.toml").write_text((ROOT / "examples" / "vowel.toml").read_text())
    for command in FORMANTS:
        _typed(command)
    assert "F1 " in capsys.readouterr().out
    assert Path("formants.csv").read_text().startswith("formant,frequency (Hz),bandwidth (Hz)")
    _typed("plica keys tract")
    _typed("plica keys trachea")


@pytest.mark.slow
def test_commands_on_a_recording_go_as_they_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    encoded(Path("larynx.avi"), SyntheticGlottis(MOVIE).stack(), "rawvideo", "gray")
    for command in VIDEO_SESSION:
        if command == "plica compare before after":
            (tmp_path / "analysis").rename("after")
        _typed(command)


@pytest.mark.slow
def test_commands_on_two_pictures_go_as_they_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    first, second, *_ = SyntheticGlottis(MOVIE).stack()
    for name, picture in (("frame10", first), ("frame11", second), ("tissue", np.full_like(first, 255))):
        Image.fromarray(_grey(picture)).save(f"{name}.png")
    for command in PICTURES:
        _typed(command)
        Path("ab.flo").unlink()


def _grey(picture: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.clip(picture, 0, 255).astype(np.uint8))
