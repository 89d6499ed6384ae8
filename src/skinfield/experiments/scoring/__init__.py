"""How far an estimate is off, how far it must be, and what many errors say together."""
