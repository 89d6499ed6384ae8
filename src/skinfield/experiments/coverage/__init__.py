"""Do intervals hold the truth as often as they say; learnt on some presses, tried on others."""
