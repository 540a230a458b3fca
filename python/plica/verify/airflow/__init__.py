"""The flow through the glottis and what it does to the tissue."""

from plica.verify.airflow import bernoulli, slits, work

__all__ = ["CASES"]

CASES = (*bernoulli.CASES, *slits.CASES, *work.CASES)
