"""The march through time: the only owner of a state that changes."""
