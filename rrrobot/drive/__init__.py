"""What moves and brakes the joints: gaits, moves, torque laws, damping."""
