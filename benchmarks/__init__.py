"""Programs that make the figures in the documents; each writes JSON."""
