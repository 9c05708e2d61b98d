#include <Eigen/Geometry>

#include "engine/geometry/kinds.h"

namespace whorl {
namespace {

class Box final : public Shape {
public:
    Box(const Vec3d& min, const Vec3d& max) : centre_(((min + max) / 2).cast<Real>()), half_(((max - min) / 2).cast<Real>()) {}

    // |max(q, 0)| + min(max(q), 0), q = |x - c| - h
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
    /// Each face on its own, so that its normals are sharp at the edges.
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

private:
    Vec3 centre_, half_;
};

}  // namespace

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max) { return std::make_shared<Box>(min, max); }

void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v) {
    int least = 0;
    n.cwiseAbs().minCoeff(&least);
    u = n.cross(Vec3d::Unit(least)).normalized();
    v = n.cross(u);
}

}  // namespace whorl
