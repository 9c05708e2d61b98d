#include <Eigen/Geometry>

#include "engine/geometry/shape.h"
#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

class Box final : public Shape {
public:
    Box(const Vec3d& min, const Vec3d& max) : centre_(((min + max) / 2).cast<Real>()), half_(((max - min) / 2).cast<Real>()) {}

    // |max(q, 0)| + min(max(q), 0), with q = |x - c| - h by axis, the centre c and the half sizes h
    Real distance(const Vec3& x) const override {
        const Vec3 q = (x - centre_).cwiseAbs() - half_;
        return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), Real(0));
    }
    Vec3 normal(const Vec3& x) const override {
        const Vec3 r = x - centre_, q = r.cwiseAbs() - half_;
        Vec3 n = q.cwiseMax(0);
        if (n == Vec3::Zero()) {
            int a = 0;
            q.maxCoeff(&a);
            n[a] = 1;
        }
        for (int a = 0; a < 3; ++a) n[a] = std::copysign(n[a], r[a]);
        return n.normalized();
    }
    void bounds(Vec3& min, Vec3& max) const override {
        min = centre_ - half_;
        max = centre_ + half_;
    }
    bool prismatic(int) const override { return true; }
    MassProperties bulk() const override {
        const Vec3d half = half_.cast<double>();
        const double volume = 8 * half.prod();
        return {volume, centre_.cast<double>(), Mat3d((volume / 3 * half.cwiseProduct(half)).asDiagonal())};
    }
    /// Each face has its own vertices, so that normals are sharp at the edges.
    TriangleMesh mesh(Real, Real) const override {
        TriangleMesh m;
        for (int a = 0; a < 3; ++a)
            for (int side : {-1, 1}) {
                const int b = (a + 1) % 3, c = (a + 2) % 3;
                const std::uint32_t first = static_cast<std::uint32_t>(m.position.size());
                for (int k = 0; k < 4; ++k) {
                    Vec3 x = centre_;
                    x[a] += Real(side) * half_[a];
                    x[b] += (k == 1 || k == 2 ? 1 : -1) * half_[b];
                    x[c] += (k >= 2 ? 1 : -1) * half_[c];
                    m.position.push_back(x.cast<float>());
                    m.normal.push_back(static_cast<float>(side) * Vec3f::Unit(a));
                }
                if (side > 0) {
                    m.triangle.push_back({first, first + 1, first + 2});
                    m.triangle.push_back({first, first + 2, first + 3});
                } else {
                    m.triangle.push_back({first, first + 2, first + 1});
                    m.triangle.push_back({first, first + 3, first + 2});
                }
            }
        return m;
    }

    /// A lattice on the six faces. Points of edges and corners occur only once.
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        LatticeLine line[3];
        for (int a = 0; a < 3; ++a) line[a] = lattice_line(region, a, centre_[a], half_[a], offset, "box");
        const double n[3] = {double(line[0].at.size()), double(line[1].at.size()), double(line[2].at.size())};
        check_count(2 * (n[0] * n[1] + n[1] * n[2] + n[2] * n[0]), "box");
        std::vector<SurfaceSample> points;
        for (std::size_t i = 0; i < line[0].at.size(); ++i)
            for (std::size_t j = 0; j < line[1].at.size(); ++j) {
                const bool on_face = line[0].side[i] != 0 || line[1].side[j] != 0;
                for (std::size_t k = 0; k < line[2].at.size(); k += line[2].next(on_face)) {
                    if (!on_face && line[2].side[k] == 0) continue;
                    const Vec3d side(line[0].side[i], line[1].side[j], line[2].side[k]);
                    points.push_back({Vec3d(line[0].at[i], line[1].at[j], line[2].at[k]), side.normalized(), 0, face_of(side)});
                }
            }
        return points;
    }

private:
    Vec3 centre_, half_;
};

}  // namespace

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max) { return std::make_shared<Box>(min, max); }

}  // namespace whorl
