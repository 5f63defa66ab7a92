"""Parts that an object's file or a person names: which particles they are, and how they hang on the rest."""

import numpy as np
import pytest
import trimesh

from physagent_jax.api import load_object
from physagent_jax.core.errors import UserError
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.mesh_files import read_named_parts
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.mesh_formats.names import list_limbs, list_names
from physagent_jax.scene.parts import join_parts
from physagent_jax.scene.parts.cells import fit_part

FIGURE = {  # centre and half sizes, z up
    "body": ((0, 0, 0.5), (0.2, 0.1, 0.5)),
    "Arm_L": ((-0.45, 0, 0.85), (0.25, 0.06, 0.06)),
    "Arm_R": ((0.45, 0, 0.85), (0.25, 0.06, 0.06)),
    "head": ((0, 0, 1.15), (0.15, 0.1, 0.15)),
}


COARSE = dict(cells=48, max_particles=1500)


def make_box(centre, half):
    return trimesh.creation.box(extents=2 * np.array(half)).apply_translation(centre)


def write_obj(path, boxes=FIGURE, keyword="g"):
    """Boxes as groups or objects of an OBJ file."""
    lines, count = [], 0
    for name, (centre, half) in boxes.items():
        mesh = make_box(centre, half)
        lines += [f"{keyword} {name}", *("v {} {} {}".format(*v) for v in mesh.vertices)]
        lines += ["f {} {} {}".format(*(f + count + 1)) for f in mesh.faces]
        count += len(mesh.vertices)
    path.write_text("\n".join(lines))
    return path


def write_glb(path, meshes, up="+y", **names):
    """Meshes as nodes of a GLB file, by name; built z up."""
    scene = trimesh.Scene()
    for name, mesh in meshes.items():
        turned = mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
        scene.add_geometry(turned, node_name=name, geom_name=f"mesh_{len(scene.geometry)}", **names)
    path.write_bytes(scene.export(file_type="glb"))
    return path


def make_pot():
    """A pot with a lid of the same width that lies 0.02 above it."""
    pot = trimesh.creation.cylinder(0.5, 0.6, sections=32)
    lid = trimesh.creation.cylinder(0.52, 0.1, sections=32).apply_translation((0, 0, 0.37))
    return {"pot": pot, "lid": lid}


def find(path, **options):
    """The body, its particles in the file's frame, and its parts by name."""
    body = load_object(path, **{"preset": "fast", "max_particles": 6000, **options}).body
    source = body.placement.to_source(body.particles.x)
    return body, source, {part.name or part.roles[0]: part for part in body.parts}


@pytest.fixture(scope="module")
def figure(tmp_path_factory):
    """The file of the figure, and what is found in it."""
    path = write_obj(tmp_path_factory.mktemp("figure") / "figure.obj")
    return path, find(path, up="+z")


@pytest.fixture(scope="module")
def pot(tmp_path_factory):
    return find(write_glb(tmp_path_factory.mktemp("pot") / "pot.glb", make_pot()))


@pytest.mark.parametrize(
    ("raw", "name"),
    [
        ("left_arm", "left arm"),
        ("Arm.L", "left arm"),
        ("wheel_FR", "front right wheel"),
        ("Wheel RL", "rear left wheel"),
        ("armR_geo", "right arm"),
        ("LidShape", "lid"),
        ("lid.001", "lid 1"),
        ("Lid_lambert1_0", "lid"),
        *(
            (each, "")
            for each in ("default", "Object.001", "mesh_0", "pCube3", "Cube.002", "lambert1", "L", "")
        ),
        *((each, "") for each in ("RootNode", "group 7", "12", "None", "gltf_scene_rootnode")),
    ],
)
def test_names_that_a_person_gave_are_told_from_machine_made_ones(raw, name):
    assert list_names([raw], ["lambert1"]) == ((name,) if name else ())


def test_a_part_may_have_the_name_of_its_material():
    """As cars have it: the material of all wheels is "Wheel"."""
    told = [list_names([raw], ["Wheel"]) for raw in ("wheel_fl", "wheel", "tank_Wheel_0")]
    assert told == [("front left wheel",), ("wheel",), ("tank",)]


@pytest.mark.parametrize("keyword", ["g", "o"])
def test_groups_of_an_obj_are_parts(tmp_path, keyword, figure):
    path = tmp_path / "figure.obj"
    body, source, parts = figure[1] if keyword == "g" else find(write_obj(path, keyword=keyword), up="+z")
    named = {name: part for name, part in parts.items() if part.origin == "file"}
    assert list(named) == ["body", "left arm", "right arm", "head"]
    for name, (centre, half) in zip(named, FIGURE.values()):
        held = ~make_region_mask(named[name].rest, np.asarray(body.particles.x, float))
        around, within = ((np.abs(source - centre) <= np.add(half, by)).all(1) for by in (0.03, -0.03))
        assert (held & around).sum() > 0.97 * held.sum(), name
        assert (held & within).sum() > 0.99 * within.sum() > 0, name


def test_what_hangs_on_a_neck_turns_and_what_sits_on_the_rest_moves(figure, pot):
    _, _, parts = figure[1]
    arm = parts["left arm"]
    assert not arm.seated and arm.arm[0] < -0.25 and abs(arm.arm[0]) > 3 * np.abs(arm.arm[1:]).max()
    _, _, parts = pot
    lid = parts["lid"]
    assert lid.seated and lid.arm[2] > 0.9 * np.linalg.norm(lid.arm) and lid.side[2] > 0.9
    np.testing.assert_allclose(lid.joint[:2], 0.5, atol=0.03)  # it turns about its own middle


def test_the_lid_of_a_glb_is_the_lid_alone(pot):
    body, source, parts = pot
    assert parts["lid"].origin == "file"
    x = np.asarray(body.particles.x, float)
    moved, rest = (make_region_mask(region, x) for region in (parts["lid"].moved, parts["lid"].rest))
    assert (moved ^ rest).all()  # a piece of its own has no joint that bends
    on_top = source[:, 1] > 0.31  # glTF is y up
    assert (moved == on_top).mean() > 0.99


def test_a_node_holds_those_below_it(tmp_path):
    """An arm takes its hand along, by whatever names the meshes go."""
    scene = trimesh.Scene()
    scene.add_geometry(make_box((0, 0, 0), (0.5, 0.2, 0.2)), node_name="body", geom_name="mesh_0")
    scene.add_geometry(make_box((0.7, 0, 0), (0.2, 0.05, 0.05)), node_name="arm", geom_name="mesh_1")
    scene.add_geometry(
        make_box((1.0, 0, 0), (0.1, 0.08, 0.08)), node_name="hand", geom_name="mesh_2", parent_node_name="arm"
    )
    (tmp_path / "thing.glb").write_bytes(scene.export(file_type="glb"))
    names = {part.names for part in read_named_parts(tmp_path / "thing.glb")}
    assert {("body",), ("arm",), ("hand", "arm")} <= names


@pytest.mark.parametrize("mesh", ["wheel_left", "Mesh wheel_left.002"])
def test_a_mesh_that_is_called_as_one_of_its_nodes_names_no_other_one(tmp_path, mesh):
    """Else one wheel of four was all of them."""
    scene, far = trimesh.Scene(), np.eye(4)
    scene.add_geometry(make_box((0, 0, 0), (0.5, 0.5, 0.2)), node_name="body", geom_name="mesh_0")
    wheel = make_box((0.8, 0, 0), (0.1, 0.2, 0.2))
    scene.add_geometry(wheel, node_name="wheel_left", geom_name=mesh)
    far[0, 3] = -1.6
    scene.graph.update(frame_to="wheel_right", matrix=far, geometry=mesh)
    path = tmp_path / "cart.glb"
    path.write_bytes(scene.export(file_type="glb"))
    names = [each.names for each in read_named_parts(path)]
    assert sum("left wheel" in each for each in names) == 1 and ("right wheel",) in [n[:1] for n in names]
    assert not any("left wheel 2" in each for each in names[2:])


@pytest.mark.parametrize("name", ["default", "Object.001", "mesh_0"])
def test_machine_made_names_are_no_parts(tmp_path, name):
    boxes = {f"{name}{k}": box for k, box in enumerate(FIGURE.values())}
    body = find(write_obj(tmp_path / "figure.obj", boxes), up="+z", **COARSE)[0]
    assert all(part.origin == "shape" for part in body.parts)


def test_one_group_for_all_is_no_part(tmp_path):
    path = tmp_path / "figure.obj"
    write_obj(path)
    path.write_text("g figure\n" + "\n".join(l for l in path.read_text().splitlines() if l[0] != "g"))
    assert all(part.origin == "shape" for part in find(path, up="+z", **COARSE)[0].parts)


def test_a_group_of_one_skin_bends_beside_its_joint(tmp_path):
    """Faces of one closed surface in two groups: the end of a bar that is marked is no piece of its own."""
    bar = trimesh.creation.box(extents=(2.0, 0.2, 0.2)).subdivide().subdivide().subdivide()
    middles = bar.triangles_center[:, 0]
    lines = ["v {} {} {}".format(*v) for v in bar.vertices]
    for name, chosen in (("shaft", middles < 0.2), ("blade", middles >= 0.2)):
        lines += [f"g {name}", *("f {} {} {}".format(*(f + 1)) for f in bar.faces[chosen])]
    (tmp_path / "bar.obj").write_text("\n".join(lines))
    body, source, parts = find(tmp_path / "bar.obj", up="+z")
    x = np.asarray(body.particles.x, float)
    moved, rest = (make_region_mask(region, x) for region in (parts["blade"].moved, parts["blade"].rest))
    assert not (moved & rest).any() and not parts["blade"].seated
    beside = ~moved & ~rest
    assert source[beside, 0].min() > 0.1 and 0.3 < source[beside, 0].max() < 0.6
    assert source[moved, 0].min() > 0.3


def test_a_box_in_the_files_units_is_a_part(tmp_path):
    choice = dict(name="top", box=(-1, -1, 0.9, 1, 1, 3))
    body, source, parts = find(
        write_obj(tmp_path / "figure.obj", {"body": FIGURE["body"]}), up="+z", parts=[choice]
    )
    assert parts["top"].origin == "option"
    held = ~make_region_mask(parts["top"].rest, np.asarray(body.particles.x, float))
    assert (held == (source[:, 2] >= 0.9)).mean() > 0.98


def test_a_point_and_a_number_name_parts_that_are_there(figure):
    path, (body, _, _) = figure
    point = dict(name="pump handle", point=(0.6, 0, 0.85))
    number = dict(name="torso", number=1)
    before = body.parts
    after = find(path, up="+z", parts=[point, number])[0].parts
    assert [part.moved for part in before] == [part.moved for part in after]
    assert [part.name for part in before][:3] == ["body", "left arm", "right arm"]
    assert [part.name for part in after][:3] == ["torso", "left arm", "pump handle"]
    assert [part.origin for part in after][:3] == ["option", "file", "option"]


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        (dict(name="x", box=(5, 5, 5, 6, 6, 6)), ("holds nothing", "reaches from")),
        (dict(name="x", box=(-9, -9, -9, 9, 9, 9)), ("holds all", "reaches from")),
        (dict(name="x", number=77), ("77", "1 body, 2 left arm")),
    ],
)
def test_what_is_no_part_is_refused(figure, choice, words):
    body = load_object(figure[0], up="+z", parts=[choice], **COARSE).body
    with pytest.raises(UserError) as error:
        _ = body.parts
    assert all(word in str(error.value) for word in words)


@pytest.mark.parametrize(
    ("raw", "names"),
    [
        (["mixamorig:LeftForeArm", "mixamorig:LeftArm", "mixamorig:Spine2"], ("left forearm", "left arm")),
        (["b_Tail03_014", "b_Tail02_013", "b_Tail01_012", "b_Hip_01"], ("tail",)),
        (["DEF-shin.R.001", "DEF-thigh.R", "DEF-pelvis.R"], ("right shin", "right leg")),
        (["Bip01 L UpperArm"], ("left arm",)),
        (["RightHandThumb2", "RightHand"], ("right thumb", "right hand")),
        (["Head_End", "Head", "Neck"], ("head", "neck")),
        (["Bone.042", "root_joint"], ()),
    ],
)
def test_joints_are_called_as_the_limbs_that_they_move(raw, names):
    assert list_limbs(raw) == names


def test_a_skin_divides_a_surface_by_its_joints():
    """A strip of four triangles, of which the last two hang on the forearm."""
    faces = np.array([[k, k + 1, k + 2] for k in range(4)])
    vertices = np.arange(18.0).reshape(6, 3)
    limbs = (np.array([0, 0, 1, 1]), (("left arm",), ("left forearm", "left arm")))
    whole = MeshPart(vertices, faces, names=("fox",), bones=limbs)
    upper, lower = whole.split()
    assert upper.names == ("left arm", "fox") and lower.names == ("left forearm", "left arm", "fox")
    assert (np.concatenate([upper.faces, lower.faces]) == faces).all()


def test_a_part_that_few_particles_leave_none_is_left_out():
    """A knob so small that none of a coarse body's particles is nearest to its seeds."""
    points = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3), -1).reshape(-1, 3)
    half = points[:, 0] < 0.4
    part = fit_part(points, half, joined=True).model_copy(update=dict(name="half", origin="file"))
    tiny = part.moved.model_copy(update=dict(inside=((0.1, 0.1, 0.1),), outside=tuple(map(tuple, points))))
    gone = part.model_copy(update=dict(name="knob", moved=tiny))
    assert [each.name for each in join_parts(points, [part, gone], [])] == ["half"]


def test_a_named_part_that_no_particle_is_in_is_left_out(tmp_path):
    """Its surface has splats, and few particles are spread over the object."""
    path = write_obj(tmp_path / "figure.obj", FIGURE | {"knob": ((0, 0, 1.33), (0.02, 0.02, 0.02))})
    names = list(find(path, max_particles=300)[2])
    assert "left arm" in names and "knob" not in names


def test_where_the_file_names_all_a_shape_across_its_parts_is_none():
    points = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3), -1).reshape(-1, 3)

    def cut(low, high, **told):
        mask = (points[:, 2] >= low) & (points[:, 2] < high)
        return fit_part(points, mask, joined=True).model_copy(update=told)

    named = [cut(0, 0.5, name="body", origin="file"), cut(0.5, 1.1, name="head", origin="file")]
    across, within = cut(0.3, 0.7, roles=("lid",)), cut(0.9, 1.1, roles=("knob",))
    found = join_parts(points, named, [across, within])
    assert [each.name or each.roles[0] for each in found] == ["body", "head", "knob"]


def test_parts_do_not_depend_on_how_many_particles_a_run_has(tmp_path):
    """A head on a neck is found with a thousand particles as with many, and whatever the grid's cells."""
    radii = {0.0: 0.35, 0.38: 0.08, 0.55: 0.17}  # by the height of each ball
    balls = [trimesh.creation.icosphere(3, r).apply_translation((0, 0, z)) for z, r in radii.items()]
    path = tmp_path / "figure.obj"
    trimesh.util.concatenate(balls).export(path)
    few, many = (find(path, up="+z", max_particles=n, cells=c)[0] for n, c in ((1000, 24), (4000, 96)))
    assert few.particles.count < 1100 < many.particles.count
    assert few.parts == many.parts != ()


def test_a_short_limb_of_its_own_turns_about_its_shoulder():
    steps = np.linspace(-1, 1, 11)
    cloud = np.array([(x, y, z) for x in steps for y in steps for z in steps])
    body, arm = 0.5 * cloud, cloud * (0.3, 0.2, 0.2) + (0.75, 0, 0)
    points, mask = np.concatenate([body, arm]), np.arange(2 * len(cloud)) >= len(cloud)
    seated, limb = (fit_part(points, mask, joined=False, limb=each) for each in (False, True))
    assert seated.seated and not limb.seated and limb.joint[0] < seated.joint[0] and limb.arm[0] > 0.2


def test_a_limb_that_is_sunk_in_the_rest_turns_about_the_end_inside():
    steps = np.linspace(-1, 1, 11)
    cloud = np.array([(x, y, z) for x in steps for y in steps for z in steps])
    skirt, leg = cloud * (0.5, 0.5, 0.5), cloud * (0.1, 0.1, 0.3) + (0.2, 0, -0.45)
    points, mask = np.concatenate([skirt, leg]), np.arange(2 * len(cloud)) >= len(cloud)
    part = fit_part(points, mask, joined=False, limb=True)
    assert not part.seated and part.arm[2] < -0.3 and abs(part.arm[0]) < 0.1
