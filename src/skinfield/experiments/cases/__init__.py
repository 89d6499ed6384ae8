"""Cases: readings beside their truth, made, posed, kept in files."""
