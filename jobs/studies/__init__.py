"""The published studies that jobs/study.py repeats, one module each."""
