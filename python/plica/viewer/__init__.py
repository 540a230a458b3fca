"""A run as a page on which the larynx can be turned, cut and played (docs/view.md)."""

from __future__ import annotations

from plica.viewer.page import write_view

__all__ = ["write_view"]
