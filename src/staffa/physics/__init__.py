"""Laws and scales as small pure functions of floats, arrays or forms."""
