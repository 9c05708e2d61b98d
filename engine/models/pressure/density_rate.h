#pragma once
/// Rate of change of every particle's density, as a linear function of the velocities, and its transpose (docs/physics.md 3).
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/math/kernel.h"
#include "engine/models/pressure/mirrors.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

/// Contribution of a solid to the density of a fluid particle, through the boundary particles. The space behind the surface is treated as
/// full of fluid with the density of the particle's surroundings,
///   rho_i = (m W_ii + sum_j m W_ij)/(1 - w_i),   w_i = sum_s V_s W(|r'_is|).
/// Like a mirror image, this fluid approaches i `stretch` times as fast as the boundary particle s does: r'_is is r_is, with the component
/// along the normal of s replaced by d + stretch (r_is.n_s - d). So on a lattice that touches a flat wall the density is that of the
/// lattice without a wall, and a uniform pressure exerts no force.
struct WallImage {
    Real factor;   ///< factor on the volumes of boundary particles
    Real stretch;  ///< 1.85 for the cubic kernel with R = 2 d
    Real virial;   ///< factor on the boundary particles' part of a particle's virial (DensityRate::virial)
    Real spacing;  ///< m
    Real nearest;  ///< if an image is closer than this along the normal, w grows linearly [m]
    /// By solid; 1: w stays constant for images closer than `nearest`. Empty: w grows at all solids. The value is 1 for free bodies lighter
    /// than the fluid. With growth these would float 0.05 d higher, up to 0.19 d above Archimedes' height
    /// (tests/validation/simulation/bodies.cpp).
    std::vector<char> constant_when_near;
    SolidGate gate;  ///< the gate's weight multiplies w_i, in the density and in the density's derivative
    WallImage(KernelForm kernel, Real support, Real spacing, SolidGate gate = {});
    WallImage(const InteractionContext& context, SolidGate gate);

    /// Contribution of a boundary particle: `value` to w_i, `gradient` of this value with respect to x_i, `pull` -V W' |r'|.
    struct Share {
        Real value, pull;
        Vec3 gradient;
    };
    template <class Kernel>
    Share share(const Kernel& W, const Vec3& r, Real distance, const BoundaryParticles& boundary, Index s) const {
        const Vec3& normal = boundary.normal[s];
        if (boundary.behind[s] == 0) return edge_share(W, r, boundary, s);
        const Real V = factor * boundary.volume[s] * boundary.behind[s], height = r.dot(normal);
        Vec3 g = r;
        Real beyond = 0;   // by how much the image is closer than `nearest`
        if (height > 0) {  // else i is behind the face of s
            const Real wanted = spacing + stretch * (height - spacing), image = std::max(wanted, nearest);
            beyond = image - wanted;
            g += (stretch * image - height) * normal;
            distance = std::sqrt(std::max(Real(0), r.squaredNorm() - height * height) + image * image);
        }
        const Real slope = W.slope(distance);
        g *= V * slope;
        if (!constant_when_near.empty() && constant_when_near[boundary.solid[s]]) beyond = 0;
        return {V * (W.value(distance) - slope * nearest * beyond), -V * slope * distance * distance * virial, g};
    }
    /// Share of a boundary particle on an edge. At a convex edge the height h of i above each face that i is in front of is replaced by h
    /// [1 + (stretch - 1)(h/d - 1)]. Particles on other edges act at their own positions.
    template <class Kernel>
    [[gnu::noinline]] Share edge_share(const Kernel& W, const Vec3& r, const BoundaryParticles& boundary, Index s) const {
        const Vec3 &normal = boundary.normal[s], &one = boundary.face[s];
        Vec3 image = r, g = r;
        const auto face = [&](const Vec3& n) {
            const Real h = r.dot(n), near = (stretch - 1) / spacing * h;
            if (h <= 0) return;
            const Real at = h * (2 - stretch + near);
            image += (at - h) * n, g += (at * (2 - stretch + 2 * near) - h) * n;
        };
        if (!one.isZero()) {
            const Real part = one.dot(normal);
            const Vec3 rest = normal / part - one, other = part > Real(0.6) ? Vec3::Zero() : one.cross(rest);
            face(one);
            if (other.isZero()) face(rest);
            else face((rest + other) / 2), face((rest - other) / 2);
        }
        const Real V = factor * boundary.volume[s], distance = image.norm(), slope = W.slope(distance);
        return {V * W.value(distance), -V * slope * distance * distance * virial, V * slope * g};
    }
    /// `left`: fraction of the volume around i that solids leave to the fluid, if they fill the fraction w; 1 - w, but always positive.
    /// `slope`: -d left/dw.
    struct FreeVolume {
        Real left, slope;
    };
    static FreeVolume free_volume(Real w) {
        constexpr Real least = Real(0.25);
        if (w <= 1 - least) return {1 - w, 1};
        const Real left = least * std::exp((1 - least - w) / least);
        return {left, left / least};
    }
};

/// Terms of the density of one particle.
struct DensityRow {
    Real density, fill;  ///< rho_i, f_i
    Vec3 own;            ///< kg/m^4
    Real wall_slope;     ///< (d rho_i/d w_i)/(f_i rho_i)
    Real squares;        ///< sum_j |g_ij|^2
    Real pull;           ///< -sum_j m W' r + rho_i times the sum of Share::pull [kg/m^3]
};

/// @param fluid_neighbours called as f<image>(group, c) with g_ij = c r @param solid_neighbour called as f(s, r, Share)
template <class Kernel, class Fluid, class SolidPart>
DensityRow density_row(const WallImage& wall, const Kernel& W, const InteractionContext& context, const Mirrors& mirrors, Index i,
                       Fluid&& fluid_neighbours, SolidPart&& solid_neighbour) {
    const Real mass = context.step.mass;
    Vec3 fluid = Vec3::Zero(), walls = Vec3::Zero();
    Real density = mass * W.value(0), squares = 0, pull = 0, w = 0, wall_pull = 0;
    const Real left = 1 - mirrors.part(i);
    mirrors.groups_of(context.pairs, i, [&]<bool image>(const Pairs::Group& group, const Real* weight) {
        alignas(64) Real c[Pairs::Group::most];
        Real x = 0, y = 0, z = 0, sum = 0, sum_squares = 0, sum_pull = 0;
        for (Index l = 0; l < group.padded(); ++l) {
            const Real r = group.distance[l], a = image ? weight[l] : Real(1), slope = a * mass * W.slope(r), part = slope * r * r;
            c[l] = slope;
            x += slope * group.r[0][l];
            y += slope * group.r[1][l];
            z += slope * group.r[2][l];
            sum += a * W.value(r);
            sum_pull -= part;
            sum_squares += slope * part;
        }
        fluid += Vec3(x, y, z);
        density += mass * sum;
        squares += sum_squares;
        pull += sum_pull;
        fluid_neighbours.template operator()<image>(group, static_cast<const Real*>(c));
    });
    if (left > 0 && context.boundary.size() > 0)
        context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
            const WallImage::Share share = wall.share(W, r, distance, context.boundary, s);
            w += share.value;
            wall_pull += share.pull;
            walls += share.gradient;
            solid_neighbour(s, r, share);
        });
    if (left < 1) w *= left;
    const SolidGate::Gated gated = wall.gate.gated(w);
    const WallImage::FreeVolume free_volume = WallImage::free_volume(gated.sum);
    const Real f = 1 / free_volume.left, rho = f * density;
    Real slope = gated.slope * free_volume.slope;
    if (left < 1) slope *= left;
    return {rho, f, f * (fluid + rho * slope * walls), slope, squares, pull + rho * slope * wall_pull};
}

/// The density of density_row() alone.
template <class Kernel>
Real density_at(const WallImage& wall, const Kernel& W, const InteractionContext& context, const Mirrors& mirrors, Index i) {
    Real sum = W.value(0), w = 0;
    const Real left = 1 - mirrors.part(i);
    mirrors.groups_of(context.pairs, i, [&]<bool image>(const Pairs::Group& group, const Real* weight) {
        Real part = 0;
        for (Index l = 0; l < group.padded(); ++l) part += (image ? weight[l] : Real(1)) * W.value(group.distance[l]);
        sum += part;
    });
    if (left > 0 && context.boundary.size() > 0)
        context.solid_pairs.of(i,
                               [&](Index s, const Vec3& r, Real distance) { w += wall.share(W, r, distance, context.boundary, s).value; });
    if (left < 1) w *= left;
    return context.step.mass * sum / WallImage::free_volume(wall.gate.gated(w).sum).left;
}

/// Three components and a zero: one vector register.
using Padded = Eigen::Matrix<Real, 4, 1>;
inline Padded padded(const Vec3& v) { return {v[0], v[1], v[2], 0}; }

/// (D u)_i = d rho_i/dt = own_i.u_i - f_i sum_j g_ij.u_j - wall_i,   g_ij = m grad W_ij = c_ij r_ij,   f_i = 1/(1 - w_i)
/// wall_i is the contribution of moving solids. D is the exact derivative of the density of WallImage, so the forces D^T q that limit the
/// densities derive from an energy.
struct DensityRate {
    Span<const std::size_t> first;  ///< rows of the pairs that D was built from, each followed by its images
    Span<const Index> other;        ///< particles; images from size() on
    Column<Real> slope;             ///< c_ij by pair [kg/m^5]. Together with x it takes a third of the memory and reads of g_ij
    mutable Column<Padded> x;       ///< positions of particles and images [m]; in a product the fourth component is f_i q_i
    Vec3 period = Vec3::Zero();     ///< Domain::period()
    Column<Real> fill;              ///< f_i
    Column<Vec3> own;               ///< own_i [kg/m^4]
    Column<Real> diagonal;          ///< of D D^T [kg^2/m^8]; 0 if the density cannot change
    /// (f_i sum_j V_j |W'_ij| |r_ij|)/(number of dimensions), images of solids included: 1 for an exact gradient, 1.02 on a lattice with R
    /// = 2 d, up to 1.05 after particles have left the lattice. The pair forces of q exert a pressure (their virial) of q times this
    /// factor.
    Column<Real> virial;
    Mirrors mirrors;         ///< walls with images of the fluid, which are neighbours, too
    std::vector<char> free;  ///< 0: the velocity is prescribed (inside a nozzle), so the particle has no pressure and does not react

    Index size() const { return static_cast<Index>(own.size()); }

    /// @param rho written @param rate written: D u, including prescribed particles and solids
    void build(const WallImage& wall, const InteractionContext& context, Read<field::role> role, Read<field::velocity> u, Span<Real> rho,
               Span<Real> rate);
    /// Writes rho_i(x + dt v) - rho_i(x) - dt (D v)_i [kg/m^3]: the error of the linear D for displacements dt v, with the pairs kept.
    /// Solids rotate as they do within a step. @param rho at x @param poses of the solids; free bodies move with the velocities in them
    void bend(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Vec3> v,
              const std::vector<Pose>& poses, Span<Real> change) const;
    /// Calls f(j, g_ij) for row i: j is a neighbour, or the owner of an image that is a neighbour.
    template <class F>
    void row(Index i, const F& f) const {
        for (std::size_t k = first[i]; k < first[i + 1]; ++k)
            f(other[k] < size() ? other[k] : mirrors.owner(other[k] - size()), gradient(i, other[k], slope[k]));
    }
    /// c_ij of the images of i.
    const Real* image_slopes(Index i) const { return slope.data() + first[i + 1] - mirrors.count(i); }
    /// v = D^T q of free particles, 0 of others; elements from size() on are those of the images.
    void transposed(Span<const Real> q, Span<Padded> v) const;
    /// rate_i = (D v)_i without the solids if wanted[i], else 0.
    void apply(Span<const Padded> v, Span<const char> wanted, Span<Real> rate) const;

private:
    void join_rows(const Pairs& fluid);
    Vec3 gradient(Index i, Index j, Real c) const {
        Vec3 r = (x[i] - x[j]).template head<3>();
        for (int a = 0; a < 3; ++a)
            if (period[a] > 0) r[a] -= period[a] * std::nearbyint(r[a] / period[a]);
        return c * r;
    }
    /// Sum of term(c_ij, j, r_ij) over the neighbours j of i; images have numbers from size() on.
    template <bool periodic, class F>
    Padded sum_over_row(Index i, const F& term) const;

    std::vector<std::size_t> joined_first_;  ///< rows of particles and images; unused without images
    Column<Index> joined_;
};

}  // namespace whorl
