"""Wire: bytes of boards and buses, and the live sources that read them."""
