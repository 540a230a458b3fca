"""From a likelihood to a posterior."""
