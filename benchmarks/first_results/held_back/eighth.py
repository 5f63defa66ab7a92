"""Pairs on an eighth lot of objects that nothing was developed with, written before any was run, and never changed.

As the sixth lot: a language model wrote them from pictures of the objects, without the code or other sentences.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, pin_things
from benchmarks.first_results.pins import PinnedFile

KAYKIT = "KayKit-Game-Assets/KayKit-"
CREDIT = "by Kay Lousberg (kaylousberg.com), CC0-1.0"

FILES: Mapping[str, PinnedFile] = {
    "viking": PinnedFile(
        "Barbarian.glb",
        f"{KAYKIT}Character-Pack-Adventures-1.0/672074b73ba276876a19e8816ecdc5241817ab47"
        "/addons/kaykit_character_pack_adventures/Characters/gltf",
        "cefc311a0e10c7858b6141f5ada7e33268727564fb8ac1347aab97d000669cc6",
        f"mesh with colours, Character Pack Adventurers {CREDIT}",
    ),
    "boat": PinnedFile(
        "boat.obj",
        "odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/boat",
        "c40a8338903a1acae3013ec38326f540e901a6d55d63a32fafee16e96053f27e",
        "mesh, boat by Oded Stein, Eitan Grinspun and Keenan Crane, CC BY 4.0",
    ),
    "pumpkin": PinnedFile(
        "pumpkin_orange_jackolantern.obj",
        f"{KAYKIT}Halloween-Bits-1.0/6dc69bf6b2fa766a985754f35ec6a0324090e6c6/addons/kaykit_halloween_bits/Assets/obj",
        "60dbfa3a0df166b2742fec98be289a62309f2f894261f31eeb2da84149295161",
        f"mesh, Halloween Bits {CREDIT}",
    ),
    "taxi": PinnedFile(
        "car_taxi.obj",
        f"{KAYKIT}City-Builder-Bits-1.0/63976910ca04d16f0fc531b9c614244be8128713"
        "/addons/kaykit_city_builder_bits/Assets/obj",
        "a12641270142af6a863d4229c8f3f0af4816c50369a6c9c830dfb9ce572677c3",
        f"mesh, City Builder Bits {CREDIT}",
    ),
    "chest": PinnedFile(
        "chest.glb",
        f"{KAYKIT}Dungeon-Remastered-1.0/b0ca9bd96a8072ab36a3a5464f00ed1e06a16d07"
        "/addons/kaykit_dungeon_remastered/Assets/gltf",
        "f72fd2201cd42ad399928a0b7bcc34d5b0e6d0624aeaf824fef81852109955f8",
        f"mesh with colours, Dungeon Remastered {CREDIT}",
    ),
}

_OPTIONS = {
    "boat": ("--up", "+y"),
    "pumpkin": ("--up", "+y"),
    "taxi": ("--up", "+y"),
}  # the files do not tell; pictures show each upright

THINGS = pin_things(FILES, _OPTIONS)

_PAIRS = (
    Case("viking", "The viking jumps up and down three times.", "jump quantity"),
    Case("viking", "A strong wind hits the viking and knocks him onto his back.", "wind tip violent"),
    Case("viking", "The little viking flaps both his arms like a bird.", "part sway"),
    Case("viking", "The viking is made of jelly and gets dropped on the floor.", "material drop"),
    Case("boat", "The boat rocks gently left and right as if on waves.", "sway slight"),
    Case("boat", "The boat is lifted one meter up and then dropped.", "sequence quantity lift drop"),
    Case("boat", "The cabin on the boat is made of sponge and gets pressed down.", "part material squeeze"),
    Case("boat", "The boat slams into a wall at full speed.", "hit violent"),
    Case("pumpkin", "Give the pumpkin a gentle push so it rolls to the left", "push roll slight"),
    Case("pumpkin", "The stem of the pumpkin bends over to one side", "part bend"),
    Case("pumpkin", "A jelly pumpkin drops to the floor and wobbles", "material drop"),
    Case("pumpkin", "The pumpkin gets kicked really hard from the front", "hit violent"),
    Case("taxi", "The taxi spins around three times", "quantity spin"),
    Case("taxi", "The sign on top of the taxi sways in a strong wind", "part sway wind"),
    Case("taxi", "The taxi is slowly crushed flat from above", "squeeze"),
    Case("taxi", "The taxi jumps up and then rolls over onto its side", "sequence jump roll"),
    Case("chest", "The lid of the chest slowly opens", "part lift"),
    Case("chest", "The chest is made of rubber and bounces when it falls", "material drop"),
    Case("chest", "The chest shakes a little and then tips over backwards", "sequence tip slight"),
    Case("chest", "Throw the chest two meters up into the air", "quantity throw"),
)

SETS = {"eighth": _PAIRS}
