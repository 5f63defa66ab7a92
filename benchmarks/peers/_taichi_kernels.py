"""The stages of one MLS-MPM substep as Taichi kernels: clear, p2g (with F, return mapping and stress), grid, g2p.

Quadratic B-splines, APIC and the stress form of Hu et al. 2018 (MLS-MPM), on a dense cube of nodes. Import only
where Taichi is installed, after `ti.init`. No ``from __future__ import annotations`` here: Taichi needs the
annotations of a kernel as types.
"""

# The bodies are Taichi's language, not Python.
# pyright: reportIndexIssue=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAttributeAccessIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import taichi as ti
import taichi.math as tm

JELLY, NEO_HOOKEAN, METAL, SAND, FLUID = range(5)
STICKY, SLIP, SEPARATE = range(3)
FLUID_EXPONENT = 7.0
LEAST_STRETCH = 1e-6  # of a crushed particle, whose logarithm is taken


@ti.data_oriented
class Fields:
    """Particles and nodes of one scene, and the kernels on them.

    What does not change during a run is a compile-time constant: the law, the planes, the damping.

    Args:
        count: Particles.
        cells: Along a side; nodes are 0..cells.
        dx: [m].
        dt: [s].
        law: One of the constants above.
        gravity: [m/s^2].
        planes: (point, unit normal, contact, friction) each.
        padding: Walls as in `PeerScene.domain_box`; 0 = none.
        keep, swap: The affine part that P2G carries is keep * C - swap * C^T.
        empty: Nodes with less mass carry nothing [kg].
        slope: alpha of the Drucker-Prager cone.
    """

    def __init__(self, count, cells, dx, dt, law, gravity, planes, padding, keep, swap, empty, slope):
        self.cells, self.dx, self.dt = cells, dx, dt
        self.law, self.gravity, self.planes, self.padding = law, gravity, planes, padding
        self.keep, self.swap, self.empty, self.slope = keep, swap, empty, slope
        self.x, self.v = ti.Vector.field(3, ti.f32, count), ti.Vector.field(3, ti.f32, count)
        self.C, self.F = ti.Matrix.field(3, 3, ti.f32, count), ti.Matrix.field(3, 3, ti.f32, count)
        self.mass, self.volume = ti.field(ti.f32, count), ti.field(ti.f32, count)
        # mu and lam; FLUID: first is the bulk modulus. `bound` is the yield stress of METAL.
        self.first, self.second, self.bound = (ti.field(ti.f32, count) for _ in range(3))
        nodes = (cells + 1,) * 3
        self.node_v, self.node_mass = ti.Vector.field(3, ti.f32, nodes), ti.field(ti.f32, nodes)
        self.lost = ti.field(ti.i32, ())

    @ti.kernel
    def clear(self):
        """Empty the nodes."""
        for node in ti.grouped(self.node_mass):
            self.node_v[node] = ti.Vector([0.0, 0.0, 0.0])
            self.node_mass[node] = 0.0

    @ti.kernel
    def p2g(self):
        """F grows with C and returns to the yield surface; stress and momentum go to the nodes."""
        inverse = ti.static(1.0 / self.dx)
        for p in self.x:
            g = self.x[p] * inverse
            if self.has_stencil(g):
                C = self.C[p]
                F, tau = self.respond(p, self.F[p] + self.dt * (C @ self.F[p]))
                self.F[p] = F
                base = ti.cast(g - 0.5, ti.i32)
                f = g - ti.cast(base, ti.f32)
                w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
                m = self.mass[p]
                carried = self.keep * C - self.swap * C.transpose()
                affine = m * carried - (4.0 * self.dt * inverse * inverse * self.volume[p]) * tau
                momentum = m * self.v[p]
                for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                    offset = ti.Vector([i, j, k])
                    weight = w[i][0] * w[j][1] * w[k][2]
                    reach = (ti.cast(offset, ti.f32) - f) * self.dx
                    self.node_v[base + offset] += weight * (momentum + affine @ reach)
                    self.node_mass[base + offset] += weight * m
            else:
                self.lost[None] += 1

    @ti.kernel
    def grid(self):
        """Momentum to velocity, gravity, all planes in order, and the walls, in one pass."""
        for node in ti.grouped(self.node_mass):
            m = self.node_mass[node]
            if m > self.empty:
                u = self.node_v[node] / m + self.dt * ti.Vector(self.gravity)
                position = self.dx * ti.cast(node, ti.f32)
                for plane in ti.static(self.planes):
                    normal = ti.Vector(plane[1])
                    # A node on the plane is in the solid; the tolerance covers round-off of its position.
                    if (position - ti.Vector(plane[0])).dot(normal) <= 1e-4 * self.dx:
                        u = self.behind(u, normal, ti.static(plane[2]), ti.static(plane[3]))
                for d in ti.static(range(3)):
                    if node[d] < self.padding:
                        u[d] = ti.max(u[d], 0.0)
                    if node[d] > self.cells - self.padding and ti.static(self.padding > 0):
                        u[d] = ti.min(u[d], 0.0)
                self.node_v[node] = u
            else:
                self.node_v[node] = ti.Vector([0.0, 0.0, 0.0])

    @ti.kernel
    def g2p(self):
        """Velocities and C back to the particles, which move."""
        inverse = ti.static(1.0 / self.dx)
        for p in self.x:
            g = self.x[p] * inverse
            if self.has_stencil(g):
                base = ti.cast(g - 0.5, ti.i32)
                f = g - ti.cast(base, ti.f32)
                w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
                velocity = ti.Vector.zero(ti.f32, 3)
                affine = ti.Matrix.zero(ti.f32, 3, 3)
                for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                    offset = ti.Vector([i, j, k])
                    share = w[i][0] * w[j][1] * w[k][2] * self.node_v[base + offset]
                    velocity += share
                    affine += share.outer_product(ti.cast(offset, ti.f32) - f)
                self.v[p] = velocity
                self.C[p] = (4.0 * inverse) * affine
                self.x[p] += self.dt * velocity

    @ti.func
    def has_stencil(self, g):
        """Return whether all 27 nodes exist; false also for what is not a number."""
        return g.min() >= 0.5 and g.max() < self.cells - 0.5 and g.sum() == g.sum()

    @ti.func
    def behind(self, u, normal, contact: ti.template(), friction: ti.template()):
        """The velocity that a plane lets pass."""
        result = ti.Vector([0.0, 0.0, 0.0])
        if ti.static(contact != STICKY):
            approach = u.dot(normal)
            along = u - approach * normal
            if ti.static(contact == SLIP):
                result = along
            else:
                result = u
                if approach < 0.0:
                    speed = along.norm()
                    result = ti.max(1.0 + friction * approach / ti.max(speed, 1e-30), 0.0) * along
        return result

    @ti.func
    def respond(self, p, trial):
        """F after the return mapping, and the Kirchhoff stress; one decomposition serves both."""
        F, tau = trial, ti.Matrix.zero(ti.f32, 3, 3)
        one = ti.Matrix.identity(ti.f32, 3)
        mu, lam = self.first[p], self.second[p]
        if ti.static(self.law == NEO_HOOKEAN):
            tau = mu * (F @ F.transpose() - one) + lam * ti.log(F.determinant()) * one
        elif ti.static(self.law == FLUID):
            J = F.determinant()
            F = J ** (1.0 / 3.0) * one
            tau = (-J * mu * (J**-FLUID_EXPONENT - 1.0) / FLUID_EXPONENT) * one
        elif ti.static(self.law == JELLY):
            U, _, V = ti.svd(F)
            J = F.determinant()
            tau = 2.0 * mu * (F - U @ V.transpose()) @ F.transpose() + lam * J * (J - 1.0) * one
        else:
            U, S, V = ti.svd(F)
            strain = ti.Vector([ti.log(ti.max(S[d, d], LEAST_STRETCH)) for d in ti.static(range(3))])
            kept, yields = self.admissible(p, strain)
            if yields:
                F = U @ diagonal(ti.exp(kept)) @ V.transpose()
            tau = U @ diagonal(2.0 * mu * kept + lam * kept.sum()) @ U.transpose()
        return F, tau

    @ti.func
    def admissible(self, p, strain):
        """Logarithmic strain on or within the yield surface, and whether it had to be brought there."""
        mu, lam = self.first[p], self.second[p]
        kept, yields = strain, False
        trace = strain.sum()
        deviator = strain - trace / 3.0
        size = deviator.norm()
        if ti.static(self.law == METAL):
            if 2.0 * mu * size > self.bound[p]:
                kept, yields = trace / 3.0 + deviator * (self.bound[p] / (2.0 * mu * size)), True
        else:  # Klar et al. 2016
            excess = size + self.slope * (3.0 * lam + 2.0 * mu) / (2.0 * mu) * trace
            if trace >= 0.0:
                kept, yields = ti.Vector([0.0, 0.0, 0.0]), True
            elif excess > 0.0:
                kept, yields = strain - deviator * (excess / size), True
        return kept, yields


@ti.func
def diagonal(values):
    """The matrix with these on its diagonal."""
    return tm.mat3(values[0], 0, 0, 0, values[1], 0, 0, 0, values[2])
