"""Surfaces, and how they roll."""
