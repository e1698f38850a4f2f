"""Plots: of one trajectory, and the figures and tables of the paper. Matplotlib loads on use."""
