"""Ready cases that come with staffa."""
