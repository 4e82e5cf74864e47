"""Keys of a case file as typed, frozen models, and their text."""
