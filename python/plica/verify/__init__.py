"""Verification of this installation's engine and measures against closed forms: ``plica verify``.

A subject is a package of cases; a case states in one sentence what it proves and yields its checks, each a
value computed by plica and a reference given in the case: a closed form, a second algorithm, or a published
number. Nothing else in the package imports this one.
"""
