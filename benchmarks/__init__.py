"""Measurements, each a module that prints, writes benchmarks/results/*.json and can be rerun."""
