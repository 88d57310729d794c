"""Bare grains and fines: modelled shapes, bodies of traced outlines, the user's own grains."""
