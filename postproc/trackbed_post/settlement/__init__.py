"""Settlement over cycles of load and trains: laws, their fit, and a forecast for a traffic."""
