"""Subcommands of ``plica``: help texts, arguments and actions."""
