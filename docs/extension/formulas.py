"""Formulas as MathML, which browsers draw by themselves: no script, and nothing from elsewhere."""

from __future__ import annotations

from typing import Any

from latex2mathml.converter import convert
from sphinx.errors import ExtensionError


def setup(app: Any) -> None:
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))


def _mathml(tex: str, display: str, place: str) -> str:
    try:
        return str(convert(tex, display=display))
    except Exception as error:  # of several kinds, for what is not TeX
        raise ExtensionError(f"{place}: {tex!r} is no formula ({error!r})") from error


def _inline(writer: Any, node: Any) -> None:
    writer.body.append(_mathml(node.astext(), "inline", writer.builder.current_docname))


def _block(writer: Any, node: Any) -> None:
    if node["number"]:
        writer.body.append(f'<span class="eqno">({node["number"]})</span>')
    writer.body.append(
        f'<div class="math">{_mathml(node.astext(), "block", writer.builder.current_docname)}</div>'
    )
