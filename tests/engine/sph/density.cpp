#include "engine/sph/density.h"

#include <catch2/catch.hpp>

#include "engine/particles/search.h"

using namespace whorl;

namespace {

/// A lattice of n^3 points in a periodic box.
struct Lattice {
    std::vector<Vec3> x;
    Domain domain;
    FluidPairs pairs;
    Lattice(int n, Real d, Real support) {
        for (int k = 0; k < n * n * n; ++k)
            x.push_back(d * Vec3(Real(k % n) + Real(0.5), Real(k / n % n) + Real(0.5), Real(k / n / n) + Real(0.5)));
        domain.max = Vec3::Constant(n * d);
        domain.periodic = {true, true, true};
        NeighbourSearch().find(x, support, domain, pairs);
    }
};

}  // namespace

TEST_CASE("on a lattice every kernel sums to one within one per cent, and the density is the rest density", "[sph]") {
    for (KernelKind kind : {KernelKind::cubic, KernelKind::wendland_c2, KernelKind::wendland_c4}) {
        // The error of the sum depends on the kernel and falls with support/spacing. Wendland C4 needs 3 spacings for the error of the
        // cubic kernel with 2.
        const Real support = kind == KernelKind::cubic ? Real(2) : Real(3);
        const Real d = Real(1e-3);
        const Lattice lattice(8, d, support * d);
        StepContext step;
        step.support = support * d;
        step.kernel = kind;
        step.rest_density = 1000;
        step.mass = 1000 * d * d * d;
        std::vector<Real> density(lattice.x.size());
        Solids solids;
        BoundaryParticles boundary;
        sum_density({lattice.pairs, {}, solids, boundary, step}, 1, {}, density);
        for (Real rho : density) REQUIRE(rho == Approx(1000).epsilon(0.01));
    }
}

TEST_CASE("solids count in the density with their volume", "[sph]") {
    // The lower half of a periodic lattice is solid, which does not change a fluid particle's density.
    const Lattice lattice(8, Real(0.1), Real(0.2));
    std::vector<Vec3> fluid, solid;
    for (const Vec3& x : lattice.x) (x[1] < Real(0.4) ? solid : fluid).push_back(x);
    FluidPairs fluid_pairs;
    SolidPairs solid_pairs;
    NeighbourSearch().find(fluid, Real(0.2), lattice.domain, fluid_pairs);
    NeighbourSearch().find(fluid, solid, Real(0.2), lattice.domain, solid_pairs);
    StepContext step;
    step.support = Real(0.2);
    step.rest_density = 500;
    step.mass = Real(500 * 1e-3);
    Solids solids;
    BoundaryParticles boundary;
    boundary.volume.assign(solid.size(), Real(1e-3));
    std::vector<Real> density(fluid.size());
    sum_density({fluid_pairs, solid_pairs, solids, boundary, step}, 1, {}, density);
    for (Real rho : density) REQUIRE(rho == Approx(density[0]).epsilon(1e-5));
}
