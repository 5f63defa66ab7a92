"""One photo as an object: cut out, lifted to Gaussians, and seen again from the camera that took it."""
