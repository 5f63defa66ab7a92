// P2G and G2P on NVIDIA GPUs, compiled at run time with these macros: REAL (float or double), SINGLE (1 for float),
// GRADIENT (the classical stress form instead of MLS), NEO_HOOKEAN (S is F, not the stress), THREADS (of a block).
// Arrays are those of `mpm.transfer`, row by row; sizes = {particles, nx, ny, nz}, scalars = {dt, dx, low, high}.
//
// A warp has 32 particles that are neighbours in memory, and moves their arrays through shared memory: neighbouring
// threads then read and write neighbouring addresses.

#define ALL 0xffffffffu
#define WARPS (THREADS / 32)
#define EACH _Pragma("unroll") for

struct alignas(4 * sizeof(REAL)) Row {
  REAL x, y, z, w;
};

struct Warp {
  int lane, first, count;  // the first particle, and how many there are
  REAL* shared;            // 9 * 32 numbers
};

// N numbers of each particle; threads beyond the last particle get those of the last.
template <int N>
__device__ __forceinline__ void load(const Warp& warp, const REAL* from, REAL* own) {
  from += size_t(N) * warp.first;
  __syncwarp();
  EACH (int k = 0; k < N; ++k) {
    const int place = 32 * k + warp.lane;
    if (place < N * warp.count) warp.shared[place] = from[place];
  }
  __syncwarp();
  EACH (int k = 0; k < N; ++k) own[k] = warp.shared[N * min(warp.lane, warp.count - 1) + k];
}

template <int N>
__device__ __forceinline__ void store(const Warp& warp, REAL* to, const REAL* own) {
  to += size_t(N) * warp.first;
  __syncwarp();
  EACH (int k = 0; k < N; ++k) warp.shared[N * warp.lane + k] = own[k];
  __syncwarp();
  EACH (int k = 0; k < N; ++k) {
    const int place = 32 * k + warp.lane;
    if (place < N * warp.count) to[place] = warp.shared[place];
  }
}

struct Stencil {
  int node;   // flat index of the lowest node
  REAL f[3];  // distance to it in cells, in [0.5, 1.5)
};

// Beyond the window particles write on its rim, as in `transfer`.
__device__ __forceinline__ Stencil find_stencil(const REAL* x, REAL dx, const int* origin, const int* sizes) {
  Stencil made;
  int base[3];
  EACH (int a = 0; a < 3; ++a) {
    const REAL scaled = x[a] / dx, low = floor(scaled - REAL(0.5));
    made.f[a] = scaled - low;
    base[a] = min(max(int(low) - origin[a], 0), sizes[1 + a] - 3);
  }
  made.node = (base[0] * sizes[2] + base[1]) * sizes[3] + base[2];
  return made;
}

// Weight of the k-th of three nodes, its slope [1/cell] and its distance [cells]; f as in Stencil.
__device__ __forceinline__ REAL weigh(int k, REAL f) {
  const REAL g = f - (k == 0 ? REAL(1.5) : k == 1 ? REAL(1) : REAL(0.5));
  return k == 1 ? REAL(0.75) - g * g : REAL(0.5) * g * g;
}
__device__ __forceinline__ REAL slope(int k, REAL f) {
  return k == 0 ? f - REAL(1.5) : k == 1 ? REAL(2) - REAL(2) * f : f - REAL(0.5);
}

__device__ __forceinline__ REAL determinant(const REAL* m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

__device__ __forceinline__ void add_node(REAL* node, REAL x, REAL y, REAL z, REAL w) {
#if __CUDA_ARCH__ >= 900 && SINGLE
  atomicAdd(reinterpret_cast<float4*>(node), make_float4(x, y, z, w));
#else
  atomicAdd(node, x), atomicAdd(node + 1, y), atomicAdd(node + 2, z), atomicAdd(node + 3, w);
#endif
}

// Momentum and mass at the nodes, which are zero at the start. Each thread prepares one particle; then each takes one
// of the 27 nodes and sums over the particles of the warp one after the other. It writes when the stencil changes,
// which is seldom where particles are sorted, and threads beside it write beside it.
extern "C" __global__ void __launch_bounds__(THREADS)
    p2g(const REAL* x, const REAL* v, const REAL* C, const REAL* S, const REAL* mu, const REAL* lam, const REAL* mass,
        const REAL* volume, const REAL* dv, const int* origin, const int* sizes, const REAL* scalars, const REAL*,
        REAL* nodes) {
  __shared__ Row rows[WARPS][GRADIENT ? 8 : 4][32];
  const int number = threadIdx.x / 32, lane = threadIdx.x & 31, first = blockIdx.x * THREADS + 32 * number;
  if (first >= sizes[0]) return;
  Row(*mine)[32] = rows[number];
  const Warp warp = {lane, first, min(32, sizes[0] - first), reinterpret_cast<REAL*>(mine)};
  const int p = first + min(lane, warp.count - 1);
  const REAL dt = scalars[0], dx = scalars[1], m = mass[p], impulse = -dt * volume[p];

  REAL own[9], A[9], position[3], momentum[3];
  load<3>(warp, x, position);
  load<3>(warp, v, momentum);
  load<9>(warp, C, A);
  load<9>(warp, S, own);
  const Stencil at = find_stencil(position, dx, origin, sizes);
#if NEO_HOOKEAN
  REAL tau[9];
  const REAL shear = mu[p], pressure = lam[p] * log(determinant(own));
  EACH (int r = 0; r < 3; ++r)
    EACH (int c = 0; c < 3; ++c) {
      const REAL b = own[3 * r] * own[3 * c] + own[3 * r + 1] * own[3 * c + 1] + own[3 * r + 2] * own[3 * c + 2];
      tau[3 * r + c] = r == c ? shear * (b - REAL(1)) + pressure : shear * b;
    }
#else
  const REAL* tau = own;
#endif
  EACH (int k = 0; k < 9; ++k) A[k] *= m * dx;  // distances in cells from here on
#if !GRADIENT
  EACH (int k = 0; k < 9; ++k) A[k] += REAL(4) / dx * impulse * tau[k];
#endif

  __syncwarp();
  EACH (int d = 0; d < 3; ++d) {
    mine[d][lane] = {A[3 * d], A[3 * d + 1], A[3 * d + 2], m * (momentum[d] + dv[d])};
#if GRADIENT
    const REAL scale = impulse / dx;
    mine[4 + d][lane] = {scale * tau[3 * d], scale * tau[3 * d + 1], scale * tau[3 * d + 2], REAL(0)};
#endif
  }
  mine[3][lane] = {at.f[0], at.f[1], at.f[2], m};
  const int before = __shfl_up_sync(ALL, at.node, 1);
  // Where a run of particles with one stencil ends; the bit after the last particle is set.
  const unsigned starts = __ballot_sync(ALL, lane >= warp.count || before != at.node);
  const int a = lane / 9, b = lane / 3 % 3, c = lane % 3, offset = (a * sizes[2] + b) * sizes[3] + c;
  REAL sum[4] = {0, 0, 0, 0};
  __syncwarp();
#pragma unroll 4
  for (int j = 0; j < warp.count; ++j) {
    const Row place = mine[3][j];
    const REAL w[3] = {weigh(a, place.x), weigh(b, place.y), weigh(c, place.z)}, all = w[0] * w[1] * w[2];
    const REAL o[3] = {REAL(a) - place.x, REAL(b) - place.y, REAL(c) - place.z};
    EACH (int d = 0; d < 3; ++d) {
      const Row row = mine[d][j];
      sum[d] += all * (row.w + row.x * o[0] + row.y * o[1] + row.z * o[2]);
#if GRADIENT
      const Row push = mine[4 + d][j];
      sum[d] += push.x * (slope(a, place.x) * w[1] * w[2]) + push.y * (w[0] * slope(b, place.y) * w[2]) +
                push.z * (w[0] * w[1] * slope(c, place.z));
#endif
    }
    sum[3] += all * place.w;
    if (j == 31 || starts >> (j + 1) & 1) {
      const int node = __shfl_sync(ALL, at.node, j);
      if (lane < 27) add_node(nodes + 4 * size_t(node + offset), sum[0], sum[1], sum[2], sum[3]);
      EACH (int d = 0; d < 4; ++d) sum[d] = 0;
    }
  }
}

// Least value at an address that holds no NaN: numbers are ordered as integers, negative ones backwards.
__device__ __forceinline__ void lower(REAL* address, REAL value) {
  if (*reinterpret_cast<volatile REAL*>(address) <= value) return;
#if SINGLE
  if (value >= 0) atomicMin(reinterpret_cast<int*>(address), __float_as_int(value));
  else atomicMax(reinterpret_cast<unsigned*>(address), __float_as_uint(value));
#else
  if (value >= 0) atomicMin(reinterpret_cast<long long*>(address), __double_as_longlong(value));
  else atomicMax(reinterpret_cast<unsigned long long*>(address), (unsigned long long)__double_as_longlong(value));
#endif
}

// Particles moved and deformed, a thread each. ``extremes`` begin at infinity: least J, -J, det(I + dt grad v) and
// -|v|^2; ``counts`` at zero: particles that are not finite, outside the window, beyond the walls.
extern "C" __global__ void __launch_bounds__(THREADS)
    g2p(const REAL* x, const REAL*, const REAL*, const REAL* F, const REAL* __restrict__ velocity, const int* origin,
        const int* sizes, const REAL* scalars, const REAL*, const int*, REAL* new_x, REAL* new_v, REAL* new_C,
        REAL* new_F, REAL* extremes, int* counts) {
  __shared__ REAL staged[WARPS][9 * 32];
  __shared__ REAL least[WARPS][4];
  const int number = threadIdx.x / 32, lane = threadIdx.x & 31, first = blockIdx.x * THREADS + 32 * number;
  const bool any = first < sizes[0];
  if (any) {
    const Warp warp = {lane, first, min(32, sizes[0] - first), staged[number]};
    const REAL dt = scalars[0], dx = scalars[1];
    REAL position[3], old[9], v[3] = {0, 0, 0}, B[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    load<3>(warp, x, position);
    load<9>(warp, F, old);
    const Stencil at = find_stencil(position, dx, origin, sizes);
#if GRADIENT
    REAL G[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
#endif
    EACH (int a = 0; a < 3; ++a)
      EACH (int b = 0; b < 3; ++b)
        EACH (int c = 0; c < 3; ++c) {
          const REAL* u = velocity + 3 * size_t(at.node + (a * sizes[2] + b) * sizes[3] + c);
          const REAL w[3] = {weigh(a, at.f[0]), weigh(b, at.f[1]), weigh(c, at.f[2])}, all = w[0] * w[1] * w[2];
          EACH (int d = 0; d < 3; ++d) {
            const REAL q = all * u[d];
            v[d] += q;
            B[3 * d] += q * (REAL(a) - at.f[0]);
            B[3 * d + 1] += q * (REAL(b) - at.f[1]);
            B[3 * d + 2] += q * (REAL(c) - at.f[2]);
#if GRADIENT
            G[3 * d] += u[d] * (slope(a, at.f[0]) * w[1] * w[2]);
            G[3 * d + 1] += u[d] * (w[0] * slope(b, at.f[1]) * w[2]);
            G[3 * d + 2] += u[d] * (w[0] * w[1] * slope(c, at.f[2]));
#endif
          }
        }
    EACH (int k = 0; k < 9; ++k) B[k] *= REAL(4) / dx;
#if GRADIENT
    EACH (int k = 0; k < 9; ++k) G[k] /= dx;
#else
    const REAL* G = B;
#endif
    REAL trial[9], strain[9];
    EACH (int r = 0; r < 3; ++r)
      EACH (int c = 0; c < 3; ++c) {
        trial[3 * r + c] =
            old[3 * r + c] + dt * (G[3 * r] * old[c] + G[3 * r + 1] * old[3 + c] + G[3 * r + 2] * old[6 + c]);
        strain[3 * r + c] = dt * G[3 * r + c] + (r == c ? REAL(1) : REAL(0));
      }
    const REAL J = determinant(trial), increment = determinant(strain);
    const REAL square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const bool finite = isfinite(J + increment + v[0] + v[1] + v[2]);
    bool outside = false, beyond = false;
    EACH (int a = 0; a < 3; ++a) {
      position[a] += dt * v[a];
      beyond |= position[a] < scalars[2] || position[a] > scalars[3];
      const REAL within = min(max(position[a], scalars[2]), scalars[3]);
      const int low = int(floor(within / dx - REAL(0.5))) - origin[a];
      outside |= low < 0 || low + 3 > sizes[1 + a];
    }
    store<3>(warp, new_x, position);
    store<3>(warp, new_v, v);
    store<9>(warp, new_C, B);
    store<9>(warp, new_F, trial);

    REAL seen[4] = {finite ? J : REAL(1), finite ? -J : REAL(-1), finite ? increment : REAL(1),
                    finite ? -square : REAL(0)};
    for (int s = 16; s; s >>= 1)
      EACH (int k = 0; k < 4; ++k) seen[k] = min(seen[k], __shfl_xor_sync(ALL, seen[k], s));
    EACH (int k = 0; k < 4; ++k)
      if (lane == k) least[number][k] = seen[k];
    const bool here = lane < warp.count;
    const unsigned lost[3] = {__ballot_sync(ALL, here && !finite), __ballot_sync(ALL, here && outside),
                              __ballot_sync(ALL, here && beyond)};
    EACH (int k = 0; k < 3; ++k)
      if (lane == k && lost[k]) atomicAdd(counts + k, __popc(lost[k]));
  }
  __syncthreads();
  if (threadIdx.x >= 4) return;
  REAL all = least[0][threadIdx.x];  // a block's first warp has particles
  for (int k = 1; k < WARPS && blockIdx.x * THREADS + 32 * k < sizes[0]; ++k) all = min(all, least[k][threadIdx.x]);
  lower(extremes + threadIdx.x, all);
}
