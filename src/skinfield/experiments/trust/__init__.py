"""Contacts you can trust: solvers on random unseen presses, beside the bound."""
