"""Pages of reports: one self-contained HTML file, and the same as PDF."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from plica.errors import InvalidInput, library
from plica.storage.files import replaced

__all__ = ["pdf_of", "render", "require_pdf"]


def render(template: str, **values: Any) -> str:
    """Render a template of a package, ``video/report/page.html.j2``; missing values raise UndefinedError.

    Templates that extend ``report/base.html.j2`` need `title`, and `running`, the header of each printed
    page.
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
    """A CSS string, with all characters except letters and digits escaped."""
    return Markup('"%s"') % Markup("".join(c if c.isalnum() else f"\\{ord(c):x} " for c in text))


def _source(name: str) -> str:
    package, _, file = name.rpartition("/")
    return files(f"plica.{package.replace('/', '.')}").joinpath(file).read_text(encoding="utf-8")


def require_pdf() -> Any:
    """The library that writes PDFs (WeasyPrint).

    Raises
    ------
    InvalidInput
        If it is not installed, or Pango is missing; call this before a computation.
    """
    try:
        return library("weasyprint", "pdf", "A report as PDF (--pdf)")
    except OSError as error:
        raise InvalidInput(
            f"PDF: WeasyPrint does not find a system library ({str(error).splitlines()[0]}); must find it. "
            "Install Pango: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0, or similar."
        ) from None


def pdf_of(page: Path) -> Path:
    """Convert a page to PDF beside it, on A4 with a running header; returns its path.

    Raises
    ------
    InvalidInput
        As :func:`require_pdf`.
    """
    weasyprint, path = require_pdf(), page.with_suffix(".pdf")
    fetcher = weasyprint.urls.URLFetcher(allowed_protocols=("data",))  # the page is self-contained

    def fill(draft: Path) -> None:
        weasyprint.HTML(string=page.read_text(encoding="utf-8"), url_fetcher=fetcher).write_pdf(draft)

    replaced(path, fill)
    return path
