"""The colours of a bed's materials in files for other programs."""

import colorsys


def colours(materials):
    """Sand tones, told apart by hue and lightness: red, green and blue of each material."""
    shares = [i / max(len(materials) - 1, 1) for i in range(len(materials))]
    return [
        colorsys.hsv_to_rgb(0.13 - 0.09 * share, 0.12 + 0.55 * share**0.5, 0.95 - 0.6 * share)
        for share in shares
    ]
