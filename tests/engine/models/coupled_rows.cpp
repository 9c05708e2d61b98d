#include "engine/models/viscosity/coupled/coupled_rows.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "engine/core/random.h"
#include "engine/geometry/solids.h"
#include "engine/math/kernel.h"

using namespace whorl;

namespace coupled_rows_test {

namespace {

constexpr Real d = 0.002;

/// Particles, lengths in spacings.
struct Fluid {
    std::vector<Vec3> x;
    std::vector<std::int16_t> role;
    Domain domain;

    void add(const Vec3& at, std::int16_t whose = 0) { x.push_back(d * at), role.push_back(whose); }
    /// A lattice, each particle moved by up to a tenth of a spacing along each axis.
    void add_block(const Vec3& from, int nx, int ny, int nz, std::int16_t whose = 0, Real apart = 1) {
        RandomNumbers random(5);
        for (int i = 0; i < nx; ++i)
            for (int j = 0; j < ny; ++j)
                for (int k = 0; k < nz; ++k) {
                    Vec3 at = from + apart * Vec3(Real(i), Real(j), Real(k));
                    for (int a = 0; a < 3; ++a) at[a] += static_cast<Real>(0.2 * random() - 0.1);
                    add(at, whose);
                }
    }
    Vec3d between(std::size_t i, std::size_t j) const {
        Vec3d r = x[j].cast<double>() - x[i].cast<double>();
        for (int a = 0; a < 3; ++a)
            if (const double L = double(domain.max[a]) - double(domain.min[a]); domain.periodic[a]) r[a] -= L * std::nearbyint(r[a] / L);
        return r / d;
    }
};

/// Expected content of a row, from all pairs.
struct Expected {
    double h = 0, density = 1;
    std::map<Index, Vec3d> pairs;  ///< r of each j that counts
    std::vector<Index> undecided;  ///< whether a distance is so near a limit that rounding decides
};

constexpr double rounding = 1e-5;  // of distances in spacings: places of up to 30 spacings, in single precision

Expected expected_row(const Fluid& fluid, std::size_t i, const CoupledOptions& o) {
    Expected row;
    const std::size_t n = fluid.x.size();
    std::vector<double> distance(n), sorted;
    for (std::size_t j = 0; j < n; ++j)
        if (j != i) sorted.push_back(distance[j] = fluid.between(i, j).norm());
    std::sort(sorted.begin(), sorted.end());
    const auto within = static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), o.support) - sorted.begin());
    row.h = o.support;
    if (within < o.enough_neighbours)
        row.h = static_cast<int>(sorted.size()) < o.enough_neighbours ? o.widest() : std::min(sorted[o.enough_neighbours - 1], o.widest());
    const double scale = row.h / o.support, gate = o.gate * scale, bridge = o.bridge * scale;
    for (std::size_t j = 0; j < n; ++j) {
        if (j == i) continue;
        if (distance[j] < o.support) row.density += std::pow(1 - std::pow(distance[j] / o.support, 2), 3);
        if (distance[j] > row.h + rounding || distance[j] < 1e-6) continue;  // in one place: no pair
        bool counts = distance[j] <= gate || (fluid.role[i] != 0 && fluid.role[j] != 0), near_limit = distance[j] > row.h - rounding;
        if (!counts)
            for (std::size_t k = 0; k < n; ++k) {
                if (k == i || k == j || distance[k] > bridge + rounding) continue;
                const double other = fluid.between(k, j).norm(), longest = std::max(distance[k], other);
                counts |= longest < bridge;
                near_limit |= std::abs(longest - bridge) < rounding;
            }
        near_limit |= std::abs(distance[j] - gate) < rounding;
        if (near_limit) row.undecided.push_back(static_cast<Index>(j));
        else if (counts) row.pairs[static_cast<Index>(j)] = fluid.between(i, j);
    }
    double at_rest = 0;  // on a lattice
    each_lattice_point(3, 2, [&](int a, int b, int c) {
        at_rest += std::pow(std::max(0.0, 1 - Vec3d(a, b, c).squaredNorm() / (o.support * o.support)), 3);
    });
    row.density /= at_rest;
    return row;
}

/// Number of pairs, and number of particles whose support is wider than usual.
struct Found {
    int pairs = 0, wide = 0, gated = 0;
};

Found require_rows_of_all_pairs(const Fluid& fluid) {
    const CoupledOptions options;
    CoupledRows rows;
    rows.build(fluid.x, fluid.role, fluid.domain, d, options);
    REQUIRE(rows.size() == static_cast<Index>(fluid.x.size()));
    Found found;
    std::size_t pairs = 0;
    for (const RowBlock& block : rows.blocks) {
        const std::vector<Vec4> at(rows.positions(block), rows.positions(block) + block.touched.size());
        std::vector<std::map<Index, std::pair<Vec3d, double>>> in(block.size());
        for (const RowSlice& slice : block.slices)
            rows.pairs_of(block, slice, rows.positions(block)).each([&](std::size_t k, const PairLanes& p) {
                for (Index lane = 0; lane < lane_count; ++lane) {
                    const bool padding = lane >= slice.rows || static_cast<Index>(k) >= block.count[slice.row[lane]];
                    REQUIRE((padding ? p.w[lane] == 0 && p.other[lane] == slice.row[lane] : p.w[lane] > -1e-6));
                    REQUIRE(p.r2[lane] > 0);
                    if (padding) continue;
                    const Index j = block.touched[p.other[lane]];
                    auto& row = in[slice.row[lane]];
                    REQUIRE(row.count(j) == 0);  // no neighbour twice
                    row[j] = {Vec3d(p.r.x[lane], p.r.y[lane], p.r.z[lane]), p.w[lane]};
                }
            });
        for (Index row = 0; row < block.size(); ++row) {
            const Index i = block.begin + row;
            INFO("particle " << i);
            const Expected expected = expected_row(fluid, static_cast<std::size_t>(i), options);
            for (const Index j : expected.undecided) in[row].erase(j);
            REQUIRE(in[row].size() == expected.pairs.size());
            double weights = 0;
            for (const auto& [j, r] : expected.pairs) {
                INFO("and " << j << " at " << r.norm());
                REQUIRE(in[row].count(j) == 1);
                const auto& [r_there, w_there] = in[row][j];
                REQUIRE((r_there - r).norm() < rounding);
                const double w = std::pow(1 - r.squaredNorm() / (expected.h * expected.h), 3);
                REQUIRE(std::abs(w_there - w) < 2 * rounding);  // |dw/dr| is below 2
                weights += w;
            }
            const Neighbourhood& n = rows.neighbourhood[i];
            REQUIRE(n.density == Approx(expected.density).epsilon(1e-5));
            if (expected.undecided.empty()) REQUIRE(n.weights == Approx(weights).margin(1e-4));
            found.pairs += static_cast<int>(expected.pairs.size());
            found.wide += expected.h > options.support;
            pairs += static_cast<std::size_t>(block.count[row]);
            for (std::size_t j = 0; j < fluid.x.size(); ++j)
                found.gated += static_cast<Index>(j) != i && fluid.between(static_cast<std::size_t>(i), j).norm() < expected.h - rounding &&
                               expected.pairs.count(static_cast<Index>(j)) == 0;
        }
    }
    CHECK(rows.pairs == pairs);
    return found;
}

}  // namespace

TEST_CASE("block rows contain the pairs of a brute-force search, with an extra block for 257 particles", "[models][coupled]") {
    Fluid fluid;
    fluid.add_block(Vec3(0, 0, 0), 16, 4, 4);
    fluid.add(Vec3(16, 1, 1));
    REQUIRE(fluid.x.size() == 257);
    CHECK(require_rows_of_all_pairs(fluid).pairs > 257 * 16);
}

TEST_CASE("two coil turns 1.8 spacings apart share no pair through air, unless both are prescribed", "[models][coupled]") {
    Fluid fluid;
    fluid.add_block(Vec3(0, 0, 0), 10, 3, 3);
    fluid.add_block(Vec3(0, Real(4.0), 0), 10, 3, 3);
    CHECK(require_rows_of_all_pairs(fluid).gated > 100);
    for (std::int16_t& role : fluid.role) role = -1;
    CHECK(require_rows_of_all_pairs(fluid).gated == 0);
    for (std::size_t i = 90; i < 180; ++i) fluid.role[i] = 0;
    CHECK(require_rows_of_all_pairs(fluid).gated > 100);
}

TEST_CASE("a bridge of single particles joins the bodies that it touches", "[models][coupled]") {
    Fluid fluid;
    fluid.add_block(Vec3(0, 0, 0), 5, 5, 5);
    fluid.add_block(Vec3(0, Real(6.2), 0), 5, 5, 5);
    for (int k = 0; k < 2; ++k) fluid.add(Vec3(2, Real(5.1) + Real(0.1) * Real(k), Real(2 + k)));
    require_rows_of_all_pairs(fluid);
}

TEST_CASE("the support of a sparse particle reaches its 16th neighbour, at most 4 d, and a lone one has no row", "[models][coupled]") {
    Fluid fluid;
    fluid.add_block(Vec3(0, 0, 0), 6, 6, 6, 0, Real(1.5));
    for (int k = 0; k < 30; ++k) fluid.add(Vec3(30, Real(k), 0));  // a single file
    fluid.add(Vec3(-20, 0, 0));
    fluid.add(Vec3(-20, 10, 0)), fluid.add(Vec3(-20, Real(13.5), 0));  // a pair that only the widest support joins, without a bridge
    fluid.add(Vec3(-20, 20, 0)), fluid.add(Vec3(-20, 20, 0)), fluid.add(Vec3(-19, 20, 0));  // two in one place, which are no pair
    const Found found = require_rows_of_all_pairs(fluid);
    CHECK(found.wide > 100);
    CHECK(found.pairs > 1000);
    CoupledRows rows;
    rows.build(fluid.x, fluid.role, fluid.domain, d, {});
    const RowBlock& block = rows.block_of(246);
    CHECK(block.count[246 - block.begin] == 0);
    CHECK(rows.neighbourhood[246].weights == 0);
    CHECK(rows.inverse_moment(246) == Mat3::Zero());
}

TEST_CASE("a round wall counts in the density by the part of the kernel that lies behind it, within .7 %", "[models][coupled]") {
    // A plane at the same height would give 2.3 % too little inside a cylinder of six spacings, and 4.7 % inside such a sphere.
    const double radius = 6 * double(d), length = 20 * double(d), height = 0.55;  // between two points of the sum below
    const std::shared_ptr<const Shape> cylinder = make_cylinder({0, -length, 0}, {0, length, 0}, radius),
                                       sphere = make_sphere(Vec3d::Zero(), radius);
    for (const bool round : {false, true})
        for (const bool inside : {true, false}) {
            CAPTURE(round, inside);
            Fluid one;
            one.add({static_cast<Real>(inside ? 6 - height : 6 + height), 0, 0});
            Solids solids;
            solids.all.emplace_back();
            solids.all[0].shape = round ? sphere : cylinder;
            solids.all[0].inside = inside;
            std::vector<std::int32_t> held(1, -1);
            const CoupledOptions o;
            CoupledRows rows;
            rows.build(one.x, one.role, one.domain, d, o);
            const double alone = rows.neighbourhood[0].density;
            rows.build(one.x, one.role, one.domain, d, o, {solids, Real(0.001), held, {}});
            double all = 0, behind = 0;
            const auto n = static_cast<int>(10 * o.support);
            each_lattice_point(3, n, [&](int a, int b, int c) {
                const Vec3 r = Real(0.1) * Vec3(Real(a), Real(b), Real(c));
                const double w = std::pow(std::max(0.0, 1 - double(r.squaredNorm()) / (o.support * o.support)), 3);
                all += w;
                if (solids.all[0].distance(one.x[0] + d * r) < 0) behind += w;
            });
            CHECK(double(rows.neighbourhood[0].density) - alone == Approx(behind / all - 0.0119).margin(0.007));
        }
}

TEST_CASE("rows of zero particles and of one particle are empty", "[models][coupled]") {
    Fluid fluid;
    CHECK(require_rows_of_all_pairs(fluid).pairs == 0);
    fluid.add(Vec3(1, 2, 3));
    CHECK(require_rows_of_all_pairs(fluid).pairs == 0);
}

TEST_CASE("rows continue across periodic borders, along one axis and along all", "[models][coupled]") {
    for (const int axes : {1, 2, 4, 7}) {
        Fluid fluid;
        fluid.domain.min = Vec3::Zero(), fluid.domain.max = d * Vec3(9, 9, 9);
        for (int a = 0; a < 3; ++a) fluid.domain.periodic[a] = (axes >> a) & 1;
        fluid.add_block(Vec3(Real(0.5), Real(0.5), Real(0.5)), 9, 9, 4);
        for (Vec3& x : fluid.x) x = fluid.domain.wrapped(x);
        require_rows_of_all_pairs(fluid);
    }
}

}  // namespace coupled_rows_test
