#include <limits>

#include "engine/geometry/kinds.h"

namespace whorl {
namespace {

class Plane final : public Shape {
public:
    Plane(const Vec3d& point, const Vec3d& normal) : point_(point.cast<Real>()), normal_(normal.normalized().cast<Real>()) {}

    Real distance(const Vec3& x) const override { return (x - point_).dot(normal_); }
    Vec3 normal(const Vec3&) const override { return normal_; }
    void bounds(Vec3& min, Vec3& max) const override {
        const Real inf = std::numeric_limits<Real>::infinity();
        min = Vec3::Constant(-inf);
        max = Vec3::Constant(inf);
        for (int a = 0; a < 3; ++a) {  // an upright plane bounds its half-space on one side
            if (normal_[a] == 1) max[a] = point_[a];
            if (normal_[a] == -1) min[a] = point_[a];
        }
    }
    bool bounded() const override { return false; }
    TriangleMesh mesh(Real, Real extent) const override {
        Vec3d u, v;
        frame_of(normal_.cast<double>(), u, v);
        TriangleMesh m;
        for (int k = 0; k < 4; ++k) {
            const Vec3d x = point_.cast<double>() + double(extent) * ((k == 1 || k == 2 ? 1 : -1) * u + (k >= 2 ? 1 : -1) * v);
            m.position.push_back(x.cast<float>());
            m.normal.push_back(normal_.cast<float>());
        }
        m.triangle = {{0, 1, 2}, {0, 2, 3}};
        return m;
    }

private:
    Vec3 point_, normal_;
};

}  // namespace

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal) { return std::make_shared<Plane>(point, normal); }

}  // namespace whorl
