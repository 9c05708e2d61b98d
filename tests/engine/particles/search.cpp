#include "engine/particles/search.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <set>

#include "tests/support/threads.h"

using namespace whorl;

namespace {

std::vector<Vec3> cloud(int n, Real size, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<Vec3> x(n);
    for (Vec3& p : x)
        for (int a = 0; a < 3; ++a) p[a] = size * Real(random()) / Real(4294967296.0);
    return x;
}

Domain box(Real size, int periodic_axes) {
    Domain domain;
    domain.min = Vec3::Zero();
    domain.max = Vec3::Constant(size);
    for (int a = 0; a < 3; ++a) domain.periodic[a] = (periodic_axes >> a) & 1;
    return domain;
}

std::vector<std::set<Index>> rows_of(const Pairs& pairs) {
    std::vector<std::set<Index>> rows(pairs.size());
    for (Index i = 0; i < pairs.size(); ++i) {
        pairs.of(i, [&](Index j, const Vec3&, Real) { rows[i].insert(j); });
        REQUIRE(static_cast<Index>(rows[i].size()) == pairs.count(i));  // no neighbour twice
    }
    return rows;
}

/// Pairs within 1e-5 of the support may fall on either side: they are not compared.
void require_as_brute_force(const Pairs& pairs, const std::vector<Vec3>& own, const std::vector<Vec3>& other, Real support,
                            const Domain& domain, bool among_themselves) {
    const auto rows = rows_of(pairs);
    for (std::size_t i = 0; i < own.size(); ++i)
        for (std::size_t j = 0; j < other.size(); ++j) {
            if (among_themselves && i == j) {
                REQUIRE(rows[i].count(static_cast<Index>(j)) == 0);
                continue;
            }
            double r2 = 0;
            for (int a = 0; a < 3; ++a) {
                double d = double(own[i][a]) - double(other[j][a]);
                const double L = double(domain.max[a]) - double(domain.min[a]);
                if (domain.periodic[a]) d -= L * std::nearbyint(d / L);
                r2 += d * d;
            }
            const double q = std::sqrt(r2) / support;
            if (std::abs(q - 1) < 1e-5) continue;
            const bool found = rows[i].count(static_cast<Index>(j)) == 1;
            if (found != (q < 1)) FAIL("pair " << i << " " << j << " at " << q << " supports, found: " << found);
        }
}

void require_symmetric(const Pairs& pairs) {
    const auto rows = rows_of(pairs);
    for (Index i = 0; i < pairs.size(); ++i)
        for (Index j : rows[i]) REQUIRE(rows[j].count(i) == 1);
}

}  // namespace

TEST_CASE("the search finds all pairs along any periodic axes, from micrometres to kilometres", "[particles]") {
    for (const Real scale : {Real(1e-6), Real(1), Real(1e3)})
        for (int axes = 0; axes < 8; ++axes) {
            const auto x = cloud(300, 10 * scale, 1 + static_cast<std::uint32_t>(axes));
            const auto solid = cloud(150, 10 * scale, 77);
            const Domain domain = box(10 * scale, axes);
            NeighbourSearch search;
            for (const Real support : {Real(1.1) * scale, Real(2) * scale, Real(4.9) * scale}) {
                Pairs pairs;
                search.find(x, support, domain, pairs);
                require_as_brute_force(pairs, x, x, support, domain, true);
                require_symmetric(pairs);
                search.find(x, solid, support, domain, pairs);
                require_as_brute_force(pairs, x, solid, support, domain, false);
            }
        }
}

TEST_CASE("rows found in parts equal rows found together", "[particles]") {
    for (const int axes : {0, 5}) {
        const std::vector<Vec3> x = cloud(700, 1, 4);
        const Domain domain = box(1, axes);
        NeighbourSearch search;
        Pairs all, part;
        search.find(x, Real(0.2), domain, all);
        search.start(x, Real(0.2), domain);
        for (Index begin = 0; begin < 700; begin += 300) {
            const Index end = std::min(700, begin + 300);
            search.rows(x, begin, end, Real(0.2), domain, part);
            REQUIRE(part.size() == end - begin);
            for (Index i = begin; i < end; ++i) {
                const auto row = part.other.begin() + static_cast<std::ptrdiff_t>(part.first[i - begin]);
                REQUIRE(std::equal(row, row + part.count(i - begin), all.other.begin() + static_cast<std::ptrdiff_t>(all.first[i]),
                                   all.other.begin() + static_cast<std::ptrdiff_t>(all.first[i + 1])));
            }
        }
    }
}

TEST_CASE("pairs exactly a support apart are in both rows or in neither", "[particles]") {
    // A lattice whose spacing is not a binary fraction, moved off the origin: rounding decides each pair, and must decide equally for both
    // particles.
    for (int axes : {0, 7}) {
        std::vector<Vec3> x;
        const Real d = Real(0.1);
        for (int k = 0; k < 1000; ++k) x.push_back(Vec3(Real(k % 10), Real(k / 10 % 10), Real(k / 100)) * d + Vec3(d / 3, d / 7, d / 11));
        Pairs pairs;
        NeighbourSearch search;
        search.find(x, 2 * d, box(1, axes), pairs);
        require_symmetric(pairs);
        for (Index i = 0; i < pairs.size(); ++i)
            if (axes == 7) CHECK(pairs.count(i) >= 26);
    }
}

TEST_CASE("particles outside a periodic box have the neighbours of their images inside", "[particles]") {
    auto x = cloud(500, 1, 3);
    const Domain domain = box(1, 7);
    Pairs inside, outside;
    NeighbourSearch search;
    search.find(x, Real(0.2), domain, inside);
    auto moved = x;
    for (std::size_t k = 0; k < x.size(); k += 3) moved[k][k % 2] += Real(k % 2 == 0 ? 1 : -2);
    search.find(moved, Real(0.2), domain, outside);
    require_as_brute_force(outside, moved, moved, Real(0.2), domain, true);
    require_symmetric(outside);
}

TEST_CASE("positions that are not finite get no neighbours and change no others", "[particles]") {
    auto x = cloud(600, 1, 5);
    const auto clean = x;
    const Real nan = std::numeric_limits<Real>::quiet_NaN(), inf = std::numeric_limits<Real>::infinity();
    x[10] = Vec3(nan, 0, 0);
    x[20] = Vec3(0, inf, 0);
    x[30] = Vec3(0, 0, -inf);
    for (int axes : {0, 2, 7}) {
        Pairs pairs, before;
        NeighbourSearch search;
        search.find(clean, Real(0.15), box(1, axes), before);
        search.find(x, Real(0.15), box(1, axes), pairs);
        const auto rows = rows_of(pairs), old = rows_of(before);
        for (Index i = 0; i < pairs.size(); ++i) {
            auto expected = old[i];
            for (Index gone : {10, 20, 30}) expected.erase(gone);
            if (i == 10 || i == 20 || i == 30) expected.clear();
            REQUIRE(rows[i] == expected);
        }
    }
}

TEST_CASE("a few stray particles far away cost no memory and no neighbours", "[particles]") {
    auto x = cloud(3000, 1, 9);
    const Real far = std::numeric_limits<Real>::max() / 4;
    const std::size_t n = x.size();
    x.push_back(Vec3(5000, 0, 0));
    x.push_back(Vec3(5000, Real(0.01), 0));
    x.push_back(Vec3(0, -80000, 90000));
    x.push_back(Vec3(far, -far, far));
    Pairs pairs;
    NeighbourSearch search;
    search.find(x, Real(0.1), box(1, 0), pairs);
    CHECK(search.capacity_bytes() < 40e6);
    CHECK(pairs.count(static_cast<Index>(n)) == 1);
    CHECK(pairs.count(static_cast<Index>(n) + 2) == 0);
    CHECK(pairs.count(static_cast<Index>(n) + 3) == 0);
    x.resize(n);
    Pairs alone;
    NeighbourSearch().find(x, Real(0.1), box(1, 0), alone);
    for (Index i = 0; i < alone.size(); ++i) REQUIRE(pairs.count(i) == alone.count(i));
}

TEST_CASE("grouped neighbours equal single ones, and padding lies outside the kernel", "[particles]") {
    // So dense that some rows need two groups; two periodic axes and a free one.
    const auto x = cloud(3000, 1, 5);
    const Real R = Real(0.25);
    const Domain domain = box(1, 3);
    Pairs pairs;
    NeighbourSearch().find(x, R, domain, pairs);
    Index most = 0;
    for (Index i = 0; i < pairs.size(); ++i) {
        std::vector<Index> other;
        std::vector<Vec3> r;
        std::vector<Real> distance;
        pairs.of(i, [&](Index j, const Vec3& r_ij, Real d) { other.push_back(j), r.push_back(r_ij), distance.push_back(d); });
        most = std::max(most, pairs.count(i));
        std::size_t seen = 0;
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real at[3][Pairs::Group::most];
            group.gather(x.data(), at);
            for (Index l = 0; l < group.padded(); ++l) {
                for (int a = 0; a < 3; ++a) REQUIRE(at[a][l] == x[group.other[l]][a]);
                if (l >= group.count) {
                    REQUIRE(group.distance[l] == R);
                    continue;
                }
                REQUIRE(group.other[l] == other[seen]);
                // The image is found by a quotient or by a product, which differ by round-off of the box's length.
                for (int a = 0; a < 3; ++a) REQUIRE(group.r[a][l] == Approx(r[seen][a]).margin(1e-6));
                REQUIRE(group.distance[l] == Approx(distance[seen]).margin(1e-6));
                ++seen;
            }
        });
        REQUIRE(seen == other.size());
    }
    CHECK(most > Pairs::Group::most);
}

TEST_CASE("the search accepts no particles, one particle, and fluid without solids", "[particles]") {
    NeighbourSearch search;
    Pairs pairs;
    const std::vector<Vec3> none, one{Vec3(Real(0.3), 0, 0)};
    search.find(none, Real(0.1), box(1, 0), pairs);
    CHECK(pairs.size() == 0);
    search.find(one, Real(0.1), box(1, 7), pairs);
    CHECK(pairs.count(0) == 0);
    search.find(one, none, Real(0.1), box(1, 0), pairs);
    CHECK(pairs.count(0) == 0);
    search.find(one, one, Real(0.1), box(1, 0), pairs);
    CHECK(pairs.count(0) == 0);
}

TEST_CASE("the rows are equal for 1, 2 and 4 threads and for a search that was used before", "[particles]") {
    const auto x = cloud(5000, 1, 11), y = cloud(9000, 2, 12);
    NeighbourSearch used;
    Pairs scratch;
    used.find(y, Real(0.2), box(2, 1), scratch);
    CHECK(test::same_on_threads([&] {
        Pairs pairs;
        used.find(x, Real(0.1), box(1, 5), pairs);
        return std::pair(pairs.first, pairs.other);
    }));
}

TEST_CASE("pairs found with a margin are narrowed to those of a new search, unless a particle moved too far", "[particles]") {
    const Real support = Real(1.1), spare = Real(0.2);
    for (int axes = 0; axes < 8; ++axes) {
        const Domain domain = box(10, axes);
        auto x = cloud(1500, 10, 5);
        const auto solid = cloud(400, 10, 77);
        NeighbourSearch search;
        Pairs pairs, solid_pairs;
        search.find_wide(x, x, support + spare, domain, pairs);
        search.find_wide(x, solid, support + spare, domain, solid_pairs);
        std::mt19937 random(9);
        for (Vec3& p : x) {  // moves by at most half of the margin, also across periodic faces
            Vec3 move;
            for (int a = 0; a < 3; ++a) move[a] = Real(random()) / Real(4294967296.0) - Real(0.5);
            p = domain.wrapped(p + Real(0.49) * spare * move / std::max(Real(1e-3), move.norm()));
        }
        REQUIRE(NeighbourSearch::narrow(x, x, support, domain, pairs));
        require_as_brute_force(pairs, x, x, support, domain, true);
        require_symmetric(pairs);
        REQUIRE(NeighbourSearch::narrow(x, solid, support, domain, solid_pairs));
        require_as_brute_force(solid_pairs, x, solid, support, domain, false);
        REQUIRE_FALSE(NeighbourSearch::narrow(x, x, support, domain, pairs));  // the margin is used up

        search.find_wide(x, x, support + spare, domain, pairs);
        const auto before = pairs.other;
        x[700][1] += Real(0.6) * spare;
        REQUIRE_FALSE(NeighbourSearch::narrow(x, x, support, domain, pairs));
        REQUIRE(pairs.other == before);
        x.pop_back();
        REQUIRE_FALSE(NeighbourSearch::narrow(x, x, support, domain, pairs));
    }
}

TEST_CASE("narrowed rows equal those of a search and are bit-identical with 1, 2 and 4 threads", "[particles]") {
    const Domain domain = box(19, 1);
    const auto x = cloud(20000, 19, 5);  // more rows than are joined together
    const auto narrowed = [&] {
        NeighbourSearch search;
        Pairs pairs;
        search.find_wide(x, x, Real(1.3), domain, pairs);
        REQUIRE(NeighbourSearch::narrow(x, x, Real(1.1), domain, pairs));
        return std::pair(pairs.first, pairs.other);
    };
    REQUIRE(test::same_on_threads(narrowed));
    auto [first, rows] = narrowed();
    NeighbourSearch search;
    Pairs fresh;
    search.find(x, Real(1.1), domain, fresh);
    REQUIRE(first == fresh.first);
    for (Index i = 0; i < fresh.size(); ++i)  // in another order
        for (Column<Index>* other : {&fresh.other, &rows})
            std::sort(other->begin() + static_cast<std::ptrdiff_t>(fresh.first[i]),
                      other->begin() + static_cast<std::ptrdiff_t>(fresh.first[i + 1]));
    REQUIRE(fresh.other == rows);
}
