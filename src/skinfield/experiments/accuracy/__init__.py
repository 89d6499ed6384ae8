"""The accuracy table: solvers, models and quantities over indenters, places and loads."""
