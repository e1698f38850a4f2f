"""What is the paper's alone: tables, figures, claims, errata."""
