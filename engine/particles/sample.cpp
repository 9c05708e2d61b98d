#include "engine/particles/sample.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/geometry/repeats.h"
#include "engine/math/kernel.h"
#include "engine/particles/search.h"

namespace whorl {
namespace {

/// The box to sample: the shape's bounds, limited to the domain along axes that are not periodic, and the axes that the shape spans.
struct Extent {
    Vec3d min, max;
    bool spans_period[3];
    int dimensions;  ///< 2: the box has no depth
};

Extent extent_of(const Shape& shape, const Domain& domain) {
    Vec3 low, high;
    shape.bounds(low, high);
    Extent e{low.cast<double>(), high.cast<double>(), {}, domain.dimensions()};
    for (int a = 0; a < 3; ++a) {
        const double first = domain.min[a], last = domain.max[a], tolerance = 1e-5 * static_cast<double>(domain.max[a] - domain.min[a]);
        e.spans_period[a] = domain.periodic[a] && e.max[a] - e.min[a] >= last - first - 2 * tolerance;
        const bool all = e.min[a] <= first + tolerance && e.max[a] >= last - tolerance;
        if (!domain.periodic[a] || all) e.min[a] = std::max(e.min[a], first), e.max[a] = std::min(e.max[a], last);
        else if (e.spans_period[a]) e.max[a] = e.min[a] + (last - first);
    }
    return e;
}

std::vector<Vec3> lattice(const Shape& shape, const Extent& e, double spacing, double jitter, std::uint64_t seed,
                          Layers layers = Layers::nearest, Real beyond = 0) {
    std::vector<Vec3> x;
    Vec3d step = Vec3d::Zero(), first = Vec3d::Zero();
    long count[3] = {1, 1, 1};
    for (int a = 0; a < e.dimensions; ++a) {
        const double length = e.max[a] - e.min[a];
        if (!(length > 0)) return x;
        const bool within = layers == Layers::within && !e.spans_period[a];
        count[a] = std::max(1L, within ? static_cast<long>(length / spacing + 0.1) : std::lround(length / spacing));
        // Layers are one spacing apart, except along a periodic axis that the shape spans, which is filled without a seam.
        step[a] = e.spans_period[a] ? length / static_cast<double>(count[a]) : spacing;
        first[a] = e.min[a] + 0.5 * (length - step[a] * static_cast<double>(count[a] - 1));
        if (beyond > 0 && !e.spans_period[a]) first[a] -= step[a], count[a] += 2;
    }
    RandomNumbers random(seed);
    for (long k = 0; k < count[2]; ++k)
        for (long j = 0; j < count[1]; ++j)
            for (long i = 0; i < count[0]; ++i) {
                Vec3d p =
                    first + Vec3d(static_cast<double>(i) * step[0], static_cast<double>(j) * step[1], static_cast<double>(k) * step[2]);
                Vec3d shift(random() - 0.5, random() - 0.5, random() - 0.5);
                if (e.dimensions == 2) shift.z() = 0;
                if (shape.distance(p.cast<Real>()) >= beyond) continue;
                const Vec3 moved = (p + 2 * jitter * spacing * shift).cast<Real>();
                x.push_back(shape.distance(moved) < 0 ? moved : Vec3(p.cast<Real>()));
            }
    return x;
}

/// Volume of the shape within the extent (in 2D: area), summed over cells a quarter of a spacing wide whose middle is inside.
double volume_within(const Shape& shape, const Extent& e, double spacing) {
    long count[3] = {1, 1, 1};
    Vec3d step = Vec3d::Zero();
    double cells = 1;
    for (int a = 0; a < e.dimensions; ++a) {
        const double length = e.max[a] - e.min[a];
        if (!(length > 0)) return 0;
        count[a] = std::clamp(std::lround(4 * length / spacing), 1L, 512L);
        step[a] = length / static_cast<double>(count[a]);
        cells *= step[a];
    }
    const double inside = parallel_sum(static_cast<Index>(count[2]), [&](Index k) {
        long n = 0;
        for (long j = 0; j < count[1]; ++j)
            for (long i = 0; i < count[0]; ++i) {
                const Vec3d p =
                    e.min + Vec3d((static_cast<double>(i) + 0.5) * step[0], (static_cast<double>(j) + 0.5) * step[1], (k + 0.5) * step[2]);
                n += shape.distance(p.cast<Real>()) < 0;
            }
        return static_cast<double>(n);
    });
    return inside * cells;
}

Vec3 slope(const Distance& distance, const Vec3& x, Real step) {
    Vec3 g;
    for (int a = 0; a < 3; ++a) {
        Vec3 e = Vec3::Zero();
        e[a] = step;
        g[a] = distance(x + e) - distance(x - e);
    }
    const Real length = g.norm();
    return length > 0 ? Vec3(g / length) : Vec3::Zero();
}

}  // namespace

void relax(std::vector<Vec3>& x, const Distance& distance, Real spacing, const Domain& domain, int sweeps, const std::vector<Vec3>& fixed,
           const Distance& obstacle) {
    const auto n = static_cast<Index>(x.size());
    const Real range = Real(1.6) * spacing, shell = Real(0.25) * spacing;
    Domain images = domain;  // only its periods are used, because mirror images may be outside the box
    NeighbourSearch search;
    Pairs pairs;
    std::vector<Vec3> all, moved(x.size());
    std::vector<Real> depth(x.size());
    std::vector<Vec3> outward(x.size());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        const Real rate = Real(0.5) * (1 - Real(0.7) * static_cast<Real>(sweep) / static_cast<Real>(sweeps));
        parallel_for(n, [&](Index i) {
            depth[i] = -distance(x[i]);
            outward[i] = depth[i] < range ? slope(distance, x[i], Real(0.05) * spacing) : Vec3(Vec3::Zero());
        });
        all = x;
        for (std::size_t k = 0; k < x.size(); ++k)
            if (depth[k] < range) all.push_back(domain.wrapped(x[k] + 2 * depth[k] * outward[k]));
        all.insert(all.end(), fixed.begin(), fixed.end());
        search.find(x, all, range, images, pairs);
        parallel_for(n, [&](Index i) {
            Vec3 push = Vec3::Zero();
            pairs.of(i, [&](Index j, const Vec3& r, Real distance_ij) {
                if (j == i || distance_ij < Real(1e-6) * spacing) return;
                const Real gap = 1 - distance_ij / range;
                push += gap * gap * rate * spacing / distance_ij * r;
            });
            const Real length = push.norm();
            if (length > Real(0.2) * spacing) push *= Real(0.2) * spacing / length;
            Vec3 p = domain.wrapped(x[i] + push);
            if (obstacle)
                if (const Real near = static_cast<Real>(least_clearance) * spacing - obstacle(p); near > 0)
                    p += near * slope(obstacle, p, Real(0.05) * spacing);
            const Real d = distance(p);
            if (d > -shell) p -= (d + shell) * slope(distance, p, Real(0.05) * spacing);
            moved[i] = domain.wrapped(p);
        });
        x.swap(moved);
    }
}

namespace {

/// Sample points of the shape; some may be outside the domain.
std::vector<Vec3> unwrapped(const Shape& shape, Sampling sampling, Real spacing, const Domain& domain, std::uint64_t seed, Layers layers,
                            Real beyond) {
    const Extent e = extent_of(shape, domain);
    if (sampling == Sampling::lattice) return lattice(shape, e, spacing, 0, seed, layers, beyond);
    if (sampling == Sampling::jittered) return lattice(shape, e, spacing, 0.2, seed, layers);

    // Blue noise starts from a strongly jittered lattice with as many points as the volume requires.
    std::vector<Vec3> x = lattice(shape, e, spacing, 0.4, seed);
    const auto wanted =
        static_cast<std::size_t>(std::lround(volume_within(shape, e, spacing) / power_of(static_cast<double>(spacing), e.dimensions)));
    RandomNumbers random(seed + 1);
    while (x.size() > wanted) {
        std::swap(x[random() * static_cast<double>(x.size())], x.back());
        x.pop_back();
    }
    while (x.size() < wanted && wanted > 0) {
        const Vec3d p = e.min + Vec3d(random(), random(), random()).cwiseProduct(e.max - e.min);
        if (shape.distance(p.cast<Real>()) < 0) x.push_back(p.cast<Real>());
    }
    Domain periods = domain;
    for (std::size_t a = 0; a < 3; ++a) periods.periodic[a] = e.spans_period[a];
    relax(
        x, [&](const Vec3& p) { return shape.distance(p); }, spacing, periods, 150);
    return x;
}

}  // namespace

std::vector<Vec3> sample_shape(const Shape& shape, Sampling sampling, Real spacing, const Domain& domain, std::uint64_t seed, Layers layers,
                               Real beyond) {
    std::vector<Vec3> x = unwrapped(Repeated(shape, domain), sampling, spacing, domain, seed, layers, beyond);
    for (Vec3& p : x) p = domain.wrapped(p);
    return x;
}

}  // namespace whorl
