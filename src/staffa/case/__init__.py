"""Cases: what a TOML file says, the ready ones, and how they become problems and runs."""
