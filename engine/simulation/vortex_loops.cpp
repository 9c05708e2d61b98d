#include "engine/simulation/vortex_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/models/ink/ink_markers.h"

namespace whorl {
namespace {

std::vector<Vec3d> points(const VectorExpression& path, std::size_t count) {
    std::vector<Vec3d> line;
    for (std::size_t s = 0; s < count; ++s)
        line.push_back(path(2 * std::numbers::pi * static_cast<double>(s) / static_cast<double>(count)));
    return line;
}

}  // namespace

VortexLoop::VortexLoop(const VortexKeys& keys, const Domain& domain)
    : strength_(keys.circulation / (4 * std::numbers::pi)), core_(keys.core) {
    const auto rough = points(keys.path, 256);
    double length = 0;
    for (std::size_t s = 0; s < rough.size(); ++s) length += (rough[(s + 1) % rough.size()] - rough[s]).norm();
    segments_ = static_cast<std::size_t>(std::clamp(std::ceil(4 * length / core_), 64.0, 4096.0));
    const auto line = points(keys.path, segments_);
    for (std::size_t s = 0; s < segments_; ++s) longest_ = std::max(longest_, (line[(s + 1) % segments_] - line[s]).norm());
    const Vec3d period = domain.period().cast<double>();
    const auto images = [&](int a) { return period[a] > 0 ? 1 : 0; };
    for (int i = -images(0); i <= images(0); ++i)
        for (int j = -images(1); j <= images(1); ++j)
            for (int k = -images(2); k <= images(2); ++k) {
                const Vec3d shift = period.cwiseProduct(Vec3d(i, j, k));
                boxes_.emplace_back();
                for (std::size_t s = 0; s < segments_; ++s) {
                    const Vec3d& from = line[s];
                    const Vec3d& to = line[(s + 1) % segments_];
                    boxes_.back().extend((0.5 * (from + to) + shift).eval());
                    for (int a = 0; a < 3; ++a)
                        middle_[a].push_back(0.5 * (from[a] + to[a]) + shift[a]), along_[a].push_back(to[a] - from[a]);
                }
            }
}

Vec3d VortexLoop::velocity(const Vec3d& x) const {
    double u = 0, v = 0, w = 0;
    for (std::size_t s = 0; s < middle_[0].size(); ++s) {
        const double a = x[0] - middle_[0][s], b = x[1] - middle_[1][s], c = x[2] - middle_[2][s];
        const double square = a * a + b * b + c * c + core_ * core_, weight = 1 / (square * std::sqrt(square));
        u += weight * (along_[1][s] * c - along_[2][s] * b);
        v += weight * (along_[2][s] * a - along_[0][s] * c);
        w += weight * (along_[0][s] * b - along_[1][s] * a);
    }
    return strength_ * Vec3d(u, v, w);
}

VortexLoop::Nearest VortexLoop::nearest(const Vec3d& x, double reach) const {
    double least = std::numeric_limits<double>::infinity(), where = 0;
    const double far = reach + 0.5 * longest_;
    for (std::size_t s = 0; s < middle_[0].size(); ++s) {
        if (s % segments_ == 0 && boxes_[s / segments_].squaredExteriorDistance(x) > far * far) {
            s += segments_ - 1;  // the next image
            continue;
        }
        const Vec3d along(along_[0][s], along_[1][s], along_[2][s]), to = x - Vec3d(middle_[0][s], middle_[1][s], middle_[2][s]);
        if (to.squaredNorm() > far * far) continue;
        const double part = std::clamp(to.dot(along) / along.squaredNorm(), -0.5, 0.5), square = (to - part * along).squaredNorm();
        if (square < least) least = square, where = static_cast<double>(s % segments_) + 0.5 + part;
    }
    return {std::sqrt(least), 2 * std::numbers::pi / static_cast<double>(segments_) * where};
}

void add_vortices(const Scene& scene, World& world) {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    for (const VortexKeys& keys : scene.vortices) {
        const VortexLoop loop(keys, world.step.domain);
        parallel_for(x.size(), [&](Index i) { u[i] += loop.velocity(x[i].cast<double>()).cast<Real>(); });
        if (!keys.ink.any()) continue;
        const VectorExpression concentration = keys.ink.vector();
        const double reach = 2.2 * keys.core;  // beyond it, less than 1e-10 of the ink is left
        const auto colour = [&](Span<const Vec3> place, Span<Vec3> ink) {
            std::vector<VortexLoop::Nearest> lines(ink.size());
            parallel_for(static_cast<Index>(ink.size()), [&](Index i) { lines[i] = loop.nearest(place[i].cast<double>(), reach); });
            for (std::size_t i = 0; i < ink.size(); ++i) {  // not in parallel, because threads would share the parser of the expression
                const VortexLoop::Nearest& line = lines[i];
                if (line.distance > reach) continue;
                const double inside = std::exp(-std::pow(line.distance / keys.core, 4));
                ink[i] = ink[i].cwiseMax((inside * concentration(line.t)).cwiseMax(0.0).cwiseMin(1.0).cast<Real>());
            }
        };
        colour(x, world.fluid.column<field::ink>());
        if (ParticleStore& markers = world.ink_markers.store; world.ink_markers.per_spacing > 0)
            colour(markers.column<field::position>(), markers.column<field::ink>());
    }
}

}  // namespace whorl
