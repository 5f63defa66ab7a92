"""A compiled scene, simulated and rendered into a recording; frames that two scenes share are reused."""
