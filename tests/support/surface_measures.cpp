#include "tests/support/surface_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "engine/particles/sample.h"

namespace whorl::test {
namespace {

constexpr double pi = std::numbers::pi;
const Vec3d cylinder_axis = Vec3d(1, 0.31, 0.17).normalized();  // nothing special about the grid either

Domain unbounded() {
    Domain domain;
    domain.min = Vec3::Constant(-1000);
    domain.max = Vec3::Constant(1000);
    return domain;
}

Frame frame_of(const std::vector<Vec3>& x) {
    Frame frame;
    frame.spacing = 1;
    for (const Vec3& p : x) frame.position.push_back(p.cast<float>());
    frame.velocity.assign(x.size(), Vec3f::Zero());
    return frame;
}

// One particle per unit volume of the shape: a randomly displaced lattice, thinned or filled up to the right number, then relaxed to blue
// noise if requested.
Frame filled(const Distance& distance, const Vec3d& low, const Vec3d& high, double volume_wanted, bool blue_noise, std::uint64_t seed) {
    RandomNumbers random(seed);
    std::vector<Vec3> x;
    for (double i = low.x() + 0.5; i < high.x(); ++i)
        for (double j = low.y() + 0.5; j < high.y(); ++j)
            for (double k = low.z() + 0.5; k < high.z(); ++k) {
                const Vec3 p = Vec3d(i, j, k).cast<Real>();
                if (distance(p) < 0)
                    x.push_back(p + (Vec3d(0.4 * random() - 0.2, 0.4 * random() - 0.2, 0.4 * random() - 0.2)).cast<Real>());
            }
    if (!blue_noise) return frame_of(x);
    const auto wanted = static_cast<std::size_t>(std::lround(volume_wanted));
    for (; x.size() > wanted; x.pop_back()) std::swap(x[random() * static_cast<double>(x.size())], x.back());
    while (x.size() < wanted) {
        const Vec3d p = low + Vec3d(random(), random(), random()).cwiseProduct(high - low);
        if (distance(p.cast<Real>()) < 0) x.push_back(p.cast<Real>());
    }
    relax(x, distance, 1, unbounded(), 100);
    return frame_of(x);
}

class Accumulated {
public:
    void add(double value, double weight) { w_ += weight, sum_ += weight * value, square_ += weight * value * value; }
    Deviation about(double reference) const {
        const double mean = sum_ / w_;
        return {mean - reference, std::sqrt(std::max(0.0, square_ / w_ - mean * mean))};
    }

private:
    double w_ = 0, sum_ = 0, square_ = 0;
};

// Each triangle's middle and area.
void for_triangles(const TriangleMesh& mesh, const std::function<void(const Vec3d& middle, double area)>& f) {
    for (const std::array<std::uint32_t, 3>& t : mesh.triangle) {
        const Vec3d p = mesh.position[t[0]].cast<double>(), q = mesh.position[t[1]].cast<double>(), r = mesh.position[t[2]].cast<double>();
        f(Vec3d((p + q + r) / 3), 0.5 * (q - p).cross(r - p).norm());
    }
}

Vec3d centroid(const Frame& frame) {
    Vec3d sum = Vec3d::Zero();
    for (const Vec3f& p : frame.position) sum += p.cast<double>();
    return sum / static_cast<double>(frame.position.size());
}

}  // namespace

Topology topology(const TriangleMesh& mesh) {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Edge> edges;
    std::vector<std::uint32_t> parent(mesh.position.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    // Triangles around a vertex: edges from each second to its third corner. They are one fan if these edges are one cycle.
    std::vector<std::vector<Edge>> fan(mesh.position.size());
    for (const auto& t : mesh.triangle)
        for (int c = 0; c < 3; ++c) {
            edges.emplace_back(t[c], t[(c + 1) % 3]);
            parent[root(t[c])] = root(t[(c + 1) % 3]);
            fan[t[c]].emplace_back(t[(c + 1) % 3], t[(c + 2) % 3]);
        }
    std::sort(edges.begin(), edges.end());
    Topology result;
    result.closed =
        std::adjacent_find(edges.begin(), edges.end()) == edges.end() && std::all_of(edges.begin(), edges.end(), [&](const Edge& e) {
            return e.first != e.second && std::binary_search(edges.begin(), edges.end(), Edge(e.second, e.first));
        });
    result.manifold = result.closed && std::all_of(fan.begin(), fan.end(), [](const std::vector<Edge>& round) {
                          if (round.size() < 3) return false;
                          std::size_t steps = 0;
                          std::uint32_t at = round[0].first;
                          do {
                              const auto next = std::find_if(round.begin(), round.end(), [&](const Edge& e) { return e.first == at; });
                              if (next == round.end()) return false;
                              at = next->second;
                          } while (++steps < round.size() && at != round[0].first);
                          return steps == round.size() && at == round[0].first;
                      });
    for (std::uint32_t v = 0; v < parent.size(); ++v) result.components += root(v) == v;
    result.euler = static_cast<int>(mesh.position.size()) - static_cast<int>(edges.size() / 2) + static_cast<int>(mesh.triangle.size());
    return result;
}

double volume(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangle)
        sum += mesh.position[a].cast<double>().dot(mesh.position[b].cast<double>().cross(mesh.position[c].cast<double>())) / 6;
    return sum;
}

Frame sphere_frame(double radius, std::uint64_t seed) {
    const Vec3d centre(0.3, 0.1, 0.4);  // nothing special about the grid
    const auto distance = [&](const Vec3& x) { return static_cast<Real>((x.cast<double>() - centre).norm() - radius); };
    return filled(distance, centre.array() - radius, centre.array() + radius, 4 * pi / 3 * radius * radius * radius, true, seed);
}

Frame cylinder_frame(double radius, double length, std::uint64_t seed) {
    const auto distance = [&](const Vec3& x) {
        const Vec3d p = x.cast<double>();
        const double along = p.dot(cylinder_axis), ends = std::abs(along) - 0.5 * length,
                     round = (p - along * cylinder_axis).norm() - radius;
        return static_cast<Real>(std::max(ends, round));
    };
    const Vec3d reach = (0.5 * length * cylinder_axis).array() + radius;
    return filled(distance, -reach, reach, pi * radius * radius * length, true, seed);
}

Frame pool_frame(double width, double depth, bool jittered_lattice, std::uint64_t seed) {
    const Vec3d low(-0.5 * width, -depth, -0.5 * width), high(0.5 * width, 0, 0.5 * width);
    const auto distance = [&](const Vec3& x) {
        const Vec3d p = x.cast<double>();
        return static_cast<Real>(std::max((low - p).maxCoeff(), (p - high).maxCoeff()));
    };
    return filled(distance, low, high, width * width * depth, !jittered_lattice, seed);
}

Frame coil_frame(double thread_radius, double coil_radius, double pitch, double turns, std::uint64_t seed) {
    // The distance to the nearest of the curve's points is near enough to the distance to the curve.
    std::vector<Vec3> curve;
    const int points = static_cast<int>(40 * turns);
    for (int n = 0; n <= points; ++n) {
        const double angle = 2 * pi * turns * n / points;
        curve.push_back(Vec3d(coil_radius * std::cos(angle), pitch * turns * n / points, coil_radius * std::sin(angle)).cast<Real>());
    }
    const auto distance = [&](const Vec3& x) {
        Real least = std::numeric_limits<Real>::max();
        for (std::size_t n = 0; n + 1 < curve.size(); ++n) {
            const Vec3 along = curve[n + 1] - curve[n];
            const Real t = std::clamp((x - curve[n]).dot(along) / along.squaredNorm(), Real(0), Real(1));
            least = std::min(least, (x - curve[n] - t * along).norm());
        }
        return least - static_cast<Real>(thread_radius);
    };
    RandomNumbers random(seed);
    std::vector<Vec3> x;
    const double length = turns * std::hypot(2 * pi * coil_radius, pitch);
    const auto wanted = static_cast<std::size_t>(pi * thread_radius * thread_radius * length);
    while (x.size() < wanted) {
        const double reach = coil_radius + thread_radius;
        const Vec3d p((2 * random() - 1) * reach, random() * pitch * turns, (2 * random() - 1) * reach);
        if (distance(p.cast<Real>()) < 0) x.push_back(p.cast<Real>());
    }
    relax(x, distance, 1, unbounded(), 60);
    return frame_of(x);
}

Frame file_frame(double distance, int count) {
    std::vector<Vec3> x;
    for (int n = 0; n < count; ++n) x.push_back(Vec3d(0.2 + n * distance, 0.1 + 0.02 * n, 0.3).cast<Real>());
    return frame_of(x);
}

Deviation sphere_deviation(const TriangleMesh& mesh, const Frame& frame) {
    const Vec3d centre = centroid(frame);
    const double radius = std::cbrt(3 * static_cast<double>(frame.position.size()) / (4 * pi));
    Accumulated r;
    for_triangles(mesh, [&](const Vec3d& p, double area) { r.add((p - centre).norm(), area); });
    return r.about(radius);
}

Deviation cylinder_deviation(const TriangleMesh& mesh, const Frame& frame, double length) {
    const Vec3d centre = centroid(frame), axis = cylinder_axis;
    const double radius = std::sqrt(static_cast<double>(frame.position.size()) / (pi * length));
    Accumulated r;
    for_triangles(mesh, [&](const Vec3d& p, double area) {
        const double along = (p - centre).dot(axis);
        if (std::abs(along) < 0.5 * length - 2 * radius - 2) r.add((p - centre - along * axis).norm(), area);
    });
    return r.about(radius);
}

std::vector<double> heights(const TriangleMesh& mesh, const Vec3f& centre, double half_width, double step) {
    const int n = static_cast<int>(2 * half_width / step) + 1;
    std::vector<double> height(static_cast<std::size_t>(n) * n, -std::numeric_limits<double>::infinity());
    const double x0 = centre.x() - half_width, z0 = centre.z() - half_width;
    for (const auto& [ia, ib, ic] : mesh.triangle) {
        const Vec3d a = mesh.position[ia].cast<double>(), b = mesh.position[ib].cast<double>(), c = mesh.position[ic].cast<double>();
        const double area = (b.x() - a.x()) * (c.z() - a.z()) - (c.x() - a.x()) * (b.z() - a.z());
        if (std::abs(area) < 1e-12) continue;
        const auto from = [&](double low, double origin) { return std::max(0, static_cast<int>(std::ceil((low - origin) / step))); };
        const auto to = [&](double high, double origin) { return std::min(n - 1, static_cast<int>(std::floor((high - origin) / step))); };
        for (int k = from(std::min({a.z(), b.z(), c.z()}), z0); k <= to(std::max({a.z(), b.z(), c.z()}), z0); ++k)
            for (int i = from(std::min({a.x(), b.x(), c.x()}), x0); i <= to(std::max({a.x(), b.x(), c.x()}), x0); ++i) {
                const double x = x0 + i * step, z = z0 + k * step;
                const double v = ((x - a.x()) * (c.z() - a.z()) - (c.x() - a.x()) * (z - a.z())) / area;
                const double w = ((b.x() - a.x()) * (z - a.z()) - (x - a.x()) * (b.z() - a.z())) / area;
                if (v < -1e-9 || w < -1e-9 || v + w > 1 + 1e-9) continue;
                double& top = height[static_cast<std::size_t>(k) * n + i];
                top = std::max(top, a.y() + v * (b.y() - a.y()) + w * (c.y() - a.y()));
            }
    }
    return height;
}

Deviation deviation(const std::vector<double>& values) {
    Accumulated sum;
    for (double value : values) sum.add(value, 1);
    return sum.about(0);
}

}  // namespace whorl::test
