"""The tables, figures and claims of the paper, made anew and set beside what it prints."""
