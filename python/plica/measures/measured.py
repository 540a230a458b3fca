"""What is known of a quantity, in one shape for runs, recordings and identifications."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Measured"]


class Measured(Protocol):
    """A quantity of `Run.measures`, `Analysis.measures` or `Identification.measures`."""

    @property
    def name(self) -> str:
        """Of the catalogue, or of the parameter."""

    @property
    def value(self) -> float | None:
        """None if undefined."""

    @property
    def unit(self) -> str:
        """Of the value; "1" for a pure number."""

    @property
    def spread(self) -> float | None:
        """Standard deviation between cycles, which is no accuracy; None without averaging."""

    @property
    def uncertainty(self) -> float | None:
        """How far the value may be from the truth of its model, in its unit; None if it is not known."""

    @property
    def uncertainty_source(self) -> str:
        """What the uncertainty is of; empty without one."""

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % interval of the value; None for runs, and if it is not known."""

    @property
    def cautions(self) -> tuple[str, ...]:
        """Reasons to doubt the value."""
