"""A robot: parameters, URDF, joints."""
