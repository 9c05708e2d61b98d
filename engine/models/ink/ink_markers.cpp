#include "engine/models/ink/ink_markers.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/particles/sort.h"

namespace whorl {
namespace {

/// Sums over the particles near a marker, r = x_j - x_m.
struct LinearFit {
    Real weight = 0, path_square = 0;
    Vec3 r = Vec3::Zero(), path = Vec3::Zero(), ink = Vec3::Zero();
    Mat3 rr = Mat3::Zero(), path_r = Mat3::Zero();

    /// Adds a group of neighbours with the weights w = (1 - distance^2 over)^2. @param c null: without ink
    void add(const Pairs::Group& group, Real over, const Vec3* displacement, const Vec3* c) {
        Real s[3][Pairs::Group::most], w[Pairs::Group::most], of_r[3]{}, of_s[3]{}, of_rr[6]{}, of_sr[9]{}, of_w = 0, square = 0;
        group.gather(displacement, s);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real q = 1 - group.distance[l] * group.distance[l] * over;
            w[l] = l < group.count ? q * q : 0;
        }
        for (Index l = 0; l < group.padded(); ++l) {
            const Real x = -group.r[0][l], y = -group.r[1][l], z = -group.r[2][l];
            const Real a = w[l] * s[0][l], b = w[l] * s[1][l], d = w[l] * s[2][l];
            of_w += w[l], of_r[0] += w[l] * x, of_r[1] += w[l] * y, of_r[2] += w[l] * z;
            of_s[0] += a, of_s[1] += b, of_s[2] += d, square += a * s[0][l] + b * s[1][l] + d * s[2][l];
            of_rr[0] += w[l] * x * x, of_rr[1] += w[l] * x * y, of_rr[2] += w[l] * x * z;
            of_rr[3] += w[l] * y * y, of_rr[4] += w[l] * y * z, of_rr[5] += w[l] * z * z;
            of_sr[0] += a * x, of_sr[1] += a * y, of_sr[2] += a * z, of_sr[3] += b * x, of_sr[4] += b * y;
            of_sr[5] += b * z, of_sr[6] += d * x, of_sr[7] += d * y, of_sr[8] += d * z;
        }
        weight += of_w, path_square += square;
        r += Vec3(of_r[0], of_r[1], of_r[2]), path += Vec3(of_s[0], of_s[1], of_s[2]);
        Mat3 part;
        part << of_rr[0], of_rr[1], of_rr[2], of_rr[1], of_rr[3], of_rr[4], of_rr[2], of_rr[4], of_rr[5];
        rr += part;
        part << of_sr[0], of_sr[1], of_sr[2], of_sr[3], of_sr[4], of_sr[5], of_sr[6], of_sr[7], of_sr[8];
        path_r += part;
        for (Index l = 0; c != nullptr && l < group.count; ++l) ink += w[l] * c[group.other[l]];
    }
    /// Value at the marker of the linear function that fits the displacements. Along directions that the particles do not resolve, the
    /// function is constant.
    /// @param least_spread squared length, below which differences between the particles' places are round-off [m^2]
    Vec3 displacement(bool flat, Real least_spread) const {
        const Vec3 middle = r / weight, mean = path / weight;
        Mat3 spread = rr / weight - middle * middle.transpose();
        const Real size = std::max(spread.trace(), least_spread);
        spread /= size;  // the inverse of square metres would leave the range of floats
        spread.diagonal().array() += Real(1e-3);
        if (flat) spread(2, 2) = 1;
        const Vec3 correction = -(path_r / weight - mean * middle.transpose()) * (spread.inverse() * middle) / size;
        // Few particles do not determine a gradient: the correction stays within twice the deviation of their displacements.
        const Real most = 2 * std::sqrt(std::max(path_square / weight - mean.squaredNorm(), Real(0))), length = correction.norm();
        return mean + (length > most ? most / length : 1) * correction;
    }
};

}  // namespace

Index InkMarkers::add(Span<const Vec3> particles, const StepContext& step) {
    const Index first = store.size();
    const int n = per_spacing, deep = step.dimensions() == 2 ? 1 : n;
    store.resize(first + static_cast<Index>(particles.size()) * n * n * deep);
    const auto x = store.column<field::position>();
    const auto offset = [&](int k, int count) {
        return step.spacing * ((static_cast<Real>(k) + Real(0.5)) / static_cast<Real>(count) - Real(0.5));
    };
    Index m = first;
    for (const Vec3& p : particles)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                for (int k = 0; k < deep; ++k) x[m++] = step.domain.wrapped(p + Vec3(offset(i, n), offset(j, n), offset(k, deep)));
    return first;
}

void InkMarkers::fill_gaps(const StepContext& step, Span<const Vec3> particles, Span<const Vec3> inks, NeighbourSearch& search) {
    Pairs pairs;
    search.find(particles, store.column<field::position>(), Real(0.75) * step.spacing, step.domain, pairs);
    std::vector<Vec3> bare, ink;
    for (Index i = 0; i < pairs.size(); ++i)
        if (pairs.count(i) == 0) bare.push_back(particles[i]), ink.push_back(inks[i]);
    if (bare.empty()) return;
    const auto first = static_cast<std::size_t>(add(bare, step));
    const auto of = store.column<field::ink>().subspan(first);
    for (std::size_t m = 0; m < of.size(); ++m) of[m] = ink[m / (of.size() / ink.size())];
}

void MoveInkMarkers::operator()(const StepContext& step, Read<field::position> x, Read<field::velocity> u, Read<field::ink> c,
                                Update<field::path_start> start, Update<field::path> path, InkMarkers& markers,
                                NeighbourSearch& search) const {
    parallel_for(x.size(), [&](Index i) { path[i] += step.dt * u[i]; });
    markers.waiting += static_cast<double>(step.dt);
    const double farthest = parallel_max(x.size(), 0, [&](Index i) { return static_cast<double>(path[i].squaredNorm()); });
    if (!step.to_frame_time && farthest < 4 * static_cast<double>(step.spacing * step.spacing)) return;

    ParticleStore& store = markers.store;
    if (step.to_frame_time) store.gather(curve_order(std::as_const(store).column<field::position>(), step.support));
    const auto place = store.column<field::position>();
    const auto ink = store.column<field::ink>();
    const Real reach = Real(1.75) * step.spacing, over = 1 / (reach * reach);
    const double wave = std::numbers::pi / static_cast<double>(step.spacing);
    const Real mixed = static_cast<Real>(-std::expm1(-diffusion * wave * wave * markers.waiting));
    const bool flat = step.dimensions() == 2;
    const Real least_spread = Real(0.1) * step.spacing * step.spacing;
    Pairs pairs;
    const auto fit_at = [&](Index i, Span<const Vec3> displacement) {
        LinearFit fit;
        pairs.groups_of(i, [&](const Pairs::Group& group) { fit.add(group, over, displacement.data(), mixed > 0 ? c.data() : nullptr); });
        return fit;
    };
    // The fit smooths curved fields. Adding the fit of its errors at the particles cancels this to second order.
    search.find(start.values, reach, step.domain, pairs);
    std::vector<Vec3> sharp(path.values.size());
    parallel_for(pairs.size(), [&](Index i) {
        LinearFit fit = fit_at(i, path.values);
        fit.weight += 1, fit.path += path[i], fit.path_square += path[i].squaredNorm();  // i itself
        sharp[i] = 2 * path[i] - fit.displacement(flat, least_spread);
    });
    std::vector<char> alone(place.size(), 0);
    // Markers are handled in pieces, so that their rows of neighbours need no more memory than those of the particles.
    const std::size_t piece = std::max<std::size_t>(static_cast<std::size_t>(x.size()), 1 << 15);
    for (std::size_t begin = 0; begin < place.size(); begin += piece) {
        const auto part = place.subspan(begin, std::min(piece, place.size() - begin));
        search.find(part, start.values, reach, step.domain, pairs);
        parallel_for(pairs.size(), [&](Index m) {
            const LinearFit fit = fit_at(m, sharp);
            const std::size_t k = begin + static_cast<std::size_t>(m);
            alone[k] = !(fit.weight > Real(1e-6));  // nearer to the edge of the reach, positions would be lost to round-off
            if (alone[k]) return;
            if (mixed > 0) ink[k] += mixed * (fit.ink / fit.weight - ink[k]);
            part[m] = step.domain.wrapped(part[m] + fit.displacement(flat, least_spread));
        });
    }
    std::vector<Index> kept;
    for (std::size_t k = 0; k < alone.size(); ++k)
        if (!alone[k]) kept.push_back(static_cast<Index>(k));
    if (kept.size() < alone.size()) store.gather(kept);
    if (step.to_frame_time) markers.fill_gaps(step, x.values, c.values, search);
    parallel_for(x.size(), [&](Index i) { start[i] = step.domain.wrapped(x[i]), path[i].setZero(); });
    markers.waiting = 0;
}

}  // namespace whorl
