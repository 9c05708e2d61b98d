#include "engine/models/viscosity/coupled/strain_form.h"

#include <catch2/catch.hpp>

#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/coupled/two_level.h"
#include "tests/support/coarse_difference.h"
#include "tests/support/coupled_world.h"
#include "tests/support/random_vectors.h"

using namespace whorl;
using namespace whorl::test;

namespace strain_form_test {

namespace {

constexpr Real d = 0.002;

/// Rows and form of a blob, with K = nu dt / d^2.
struct Form {
    CoupledOptions options;
    CoupledRows rows;
    StrainForm form;
    std::vector<Real> mu;
    std::vector<std::int16_t> role;
    Form(const std::vector<Vec3>& x, Real K, const Domain& domain = {}) : mu(x.size(), 1000 * K * d * d), role(x.size(), 0) {
        rows.build(x, role, domain, d, options);
        form.set(rows, mu, 1, 1000, d, options);
    }
};

double dot_all(const std::vector<Vec3>& a, const std::vector<Vec3>& b) { return dot<Vec3>(a, b); }

}  // namespace

TEST_CASE("the strain form is symmetric, conserves momentum, and leaves rigid motions alone", "[models][coupled]") {
    const std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 20 * d, d);
    const Form f(x, 10);
    RandomNumbers random(1);
    std::vector<Vec3> u(x.size()), v(x.size()), Au(x.size()), Av(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = random_vector(random), v[i] = random_vector(random);
    f.form.apply(u, Au);
    f.form.apply(v, Av);
    CHECK(dot_all(Au, v) == Approx(dot_all(u, Av)).epsilon(1e-5));

    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    double scale = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d inner = (Au[i] - u[i]).cast<double>();
        force += inner;
        torque += (x[i].cast<double>() / d).cross(inner);
        scale += inner.norm();
    }
    CHECK(force.norm() < 1e-6 * scale);
    CHECK(torque.norm() < 1e-5 * scale);

    const Vec3 omega(1, 2, -3);
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = Vec3(1, 0, 2) + omega.cross(x[i] / d);
    f.form.apply(u, Au);
    double left = 0, size = 0;
    for (std::size_t i = 0; i < x.size(); ++i) left += (Au[i] - u[i]).squaredNorm(), size += u[i].squaredNorm();
    // Round-off of K w (u_j - u_i), which K = 10 and the penalties' factors amplify.
    CHECK(std::sqrt(left / size) < 1e-4);
}

TEST_CASE("a linear velocity field has its exact gradient, also at the surface", "[models][coupled]") {
    const std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 20 * d, d);
    const Form f(x, 1);
    Mat3 gradient;
    gradient << 1, 2, 3, -4, 5, 6, 7, -8, -6;
    std::vector<Vec3> u(x.size());
    std::vector<Mat3> G(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = gradient * x[i];
    f.form.gradient(u, G);
    double worst = 0;
    for (const Mat3& g : G) worst = std::max(worst, double((g - gradient).norm()));
    CHECK(worst < 1e-3 * gradient.norm());
}

TEST_CASE("the diagonal blocks equal those of the operator", "[models][coupled]") {
    const std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 12 * d, d);
    const Form f(x, 10);
    std::vector<Mat3> B(x.size());
    f.form.diagonal(B);
    std::vector<Vec3> e(x.size(), Vec3::Zero()), column(x.size());
    for (std::size_t i = 0; i < x.size(); i += 37)
        for (int a = 0; a < 3; ++a) {
            e[i][a] = 1;
            f.form.apply(e, column);
            e[i][a] = 0;
            // The blocks use the mean of the penalties' projections: an error of 2 % of the block.
            CHECK((column[i] - B[i].col(a)).norm() < 0.05 * B[i].norm());
        }
}

TEST_CASE("the coarse matrix is R^T A R to 1e-5, with a thin thread, held particles and friction", "[models][coupled]") {
    std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 14 * d, d);
    for (int k = 0; k < 12; ++k) x.push_back(Vec3(0, (Real(14.5) + Real(k)) * d, 0));
    Form f(x, 10);
    std::vector<Mat3> friction(x.size(), Mat3::Zero());
    for (std::size_t i = 0; i < 30; ++i) f.role[i] = -1;
    for (std::size_t i = 30; i < 60; ++i) friction[i].diagonal() = Vec3(2, 0, 3);
    f.form.set_friction(friction);
    const auto neighbours = [&](Index i, const auto& visit) {
        const RowBlock& block = f.rows.blocks[i / CoupledRows::block_size];
        block.each_pair(i - block.begin, [&](RowBlock::LocalIndex at) { visit(block.touched[at]); });
    };
    std::vector<std::int32_t> group(x.size());
    aggregate_by(neighbours, x, f.role, Domain{}, d / 2, 24, group);
    const int groups = split_unconnected(neighbours, group);
    CHECK(groups > 6);
    RigidAggregates R;
    R.place(x, f.role, group, groups, Domain{}, d);
    const SymmetricBlocks coarse = coarse_matrix(f.form, R);
    const CoarseDifference found = coarse_difference([&](Span<const Vec3> u, Span<Vec3> Au) { f.form.apply(u, Au); }, R, coarse, x.size());
    CHECK(found.difference < 1e-5 * found.largest);
}

TEST_CASE("the coarse matrix is R^T A R in a periodic slab whose rows meet both sides of an aggregate", "[models][coupled]") {
    for (const int width : {5, 8}) {
        RandomNumbers random(3);
        std::vector<Vec3> x;
        for (int i = 0; i < width; ++i)
            for (int j = 0; j < 8; ++j)
                for (int k = 0; k < 8; ++k)
                    x.push_back(d * (Vec3(Real(i) + Real(0.5), Real(j), Real(k)) + Real(0.1) * random_vector(random)));
        Domain domain;
        domain.min = Vec3::Zero(), domain.max = Vec3(Real(width) * d, 1, 1), domain.periodic[0] = true;
        Form f(x, 10, domain);
        std::vector<std::int32_t> group(x.size());
        const auto neighbours = [&](Index i, const auto& visit) {
            const RowBlock& block = f.rows.blocks[i / CoupledRows::block_size];
            block.each_pair(i - block.begin, [&](RowBlock::LocalIndex at) { visit(block.touched[at]); });
        };
        const int groups = aggregate_by(neighbours, x, f.role, domain, d / 2, 64, group);
        RigidAggregates R;
        R.place(x, f.role, group, groups, domain, d);
        const SymmetricBlocks coarse = coarse_matrix(f.form, R);
        const auto A = [&](Span<const Vec3> u, Span<Vec3> Au) { f.form.apply(u, Au); };
        const CoarseDifference found = coarse_difference(A, R, coarse, x.size());
        CHECK(found.difference < 1e-5 * found.largest);  // round-off
    }
}

TEST_CASE("the strain form returns the product u.y of the free particles", "[models][coupled]") {
    const std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 12 * d, d);
    const Form f(x, 10);
    RandomNumbers random(2);
    std::vector<Vec3> u(x.size()), all(x.size()), y(x.size());
    for (Vec3& v : u) v = random_vector(random);
    f.form.apply(u, all);
    const auto free = [](Index i, const Vec3& v) { return i % 3 == 0 ? Vec3(Vec3::Zero()) : v; };
    const double product = f.form.apply(u, y, free);
    for (std::size_t i = 0; i < x.size(); ++i) CHECK(y[i] == free(static_cast<Index>(i), all[i]));
    CHECK(product == dot_all(u, y));
}

}  // namespace strain_form_test
