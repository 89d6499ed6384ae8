"""Page: skins in the browser, alive."""
