"""Runs the package without installing it: python3 postproc COMMAND ..."""
import sys

from trackbed_post.__main__ import main

sys.exit(main())
