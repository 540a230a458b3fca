"""Runs as high-speed video, with the true motion of every pixel (docs/film.md)."""

from __future__ import annotations

from plica.film.clip import Clip, film
from plica.film.settings import Film
from plica.film.writing import write_film

__all__ = ["Clip", "Film", "film", "write_film"]
