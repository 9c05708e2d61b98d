#include "engine/models/projection/momenta.h"

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"

namespace whorl {
namespace {

Momenta momenta_of(Span<const Vec3> x, Span<const Vec3> u) {
    return parallel_sum(static_cast<Index>(x.size()), Momenta{}, [&](Index i) {
        const Vec3d v = u[i].cast<double>();
        return Momenta{v, x[i].cast<double>().cross(v)};
    });
}

/// About the centre of n equal particles.
struct Inertia {
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
    void operator+=(const Inertia& o) { first += o.first, second += o.second; }
};

}  // namespace

void TakeMomenta::operator()(Read<field::position> x, Read<field::velocity> u) const { *before = momenta_of(x.values, u.values); }

void KeepMomenta::operator()(Read<field::position> x, Update<field::velocity> u) const {
    const Index n = u.size();
    if (n == 0) return;
    const Momenta now = momenta_of(x.values, u.values);
    const Vec3d push = (before->momentum - now.momentum) / n;
    const Inertia sums = parallel_sum(n, Inertia{}, [&](Index i) {
        const Vec3d r = x[i].cast<double>();
        return Inertia{r, r.squaredNorm() * Mat3d::Identity() - r * r.transpose()};
    });
    const Vec3d centre = sums.first / n;
    Vec3d turn = Vec3d::Zero();
    if (turning) {
        const Mat3d about = sums.second - n * (centre.squaredNorm() * Mat3d::Identity() - centre * centre.transpose());
        turn = pseudo_inverse(about) * (before->turning - now.turning - n * centre.cross(push));
    }
    parallel_for(n, [&](Index i) { u[i] += (push + turn.cross(x[i].cast<double>() - centre)).cast<Real>(); });
}

}  // namespace whorl
