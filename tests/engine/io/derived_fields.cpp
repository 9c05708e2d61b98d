// Fields that are computed for a frame.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "engine/core/random.h"
#include "engine/io/snapshot.h"
#include "engine/particles/sample.h"

using namespace whorl;

TEST_CASE("the vorticity of a linear flow is exact, also at a free surface and on jittered particles", "[io]") {
    Column<Vec3> x, u;
    const Vec3 omega(1, -2, 3);
    RandomNumbers random(1);
    const auto jitter = [&] { return static_cast<Real>(0.2 * (random() - 0.5)); };
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < 6; ++j)
            for (int i = 0; i < 6; ++i) {
                const Vec3 place(Real(i) + jitter(), Real(j) + jitter(), Real(k) + jitter());
                x.push_back(place);
                u.push_back(omega.cross(place) + Vec3(place.x(), -place.y(), 0) + Vec3(5, 0, 0));  // turning, stretching, drifting
            }
    Domain domain;
    domain.min = Vec3::Constant(-10), domain.max = Vec3::Constant(10);
    const Column<Vec3> curl = vorticity(Span<const Vec3>(x.data(), x.size()), Span<const Vec3>(u.data(), u.size()), 2, domain);
    // The regularisation of 1e-4 of the moments' trace shows in the sixth corner that has few neighbours.
    for (const Vec3& c : curl) CHECK((c - 2 * omega).norm() < 2e-3 * omega.norm());
}

TEST_CASE("a lone particle has no vorticity", "[io]") {
    const Column<Vec3> x{Vec3(0, 0, 0)}, u{Vec3(1, 2, 3)};
    Domain domain;
    domain.min = Vec3::Constant(-1), domain.max = Vec3::Constant(1);
    CHECK(vorticity(Span<const Vec3>(x.data(), 1), Span<const Vec3>(u.data(), 1), 1, domain)[0] == Vec3(0, 0, 0));
}

TEST_CASE("Q is the squared rotation rate minus the squared strain rate, also in rotated axes", "[io]") {
    Mat3 turning = Mat3::Zero(), strain = Mat3::Zero();
    turning(0, 1) = -3, turning(1, 0) = 3;  // 3 rad/s: |W|^2/2 = 9
    strain(0, 0) = 2, strain(1, 1) = -2;    // |S|^2/2 = 4
    const Mat3 R = Eigen::AngleAxis<Real>(Real(0.7), Vec3(1, 2, 3).normalized()).toRotationMatrix();
    CHECK(q_criterion(turning) == Approx(9));
    CHECK(q_criterion(strain) == Approx(-4));
    CHECK(q_criterion(R * (turning + strain) * R.transpose()) == Approx(5).epsilon(1e-5));
}
