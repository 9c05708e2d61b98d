// Free bodies as unknowns of the coupled solve.
#include <catch2/catch.hpp>

#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/coupled/body_solve.h"
#include "engine/models/viscosity/coupled/two_level.h"
#include "tests/support/random_vectors.h"
#include "tests/support/solids.h"

using namespace whorl;
using namespace whorl::test;

namespace coupled_bodies_test {

namespace {

constexpr Real d = 0.002;
constexpr Real mass = 1000 * d * d * d;

/// A box of particles with nu dt/d^2 = 10 around a free ball of radius 3 d and half the fluid's density.
struct BallInFluid {
    Solids solids;
    std::vector<Vec3> x;
    std::vector<std::int16_t> role;
    std::vector<Real> mu;
    std::vector<std::int32_t> held;
    std::vector<Vec3> slip;
    CoupledOptions options;
    CoupledRows rows;
    StrainForm form;
    ViscousBodies bodies;

    explicit BallInFluid(double slip_length = 0) {
        solids.all.push_back(solid_of(make_sphere(Vec3d::Zero(), 3 * double(d)), 500));
        solids.all[0].slip_length = slip_length;
        solids.place_bodies();
        RandomNumbers random(2);
        for (int i = -5; i < 5; ++i)
            for (int j = -5; j < 5; ++j)
                for (int k = -5; k < 5; ++k) {
                    const Vec3 at = d * (Vec3(Real(i), Real(j), Real(k)) + Vec3::Constant(Real(0.5)) + Real(0.1) * random_vector(random));
                    if (solids.all[0].distance(at) > Real(0.4) * d) x.push_back(at);
                }
        role.assign(x.size(), 0), held.assign(x.size(), 0), slip.assign(x.size(), Vec3::Zero());
        mu.assign(x.size(), 1000 * 10 * d * d);
        rows.build(x, role, {}, d, options, {solids, 1, held, slip});
        bodies.set_up(solids, mass, 0, {}, [](Index, std::size_t) { return BodyTouch{}; });
        form.set(rows, mu, 1, 1000, d, options);
        form.set_bodies(bodies);
    }
    std::size_t entries() const { return x.size() + 2; }
    /// Random velocities; those of the body are about as fast on its surface.
    std::vector<Vec3> velocities(RandomNumbers& random) const {
        std::vector<Vec3> u;
        for (std::size_t i = 0; i < entries(); ++i) u.push_back(random_vector(random));
        u.back() /= 3 * d;
        return u;
    }
    std::vector<Vec3> product(const std::vector<Vec3>& u) const {
        std::vector<Vec3> y(u.size());
        form.apply(u, Span<Vec3>(y));
        return y;
    }
};

}  // namespace

TEST_CASE("the strain form of fluid and a free body is symmetric and conserves their momenta to 1e-5", "[models][coupled][bodies]") {
    // The fluid sticks to the ball, or slides on it freely.
    for (const double slip_length : {0.0, std::numeric_limits<double>::infinity()}) {
        const BallInFluid f(slip_length);
        CHECK(f.rows.walls > 100);
        RandomNumbers random(1);
        const std::vector<Vec3> u = f.velocities(random), v = f.velocities(random), Au = f.product(u), Av = f.product(v);
        CHECK(dot<Vec3>(Au, v) == Approx(dot<Vec3>(u, Av)).epsilon(1e-5));
        Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
        double scale = 0;
        for (std::size_t i = 0; i < f.x.size(); ++i) {
            const Vec3d inner = (Au[i] - u[i]).cast<double>();
            force += inner, torque += (f.x[i].cast<double>() / d).cross(inner), scale += inner.norm();
        }
        std::vector<Vec3> inertia(2);
        f.bodies.weigh(Span<const Vec3>(u).last(2), inertia);
        const std::size_t n = f.x.size();
        force += (Au[n] - inertia[0]).cast<double>(), torque += (Au[n + 1] - inertia[1]).cast<double>() / d;
        CHECK(force.norm() < 1e-5 * scale);
        // Fluid slides along the plane at its particle, so torques balance only where it sticks.
        if (slip_length == 0) CHECK(torque.norm() < 1e-5 * scale);
    }
}

TEST_CASE("fluid and body that move as one rigid body have no forces between them", "[models][coupled][bodies]") {
    const BallInFluid f;
    const Vec3 v(1, 0, 2), w = Vec3(1, 2, -3) / (10 * d);
    std::vector<Vec3> u;
    for (const Vec3& x : f.x) u.push_back(v + w.cross(x));
    u.insert(u.end(), {v, w});
    std::vector<Vec3> y = f.product(u), inertia(2);
    f.bodies.weigh(Span<const Vec3>(u).last(2), inertia);
    double left = 0, size = 0;
    for (std::size_t i = 0; i < f.x.size(); ++i) left += (y[i] - u[i]).squaredNorm(), size += u[i].squaredNorm();
    const std::size_t n = f.x.size();
    left += (y[n] - inertia[0]).squaredNorm() + (y[n + 1] - inertia[1]).squaredNorm() / (d * d);
    CHECK(std::sqrt(left / size) < 1e-3);  // round-off times nu dt/d^2 and the factors of the penalties
}

TEST_CASE("the body's 6x6 block and the coarse matrix contain a free body as the operator does", "[models][coupled][bodies]") {
    const BallInFluid f;
    const std::size_t n = f.x.size();
    std::vector<Mat3> B(n);
    std::vector<SymmetricBlocks::Block> block;
    f.form.diagonal(B, &block);
    REQUIRE(block.size() == 1);
    for (int k = 0; k < 6; ++k) {
        std::vector<Vec3> e(f.entries(), Vec3::Zero());
        e[n + static_cast<std::size_t>(k / 3)][k % 3] = 1;
        const std::vector<Vec3> column = f.product(e);
        // Only fluid of less than 32 particles is solved with this block. Like the blocks of particles it approximates the penalty along
        // pairs, which a wall that moves along the surface doubles.
        const double exact = column[n + static_cast<std::size_t>(k / 3)][k % 3];
        CHECK(block[0](k, k) < 1.1 * exact);
        CHECK(block[0](k, k) > 0.45 * exact);
    }

    const auto neighbours = [&](Index i, const auto& visit) {
        const RowBlock& rows = f.rows.block_of(i);
        rows.each_pair(i - rows.begin, [&](RowBlock::LocalIndex at) { visit(rows.touched[at]); });
    };
    std::vector<std::int32_t> group(n);
    aggregate_by(neighbours, f.x, f.role, Domain{}, d / 2, 24, group);
    const int groups = split_unconnected(neighbours, group);
    RigidAggregates R;
    R.place(f.x, f.role, group, groups + 1, Domain{}, d);
    R.set_centre(groups, Vec3d::Zero());
    const SymmetricBlocks coarse = coarse_matrix(f.form, R);
    RandomNumbers random(3);
    const auto motion = [&] {
        Eigen::VectorXd m(6 * (groups + 1));
        for (Eigen::Index k = 0; k < m.size(); ++k) m[k] = 2 * random() - 1;
        return m;
    };
    const auto velocities = [&](const Eigen::VectorXd& m) {
        const Eigen::VectorXf narrow = m.cast<float>();
        std::vector<Real> of(narrow.data(), narrow.data() + narrow.size());
        std::vector<Vec3> u;
        for (std::size_t i = 0; i < n; ++i) u.push_back(R.motion_of(of, static_cast<Index>(i)));
        const auto body = m.tail<6>().cast<Real>();
        u.push_back(body.head<3>()), u.push_back(body.tail<3>() / d);
        return u;
    };
    for (int trial = 0; trial < 5; ++trial) {
        const Eigen::VectorXd a = motion(), b = motion();
        double product = 0;
        for (int r = 0; r < coarse.nodes(); ++r)
            for (const SymmetricBlocks::Entry& e : coarse.row(r)) {
                product += a.segment<6>(6 * r).dot(e.value * b.segment<6>(6 * e.column));
                if (e.column != r) product += a.segment<6>(6 * e.column).dot(e.value.transpose() * b.segment<6>(6 * r));
            }
        const std::vector<Vec3> u = velocities(a), v = velocities(b), Av = f.product(v);
        const double scale = std::sqrt(dot<Vec3>(u, f.product(u)) * dot<Vec3>(v, Av));
        CHECK(product == Approx(dot<Vec3>(u, Av)).margin(1e-5 * scale));
    }
}

}  // namespace coupled_bodies_test
