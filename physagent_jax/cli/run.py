"""`physagent run`: an object and a sentence in, a run folder out."""

from __future__ import annotations

import dataclasses
import json
import shlex
import sys
import time
from pathlib import Path
from typing import Annotated, Literal

import tyro

from physagent_jax.cli.console import ConsoleObserver, stderr, warn
from physagent_jax.cli.options import choose_prompt, name_options, read_whole_spec, report_as_options, to_spec
from physagent_jax.scene.config import SignedAxis, SplatEncoding
from physagent_jax.scene.presets import PresetName

AnchorChoice = Literal["auto", "none", "base", "top", "box", "mask"]


@dataclasses.dataclass(frozen=True)
class Run:
    """Turn an object and a sentence into a simulated 4D video.

    Simulates, looks at its own pictures, judges them against the sentence and tries again, up to three
    rounds. The folder then holds video.mp4, motion.npz, scene.json and report.html. A stopped run goes on
    when the same command is given again.
    """

    out: Path
    """Run folder to make."""
    object: Path | None = None
    """3D Gaussians (.ply, .spz, ...) or a mesh (.obj, .glb, .stl, .ply)."""
    image: Path | None = None
    """In place of `--object`: a photo, whose object is cut out, given a back, and moved in the photo."""
    image_box: tuple[float, float, float, float] | None = None
    """Box (x0 y0 x1 y1, pixels) that holds the object in --image; default: what stands out in the middle."""
    image_mask: Path | None = None
    """Picture of the size of --image that is bright on its object, or .npy of one bool per pixel."""
    image_segmenter: str | None = None
    """Segmenter that finds the object in --image; default: GrabCut."""
    image_depth: str | None = None
    """Estimator of the depth in --image; default: none, the outline is inflated."""
    image_fov: float | None = None
    """Field of view along the longer side of --image, in degrees; default: its EXIF data, else 45."""
    prompt: str | None = None
    """The wanted motion, in everyday English."""
    sentence: tyro.conf.Positional[str | None] = None
    """In place of `--prompt`."""
    spec: Path | None = None
    """JSON or YAML that says all of the run, in place of the options that do (`physagent schema run`)."""
    preset: PresetName = PresetName.FAST
    """fast: a laptop's processor; paper: the paper's resolution."""
    up: SignedAxis | None = None
    """The file's up axis; default: its card, else +y for glTF (.glb, .gltf), +z for others. 3DGS captures are
    often -y."""
    kind: str | None = None
    """plant, food, robot, ... (decides material and anchor); default: its card, else from the file's name."""
    azimuth: float | None = None
    """The camera's place, in degrees about the vertical; default: the card's, else where the object is broad."""
    elevation: float | None = None
    """The camera's height above the horizon, in degrees; of --image, that of the photo's camera; default: 10."""
    follow: bool = False
    """Have the video's camera go along with the object; else it does so only if the object would be too small."""
    anchor: AnchorChoice = "auto"
    """The part that is held fixed; auto: as the sentence says, else as the kind implies."""
    anchor_box: tuple[float, float, float, float, float, float] | None = None
    """For --anchor box: centre and half size in metres (the object's longest side is 1 m, centred in the domain)."""
    anchor_mask: Path | None = None
    """For --anchor mask: .npy of one bool per Gaussian."""
    material: str | None = None
    """A named material (`physagent materials`), or a constitutive model with the kind's values; default: the kind's."""
    physgm: Path | None = None
    """predicted_phys.json of PhysGM, which then says what the object is made of."""
    soften: float | Literal["auto"] | None = None
    """Make the material so many times softer, with the same strains at yield; auto: so that a round is affordable."""
    youngs_modulus: float | None = None
    """Young's modulus E [Pa]; default: the material's."""
    poissons_ratio: float | None = None
    """Poisson's ratio nu; default: the material's."""
    density: float | None = None
    """Density [kg/m^3]; default: the material's."""
    damping_ratio: float | None = None
    """Share of critical damping of the object's lowest mode, 0 to 1; default: its kind's, if that costs little."""
    world: Literal["ground", "free"] = "ground"
    """ground: it stands on the ground and gravity acts, unless the sentence says otherwise; free: it floats."""
    friction: float | None = None
    """Friction coefficient of the ground; default: that of a dry floor (0.4), and none in the free world."""
    opacity_threshold: float = 0.02
    """Gaussians with less opacity are left out."""
    splat_encoding: SplatEncoding | None = None
    """Encoding of scales and opacities: as logarithm and logit (the 3DGS layout) or plain; default: found out."""
    part: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A name for a part that the sentence speaks of; may be given several times. NAME=X0,Y0,Z0,X1,Y1,Z1: the part in a
    box; NAME=X,Y,Z: the part nearest to a point; both in the file's units and axes, as `physagent inspect` shows them.
    NAME=N: the part of that number in its list."""
    frames: int | None = None
    """Pictures of the clip; default: as many as the sentence needs, at least the preset's 50."""
    particles: int | None = None
    """Particles at most; default: the preset's."""
    resolution: int | None = None
    """Width and height of the pictures that perception gets; default: the preset's."""
    video_size: str = "1280x720"
    """Width and height of the video, which is drawn for people; off: none is."""
    caption: bool = False
    """Write the sentence into the video."""
    arrows: bool = False
    """Draw arrows into the video where something acts."""
    max_iterations: Annotated[int, tyro.conf.arg(aliases=("--rounds",))] = 3
    """Rounds at most; they end earlier where none of the last two improved anything."""
    reader: Literal["grammar", "model", "both"] = "grammar"
    """Agent that reads the sentence; both: the grammar's reading stands, and the model may doubt it."""
    form: Literal["clauses", "by-clause", "paper"] | None = None
    """Answer of a model that reads: words of the whole sentence (clauses, the default), words clause by clause
    (by-clause, for small models), or the paper's force field (paper)."""
    planner: Literal["rules", "chat", "both"] = "rules"
    """Agent that judges the motion; chat: a model; both: a success needs rules and model."""
    executor: Literal["rules", "chat"] = "rules"
    """Agent that rewrites the force field; chat: a model, inside the hard rules."""
    perception: str = "rgbd"
    """Backends that measure the pictures; rgbd: with the renderer's depth channel, as a depth camera has; rgb: from
    pictures alone. Backends by name follow, as in rgb,tracker=NAME (roles: segmenter, depth, tracker)."""
    llm: str | None = None
    """The language model: http://HOST:PORT/v1 of a server, a GGUF file, or a folder with a model. A key comes from the
    environment alone."""
    model: str | None = None
    """Name of the model, as the server of --llm has it."""
    eyes: bool = False
    """Show key frames to the model that judges: it has to take pictures."""
    record: Path | None = None
    """Cassette that keeps every request to the model and its answer."""
    replay: Path | None = None
    """Cassette with the model's answers, in place of --llm."""
    segmenter: str | None = None
    """Model that finds the object in the pictures, NAME or NAME:PATH (`physagent models`); default: rgbd."""
    depth: str | None = None
    """Model that tells its distance, NAME or NAME:PATH; default: sensor."""
    tracker: str | None = None
    """Model that follows its points, NAME or NAME:PATH; default: flow."""
    probe: bool = False
    """First try force fields on a coarse version of the scene; the rounds then begin with the best of them."""
    seed: int = 0
    """Seed of everything random."""
    ledger: bool = False
    """Also record work, dissipation and impulses, frame by frame (plotted in the report)."""
    save_frames: bool = False
    """Also leave perception's pictures as PNG."""
    save_splats: Literal["ply", "spz", "glb"] | None = None
    """Also leave one file of 3D Gaussians per frame, in this format; named without one: ply."""
    max_minutes: float = 60.0
    """Refuse a run of which a round is estimated to take longer; more than 60 also lets a first round take longer."""
    max_memory: float | None = None
    """Refuse what is estimated to need more [GB]; default: 80 % of the machine's."""
    overwrite: bool = False
    """Replace another run in the folder."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one line of JSON instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        # Imported here, so that --help does not wait for JAX.
        from physagent_jax.report.formats import format_plural
        from physagent_jax.run.chosen_agents import open_agents
        from physagent_jax.run.loop import run_loop
        from physagent_jax.run.resolve import resolve
        from physagent_jax.run.stopping import STOP_REASONS
        from physagent_jax.run.store import PLAIN_VIDEO, VIDEO
        from physagent_jax.scene.cost import Limits

        begun = time.perf_counter()
        limits = Limits(self.max_minutes, self.max_memory)
        if self.spec is None:
            with report_as_options():
                prompt = choose_prompt(self.prompt, self.sentence)
                run = resolve(to_spec({**vars(self), "prompt": prompt}), origin="command line")
        else:
            changed = [
                each.name for each in dataclasses.fields(self) if getattr(self, each.name) != each.default
            ]
            run = resolve(read_whole_spec(self.spec, changed), self.spec.parent, origin=str(self.spec))
        for text in run.warnings:  # now, while the run can still be stopped
            warn(name_options(text) if self.spec is None else text)
        observer = ConsoleObserver()
        command = " ".join(map(shlex.quote, sys.argv))
        try:
            with open_agents(run.spec, run.base_dir, record=self.record) as agents:
                store = run_loop(
                    run,
                    self.out,
                    agents=agents,
                    observer=observer,
                    limits=limits,
                    overwrite=self.overwrite,
                    command=command,
                )
        finally:
            observer.close()
        from physagent_jax.report.html import write_report  # nobody waits for it before the clip is there

        report = write_report(store.path)
        for text in store.manifest.warnings:
            if text not in run.warnings and text not in observer.told:
                warn(text)
        summary = summarise(store, time.perf_counter() - begun)
        if self.json_line:
            print(json.dumps(summary))
        else:
            stderr.print(
                f"[bold]{summary['verdict']}[/] after {format_plural(summary['iterations'], 'round')}: "
                f"{STOP_REASONS[summary['stopped']]}"
            )
            video = PLAIN_VIDEO if run.spec.save.video_size is None else VIDEO
            print(f"video:  {store.path / video}\nreport: {report}")
        return 0


def summarise(store, seconds: float) -> dict:
    """The line that ``--json`` prints."""
    from physagent_jax.agents.schema import SemanticReply
    from physagent_jax.simulation.record import SimulationRecord

    manifest = store.manifest
    records = [
        store.read(f"iterations/{index}/simulation.json", SimulationRecord)
        for index in range(manifest.iterations)
    ]
    best = records[manifest.best_iteration]
    understood = store.read("semantic.json", SemanticReply)
    return {
        "verdict": manifest.verdict,
        "iterations": manifest.iterations,
        "stopped": manifest.stopped,
        "assumptions": understood.notes,
        "ignored": understood.ignored,
        "not_understood": understood.not_understood,
        "unsure": understood.unsure,
        "frames": len(best.kinetic_energy),
        "particle_count": best.particle_count,
        "substeps": sum(record.substeps for record in records),
        "wall_s": {**manifest.stages.model_dump(), "total": round(seconds, 3)},
        "out": str(store.path),
        **({"probe_iterations": manifest.probe_iterations} if manifest.probe_iterations else {}),
    }
