"""Laws and scales as small pure functions of anything with arithmetic."""
