"""Pages of reports: one HTML file that fetches nothing, and the same paged as PDF."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from plica.errors import InvalidInput
from plica.storage.files import replaced

__all__ = ["pdf_of", "render", "require_pdf", "write_page"]


def render(template: str, **values: Any) -> str:
    """A template of a room, ``video/report.html.j2``, filled in; what is missing raises UndefinedError.

    Those that extend ``report/base.html.j2`` need `title`, and `running`, the header of each printed page.
    """
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_source),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.filters["css"] = _css
    return environment.get_template(template).render(**values)


def _css(text: str) -> Markup:
    """A string of a style sheet: what is no letter or figure by its number, so that nothing can end it."""
    return Markup('"%s"') % Markup("".join(c if c.isalnum() else f"\\{ord(c):x} " for c in text))


def _source(name: str) -> str:
    room, _, file = name.rpartition("/")
    return files(f"plica.{room.replace('/', '.')}").joinpath(file).read_text(encoding="utf-8")


def write_page(text: str, path: Path) -> Path:
    """Write a page and return its path; a reader sees the old one or the new one, whole."""

    def fill(draft: Path) -> None:
        draft.write_text(text, encoding="utf-8")

    replaced(path, fill)
    return path


def require_pdf() -> Any:
    """The library that makes PDFs (WeasyPrint).

    Raises
    ------
    InvalidInput
        Where it is not installed, or lacks the system's Pango: to be asked before anything is computed.
    """
    from PIL import ImageFile

    truncated = ImageFile.LOAD_TRUNCATED_IMAGES
    try:
        import weasyprint
    except ImportError:
        raise InvalidInput(
            "PDF: WeasyPrint is not installed; must be for --pdf. Install it: pip install 'plica[pdf]'."
        ) from None
    except OSError as error:
        raise InvalidInput(
            f"PDF: WeasyPrint does not find a library of the system ({str(error).splitlines()[0]}); must. "
            "Install Pango: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0, or the like."
        ) from None
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = truncated  # WeasyPrint's import lets Pillow take broken pictures
    return weasyprint


def pdf_of(page: Path) -> Path:
    """Write a page that :func:`write_page` wrote as PDF beside it, on A4 with a running header; its path.

    Raises
    ------
    InvalidInput
        As :func:`require_pdf`.
    """
    weasyprint, path = require_pdf(), page.with_suffix(".pdf")
    within = weasyprint.urls.URLFetcher(allowed_protocols=("data",))  # the page fetches nothing

    def fill(draft: Path) -> None:
        weasyprint.HTML(string=page.read_text(encoding="utf-8"), url_fetcher=within).write_pdf(draft)

    replaced(path, fill)
    return path
