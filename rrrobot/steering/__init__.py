"""From a wanted motion to leg motions."""
