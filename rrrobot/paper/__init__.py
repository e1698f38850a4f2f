"""What is the paper's alone: tables, figures, claims, errata."""

from rrrobot.paper.equations import PaperEquations, paper_equations

__all__ = ["PaperEquations", "paper_equations"]
