"""The room of `window` with a pane of glass in its window."""

import kit
import window


def build(directory):
    sky = window.build(directory)
    glass = kit.material("glass", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5)
    kit.box(glass, (2.546, -0.8, 0.9), (2.554, 0.8, 2.1))
    return sky
