"""How far the offline executor gets from wrong force fields, and what the two kinds of skill do."""
