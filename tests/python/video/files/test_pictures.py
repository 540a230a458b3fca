"""Pictures that would give a wrong flow are refused in one sentence, or are read as bright as they mean."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFile

import plica
from picture_files import (
    MAP,
    NAN,
    SHAPE,
    A,
    B,
    animated,
    colour_png,
    cut_after_the_first,
    deep,
    nothing,
    one_page_of_many,
    refused,
    stored,
    text,
    tiff,
    truncated,
    two_pages,
)
from plica.commands.main import main
from plica.video.files.image_file import read_image
from plica.video.files.recording import Recording
from plica.video.files.sources import read

PAIRS: dict[str, tuple[np.ndarray, np.ndarray, str]] = {
    "8 beside 16 bits": (A, deep(B), "second has 16-bit numbers; must have 8-bit numbers like first"),
    "16 beside 8 bits": (deep(A), B, "second has 8-bit numbers; must have 16-bit numbers like first"),
    "8 bits beside floats": (A, B / np.float32(255), "second has floating-point numbers; must have 8-bit"),
    "1 beside 8 bits": (A > 127, B, "second has 8-bit numbers; must have 1-bit numbers like first"),
    "a constant first": (np.full_like(A, 70), B, "every pixel of first is 70; must differ somewhere."),
    "a constant second": (A, np.full_like(A, 70), "every pixel of second is 70; must differ somewhere."),
    "not a number": (A.astype(np.float32), NAN, "second has nan at row 3, column 4 (1 such pixels)"),
    "sizes": (A, B[:20], "second is 48 x 20 px; must be 48 x 32 px like first"),
}


@pytest.mark.parametrize("kind", PAIRS)
def test_two_pictures_that_are_no_pair_are_refused(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second, said = PAIRS[kind]
    with pytest.raises(plica.InvalidInput) as caught:
        plica.flow(first, second)
    assert said in str(caught.value)
    kinds = {first.dtype.kind, second.dtype.kind}
    names = [stored(tmp_path / f"{name}.{'tif' if 'f' in kinds else 'png'}", picture)
             for name, picture in (("a", first), ("b", second))]  # fmt: skip
    out = tmp_path / "ab.flo"
    assert said in refused(["flow", *map(str, names), "-o", str(out)], capsys)
    assert not out.exists()


def test_a_frame_is_to_differ_where_the_mask_leaves_it_and_on_given_levels_too() -> None:
    mask = np.zeros(SHAPE, bool)
    mask[:10, :10] = True
    plain = B.copy()
    plain[:10, :10] = 9
    with pytest.raises(plica.InvalidInput, match="second that the mask leaves is 9; must differ somewhere"):
        plica.flow(A, plain, mask=mask)
    with pytest.raises(plica.InvalidInput, match="every pixel of second is 70; must differ somewhere"):
        plica.flow(A, np.full_like(A, 70), intensity=(0.0, 255.0))


@pytest.mark.parametrize(
    ("other", "cautioned"), [(B, False), (np.random.default_rng(0).permuted(A), True), (A[::-1] // 9, True)]
)
def test_a_flow_that_does_not_come_back_is_cautioned_even_if_quiet(
    other: np.ndarray, cautioned: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [str(stored(tmp_path / "a.png", A)), str(stored(tmp_path / "b.png", other))]
    assert main(["flow", *names, "-o", str(tmp_path / "ab.flo"), "--quiet"]) == 0
    said = capsys.readouterr().err
    assert ("this flow is not to be trusted" in said) == cautioned
    assert said.count("\n") == cautioned


PICTURES: dict[str, tuple[str, Callable[[Path], Path], str]] = {
    "two pages": ("x.tif", two_pages, "has 2 frames; must have one."),
    "two pages under another name": ("x.png", two_pages, "has 2 frames; must have one."),
    "many in one page": ("x.tif", one_page_of_many, "holds 3 pictures in 1 page; must have a page a picture"),
    "cut pages": ("x.tif", cut_after_the_first, "ends after page 1 and states more of them. It is cut off"),
    "animation": ("x.png", animated, "has 2 frames; must have one."),
    "text": ("x.png", text, "is not a picture; must be PNG, TIFF, JPEG"),
    "no bytes": ("x.png", nothing, "is empty: 0 bytes; must be a picture."),
    "cut": ("x.png", truncated, "cannot be read: image file is truncated"),
    "16 bits a colour": (
        "x.png",
        lambda path: colour_png(path, deep(A)),
        "has 16 bits a colour; must be grey, or have 8, or be a TIFF.",
    ),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_what_is_not_one_picture_is_refused(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, make, said = PICTURES[kind]
    bad, good = str(make(tmp_path / name)), str(stored(tmp_path / "good.png", A))
    out = ["-o", str(tmp_path / "ab.flo")]
    assert said in refused(["flow", good, bad, *out], capsys)
    assert said in refused(["flow", good, good, "--mask", bad, *out], capsys)
    assert not (tmp_path / "ab.flo").exists()


def test_a_cut_picture_is_refused_whatever_other_libraries_have_pillow_accept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ImageFile, "LOAD_TRUNCATED_IMAGES", True)
    bad, good = str(truncated(tmp_path / "x.png")), str(stored(tmp_path / "good.png", A))
    assert "image file is truncated" in refused(["flow", good, bad, "-o", str(tmp_path / "ab.flo")], capsys)
    assert ImageFile.LOAD_TRUNCATED_IMAGES  # theirs


TIFFS: dict[str, tuple[Callable[[Path], Path], np.ndarray]] = {
    "white is 0, 8 bits": (lambda path: tiff(path, 255 - A, photometric="miniswhite"), A),
    "white is 0, 16 bits": (lambda path: tiff(path, 65535 - deep(A), photometric="miniswhite"), deep(A)),
    "palette": (
        lambda path: tiff(path, 255 - A, photometric="palette", colormap=MAP.astype(np.uint16)),
        A,
    ),
    "a plane a colour": (
        lambda path: tiff(path, np.stack([A] * 3), photometric="rgb", planarconfig="separate"),
        A,
    ),
    "16 bits a colour": (
        lambda path: tiff(path, np.stack([deep(A)] * 3, axis=-1), photometric="rgb"),
        deep(A),
    ),
    "colour and alpha": (
        lambda path: tiff(
            path,
            np.stack([A, A, A, np.full_like(A, 9)], axis=-1),
            photometric="rgb",
            extrasamples=["unassalpha"],
        ),
        A,
    ),
    "double precision": (lambda path: tiff(path, A.astype(float), photometric="minisblack"), A),
    "big-endian": (lambda path: tiff(path, deep(A), photometric="minisblack", byteorder=">"), deep(A)),
    "12 of 16 bits": (lambda path: tiff(path, A.astype(np.uint16) * 16, photometric="minisblack"), 16.0 * A),
}


@pytest.mark.parametrize("kind", TIFFS)
def test_a_tiff_is_read_as_bright_as_it_means(kind: str, tmp_path: Path) -> None:
    make, truth = TIFFS[kind]
    assert read_image(make(tmp_path / "x.tif")) == pytest.approx(truth, rel=2e-4)  # weights sum to 0.9999


@pytest.mark.parametrize("photometric", ["miniswhite", "palette"])
def test_frames_of_a_tiff_stack_are_as_bright_as_they_mean(photometric: str, tmp_path: Path) -> None:
    truth = np.stack([A, B, A, B])
    options = {"colormap": MAP.astype(np.uint16)} if photometric == "palette" else {}
    found = Recording.open(tiff(tmp_path / "x.tif", 255 - truth, photometric=photometric, **options))
    for seen, meant in zip(read(found.source, 0, 4), truth, strict=True):
        assert seen == pytest.approx(meant, rel=2e-4)


def test_a_tiff_stack_packed_by_a_codec_that_only_pillow_knows_is_read(tmp_path: Path) -> None:
    pages = [Image.fromarray(picture) for picture in (A, B)]
    pages[0].save(tmp_path / "x.tif", save_all=True, append_images=pages[1:], compression="tiff_lzw")
    found = Recording.open(tmp_path / "x.tif")
    assert [np.array_equal(seen, truth) for seen, truth in zip(read(found.source, 0, 2), (A, B), strict=True)]
    assert np.array_equal(next(read(found.source, 1, 2)), B)
