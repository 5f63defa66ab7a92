"""The stages of one substep as Warp kernels: stress, p2g, grid_update, boundaries, g2p.

Quadratic B-splines and APIC transfers as in Jiang et al. 2016 ("The material point method for simulating
continuum materials", SIGGRAPH course): the force on a node is -sum V0 tau grad w, and F grows
with sum v_i (x) grad w_i, not with C. Import only where Warp is installed.
"""

# The bodies are Warp's language, not Python: its types do not describe element access or matrix products.
# pyright: reportIndexIssue=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportAttributeAccessIssue=false, reportGeneralTypeIssues=false

import warp as wp

wp.set_module_options({"enable_backward": False})

STICKY = wp.constant(0)
SLIP = wp.constant(1)
SEPARATE = wp.constant(2)
FLUID_EXPONENT = wp.constant(7.0)


@wp.func
def spline(g: float, base: int) -> wp.vec3:
    """Weights of nodes base, base + 1, base + 2 for a particle at ``g`` [cells]."""
    f = g - float(base)
    return wp.vec3(0.5 * (1.5 - f) * (1.5 - f), 0.75 - (f - 1.0) * (f - 1.0), 0.5 * (f - 0.5) * (f - 0.5))


@wp.func
def spline_slope(g: float, base: int) -> wp.vec3:
    """Derivatives of the weights by ``g``."""
    f = g - float(base)
    return wp.vec3(f - 1.5, 2.0 - 2.0 * f, f - 0.5)


@wp.func
def has_stencil(g: wp.vec3, cells: int) -> bool:
    """Return whether all 27 nodes exist; false also for a position that is not a number."""
    low, high = wp.min(g), wp.max(g)
    # A minimum may skip a component that is not a number, a sum does not.
    total = g[0] + g[1] + g[2]
    return low >= 0.5 and high < float(cells) - 0.5 and total == total


@wp.kernel
def p2g(
    x: wp.array[wp.vec3],
    v: wp.array[wp.vec3],
    C: wp.array[wp.mat33],
    tau: wp.array[wp.mat33],
    mass: wp.array[float],
    volume: wp.array[float],
    dt: float,
    dx: float,
    cells: int,
    keep: float,
    swap: float,
    node_mass: wp.array3d[float],
    node_v: wp.array3d[wp.vec3],
    lost: wp.array[int],
):
    """Mass and momentum to the nodes; the affine part carried over is keep * C - swap * C^T."""
    p = wp.tid()
    g = x[p] / dx
    if not has_stencil(g, cells):
        wp.atomic_add(lost, 0, 1)
        return
    bx, by, bz = int(g[0] - 0.5), int(g[1] - 0.5), int(g[2] - 0.5)
    wx, wy, wz = spline(g[0], bx), spline(g[1], by), spline(g[2], bz)
    sx, sy, sz = spline_slope(g[0], bx), spline_slope(g[1], by), spline_slope(g[2], bz)
    affine = keep * C[p] - swap * wp.transpose(C[p])
    force = (-dt * volume[p] / dx) * tau[p]
    velocity = v[p]
    m = mass[p]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                slope = wp.vec3(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                reach = dx * (wp.vec3(float(bx + i), float(by + j), float(bz + k)) - g)
                momentum = (weight * m) * (velocity + affine * reach) + force * slope
                wp.atomic_add(node_mass, bx + i, by + j, bz + k, weight * m)
                wp.atomic_add(node_v, bx + i, by + j, bz + k, momentum)


@wp.kernel
def grid_update(
    node_mass: wp.array3d[float],
    node_v: wp.array3d[wp.vec3],
    gravity: wp.vec3,
    dt: float,
    empty: float,
):
    """Momentum to velocity, and gravity, on the nodes with more mass than ``empty``."""
    i, j, k = wp.tid()
    m = node_mass[i, j, k]
    if m > empty:
        node_v[i, j, k] = node_v[i, j, k] / m + dt * gravity
    else:
        node_v[i, j, k] = wp.vec3()


@wp.func
def project(u: wp.vec3, normal: wp.vec3, contact: int, friction: float) -> wp.vec3:
    """The velocity that a solid with this surface lets pass."""
    if contact == STICKY:
        return wp.vec3()
    approach = wp.dot(u, normal)
    along = u - approach * normal
    if contact == SLIP:
        return along
    if approach >= 0.0:
        return u
    speed = wp.length(along)
    if speed == 0.0:
        return along
    return wp.max(1.0 + friction * approach / speed, 0.0) * along


@wp.kernel
def boundaries(
    node_v: wp.array3d[wp.vec3],
    point: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    contact: wp.array[int],
    friction: wp.array[float],
    padding: int,
    dx: float,
):
    """All planes, in order, then the walls of the domain (none if ``padding`` is 0)."""
    i, j, k = wp.tid()
    u = node_v[i, j, k]
    position = dx * wp.vec3(float(i), float(j), float(k))
    for plane in range(point.shape[0]):
        # A node on the plane is in the solid; the tolerance covers round-off of its position.
        if wp.dot(position - point[plane], normal[plane]) <= 1.0e-4 * dx:
            u = project(u, normal[plane], contact[plane], friction[plane])
    last = node_v.shape[0] - 1
    u = wp.vec3(
        wall(u[0], i, last, padding),
        wall(u[1], j, last, padding),
        wall(u[2], k, last, padding),
    )
    node_v[i, j, k] = u


@wp.func
def wall(u: float, index: int, last: int, padding: int) -> float:
    """One velocity component without its outward part inside the walls."""
    if index < padding:
        return wp.max(u, 0.0)
    if index > last - padding:
        return wp.min(u, 0.0)
    return u


@wp.kernel
def g2p(
    node_v: wp.array3d[wp.vec3],
    dt: float,
    dx: float,
    cells: int,
    x: wp.array[wp.vec3],
    v: wp.array[wp.vec3],
    C: wp.array[wp.mat33],
    F: wp.array[wp.mat33],
):
    """Velocities back to the particles, which move with them; F becomes the trial F."""
    p = wp.tid()
    g = x[p] / dx
    if not has_stencil(g, cells):
        return
    bx, by, bz = int(g[0] - 0.5), int(g[1] - 0.5), int(g[2] - 0.5)
    wx, wy, wz = spline(g[0], bx), spline(g[1], by), spline(g[2], bz)
    sx, sy, sz = spline_slope(g[0], bx), spline_slope(g[1], by), spline_slope(g[2], bz)
    velocity = wp.vec3()
    affine = wp.mat33()
    gradient = wp.mat33()
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                slope = wp.vec3(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                reach = wp.vec3(float(bx + i), float(by + j), float(bz + k)) - g
                u = node_v[bx + i, by + j, bz + k]
                velocity = velocity + weight * u
                affine = affine + wp.outer(weight * u, reach)
                gradient = gradient + wp.outer(u, slope)
    v[p] = velocity
    C[p] = (4.0 / dx) * affine
    F[p] = F[p] + (dt / dx) * (gradient * F[p])
    x[p] = x[p] + dt * velocity


@wp.func
def trace(e: wp.vec3) -> float:
    """Sum of the components."""
    return e[0] + e[1] + e[2]


@wp.func
def hencky_tau(mu: float, lam: float, U: wp.mat33, e: wp.vec3) -> wp.mat33:
    """Stress U (2 mu e + lam tr e) U^T for logarithmic principal strains e."""
    volumetric = lam * trace(e)
    principal = 2.0 * mu * e + wp.vec3(volumetric, volumetric, volumetric)
    return U * wp.diag(principal) * wp.transpose(U)


@wp.func
def log_strain(sigma: wp.vec3) -> wp.vec3:
    """Logarithms of the singular values, of which a crushed particle may have one that is not positive."""
    floor = 1.0e-6
    return wp.vec3(
        wp.log(wp.max(sigma[0], floor)), wp.log(wp.max(sigma[1], floor)), wp.log(wp.max(sigma[2], floor))
    )


@wp.func
def recompose(U: wp.mat33, e: wp.vec3, V: wp.mat33) -> wp.mat33:
    """F = U exp(e) V^T."""
    return U * wp.diag(wp.vec3(wp.exp(e[0]), wp.exp(e[1]), wp.exp(e[2]))) * wp.transpose(V)


@wp.kernel
def jelly(F: wp.array[wp.mat33], mu: wp.array[float], lam: wp.array[float], tau: wp.array[wp.mat33]):
    """Fixed corotated (Stomakhin et al. 2012), R from the singular value decomposition."""
    p = wp.tid()
    f = F[p]
    U, sigma, V = wp.svd3(f)
    R = U * wp.transpose(V)
    J = wp.determinant(f)
    tau[p] = 2.0 * mu[p] * (f - R) * wp.transpose(f) + lam[p] * J * (J - 1.0) * wp.identity(n=3, dtype=float)


@wp.kernel
def neo_hookean(F: wp.array[wp.mat33], mu: wp.array[float], lam: wp.array[float], tau: wp.array[wp.mat33]):
    """Stress mu (F F^T - I) + lam ln J I (Bonet & Wood 2008)."""
    p = wp.tid()
    f = F[p]
    pressure = lam[p] * wp.log(wp.determinant(f)) - mu[p]
    tau[p] = mu[p] * f * wp.transpose(f) + pressure * wp.identity(n=3, dtype=float)


@wp.kernel
def metal(
    F: wp.array[wp.mat33],
    mu: wp.array[float],
    lam: wp.array[float],
    yield_stress: wp.array[float],
    tau: wp.array[wp.mat33],
):
    """Von Mises return in logarithmic strain: ||dev tau|| = 2 mu ||dev e|| <= yield_stress."""
    p = wp.tid()
    U, sigma, V = wp.svd3(F[p])
    e = log_strain(sigma)
    mean = trace(e) / 3.0
    deviator = e - wp.vec3(mean, mean, mean)
    size = 2.0 * mu[p] * wp.length(deviator)
    if size > yield_stress[p]:
        e = wp.vec3(mean, mean, mean) + (yield_stress[p] / size) * deviator
        F[p] = recompose(U, e, V)
    tau[p] = hencky_tau(mu[p], lam[p], U, e)


@wp.kernel
def sand(
    F: wp.array[wp.mat33],
    mu: wp.array[float],
    lam: wp.array[float],
    alpha: float,
    tau: wp.array[wp.mat33],
):
    """Drucker-Prager return (Klar et al. 2016), no cohesion."""
    p = wp.tid()
    U, sigma, V = wp.svd3(F[p])
    e = log_strain(sigma)
    volumetric = trace(e)
    mean = volumetric / 3.0
    deviator = e - wp.vec3(mean, mean, mean)
    size = wp.length(deviator)
    excess = size + alpha * (3.0 * lam[p] + 2.0 * mu[p]) / (2.0 * mu[p]) * volumetric
    if volumetric >= 0.0:
        e = wp.vec3()
        F[p] = recompose(U, e, V)
    elif excess > 0.0:
        e = e - (excess / size) * deviator
        F[p] = recompose(U, e, V)
    tau[p] = hencky_tau(mu[p], lam[p], U, e)


@wp.kernel
def fluid(F: wp.array[wp.mat33], bulk_modulus: wp.array[float], tau: wp.array[wp.mat33]):
    """Weakly compressible: tau = -J p I, p = K (J^-gamma - 1) / gamma; only the volume is kept, in F."""
    p = wp.tid()
    J = wp.determinant(F[p])
    one = wp.identity(n=3, dtype=float)
    F[p] = wp.pow(J, 1.0 / 3.0) * one
    tau[p] = (-J * bulk_modulus[p] * (wp.pow(J, -FLUID_EXPONENT) - 1.0) / FLUID_EXPONENT) * one
