#include "engine/geometry/surface_samples.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <unordered_map>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"

namespace whorl {

bool SamplingRegion::contains(const Vec3d& x) const {
    for (int a = 0; a < 3; ++a) {
        if (domain.periodic[a]) continue;
        if (!(x[a] >= domain.min[a] - margin && x[a] <= domain.max[a] + margin)) return false;
    }
    return true;
}

bool SamplingRegion::spans_period(int axis, double low, double high) const {
    const double tolerance = 1e-3 * spacing;
    return domain.periodic[axis] && high - low >= double(domain.max[axis]) - double(domain.min[axis]) - 2 * tolerance;
}

std::vector<double> period_points(const SamplingRegion& region, int axis) {
    const double length = double(region.domain.max[axis]) - double(region.domain.min[axis]);
    const double count = std::max(1.0, std::round(length / region.spacing));
    check_count(count, "solid");
    std::vector<double> x;
    for (double k = 0; k < count; ++k) x.push_back(region.domain.min[axis] + (k + 0.5) * length / count);
    return x;
}

bool contains_once(const SamplingRegion& region, const Vec3d& x) {
    for (int a = 0; a < 3; ++a)
        if (region.domain.periodic[a] && !(x[a] >= region.domain.min[a] && x[a] < region.domain.max[a])) return false;
    return region.contains(x);
}

LatticeLine lattice_line(const SamplingRegion& region, int axis, double centre, double half_length, double offset,
                         const std::string& shape) {
    LatticeLine line;
    if (region.spans_period(axis, centre - half_length, centre + half_length)) {
        line.at = period_points(region, axis);
        line.side.assign(line.at.size(), 0);
        return line;
    }
    const double half = inset(half_length, offset), low = centre - half;
    const double steps = std::max(1.0, std::round(2 * half / region.spacing)), step = 2 * half / steps;
    double first = 0, last = steps;
    if (region.clipped && !region.domain.periodic[axis]) {
        first = std::max(first, std::ceil((region.domain.min[axis] - region.margin - low) / step));
        last = std::min(last, std::floor((region.domain.max[axis] + region.margin - low) / step));
    }
    check_count(last - first, shape);
    for (double k = first; k <= last; ++k) {
        line.at.push_back(low + k * step);
        line.side.push_back(k == 0 ? -1 : k == steps ? 1 : 0);
    }
    return line;
}

void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v) {
    int least = 0;
    n.cwiseAbs().minCoeff(&least);
    u = n.cross(Vec3d::Unit(least)).normalized();
    v = n.cross(u);
}

void check_count(double points, const std::string& shape) {
    if (points < 50e6) return;
    throw InputError({}, fmt::format("the surface of the {} needs {:.0f} million particles at this spacing", shape, points / 1e6),
                     "make the solid, the domain or the ratio of their size to the spacing smaller", "at most 50 million");
}

namespace {

struct Dart {
    Vec3d position, outward;
    int rank = -1;  ///< k >= 0: at 2^-k of the requested depth (k > 0 if the shape is too thin there); -1: rejected
};

/// A point at signed distance `offset`, or at a fraction of that distance if the shape is too thin. Fractions below a quarter are tried
/// only in a sheet, that is, if the line inward from the surface leaves the shape within half of the offset.
Dart aimed(const Shape& shape, const Vec3d& on_surface, const Vec3d& normal, const Vec3d& direction, double offset) {
    const auto distance = [&](const Vec3d& x) { return double(shape.distance(x.cast<Real>())); };
    double depth = offset;
    for (int rank = 0; rank < 10; ++rank, depth /= 2) {
        if (rank == 3 && !(offset < 0 && distance(on_surface + offset / 2 * normal) > 0)) break;
        Vec3d x = on_surface + depth * direction;
        for (int k = 0; k < 3; ++k) x += (depth - distance(x)) * shape.normal(x.cast<Real>()).cast<double>();
        if (std::abs(distance(x) - depth) < 0.1 * std::abs(depth)) return {x, shape.normal(x.cast<Real>()).cast<double>(), rank};
    }
    return {};
}

}  // namespace

std::vector<SurfaceSample> Shape::surface_samples(Real offset, const SamplingRegion& region) const {
    const double d = region.spacing;
    const TriangleMesh surface = mesh(region.spacing, (region.domain.max - region.domain.min).norm());
    std::vector<double> area_up_to;
    double area = 0;
    const auto corner = [&](std::size_t t, std::size_t k) { return Vec3d(surface.position[surface.triangle[t][k]].cast<double>()); };
    for (std::size_t t = 0; t < surface.triangle.size(); ++t) {
        area += (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm() / 2;
        area_up_to.push_back(area);
    }
    check_count(area / (d * d), "mesh");

    // With sixteen darts per point, the remaining gaps are hardly ever wide enough for another point.
    const Index count = static_cast<Index>(std::ceil(16 * area / (d * d))) + 64;
    std::vector<Dart> darts(count);
    parallel_for(count, [&](Index i) {
        RandomNumbers random(0xD1342543DE82EF95ull * (static_cast<std::uint64_t>(i) + 1));
        const double at = area * (i + random()) / count;
        const std::size_t t =
            std::min<std::size_t>(std::lower_bound(area_up_to.begin(), area_up_to.end(), at) - area_up_to.begin(), area_up_to.size() - 1);
        double u = random(), v = random();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const Vec3d e1 = corner(t, 1) - corner(t, 0), e2 = corner(t, 2) - corner(t, 0);
        // The direction varies about the face's normal, so that darts also reach the rounded surface beyond an edge.
        const Vec3d stray(random() - 0.5, random() - 0.5, random() - 0.5);
        const Vec3d normal = e1.cross(e2).stableNormalized(), direction = (normal + stray).normalized();
        darts[i] = aimed(*this, corner(t, 0) + u * e1 + v * e2, normal, direction, offset);
    });

    std::vector<Index> order(darts.size());
    for (Index i = 0; i < count; ++i) order[i] = i;
    RandomNumbers random(7);
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random() * static_cast<double>(k)]);
    std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return darts[i].rank < darts[j].rank; });

    // A dart is kept if no kept dart on the same side of the body is nearer than 0.8 d.
    const double apart = 0.8 * d;
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells;
    const auto key = [&](const Vec3d& x, int i, int j, int k) {
        const auto along = [&](int a, int shift) {
            return (static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x[a] / apart)) + shift)) & 0x1fffff;
        };
        return along(0, i) << 42 | along(1, j) << 21 | along(2, k);
    };
    std::vector<SurfaceSample> points;
    for (Index i : order) {
        const Dart& dart = darts[i];
        if (dart.rank < 0 || (region.clipped && !region.contains(dart.position))) continue;
        bool free = true;
        for (int a = -1; a <= 1 && free; ++a)
            for (int b = -1; b <= 1 && free; ++b)
                for (int c = -1; c <= 1 && free; ++c) {
                    const auto cell = cells.find(key(dart.position, a, b, c));
                    if (cell == cells.end()) continue;
                    for (std::size_t k : cell->second)
                        free = free && !((points[k].position - dart.position).norm() < apart && points[k].outward.dot(dart.outward) > -0.5);
                }
        if (!free) continue;
        cells[key(dart.position, 0, 0, 0)].push_back(points.size());
        points.push_back({dart.position, dart.outward});
    }
    return points;
}

}  // namespace whorl
