"""Cameras, and the points of surfaces that they see at pixels."""
