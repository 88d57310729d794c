"""The drop: dusty grains fall into a tray as rigid bodies until they rest."""
