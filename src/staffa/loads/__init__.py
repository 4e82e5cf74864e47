"""What drives a body to crack."""
