"""From a recipe to the files of a bed, a folder for each stage.

`make_bed` and `make_grains` go through the stages; the scripts beside this folder start them. A
stage imports from those before it in `STAGES`, never from those after it. The add-on
`soilsig_addon` imports from here, and nothing here imports from it. A test reads the imports
(tests/python/test_layers.py).
"""

STAGES = (
    "common",  # what all stages share
    "model",  # bare grains and fines: modelled shapes, and the user's own grains
    "dust",  # fines on grains
    "drop",  # dusty grains fall into the tray until they rest
    "check",  # whether the bed is to be trusted, and what it measures
    "export",  # the files
)
