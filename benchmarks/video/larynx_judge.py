"""What `plica video` says of films of a larynx whose truth is known, and what it says where it is wrong.

    python -m benchmarks.video.larynx_judge                   all films, about 8 min
    python -m benchmarks.video.larynx_judge --quick           the issue films alone, 2 min
    python -m benchmarks.video.larynx_judge --only polyp      those that have this in their name
    python -m benchmarks.video.larynx_judge --drawn 30        others, whose features are drawn at random
    python -m benchmarks.video.larynx_judge -o DIR            keeps films and analyses in a new folder
    python -m benchmarks.video.larynx_judge --record          writes docs/records/video_larynx_judge.json,
                                                              of --drawn video_larynx_drawn.json

The films are those of `larynx_films.py`. A row a film and measure: truth, what is found, its interval, and

    held    the interval has the truth, or both say that there is no such measure
    near    not so, but within 0.5 px, 5 degrees, 3 % of frequency or area, 0.03 of a quotient
    said    off, but a caution on the measure or a doubt on the recording speaks of it, or it has no value
    SILENT  off, and nothing says so

Phases are in degrees, and those of the crests.

"Told": how many cautions the measure has, `steady` being the one that says how well edges are placed in
general, which is no news of a film; and `cause wrong` with what a caution names though the film has none.
Below are the cautions of each film, the sums, and how often the 95 % intervals hold the truth.
"""

from __future__ import annotations

import math
import re
import tempfile
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness.record import this_environment
from benchmarks.harness.study import keep, script_parser
from benchmarks.harness.table import markdown, show
from benchmarks.video.larynx_films import Film, drawn_films, issue_films, unseen_films
from benchmarks.video.larynx_renderer import Truth, render, truth
from plica import video

COLUMNS = ("film", "measure", "true", "found", "interval", "verdict", "told")
VERDICTS = ("held", "near", "said", "SILENT")
STEADY = re.compile(r"edges are placed to [\d.]+ px, and the lesser amplitude")
PHASE = "left_right_phase"

SPEAKS_OF = {
    "fundamental_frequency": r"frequenc|pitch|cycle|frames are",
    "open_quotient": r"quotient|clos|frames are",
    "glottal_area_max": r"area|outline|glottis",
    "glottal_area_mean": r"area|outline|glottis",
    "glottal_gap_index": r"gap|area|clos|outline|glottis",
    "amplitude_left": r"amplitude|left|folds? |edges",
    "amplitude_right": r"amplitude|right|folds? |edges",
    "amplitude_ratio": r"amplitude|left|right|folds? |edges",
    PHASE: r"phase|left|right|folds? |edges",
}
"""What a doubt on the whole recording has in it if it speaks of a measure."""


@dataclass(frozen=True)
class Found:
    """One measure as it is reported."""

    value: float | None
    interval: tuple[float, float] | None
    cautions: tuple[str, ...]

    def told(self) -> str:
        """How many cautions there are that speak of this film, and the steady one."""
        news = sum(not STEADY.search(text) for text in self.cautions)
        steady = "steady" if news < len(self.cautions) else ""
        return ", ".join(part for part in (str(news) if news else "", steady) if part)


@dataclass(frozen=True)
class Judged:
    """One measure of one film."""

    film: str
    issue: bool
    name: str
    true: float | None
    found: Found
    verdict: str
    wrong: tuple[str, ...]
    """Causes that cautions name and the film has not."""

    def row(self) -> list[object]:
        turn = math.degrees(1) if self.name == PHASE else 1.0
        interval = self.found.interval
        told = self.found.told() + "".join(f"; cause wrong: {cause}" for cause in self.wrong)
        between = "-" if interval is None else " to ".join(_number(turn * end) for end in interval)
        values = [None if value is None else turn * value for value in (self.true, self.found.value)]
        return [self.film, self.name, *map(_number, values), between, self.verdict, told.removeprefix("; ")]


def _number(value: float | None) -> str:
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.1f}" if abs(value) >= 100 else f"{value:.3f}" if abs(value) < 1 else f"{value:.2f}"


# ---- verdicts


def holds(name: str, interval: tuple[float, float] | None, true: float) -> bool:
    """To a millionth; a phase by whole turns."""
    if interval is None:
        return False
    low, high = interval
    if name == PHASE:
        true += 2 * math.pi * round(((low + high) / 2 - true) / (2 * math.pi))
    slack = 1e-6 * max(1.0, abs(true))
    return low - slack <= true <= high + slack


def is_near(name: str, true: dict[str, float | None], value: float) -> bool:
    """Whether the error is one that nobody needs to hear of."""
    wanted = true[name]
    if wanted is None:
        return False
    miss = abs(value - wanted)
    if name == PHASE:
        return abs(math.remainder(value - wanted, 2 * math.pi)) <= math.radians(5)
    if name == "amplitude_ratio":
        return miss <= 0.5 * max(1.0, wanted) / (true["amplitude_left"] or math.inf)
    if name.startswith("amplitude"):
        return miss <= 0.5
    if name in ("open_quotient", "glottal_gap_index"):
        return miss <= 0.03
    return miss <= 0.03 * wanted


def verdict(name: str, true: dict[str, float | None], found: Found, spoken: bool) -> str:
    wanted, value = true[name], found.value
    if value is None or not math.isfinite(value):
        return "held" if wanted is None else "said"
    if wanted is None:
        low, high = found.interval or (0.0, 0.0)
        free = name == PHASE and high - low >= 1.9 * math.pi
        return "held" if free else "said" if spoken else "SILENT"
    if holds(name, found.interval, wanted):
        return "held"
    if is_near(name, true, value):
        return "near"
    return "said" if spoken else "SILENT"


def causes(film: Film, true: Truth) -> dict[str, bool]:
    """What cautions may name, as a pattern, and whether the film has it."""
    picture = film.picture
    uneven = picture.lamp != 0.0
    gap = true.measures["glottal_gap_index"] or 0.0
    return {
        r"light from one side|\blamp": uneven,
        r"\bshad(?:e|ow|ing)": uneven or picture.corners,
        r"strand|mucus": picture.strand > 0,
        r"frames? (?:is|are) (?:missing|there twice|lost)|there twice": film.taken != "all",
        r"\bnois[ey]": picture.noise >= 5,
        r"\bdrift|endoscope (?:moves|moved|turns)": film.moves,
        r"epiglottis|false fold|is covered": picture.occluded > 0,
        r"never clos|does not close|a gap": gap > 0,
    }


def edge_blur(film: Film) -> float:
    """px, standard deviation of edges in the picture: of the lens, and of a pixel's own width."""
    return math.hypot(film.picture.blur, 1 / math.sqrt(12))


def wrong_causes(text: str, known: dict[str, bool], edges: float) -> tuple[str, ...]:
    """The words of a caution that names causes of which the film has none.

    A blur is one where the px that are said are those of the film's `edges`, to a tenth.
    """
    named = [
        (match.group(), there) for what, there in known.items() if (match := re.search(what, text, re.I))
    ]
    if blur := re.search(r"edges of the glottis are blurred by ([\d.]+) px", text):
        named.append((blur.group(), abs(float(blur.group(1)) - edges) <= 0.1 * edges))
    return () if any(there for _, there in named) else tuple(word for word, _ in named)


# ---- films


def report(film: Film, directory: Path) -> tuple[dict[str, Found], tuple[str, ...]]:
    """Each measure, and the doubts on the recording; a film that is refused has no value, and the reason."""
    path, names = directory / "film.npy", list(SPEAKS_OF)
    np.save(path, render(film))
    settings = video.Settings(fps=film.fps, correct_drift=film.moves)
    try:
        found = video.analyse(path, directory / "analysis", settings, until="glottis", progress=False)
    except video.VideoError as refused:
        return dict.fromkeys(names, Found(None, None, ())), (f"refused: {refused}",)
    made = {}
    for name in names:
        item = found.measures[name]
        interval = None if item.interval is None else (float(item.interval[0]), float(item.interval[1]))
        value = None if item.value is None else float(item.value)
        made[name] = Found(value, interval, tuple(item.cautions))
    return made, tuple(found.doubts)


def judged(film: Film, issue: bool, directory: Path) -> tuple[list[Judged], list[str]]:
    """Of each measure; and all that was said, each with the causes in it that are wrong."""
    true = truth(film)
    measured, doubts = report(film, directory)
    known, edges = causes(film, true), edge_blur(film)
    made = []
    for name, found in measured.items():
        spoken = bool(found.cautions) or any(re.search(SPEAKS_OF[name], text, re.I) for text in doubts)
        wrong = {cause for text in found.cautions for cause in wrong_causes(text, known, edges)}
        result = verdict(name, true.measures, found, spoken)
        made.append(Judged(film.name, issue, name, true.measures[name], found, result, tuple(sorted(wrong))))
    texts = dict.fromkeys([*doubts, *(text for found in measured.values() for text in found.cautions)])
    said = []
    for text in texts:
        marks = "".join(f" [cause wrong: {cause}]" for cause in wrong_causes(text, known, edges))
        said.append(f"{'doubt' if text in doubts else 'caution'}: {text}{marks}")
    return made, said


# ---- sums


def sums(made: Iterable[Judged], title: str) -> str:
    """Verdicts by measure; coverage of intervals that were given for a truth; right ones with a caution."""
    columns = [title, *VERDICTS, "intervals hold", "right, yet with news", "cause wrong"]
    rows, all_of = [], list(made)
    for name in (*SPEAKS_OF, "all"):
        chosen = [one for one in all_of if name in (one.name, "all")]
        count = Counter(one.verdict for one in chosen)
        known = [(one, one.true) for one in chosen if one.true is not None and one.found.value is not None]
        given = [(one, true) for one, true in known if one.found.interval is not None]
        hold = sum(holds(one.name, one.found.interval, true) for one, true in given)
        right = [one for one in chosen if one.verdict in ("held", "near")]
        news = sum(any(not STEADY.search(text) for text in one.found.cautions) for one in right)
        share = f"{hold} of {len(given)} ({100 * hold / max(1, len(given)):.0f} %)"
        wrong = sum(bool(one.wrong) for one in chosen)
        rows.append([name, *(count[what] for what in VERDICTS), share, f"{news} of {len(right)}", wrong])
    return markdown(columns, rows)


def chosen_films(options: Namespace) -> list[tuple[Film, bool]]:
    if options.drawn:
        return [(film, False) for film in drawn_films(options.drawn, options.seed)]
    films = [(film, True) for film in issue_films()]
    if not options.quick:
        films += [(film, False) for film in unseen_films()]
    if options.only:
        films = [(film, issue) for film, issue in films if any(part in film.name for part in options.only)]
    if not films:
        raise SystemExit(f"larynx_judge: --only {' '.join(options.only)}: no film has this in its name.")
    return films


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument(
        "--only", metavar="NAME", nargs="+", default=[], help="films with this in their names"
    )
    parser.add_argument("--quick", action="store_true", help="the issue films alone")
    parser.add_argument("--drawn", metavar="COUNT", type=int, default=0, help="so many films drawn at random")
    parser.add_argument("--seed", type=int, default=0, help="of these (default: 0)")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="new folder for films and analyses")
    parser.add_argument("--record", action="store_true", help="write a record of docs/records")
    options = parser.parse_args()
    films, environment = chosen_films(options), this_environment({})
    every: list[Judged] = []
    texts: dict[str, list[str]] = {}

    def rows(folder: Path) -> Iterator[list[object]]:
        for k, (film, issue) in enumerate(films):
            directory = folder / f"{k:02d}_{re.sub('[^a-z0-9]+', '_', film.name.lower()).strip('_')}"
            directory.mkdir(parents=True)
            made, texts[film.name] = judged(film, issue, directory)
            every.extend(made)
            yield from (one.row() for one in made)

    with tempfile.TemporaryDirectory() as temporary:
        folder = options.output or Path(temporary)
        if folder.exists() and any(folder.iterdir()):
            raise SystemExit(f"larynx_judge: -o {folder}: has files; take another folder.")
        table = show(COLUMNS, rows(folder))
    for film_name, said in texts.items():
        print(f"\n{film_name}", *(f"  {text}" for text in said), sep="\n")
    parts = {"issue": True, "unseen": False}
    groups = {title: [one for one in every if one.issue == issue] for title, issue in parts.items()}
    tables = [sums(group, title) for title, group in {**groups, "both": every}.items() if group]
    print("", *tables, sep="\n\n")
    if options.record:
        name = "video_larynx_drawn" if options.drawn else "video_larynx_judge"
        keep(name, COLUMNS, table, tables[-1], environment)


if __name__ == "__main__":
    main()
