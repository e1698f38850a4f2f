"""Rest, small oscillations."""
