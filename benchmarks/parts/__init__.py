"""Named parts of public meshes, asked for by words where the names are taken away."""
