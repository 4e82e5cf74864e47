"""Pictures of a run, drawn from its directory."""

from staffa.backend.isolation import elsewhere

with elsewhere():
    import matplotlib  # noqa: F401 - before any module of it is loaded from the current folder
