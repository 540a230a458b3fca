"""What cameras write: every level of every depth is there, the rate is theirs, bad files are refused."""

from __future__ import annotations

import html
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from camera_files import cine, mraw
from picture_files import refused
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import VideoError, load
from plica.video.files.phantom import Phantom
from plica.video.files.photron import Photron
from plica.video.files.recording import Recording
from plica.video.files.sources import read

pytest.importorskip("pycine")


def levels(bits: int, count: int = 3) -> np.ndarray:
    """(count, 32, 48) every level of so many bits, or as many as there is room for, the ends among them."""
    random = np.random.default_rng(bits)
    frames = random.integers(0, 1 << bits, (count, 32, 48))
    frames[0].flat[: min(1 << bits, 1536)] = np.linspace(0, (1 << bits) - 1, min(1 << bits, 1536)).astype(int)
    return frames


def raw(source: Phantom | Photron) -> np.ndarray:
    return np.stack(list(read(source, 0, source.count)))


@pytest.mark.parametrize(("stored", "used"), [(8, 8), (10, 10), (12, 12), (16, 10), (16, 12), (16, 16)])
@pytest.mark.parametrize("side", ["Lower", "Higher"])
@pytest.mark.parametrize("kind", [".cih", ".cihx"])
def test_photron_gives_every_level(kind: str, side: str, stored: int, used: int, tmp_path: Path) -> None:
    frames = levels(used)
    header = mraw(tmp_path / f"x{kind}", frames, stored=stored, used=used, EffectiveBit_Side=side)
    for path in (header, header.with_suffix(".mraw")):
        found = Photron(path)
        assert np.array_equal(raw(found), frames)
        assert found.camera is not None
        assert (found.camera.fps, found.camera.date, found.camera.bits) == (4000, "2024/3/5 14:07", used)


@pytest.mark.parametrize(
    ("bits", "used", "packing"),
    [(8, 8, 0), (16, 10, 0), (16, 12, 0), (16, 14, 0), (16, 16, 0), (16, 12, 1024)],
)
def test_phantom_gives_every_level(bits: int, used: int, packing: int, tmp_path: Path) -> None:
    frames = levels(used)
    found = Phantom(cine(tmp_path / "x.cine", frames, bits=bits, used=used, packing=packing))
    assert np.array_equal(raw(found), frames)
    assert found.camera is not None
    assert (found.camera.fps, found.camera.bits) == (4000, used)
    assert found.camera.date == "2023-11-14 22:13:20 UTC"
    assert np.array_equal(next(read(found, 2, 3)), frames[2])


def test_packed_tens_of_phantom_become_twelve_linear_bits(tmp_path: Path) -> None:
    frames = levels(10)
    found = Phantom(cine(tmp_path / "x.cine", frames, bits=16, used=12, packing=256))
    twelve = raw(found)
    order = np.argsort(frames, axis=None)
    assert (np.diff(twelve.ravel()[order]) >= 0).all()
    assert np.unique(twelve).size > 1000
    assert 0 <= twelve.min() < 70
    assert 4000 < twelve.max() < 4096
    assert found.camera is not None
    assert found.camera.bits == 12


def test_colour_of_phantom_is_weighted(tmp_path: Path) -> None:
    colours = np.random.default_rng(1).integers(0, 256, (2, 20, 24, 3))
    found = raw(Phantom(cine(tmp_path / "x.cine", colours, bits=24)))
    assert found == pytest.approx(colours @ np.array([0.2989, 0.5870, 0.1140]), abs=1e-3)


@pytest.mark.parametrize(("bits", "used"), [(8, 8), (16, 12)])
def test_ffmpeg_reads_the_same_from_the_same_cine_file(bits: int, used: int, tmp_path: Path) -> None:
    import av

    path = cine(tmp_path / "x.cine", levels(used), bits=bits, used=used)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert 1 / stream.time_base == 4000
        form = "gray" if bits == 8 else "gray16le"
        seen = np.stack([frame.to_ndarray(format=form) for frame in container.decode(stream)])
    assert np.array_equal(seen >> (bits - used), raw(Phantom(path)))  # it fills the upper bits


def test_the_rate_is_that_of_the_frames_that_were_stored(tmp_path: Path) -> None:
    thinned = Phantom(cine(tmp_path / "x.cine", levels(8, 9), taken_every=4))
    assert thinned.camera is not None
    assert thinned.camera.fps == pytest.approx(1000, rel=1e-6)
    untimed = Phantom(cine(tmp_path / "y.cine", levels(8), taken_every=None, trigger=0, annotation=b"note"))
    assert untimed.camera is not None
    assert (untimed.camera.fps, untimed.camera.date) == (4000, None)
    stepped = Photron(mraw(tmp_path / "z.cih", levels(8), Save_Step=2))
    assert stepped.camera is not None
    assert stepped.camera.fps is None


@pytest.mark.parametrize("taken_every", [1, 4])
def test_a_gap_in_the_frames_times_is_refused(taken_every: int, tmp_path: Path) -> None:
    path = cine(tmp_path / "x.cine", levels(8, 9), taken_every=taken_every, gap=(6, 0.5))
    with pytest.raises(VideoError) as error:
        Phantom(path)
    step = taken_every / 4000
    for text in (
        f"from frame 5, at {5 * step:.6g} s, to frame 6 there are {0.5 + step:.4g} s",
        f"must be {step:.4g} s",
        "Cut the recording at the gap: store the frames up to 5, and those from 6 on",
    ):
        assert text in str(error.value)


def test_a_frame_that_is_missing_is_a_gap_and_a_clock_that_trembles_is_none(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=r"from frame 2, .* to frame 3"):
        Phantom(cine(tmp_path / "x.cine", levels(8, 9), gap=(3, 1 / 4000)))
    trembling = Phantom(cine(tmp_path / "y.cine", levels(8, 9), taken_every=2, gap=(3, 0.09 / 2000)))
    assert trembling.camera is not None
    assert trembling.camera.fps == pytest.approx(2000, rel=1e-6)


def test_a_rate_that_the_times_of_all_frames_belie_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        VideoError, match=r"states 4000 frames/s, and its frames' times 2000; must be the same"
    ):
        Phantom(cine(tmp_path / "x.cine", levels(8, 9), taken_every=2, taken=9))


GLOTTIS = SyntheticGlottis(
    Synthetic(height=64, width=64, frames=42, amplitude=(4, 4), opening=(2, 2), frequency=0.12, texture=10)
)


@pytest.mark.usefixtures("few_draws", "unrendered")
@pytest.mark.parametrize("kind", ["cine", "cih"])
def test_an_analysis_takes_the_cameras_rate_unless_another_is_given(kind: str, tmp_path: Path) -> None:
    deep = GLOTTIS.stack().astype(int) * 16  # twelve bits
    path = tmp_path / f"larynx.{kind}"
    cine(path, deep, bits=16, used=12) if kind == "cine" else mraw(path, deep, stored=16, used=12)
    out = tmp_path / "out"
    assert main(["glottis", str(path), "-o", str(out), "--no-drift", "--quiet"]) == 0
    found = load(out)
    assert found.settings.fps == 4000
    assert found.measures["fundamental_frequency"].value == pytest.approx(480, rel=0.03)
    page = (out / "report.html").read_text()
    assert "12 bits" in page
    day = {"cine": "2023-11-14", "cih": "2024-03-05"}[kind]
    assert found.described["recorded"] == day
    assert f"recorded {day} (by the file's date)" in html.unescape(page)
    np.save(tmp_path / "eight.npy", GLOTTIS.stack())
    scale = Recording.open(tmp_path / "eight.npy").scale
    assert Recording.open(path).scale == pytest.approx((16 * scale[0], 16 * scale[1]), abs=2)
    assert main(["glottis", str(path), "-o", str(out), "--no-drift", "--quiet", "--fps", "2000"]) == 0
    assert load(out).settings.fps == 2000
    assert "states 4000 frames/s, 2000 was given" in (out / "report.html").read_text()


# ---- What is refused ---------------------------------------------------------------------------

F = levels(8)


def cut(path: Path, size: int) -> Path:
    path.write_bytes(path.read_bytes()[:size])
    return path


def without(path: Path, suffix: str) -> Path:
    path.with_suffix(suffix).unlink()
    return path


FILES: dict[str, tuple[Callable[[Path], Path], str]] = {
    "text as cine": (lambda p: text(p / "x.cine"), "x.cine is cut off in its header"),
    "another file as cine": (
        lambda p: text(p / "x.cine", "BM" + "x" * 20000),
        "x.cine is no .cine file: it does not begin with CI",
    ),
    "cine cut in its header": (
        lambda p: cut(cine(p / "x.cine", F), 3000),
        "x.cine has 3000 bytes; must have",
    ),
    "cine cut in a frame": (
        lambda p: cut(cine(p / "x.cine", F), cine(p / "y.cine", F).stat().st_size - 700),
        "frame 2 is not whole. The 2 frames before it are",
    ),
    "raw colour": (lambda p: cine(p / "x.cine", F, compression=2, filters=3), "is raw colour or JPEG"),
    "unknown packing": (lambda p: cine(p / "x.cine", F, packing=512), "packed by method 512; must be"),
    "more than its bits": (
        lambda p: cine(p / "x.cine", levels(12), bits=16, used=10),
        "must be below 1024, as its header states 10 bits",
    ),
    "one frame": (lambda p: cine(p / "x.cine", F[:1]), "has 1 frame; must be two or more"),
    "no pixels": (lambda p: without(mraw(p / "x.cih", F), ".mraw"), "x.cih without x.mraw; must have it"),
    "no header": (
        lambda p: without(mraw(p / "x.cih", F), ".cih").with_suffix(".mraw"),
        "x.mraw without x.cih or x.cihx; must have it",
    ),
    "mraw cut": (
        lambda p: cut(mraw(p / "x.cih", F).with_suffix(".mraw"), 4000),
        "x.mraw has 4000 bytes; must have 4608, as x.cih states 3 frames of 48 x 32 px of 8 bits",
    ),
    "no width": (lambda p: mraw(p / "x.cih", F, Image_Width=None), "Image Width is missing; must be there"),
    "half a frame": (
        lambda p: mraw(p / "x.cih", F, Total_Frame="2.5"),
        'Total Frame = "2.5"; must be a whole',
    ),
    "nothing in a frame": (lambda p: mraw(p / "x.cih", F, Image_Height=0), 'Image Height = "0"; must be a'),
    "colour": (lambda p: mraw(p / "x.cih", F, Color_Type="Color"), 'Color Type = "Color"; must be Mono'),
    "fourteen bits": (
        lambda p: mraw(p / "x.cih", F, Color_Bit=14),
        "Color Bit = 14; must be 8, 10, 12 or 16",
    ),
    "deeper than stored": (
        lambda p: mraw(p / "x.cih", F, EffectiveBit_Depth=12),
        "EffectiveBit Depth = 12; must be in [1, 8]",
    ),
    "side": (lambda p: mraw(p / "x.cih", F, EffectiveBit_Side="Middle"), "must be Lower or Higher"),
    "brighter than its bits": (
        lambda p: mraw(p / "x.cih", levels(12), stored=16, used=12, EffectiveBit_Depth=10),
        "must be below 1024, as x.cih states 10 bits",
    ),
    "pictures beside": (
        lambda p: mraw(p / "x.cih", F, File_Format="TIFF"),
        'File Format = "TIFF"; must be MRaw',
    ),
    "no XML": (lambda p: broken_xml(p), "x.cihx has no camera's header"),
}


def text(path: Path, content: str = "no recording") -> Path:
    path.write_text(content)
    return path


def broken_xml(path: Path) -> Path:
    header = mraw(path / "x.cihx", F)
    header.write_bytes(header.read_bytes().replace(b"</frameInfo>", b""))
    return header


@pytest.mark.parametrize("kind", FILES)
def test_a_camera_file_that_would_mislead_is_refused(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, said = FILES[kind]
    out = tmp_path / "out"
    assert said in refused(["glottis", str(make(tmp_path)), "-o", str(out), "--quiet"], capsys)
    assert not out.exists()


def test_without_its_reader_it_is_said_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = cine(tmp_path / "x.cine", F)
    for name in {"pycine", *(name for name in sys.modules if name.startswith("pycine."))}:
        monkeypatch.setitem(sys.modules, name, None)
    said = refused(["glottis", str(path), "-o", str(tmp_path / "out")], capsys)
    assert "x.cine needs pycine-lite, which is not installed; must be: pip install 'plica[cine]'" in said
