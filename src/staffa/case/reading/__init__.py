"""From TOML text to a case, or to one message."""
