"""Time per substep and per job of our simulator and of its peers, on identical particles, in interleaved rounds."""
