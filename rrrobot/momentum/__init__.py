"""The fast form for prescribed legs: contact momentum, tabulated coefficients, lanes of gaits."""
