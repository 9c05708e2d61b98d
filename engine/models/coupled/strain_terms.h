#pragma once
/// What the strain form takes from the sums over a row (strain_form.h has the letters), one row a lane: for products with the form, and for
/// its coarse matrix.
#include "engine/models/coupled/coupled_rows.h"

namespace whorl {

/// What the form needs of a particle besides its row.
struct StrainCoefficients {
    Real shear = 0;  ///< 2 K
    /// K Lambda; an unresolved lateral direction is stress-free, so that a single file has Trouton's 3 mu instead of locking.
    Real bulk = 0;
    Real smooth = 0;  ///< 2 c
    Real pair = 0;    ///< 2 c'
};

/// The coefficients of a slice's rows.
struct CoefficientLanes {
    Lanes shear{}, bulk{}, smooth{}, pair{};
    void set(Index lane, const StrainCoefficients& c) {
        shear[lane] = c.shear, bulk[lane] = c.bulk, smooth[lane] = c.smooth, pair[lane] = c.pair;
    }
    StrainCoefficients of(Index lane) const { return {shear[lane], bulk[lane], smooth[lane], pair[lane]}; }
};

/// A += v b^T
inline void add_outer(const Lanes3& v, const Lanes3& b, Lanes33& A) {
    A.m[0][0] += v.x * b.x, A.m[0][1] += v.x * b.y, A.m[0][2] += v.x * b.z;
    A.m[1][0] += v.y * b.x, A.m[1][1] += v.y * b.y, A.m[1][2] += v.y * b.z;
    A.m[2][0] += v.z * b.x, A.m[2][1] += v.z * b.y, A.m[2][2] += v.z * b.z;
}

/// sum w/r^2 (r.D r) r r^T
inline SymmetricLanes contract(const FourthMoment& f, const SymmetricLanes& D) {
    const Lanes g[6] = {D.xx, D.yy, D.zz, D.xy + D.xy, D.xz + D.xz, D.yz + D.yz};
    const auto number = [&](int k) {
        Lanes sum = f.of(k, 0) * g[0];
        for (int l = 1; l < 6; ++l) sum += f.of(k, l) * g[l];
        return sum;
    };
    return {number(0), number(1), number(2), number(3), number(4), number(5)};
}

/// P (2 K D + K Lambda tr D), D of the resolved directions: dE/dG of the strain and bulk terms.
/// @param resolved_of resolved_of(m) is P m of each lane; not called where all directions are resolved
template <class Resolved>
Lanes33 stress(const Lanes33& G, const CoefficientLanes& c, bool resolved, const Resolved& resolved_of) {
    const auto of = [&](const SymmetricLanes& D) {
        const Lanes volume = c.bulk * (D.xx + D.yy + D.zz);
        return whole(
            {c.shear * D.xx + volume, c.shear * D.yy + volume, c.shear * D.zz + volume, c.shear * D.xy, c.shear * D.xz, c.shear * D.yz});
    };
    if (resolved) return of(symmetric(G));
    const Lanes33 S = of(symmetric(resolved_of(G)));
    return resolved_of(S);
}

/// Q = (P S - H) M+ - 2 c G, what the row's sums add to dE/dA: S the stress, H = 2 c' sum w/r^2 ((u_j - u_i).r - r.D r) r r^T.
/// @param along sum w/r^2 ((u_j - u_i).r) r r^T
template <class Resolved>
Lanes33 row_force(const Lanes33& G, const SymmetricLanes& along, const CoefficientLanes& c, const SymmetricLanes& inverse_moment,
                  const FourthMoment& fourth, bool resolved, const Resolved& resolved_of) {
    const SymmetricLanes linear = contract(fourth, symmetric(G));
    const Lanes33 H = whole({c.pair * (along.xx - linear.xx), c.pair * (along.yy - linear.yy), c.pair * (along.zz - linear.zz),
                             c.pair * (along.xy - linear.xy), c.pair * (along.xz - linear.xz), c.pair * (along.yz - linear.yz)});
    Lanes33 Q = stress(G, c, resolved, resolved_of);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) Q.m[a][b] -= H.m[a][b];
    Q = Q * inverse_moment;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) Q.m[a][b] -= c.smooth * G.m[a][b];
    return Q;
}

}  // namespace whorl
