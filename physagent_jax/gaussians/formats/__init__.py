"""File formats of 3D Gaussians; one file each."""
