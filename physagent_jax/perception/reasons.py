"""Reasons why something is not observable, in words."""

CUT = "the object is cut off by the picture's border"
GONE = "the object is not in the picture"
FILLING = "the object fills the picture"
NO_DEPTH = "the object's depth is not known"
NO_SIZE = "the visible surface is too large to be the object's"
LOST = "too few points could be followed"
LOOSE = "the parts move too differently to share one rotation or stretch"
