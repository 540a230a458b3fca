"""The likelihood of a recording and its derivatives."""
