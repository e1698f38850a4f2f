"""Groups of options that commands share, each a dataclass that knows what its options stand for."""
