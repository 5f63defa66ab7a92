"""Priors by kind: material, damping and anchor, with reasons that a report can give.

Stiffness is chosen for visible motion, not measured: at true scale a wooden guitar (E = 1e10 Pa) neither bends
visibly nor allows a time step above a microsecond. With an object about 1 m long, a load of one body weight
gives the strain rho g L / E, so that the values below put kinds in order, from a few tenths (jelly) to a few
per cent (instrument). Densities are those of the real matter including its pores, within [50, 2000] kg/m^3.

Matter that does not spring back has its own law. Its strength, too, is chosen against the weight of 1 m, rho g L:
clay and metal bear their own weight and are dented by a fall from half a body length, which presses with rho c v,
several times that. `scene.materials` holds true values.

Damping ratios do not depend on stiffness and are those of the real matter, to within a factor of two, as the sources
of loss factors differ: Lakes 2009, Viscoelastic Materials; Cremer, Heckl & Petersson 2005, Structure-Borne Sound;
Allard & Atalla 2009, Propagation of Sound in Porous Media; Bucur 2006, Acoustics of Wood; Fung 1993, Biomechanics;
Clark & Ross-Murphy 1987, Adv. Polym. Sci. 83, 57; Moore & Maguire 2005, Trees 19, doi 10.1007/s00468-004-0387-y.
"""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Collection, Mapping
from typing import Literal

from physagent_jax.core.names import explain_unknown_name
from physagent_jax.core.reading import read_packaged_yaml
from physagent_jax.scene.config import Anchor, Material, MaterialModel

UNKNOWN = "object"
# "A pile of sand" is sand: such words tell an amount, not a kind.
_AMOUNTS = frozenset(
    ("pile", "heap", "mound", "lump", "block", "piece", "chunk", "slab", "slice", "bit", "blob", "drop", "puddle",
     "stack", "handful", "pinch", "cube", "sphere", "column")
)  # fmt: skip
_SUBSTANCES = frozenset(("sand", "snow", "clay", "liquid"))  # "a coffee grinder" is none of them
_FILE_WORDS = frozenset(
    ("ply", "splat", "spz", "sog", "obj", "glb", "gltf", "off", "stl", "mesh", "model", "scan", "splats", "low", "high",
     "poly", "lowpoly", "highpoly", "resolution", "final", "test")
)  # fmt: skip
_DEFINITE = frozenset(("the", "this", "that", "my", "your", "our", "his", "her", "their"))
_ARTICLES = _DEFINITE | {"a", "an"}
_PLACED = frozenset(
    ("on", "onto", "in", "into", "against", "with", "by", "from", "off", "at", "under", "like", "as", "near", "behind",
     "beside", "through", "to")
)  # fmt: skip
_PREPOSITIONS = frozenset(("of", "in", "on", "with", "at", "from", "for", "by", "under", "near"))


@dataclasses.dataclass(frozen=True)
class Prior:
    """Defaults of one kind.

    Attributes:
        words: Nouns that name it (singular).
        youngs_modulus: [Pa].
        poissons_ratio: nu.
        density: [kg/m^3].
        reason: Why these values.
        rooted: Whether the foot is held unless the prompt says otherwise or a motion needs the object free
            (`motion.holds`); the reason, or None.
        base_fraction: Height of the held foot over the object's.
        damping_rate: Drag of the surrounding air on it [1/s].
        damping_ratio: Share of critical damping of its lowest mode (`scene.damping`), half the loss factor; 0 where
            yielding, friction or viscosity stop it anyway. Where an object is held, what the air takes is part of it.
        hard: Whether nobody sees the real matter deform under such loads; the stiffness is then a stand-in for motions
            that ask for a change of shape (`run.rigidity`). A robot's joints give.
        damping_source: Where that ratio is from.
        model: Constitutive model.
        parameters: Its own parameters, as in `Material`.
    """

    words: tuple[str, ...]
    youngs_modulus: float
    poissons_ratio: float
    density: float
    reason: str
    rooted: str | None = None
    base_fraction: float = 0.12
    damping_rate: float = 0.0
    damping_ratio: float = 0.0
    damping_source: str = ""
    hard: bool = False
    model: MaterialModel = MaterialModel.NEO_HOOKEAN
    parameters: Mapping[str, float] = dataclasses.field(default_factory=dict)


# Every word belongs to one kind.
PRIORS: dict[str, Prior] = {
    "jelly": Prior(
        ("jelly", "jello", "gelatin", "gelatine", "pudding", "panna", "flan", "slime", "gel", "tofu"),
        6e4, 0.42, 1000.0,
        "a gel is mostly water (1000 kg/m^3, nearly incompressible); table gelatine has E of 1 to 20 kPa at 10 cm, "
        "ten times that at 1 m sags and quivers alike (E / rho g L is what matters)",
        damping_ratio=0.05,
        damping_source="a gel stores ten times what it loses or more (Clark & Ross-Murphy 1987): a loss factor of 0.1",
    ),
    "plant": Prior(
        ("plant", "ficus", "flower", "tree", "bonsai", "rose", "tulip", "carnation", "orchid", "cactus", "bush",
         "shrub", "fern", "grass", "leaf", "sunflower", "alocasia", "oak", "pine", "fir", "spruce", "birch", "maple",
         "willow", "palm", "cedar", "sapling", "conifer"),
        2.5e5, 0.3, 150.0,
        "green stems and leaves with the air between them (150 kg/m^3); stiffness chosen so that a tree of 1 m "
        "sways at between 1 and 2 Hz, as real ones do",
        rooted="plants are rooted: the pot or the foot of the stem does not move",
        base_fraction=0.2,
        damping_rate=1.2,  # drag of the leaves: at 1.2 Hz a ratio of 1.2 / (2 omega) = 0.08
        damping_ratio=0.2,
        damping_source="trees in leaf have ratios from 0.08 to nearly 1, bare ones 0.01 to 0.08 (Moore & Maguire 2005)",
    ),
    "food": Prior(
        ("loaf", "bread", "cake", "food", "bun", "toast", "muffin", "donut", "doughnut", "cookie", "burger",
         "sandwich", "pizza", "pancake", "baguette", "pie", "cheese", "hotdog", "corndog"),
        5e4, 0.25, 250.0,
        "bread is an open foam (250 kg/m^3, low nu); crumb has E of 2 to 30 kPa",
        damping_ratio=0.1,
        damping_source="crumb is a soft open foam: as upholstery foam",
    ),
    "pillow": Prior(
        ("pillow", "cushion", "bolster", "mattress", "sofa", "couch", "beanbag", "sponge", "foam", "marshmallow"),
        1.5e4, 0.2, 60.0,
        "upholstery foam: 20 to 80 kg/m^3, E of 10 to 50 kPa, nearly no lateral strain",
        damping_ratio=0.1,
        damping_source="flexible polyurethane foam has loss factors of 0.1 to 0.3 (Allard & Atalla 2009)",
    ),
    "cloth": Prior(
        ("cloth", "fabric", "towel", "flag", "curtain", "shirt", "dress", "scarf", "blanket", "rope", "ribbon"),
        1e4, 0.2, 200.0,
        "soft enough to fold; cells are thicker than any cloth, so E stands for bending, chosen for visible motion",
        damping_ratio=0.1,
        damping_source="yarns rub on each other: as soft foam, an estimate",
    ),
    "ball": Prior(
        ("ball", "balloon", "basketball", "football", "globe"),
        5e4, 0.35, 200.0,
        "a soft rubber ball that squashes visibly when it lands; chosen for visible motion",
        damping_ratio=0.05,
        damping_source="rubber has loss factors about 0.1 (Lakes 2009)",
    ),
    "animal": Prior(
        ("animal", "cow", "spot", "bunny", "rabbit", "bear", "wolf", "dog", "cat", "horse", "duck", "bird", "fish",
         "dragon", "elephant", "pig", "sheep", "fox", "lion", "frog", "dinosaur", "armadillo"),
        4e4, 0.4, 500.0,
        "soft tissue or a plush toy: muscle at rest has E of 10 to 100 kPa; chosen for visible motion",
        damping_ratio=0.1,
        damping_source="soft tissue loses a fifth of what it stores in a cycle or more (Fung 1993)",
    ),
    "instrument": Prior(
        ("guitar", "violin", "cello", "ukulele", "banjo", "instrument", "drum", "piano", "trumpet"),
        2e5, 0.3, 300.0,
        "a hollow wooden body (300 kg/m^3); wood is 1e5 times stiffer: chosen for visible motion",
        damping_ratio=0.01,
        damping_source="spruce and maple have loss factors of 0.01 to 0.02 (Bucur 2006)",
        hard=True,
    ),
    "robot": Prior(
        ("robot", "playbot", "android", "drone", "mech", "droid", "machine"),
        1e5, 0.3, 300.0,
        "a hollow shell as of plastic (300 kg/m^3); plastic is 1e4 times stiffer: chosen for visible motion",
        damping_ratio=0.02,
        damping_source="stiff plastics have loss factors of 0.01 to 0.1 (Lakes 2009)",
    ),
    "furniture": Prior(
        ("chair", "table", "stool", "desk", "shelf", "lamp", "bench", "bed", "cabinet"),
        2e5, 0.3, 400.0,
        "wood with hollows (400 kg/m^3); wood is 1e4 times stiffer: chosen for visible motion",
        damping_ratio=0.02,
        damping_source="wood, 0.01, and its joints as much again",
        hard=True,
    ),
    "vessel": Prior(
        ("cup", "mug", "vase", "pot", "bottle", "bowl", "glass", "teapot", "jar", "jug"),
        2e5, 0.3, 500.0,
        "thin walls around air; ceramics are 1e5 times stiffer: chosen for visible motion",
        damping_ratio=0.002,
        damping_source="glass and ceramics ring: loss factors of a few thousandths (Cremer, Heckl & Petersson 2005)",
        hard=True,
    ),
    "vehicle": Prior(
        ("car", "truck", "lego", "plane", "airplane", "boat", "ship", "train", "bike", "bicycle", "bulldozer"),
        2e5, 0.3, 300.0,
        "a hollow shell (300 kg/m^3), far softer than the real one: chosen for visible motion",
        damping_ratio=0.02,
        damping_source="sheet and plastic ring less for their joints: built structures have 0.01 to 0.05",
        hard=True,
    ),
    "toy": Prior(
        ("toy", "doll", "figurine", "puppet", "teddy", "plush", "person", "man", "woman", "head"),
        5e4, 0.35, 300.0,
        "soft vinyl or plush; chosen for visible motion",
        damping_ratio=0.05,
        damping_source="soft vinyl: as rubber",
    ),
    "statue": Prior(
        ("statue", "sculpture", "bust", "statuette", "monument", "gargoyle", "obelisk", "gravestone", "tombstone",
         "idol", "totem", "carving", "effigy"),
        3e5, 0.3, 600.0,
        "carved or cast, with hollows (600 kg/m^3); stone is 1e5 times stiffer: chosen for visible motion",
        damping_ratio=0.01,
        damping_source="stone and castings ring less than metal does: an estimate",
        hard=True,
    ),
    "building": Prior(
        ("building", "house", "tower", "windmill", "castle"),
        3e5, 0.3, 400.0,
        "walls around rooms (400 kg/m^3); masonry is 1e5 times stiffer: chosen for visible motion",
        damping_ratio=0.02,
        damping_source="built structures have 0.01 to 0.05",
        hard=True,
    ),
    "tool": Prior(
        ("tool", "hammer", "axe", "wrench", "screwdriver", "pliers", "shovel", "cannon", "laptop", "computer",
         "camera", "clock", "telephone", "phone", "barrel", "crate", "chest", "anvil", "sword", "shield", "gun",
         "knife", "cutter", "slicer", "spatula", "whisk"),
        2e5, 0.3, 400.0,
        "wood, plastic and metal with hollows (400 kg/m^3), all 1e4 times stiffer or more: chosen for visible motion",
        damping_ratio=0.02,
        damping_source="stiff plastics and joined parts: as a vehicle",
        hard=True,
    ),
    "metal": Prior(
        ("metal", "can", "tin", "bucket", "kettle", "pan", "foil", "wire", "spoon", "steel", "copper",
         "aluminium", "aluminum"),
        3e5, 0.3, 500.0,
        "thin sheet around air (500 kg/m^3) that keeps its dents: it yields at a strain of 2 %, above its own weight "
        "and below a fall; steel is 1e6 times stiffer: chosen for visible motion",
        model=MaterialModel.VON_MISES,
        parameters={"yield_stress": 6e3, "hardening_modulus": 3e4},
    ),
    "sand": Prior(
        ("sand", "sandcastle", "dune", "gravel", "soil", "dirt"),
        3e5, 0.3, 1600.0,
        "loose grains (1600 kg/m^3, friction 33 degrees, no cohesion); real sand is 50 times stiffer, which cannot be "
        "seen (Klar et al. 2016 take 3.5e5 Pa)",
        model=MaterialModel.DRUCKER_PRAGER,
        parameters={"friction_angle": 33.0, "cohesion": 0.0},
    ),
    "snow": Prior(
        ("snow", "snowman", "snowball", "snowdrift", "igloo"),
        1.4e5, 0.2, 400.0,
        "packed snow with the values of Stomakhin et al. 2013, table 2",
        model=MaterialModel.SNOW,
    ),
    "clay": Prior(
        ("clay", "plasticine", "dough", "playdough", "playdoh", "putty", "mud"),
        3e5, 0.4, 1700.0,
        "modelling clay (1700 kg/m^3) keeps the shape it is pressed into: it yields at a strain of 6 %, just above "
        "its own weight; real clay is 10 times stiffer and stronger: chosen for visible motion",
        model=MaterialModel.VON_MISES,
        parameters={"yield_stress": 1.8e4},
    ),
    "liquid": Prior(
        ("liquid", "water", "juice", "milk", "honey", "oil", "syrup", "soup", "wine", "coffee", "splash"),
        3e5, 0.45, 1000.0,
        "water (1000 kg/m^3, 1 mPa s); its bulk modulus of 1 MPa carries sound at 32 m/s, ten times the speed of a "
        "fall from half a body length, so that it looks incompressible; the real one is 2000 times that",
        model=MaterialModel.FLUID,
        parameters={"viscosity": 1e-3},
    ),
    "brittle": Prior(
        (),
        3e5, 0.2, 500.0,
        "hollow glass or ceramics (500 kg/m^3) in some thirty pieces: stands under its own weight (5 kPa at 1 m) and "
        "fails by a fall from half a body length, which presses with 40 kPa; the flour between pieces has hardly any "
        "friction, so that they part; real glass is 1e5 times stiffer",
        model=MaterialModel.BRITTLE,
        parameters={"friction_angle": 1.0, "cohesion": 5e3, "fragments": 30},
    ),
    "melt": Prior(
        (),
        2e5, 0.4, 1000.0,
        "wax, chocolate or ice that melts: flows under its own weight (10 kPa at 1 m) within a second or two and keeps "
        "hardly any shape; chosen for visible motion",
        model=MaterialModel.VISCOPLASTIC,
        parameters={"yield_stress": 1e2, "plastic_viscosity": 4e3},
    ),
    "slump": Prior(
        (),
        2e5, 0.4, 1000.0,
        "dough that gives way: flows where its own weight (10 kPa at 1 m) presses by more than a third of that, and "
        "stops as it gets lower; chosen for visible motion",
        model=MaterialModel.VISCOPLASTIC,
        parameters={"yield_stress": 2.5e3, "plastic_viscosity": 3e4},
    ),
    UNKNOWN: Prior(
        (), 5e4, 0.3, 200.0,
        "nothing is known of the object: PhysGaussian's default density, a stiffness chosen for visible motion",
        damping_ratio=0.02,
        damping_source="between metal and rubber",
    ),
}  # fmt: skip


_CONTAINERS = frozenset(
    (*PRIORS["vessel"].words, "can", "tin", "bucket", "kettle", "pan", "barrel", "crate", "chest", "box", "carton",
     "bag", "sack", "basket", "tank", "tub", "tube", "packet", "package", "canister", "flask", "pitcher", "bathtub",
     "plate", "dish", "saucer", "spoon")
)  # fmt: skip


def find_kind(name: str, what: str = "the kind") -> str:
    """The kind of that name, or the one that it is a word of ("ficus" -> "plant"); case does not matter.

    Args:
        name: A key of `PRIORS`, or one of their words.
        what: Who says so, for the message.

    Raises:
        UserError: There is none; names those that come close.
    """
    key = name.strip().lower()
    by_word = {word: kind for kind, prior in PRIORS.items() for word in (*prior.words, kind)} | {
        kind: kind for kind in PRIORS
    }
    for word in (key, key.removesuffix("s"), key.removesuffix("es")):
        if word in by_word:
            return by_word[word]
    raise explain_unknown_name(what, name, by_word, do=f"Kinds: {', '.join(PRIORS)}")


def guess_kind(name: str, sentence: str = "") -> str:
    """The kind that a name or noun tells: "ficus_02.ply" -> "plant"; `UNKNOWN` if it tells none.

    Words are compared whole (a plural is allowed), so that "carpet" is no car. A name of several nouns goes
    by the last known one before any preposition, its head: "toy robot", "a loaf of rye", "plant in a pot". An
    amount does not count: "a pile of sand" is sand. A substance beside what holds it, on either side, tells what that
    is for: "bottle oil". So it does before another noun: "coffee grinder" tells nothing. Where ``sentence`` calls a
    substance something else, "honey.obj" is a jar.
    """
    words = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", name).lower())
    amounts = [
        i for i in range(1, len(words)) if words[i] == "of" and words[i - 1].removesuffix("s") in _AMOUNTS
    ]
    words = words[amounts[0] + 1 :] if amounts else words
    cut = next((i for i, word in enumerate(words) if word in _PREPOSITIONS), len(words))
    words = [word for word in words[:cut] if word not in _FILE_WORDS and len(word) > 2]
    joined = [before + word for before, word in zip(["", *words], words)]  # "hot dog", as "hotdog"
    kinds = [_find_word_kind(pair) or _find_word_kind(word) for pair, word in zip(joined, words)]
    known = [kind for kind in kinds if kind is not None]
    if not known or known[-1] not in _SUBSTANCES:
        return known[-1] if known else UNKNOWN
    holders = [kind for kind, word in zip(kinds, words) if kind and _CONTAINERS & _list_singulars(word)]
    if holders:
        return holders[-1]
    before_noun = kinds[-1] is None and words[-1].removesuffix("s") not in _AMOUNTS
    said = _find_said_kind(re.findall(r"[a-z]+", sentence.lower()), ())
    return UNKNOWN if before_noun else said or known[-1]


def _find_word_kind(word: str) -> str | None:
    """The kind that a noun tells; `UNKNOWN` of what holds anything, None of no such noun."""
    forms = _list_singulars(word)
    found = next((kind for kind, prior in PRIORS.items() if forms & set(prior.words)), None)
    return found or (UNKNOWN if forms & _CONTAINERS else None)


def _list_singulars(word: str) -> set[str]:
    return {word, word.removesuffix("s"), word.removesuffix("es")}


@functools.cache
def list_nouns(kind: str) -> tuple[str, ...]:
    """Nouns for objects of a kind, whatever their names say; all where it is `UNKNOWN` or not listed."""
    known = kind in PRIORS and kind != UNKNOWN
    own = [PRIORS[kind]] if known else PRIORS.values()
    rows = read_packaged_yaml("physagent_jax.scene", "nouns.yaml").items()
    shared = [words for kinds, words in rows if not known or kinds == "any" or kind in kinds.split()]
    words = [word.strip() for listed in shared for word in listed.split(",")]
    return tuple(dict.fromkeys([*(word for prior in own for word in prior.words), *words]))


@functools.cache
def _read_noun_kinds() -> dict[str, str]:
    """The kind of every noun that belongs to one: of several in a row of nouns.yaml, the first."""
    found = {word: kind for kind, prior in PRIORS.items() for word in prior.words}
    for kinds, words in read_packaged_yaml("physagent_jax.scene", "nouns.yaml").items():
        known = [kind for kind in kinds.split() if kind in PRIORS and kind != UNKNOWN]
        for word in words.split(",") if known else ():
            found.setdefault(word.strip(), known[0])
    return found


def find_hard_kind(name: str, sentence: str, *, others: Collection[str] = ()) -> str | None:
    """The hard kind of an object whose own kind is not known, told by what a sentence calls it, or by its name.

    What a sentence calls it is its first noun behind an article that stands in no place for another thing: "the old
    stone statue falls on a table" is about a statue.

    Args:
        name: The object's name.
        sentence: The sentence.
        others: Nouns for those who act, which are no object's beside another noun.
    """
    said = _find_said_kind(re.findall(r"[a-z]+", sentence.lower()), others)
    named = _find_heads(re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", name).lower()))
    kinds = [said, *list(named.values())[-1:]]
    return next((kind for kind in kinds if kind is not None and PRIORS[kind].hard), None)


def _find_heads(words: list[str]) -> dict[int, str]:
    """The kinds of the nouns among words, by their places; "the lion statue" is a statue."""
    kinds = _read_noun_kinds()
    single = [next((w for w in (each, each.removesuffix("s")) if w in kinds), "") for each in words]
    found = {at: kinds[word] for at, word in enumerate(single) if word}
    return {at: kind for at, kind in found.items() if at + 1 not in found}


def _find_said_kind(words: list[str], others: Collection[str]) -> str | None:
    """The kind of what a sentence is about; None if no noun tells it."""
    heads = _find_heads(words)
    for articles in (_DEFINITE, _ARTICLES):  # "a car hits the bear"
        behind = {
            at: next((k for k in range(at - 1, max(at - 5, -1), -1) if words[k] in articles), -1)
            for at in heads
        }
        said = [at for at, k in behind.items() if k >= 0 and _PLACED.isdisjoint(words[k - 1 : k])]
        said = [at for at in said if words[at] not in others] or said
        if said:
            return heads[said[0]]
    return None


def choose_material(kind: str) -> Material:
    """The material prior of a kind; that of `UNKNOWN` for one that is not listed."""
    prior = PRIORS.get(kind, PRIORS[UNKNOWN])
    return Material.model_validate(
        {
            "model": prior.model,
            "youngs_modulus": prior.youngs_modulus,
            "poissons_ratio": prior.poissons_ratio,
            "density": prior.density,
            "reason": f"prior for kind '{kind if kind in PRIORS else UNKNOWN}': {prior.reason}",
            **prior.parameters,
        }
    )


def is_hard(kind: str) -> bool:
    """Return whether nobody sees an object of ``kind`` deform."""
    return PRIORS.get(kind, PRIORS[UNKNOWN]).hard


def choose_damping(kind: str) -> float:
    """Drag of the surrounding air on an object of ``kind`` [1/s] (`Transfer.damping_rate`)."""
    return PRIORS.get(kind, PRIORS[UNKNOWN]).damping_rate


def choose_damping_ratio(kind: str) -> float:
    """Share of critical damping of the lowest mode of an object of ``kind`` (`Material.damping_ratio`)."""
    return PRIORS.get(kind, PRIORS[UNKNOWN]).damping_ratio


def explain_damping_ratio(kind: str) -> str:
    """Explain the source of `choose_damping_ratio`'s value."""
    return PRIORS.get(kind, PRIORS[UNKNOWN]).damping_source


def choose_anchor(
    kind: str, requested: Literal["base", "top", "none"] | None = None, words: str = ""
) -> Anchor:
    """Choose the anchor: what the prompt asks for, else what the kind implies.

    Args:
        kind: The object's kind.
        requested: "base", "top", "none" (explicitly free), or None (the prompt says nothing).
        words: The prompt's words that led to ``requested``, for the reason.
    """
    prior = PRIORS.get(kind, PRIORS[UNKNOWN])
    if requested is not None:
        said = f' ("{words}")' if words else ""
        outcome = "lets the object go free" if requested == "none" else f"holds the {requested}"
        return Anchor(kind=requested, fraction=prior.base_fraction, reason=f"the prompt{said} {outcome}")
    if prior.rooted is not None:
        return Anchor(kind="base", fraction=prior.base_fraction, reason=prior.rooted)
    return Anchor(kind="none", reason=f"nothing holds an object of kind '{kind}'")
