"""The engine and the measures of this installation against closed forms: ``plica verify``.

A subject is a package of cases; a case says in one sentence what it proves and yields its checks, each a
value found by plica beside a reference that is written in the case: a closed form, a second algorithm, or a
published number. Nothing else in the package imports this room.
"""
