"""inverse."""
