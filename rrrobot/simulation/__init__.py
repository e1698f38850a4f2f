"""Integrate a model in time, and what comes out."""
