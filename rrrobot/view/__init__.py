"""Robot, ground and path in the browser."""
