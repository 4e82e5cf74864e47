"""Pictures of a run, drawn from what stands in its directory."""
