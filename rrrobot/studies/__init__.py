"""Many runs: comparison, sweeps, optimisation."""
