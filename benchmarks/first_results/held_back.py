"""Pairs on objects that nothing was developed with. They were written before any was run, and are never changed."""

from __future__ import annotations

from benchmarks.first_results.cases import Case, Thing
from benchmarks.first_results.objects import FILES

_OPTIONS = {"plane": ("--up", "+z")}  # a preview shows it standing on a wing

THINGS = {
    name: Thing(file.credit, file.name, options=_OPTIONS.get(name, ()), pinned=file)
    for name, file in FILES.items()
}

SIXTY = (
    Case("teapot", "tip the teapot over to the right", "tip"),
    Case("teapot", "pull the teapot's spout to the right", "push part"),
    Case("teapot", "a teapot made of rubber falls on the floor and bounces", "drop material"),
    Case("teapot", "lift the teapot by its handle", "lift part"),
    Case("armadillo", "the armadillo jumps up and lands again", "jump"),
    Case("armadillo", "pull the armadillo's right arm down", "push part"),
    Case("armadillo", "knock the armadillo over backwards", "hit tip"),
    Case("duck", "squeeze the rubber duck and let go", "squeeze material"),
    Case("duck", "the duck rocks gently from side to side", "sway slight"),
    Case("duck", "pull the duck's head up", "stretch part"),
    Case("penguin", "the penguin sways from side to side", "sway"),
    Case("penguin", "a gust of wind topples the penguin", "wind tip"),
    Case("penguin", "lift the penguin's left wing", "lift part"),
    Case("penguin", "a penguin made of jelly wobbles", "sway material"),
    Case("koala", "push the koala forward", "push"),
    Case("koala", "pull the koala's ears up", "stretch part"),
    Case("koala", "a koala made of snow falls to the ground", "drop material"),
    Case("cat", "bend the cat's tail to the left", "bend part"),
    Case("cat", "the cat's tail sways slowly to and fro", "sway part"),
    Case("cat", "throw the cat up into the air", "throw"),
    Case("cat", "a bronze cat falls to the ground", "drop material"),
    Case("hand", "bend the fingers back", "bend part"),
    Case("hand", "push the thumb down", "push part"),
    Case("hand", "a wooden hand is knocked over", "hit tip material"),
    Case("fish", "the fish wags its tail", "sway part"),
    Case("fish", "the fish floats slowly upwards", "lift slight"),
    Case("fish", "throw the fish to the left", "throw"),
    Case("hammer", "the hammer spins around on the ground", "spin"),
    Case("hammer", "a steel hammer falls on the floor", "drop material"),
    Case("hammer", "lift the hammer by the end of its handle", "lift part"),
    Case("boot", "kick the leather boot to the right", "hit material"),
    Case("boot", "twist the boot", "twist"),
    Case("boot", "press down on the toe of the boot", "squeeze part"),
    Case("plane", "the plane takes off and flies to the right", "push lift"),
    Case("plane", "bend the wings of the plane upwards", "bend part"),
    Case("plane", "the plane slowly rolls over in the air", "roll spin slight"),
    Case("plane", "hit the tail of the plane from the left", "hit part"),
    Case("man", "the man falls over forwards", "tip"),
    Case("man", "pull the man's right arm up", "push part"),
    Case("man", "stretch a man made of rubber until he is taller", "stretch material"),
    Case("man", "shove the man hard to the left", "push violent"),
    Case("scorpion", "pull the scorpion's tail to the right", "push part"),
    Case("scorpion", "shake the scorpion", "sway"),
    Case("scorpion", "flip the scorpion onto its back", "tip"),
    Case("monkey", "squash a monkey head made of clay", "squeeze material"),
    Case("monkey", "pull both ears of the monkey outwards", "stretch part"),
    Case("monkey", "roll the monkey head to the left", "roll"),
    Case("truck", "the truck drives forward", "push"),
    Case("truck", "a heavy blow dents the roof of the truck", "hit part"),
    Case("truck", "lift the truck up, then drop it", "lift drop sequence"),
    Case("tree", "a storm bends the tree to the right", "bend wind violent"),
    Case("tree", "the crown of the tree sways in a light breeze", "sway wind slight part"),
    Case("tree", "shake the tree", "sway"),
    Case("tree", "a rubber tree is bent far to the left and springs back", "bend material"),
    Case("biker", "someone pushes the biker from the right", "push"),
    Case("biker", "turn the biker around by 180 degrees", "spin quantity"),
    Case("biker", "a very strong wind blows the biker away", "wind violent"),
    Case("chair", "tip the chair over backwards", "tip"),
    Case("chair", "push the backrest of the chair forward", "push part"),
    Case("chair", "squash a chair made of foam", "squeeze material"),
)

TWENTY = (
    Case("goat", "bend the goat's left horn to the side", "bend part"),
    Case("goat", "turn the goat's head to the left", "spin"),
    Case("goat", "a goat head made of clay falls on the floor", "drop material"),
    Case("goat", "shake the goat head", "sway"),
    Case("barrel", "knock the barrel over", "hit tip"),
    Case("barrel", "crush a steel barrel from above", "squeeze material"),
    Case("barrel", "spin the barrel around", "spin"),
    Case("barrel", "hit the top of the barrel from the right", "hit part"),
    Case("cannon", "push the cannon backwards", "push"),
    Case("cannon", "the muzzle of the cannon is lifted", "lift part"),
    Case("cannon", "the cannon jumps back as it fires", "hit jump"),
    Case("cannon", "twist a cannon made of rubber", "twist material"),
    Case("lumberjack", "a strong wind blows the lumberjack over", "wind tip"),
    Case("lumberjack", "raise the lumberjack's axe", "lift part"),
    Case("lumberjack", "the lumberjack hops on the spot", "jump"),
    Case("lumberjack", "pull the lumberjack's head to the left", "push part"),
    Case("bust", "tilt the bust to the left", "tip"),
    Case("bust", "lift the bust up and set it down gently", "lift sequence slight"),
    Case("bust", "someone taps a bust made of jelly and it wobbles", "hit sway material"),
    Case("bust", "push the top of the bust's crown to the right", "push part"),
)
