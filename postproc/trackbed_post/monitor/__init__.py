"""Condition monitoring by one accelerometer on a sleeper: displacement, indicators, trains.

The chain follows the thesis "Model-based condition monitoring of railway switches and crossings".
Signals are vertical accelerations, upwards positive, m/s2, evenly sampled at `rate`, Hz; speeds are
in m/s.
"""
