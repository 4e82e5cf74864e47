"""Heat equation: conduction, boundary conditions, and temperature from one time to the next."""
