"""Time loop: the only owner of a state that changes."""
