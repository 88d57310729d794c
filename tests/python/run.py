"""Runs every test_*.py of this folder with the Python inside Blender; fails if one fails."""

import os
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "blender_scripts"))
sys.dont_write_bytecode = True

tests = unittest.defaultTestLoader.discover(HERE)
result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(tests)
sys.stdout.flush()
if not result.wasSuccessful() or result.testsRun == 0:
    sys.exit(1)
