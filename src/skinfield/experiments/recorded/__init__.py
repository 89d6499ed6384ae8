"""What recordings and measurements of others say."""
