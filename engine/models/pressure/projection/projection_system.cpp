#include "engine/models/pressure/projection/projection_system.h"

#include <Eigen/Eigenvalues>
#include <atomic>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"
#include "engine/models/boundary/wall.h"

namespace whorl {

namespace {

/// Sums of a full lattice, the reference for those of a particle.
struct LatticeSums {
    Real trace = 0, slopes = 0;  ///< sum V |W'| r, sum 2 V |W'|/r [1/m^2]
    Real one_sided = 0;          ///< |sum V W'/r r| of the outermost layer [1/m]
};

template <class Kernel>
LatticeSums lattice_sums(const Kernel& W, const StepContext& step) {
    double trace = 0, slopes = 0, one_sided = 0;
    each_lattice_point(step.dimensions(), static_cast<int>(std::ceil(step.support / step.spacing)), [&](int a, int b, int c) {
        if (a == 0 && b == 0 && c == 0) return;
        const Real r = step.spacing * std::sqrt(static_cast<Real>(a * a + b * b + c * c));
        trace -= static_cast<double>(W.derivative(r) * r);
        slopes -= 2 * static_cast<double>(W.slope(r));
        if (b > 0) one_sided -= static_cast<double>(W.slope(r) * static_cast<Real>(b) * step.spacing);
    });
    const double V = step.volume;
    return {static_cast<Real>(V * trace), static_cast<Real>(V * slopes), static_cast<Real>(V * one_sided)};
}

/// Sums over the fluid neighbours of particle i.
struct OwnSums {
    Real kernel = 0, slopes = 0;
    Mat3d moment = Mat3d::Zero();
    Vec3 imbalance = Vec3::Zero(), spread = Vec3::Zero();
};

template <class Kernel>
OwnSums fluid_sums(const Kernel& W, const FluidPairs& pairs, Index i, Real volume, Real over_first) {
    OwnSums own;
    Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real kernel = 0, slopes = 0, part[6] = {0, 0, 0, 0, 0, 0}, plain[3] = {0, 0, 0}, weighted[3] = {0, 0, 0};
        for (Index l = 0; l < group.padded(); ++l) {
            const Real r = group.distance[l], F = W.slope(r), value = W.value(r), q = value * over_first;
            const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], f = F * (1 + Real(0.2) * q * q * q * q);
            kernel += value, slopes -= F;
            part[0] -= F * x * x, part[1] -= F * x * y, part[2] -= F * x * z;
            part[3] -= F * y * y, part[4] -= F * y * z, part[5] -= F * z * z;
            plain[0] += F * x, plain[1] += F * y, plain[2] += F * z;
            weighted[0] += f * x, weighted[1] += f * y, weighted[2] += f * z;
        }
        own.kernel += kernel, own.slopes += slopes;
        xx += part[0], xy += part[1], xz += part[2], yy += part[3], yz += part[4], zz += part[5];
        own.imbalance += Vec3(plain[0], plain[1], plain[2]);
        own.spread += Vec3(weighted[0], weighted[1], weighted[2]);
    });
    own.moment << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    own.moment *= volume;
    own.kernel *= volume, own.slopes *= 2 * volume;
    own.imbalance *= volume, own.spread *= volume;
    return own;
}

template <class Kernel>
void set_linear_sums(const Kernel& W, const InteractionContext& context, Index i, LinearSums& sums) {
    Real M[6] = {0, 0, 0, 0, 0, 0};
    Vec3 imbalance = Vec3::Zero();
    context.pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real part[6] = {0, 0, 0, 0, 0, 0}, plain[3] = {0, 0, 0};
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]), x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            part[0] -= F * x * x, part[1] -= F * x * y, part[2] -= F * x * z;
            part[3] -= F * y * y, part[4] -= F * y * z, part[5] -= F * z * z;
            plain[0] += F * x, plain[1] += F * y, plain[2] += F * z;
        }
        for (int k = 0; k < 6; ++k) M[k] += part[k];
        imbalance += Vec3(plain[0], plain[1], plain[2]);
    });
    Mat3d moment;
    moment << M[0], M[1], M[2], M[1], M[3], M[4], M[2], M[4], M[5];
    moment *= context.step.volume;
    sums.correction[i] = pseudo_inverse(moment, context.step.dimensions()).template cast<Real>();
    sums.trace[i] = static_cast<Real>(moment.trace());
    sums.imbalance[i] = context.step.volume * imbalance;
}

/// Calls f(to, distance) for the sites within the support of a lattice that continues the fluid behind walls that meet in an edge or a
/// corner. `to` points from the site to the particle. The columns of each_layer() do not fill the region that lies behind several walls.
template <class F>
void each_site_behind(const NearWalls& walls, const StepContext& step, F&& f) {
    const Real d = step.spacing;
    Vec3 axis[3];
    Real start[3] = {0, 0, 0};  // of the layers, which lie half a spacing above and below each wall
    int axes = 0;
    for (std::size_t k = 0; k < walls.count && axes < 3; ++k) {
        Vec3 part = walls.normal[k];
        for (int a = 0; a < axes; ++a) part -= part.dot(axis[a]) * axis[a];
        if (part.norm() < Real(0.4)) continue;
        axis[axes] = part.normalized();
        start[axes++] = d / 2 - walls.height[k];
    }
    if (axes < 3) axis[2] = axis[0].cross(axis[1]);
    int low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = static_cast<int>(std::ceil((-step.support - start[k]) / d));
        high[k] = static_cast<int>(std::floor((step.support - start[k]) / d));
    }
    if (step.dimensions() == 2) start[2] = 0, low[2] = high[2] = 0;
    for (int a = low[0]; a <= high[0]; ++a)
        for (int b = low[1]; b <= high[1]; ++b)
            for (int c = low[2]; c <= high[2]; ++c) {
                const Vec3 at = start[0] * axis[0] + start[1] * axis[1] + start[2] * axis[2] +
                                d * (static_cast<Real>(a) * axis[0] + static_cast<Real>(b) * axis[1] + static_cast<Real>(c) * axis[2]);
                bool behind = false;
                for (std::size_t k = 0; k < walls.count; ++k) behind = behind || walls.above(k, at) < 0;
                if (const Real distance = at.norm(); behind && distance < step.support) f(Vec3(-at), distance);
            }
}

/// Whether the fluid continues behind one of the walls, as beyond a convex edge.
bool ends_near(const NearWalls& walls, const InteractionContext& context, Index i) {
    bool ends = false;
    context.pairs.of(i, [&](Index, const Vec3& r, Real) {
        for (std::size_t k = 0; k < walls.count; ++k) ends = ends || walls.above(k, -r) < -context.step.spacing / 4;
    });
    return ends;
}

/// Whether a boundary particle lies behind another wall than its own, as where two planes cross. @param to from the particle to it
bool covered(const NearWalls& walls, const Vec3& normal, const Vec3& to, Real spacing) {
    for (std::size_t k = 0; k < walls.count; ++k) {
        const bool own = normal.dot(walls.normal[k]) > Real(0.3);  // also of boundary particles on an edge
        if (!own && walls.above(k, to) < -spacing / 4) return true;
    }
    return false;
}

/// Scales the fluxes of the walls around i to the deficit of the fluid's sums at i, so that the matrix is exact for a linear pressure. The
/// columns of layers belong to a flat wall. Behind a curved wall they contain too much: a third too much for a ball of four spacings.
void match_fluxes(const InteractionContext& context, Index i, const Vec3& imbalance, ProjectionSystem& s) {
    Vec3 total = Vec3::Zero();
    s.walls_of(i, [&](const WallTouch& touch) { total += touch.flux * context.boundary.normal[touch.s]; });
    const Real square = total.squaredNorm();
    if (!(square > 0)) return;
    const Real share = std::clamp(-2 * imbalance.dot(total) / square, Real(0.3), Real(1.3));
    for (std::size_t k = s.first_touch[i]; k < s.first_touch[i + 1]; ++k) s.touches[k].flux *= share;
}

void set_viscous_sums(const InteractionContext& context, ProjectionSystem& s) {
    const Index n = context.pairs.size();
    s.viscous.resize(n), s.inside.resize(n);
    with_viscous_kernels(context.step, [&](const auto& sharp, const auto& narrow) {
        parallel_for(n, [&](Index i) {
            s.inside[i] = s.options.sharp && !s.near_surface[i] && (!s.any_walls || context.solid_pairs.count(i) == 0);
            if (s.inside[i]) set_linear_sums(sharp, context, i, s.viscous);
            else set_linear_sums(narrow, context, i, s.viscous);
        });
    });
}

/// Sets the weights of the velocity gradient G_i in the divergence at i:
///   D_i = K : G_i - sum_k flux_k (u_i - U_k).n_k,   K = I + sum_k flux_k height_k n_k n_k^T - sum_e kappa_e v_e v_e^T,
/// over the boundary particles k, with the velocity U_k, and the eigenvectors v_e of L_i. A pressure p_i changes u_i in proportion to
/// L_i b_i, with the imbalance b_i, and so D_i in proportion to sum_e [-l_e b_e total_e - (l_e b_e)^2 v_e.K v_e], with the eigenvalues l_e
/// of L_i and total = sum_k flux_k n_k. If this sum is negative, the pressure increases the divergence that it should remove. Then kappa_e
/// makes each negative term 0.
void weigh_gradient(const InteractionContext& context, Index i, ProjectionSystem& s) {
    Mat3 K = Mat3::Identity();
    Vec3 total = Vec3::Zero();
    s.walls_of(i, [&](const WallTouch& touch) {
        const Vec3& n = context.boundary.normal[touch.s];
        K += touch.flux * touch.height * n * n.transpose();
        total += touch.flux * n;
    });
    Eigen::SelfAdjointEigenSolver<Mat3> L;
    L.computeDirect(s.whole.correction[i]);
    Real sum = 0;
    Mat3 change = Mat3::Zero();
    for (int e = 0; e < 3; ++e) {
        const Vec3 v = L.eigenvectors().col(e);
        const Real push = L.eigenvalues()[e] * s.whole.imbalance[i].dot(v), weight = v.dot(K * v), adds = push * push * weight;
        const Real removes = -push * total.dot(v);
        sum += removes - adds;
        if (adds > std::max(Real(0), removes)) change += (1 - std::max(Real(0), removes) / adds) * weight * v * v.transpose();
    }
    s.of_gradient[i] = sum < 0 ? Mat3(K - change) : K;
}

/// @param fullness fraction of a full neighbourhood @param slopes sum 2 V |W'|/r over fluid and solids @param full sums of a lattice
void find_surface(const InteractionContext& context, Read<field::role> role, const std::vector<Real>& fullness,
                  const std::vector<Real>& slopes, const LatticeSums& full, ProjectionSystem& s) {
    const Real d = context.step.spacing;
    const Index n = context.pairs.size();
    // The outermost layer of a lattice has .6 of a full neighbourhood, the next layer .9. After a surface has contracted, its outermost
    // layer has more than .6.
    constexpr Real certainly = Real(0.725), loosely = Real(0.85), densely = Real(1.2), inside = Real(0.95);
    constexpr Real cone = std::numbers::sqrt2_v<Real> / 2;
    parallel_for(n, [&](Index i) {
        if (role[i] != 0 || fullness[i] > densely) return;
        if (fullness[i] > loosely && !(s.inward[i].norm() > full.one_sided / 2)) return;
        Vec3 out = -s.inward[i].normalized();
        s.walls_of(i, [&](const WallTouch& touch) {  // only along walls, because the gap between a particle and a wall is not a surface
            const Vec3& normal = context.boundary.normal[touch.s];
            out -= std::min(Real(0), out.dot(normal)) * normal;
        });
        if (out.norm() < Real(0.5)) return;
        out.normalize();
        const auto ahead = [&](const Vec3& r, Real distance) { return distance < Real(2.2) * d && -r.dot(out) > cone * distance; };
        bool free = true;
        if (fullness[i] >= certainly) {
            context.pairs.of(i, [&](Index, const Vec3& r, Real distance) { free = free && !ahead(r, distance); });
            if (s.any_walls)
                context.solid_pairs.of(i, [&](Index q, const Vec3& r, Real distance) {
                    free = free && !(ahead(r, distance) && context.boundary.normal[q].dot(out) < -cone);
                });
        }
        s.surface[i] = free;
    });
    parallel_for(n, [&](Index i) {
        bool near = s.surface[i] || fullness[i] < inside;
        if (!near) context.pairs.of(i, [&](Index j, const Vec3&, Real) { near = near || s.surface[j]; });
        s.near_surface[i] = near;
        if (near) s.air[i] = std::max(Real(0), full.slopes - slopes[i]);
    });
}

}  // namespace

void ProjectionGeometry::operator()(const InteractionContext& context, Read<field::role> role, Write<field::density> rho) const {
    ProjectionSystem& s = *system;
    const StepContext& step = context.step;
    const BoundaryParticles& boundary = context.boundary;
    const Index n = context.pairs.size();
    s.whole.resize(n), s.spread.resize(n), s.inward.resize(n);
    s.gate.resize(n), s.air.assign(n, 0), s.surface.assign(n, 0), s.near_surface.assign(n, 0), s.near_edge.assign(n, 0);
    s.first_touch.assign(static_cast<std::size_t>(n) + 1, 0);
    s.any_walls = boundary.size() > 0 && !context.solid_pairs.other.empty();
    if (s.any_walls)
        for (Index i = 0; i < n; ++i) s.first_touch[i + 1] = s.first_touch[i] + static_cast<std::size_t>(context.solid_pairs.count(i));
    s.touches.resize(s.first_touch[n]);
    std::atomic<bool> narrow = false;
    s.mirrors.find(context);
    s.slides.resize(s.mirrors.size());
    parallel_for(s.mirrors.size(), [&](Index g) {
        const Mirrors::Image& image = s.mirrors.image(g);
        s.slides[g] = std::all_of(image.wall, image.wall + image.count,
                                  [&](const Mirrors::Wall& wall) { return context.solids.all[wall.solid].slides_freely(); });
    });
    const Real d = step.spacing, V = step.volume;
    const Real of_layer = s.any_walls ? layer_factor(step.kernel, step.support, d) : 0;

    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const LatticeSums full = lattice_sums(W, step);
        const Real over_first = 1 / W.value(d);
        std::vector<Real> fullness(n), slopes(n);
        parallel_for(n, [&](Index i) {
            OwnSums own = fluid_sums(W, context.pairs, i, V, over_first);
            s.whole.correction[i] = pseudo_inverse(own.moment, step.dimensions()).template cast<Real>();
            s.whole.trace[i] = static_cast<Real>(own.moment.trace()), s.whole.imbalance[i] = own.imbalance;
            s.gate[i] = 1;
            Real wall_trace = 0, wall_kernel = 0, wall_slopes = 0;
            Vec3 wall = Vec3::Zero(), wall_spread = Vec3::Zero();
            const auto add_wall = [&](Real volume, const Vec3& to, Real distance) {
                const Real F = volume * W.slope(distance), value = W.value(distance), first = value * over_first;
                wall_trace -= F * distance * distance;
                wall_kernel += volume * value, wall_slopes -= 2 * F;
                wall += F * to;
                wall_spread += F * (1 + Real(0.2) * first * first * first * first) * to;
            };
            if (s.any_walls && context.solid_pairs.count(i) > 0) {
                s.gate[i] = s.options.gate.weight(W, i, context.solid_pairs, boundary.volume, 1);
                const NearWalls walls = s.options.free_surface ? NearWalls{} : walls_near(context, i, step.support);
                const bool meet = walls.meet(step.support), ends = meet && ends_near(walls, context, i);
                const auto in_solid = [&](const Vec3& x) {
                    Real distance = 0;
                    return context.solids.nearest(x, distance) >= 0 && distance < 0;
                };
                Vec3 x = Vec3::Zero();
                s.near_edge[i] = meet && walls.meet(Real(1.5) * d);
                if (step.dimensions() == 3 && (ends || walls.least_gap() < Real(5.5) * d)) narrow.store(true, std::memory_order_relaxed);
                std::size_t k = s.first_touch[i];
                context.solid_pairs.of(i, [&](Index q, const Vec3& r, Real) {
                    const Vec3& normal = boundary.normal[q];
                    const Real volume = s.gate[i] * of_layer * boundary.volume[q], above = r.dot(normal);
                    x = boundary.position[q] + r;
                    const bool open = above > 0 && !(ends   ? in_solid(boundary.position[q] + Real(0.6) * d * normal)
                                                     : meet ? covered(walls, normal, -r, d)
                                                            : false);
                    Real flux = 0;
                    each_layer(r, normal, d, step.support, [&](const Vec3& to, Real distance, Real) {
                        if (open) flux += 2 * volume * W.slope(distance) * to.dot(normal);
                        if (!meet) add_wall(volume, to, distance);
                    });
                    s.touches[k++] = {q, flux, above - d / 2};
                });
                if (meet)
                    each_site_behind(walls, step, [&](const Vec3& to, Real distance) {
                        if (!ends || in_solid(x - to)) add_wall(s.gate[i] * V, to, distance);
                    });
                match_fluxes(context, i, own.imbalance, s);
            }
            s.spread[i] = own.spread + wall_spread;
            s.inward[i] = own.imbalance + wall;
            slopes[i] = own.slopes + wall_slopes;
            rho[i] = step.rest_density * (V * W.value(0) + own.kernel + wall_kernel);
            fullness[i] = static_cast<Real>(own.moment.trace()) / std::max(Real(0.3) * full.trace, full.trace - wall_trace);
        });
        s.narrow = narrow;
        s.of_gradient.assign(s.narrow ? n : 0, Mat3::Identity());
        if (s.narrow)
            parallel_for(n, [&](Index i) {
                if (context.solid_pairs.count(i) > 0) weigh_gradient(context, i, s);
            });
        if (s.options.free_surface) find_surface(context, role, fullness, slopes, full, s);
    });
    set_viscous_sums(context, s);
}

}  // namespace whorl
