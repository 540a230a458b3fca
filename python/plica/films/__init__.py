"""Runs as high-speed video, with the true motion of every pixel (docs/film.md)."""

from __future__ import annotations

from plica.films.clip import Clip, film
from plica.films.settings import Film
from plica.films.writing import write_film

__all__ = ["Clip", "Film", "film", "write_film"]
