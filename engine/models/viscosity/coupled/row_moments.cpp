// Sums over finished rows: moments, their inverse, the surface indicator.
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/math/inverse_in.h"
#include "engine/models/viscosity/coupled/row_builder.h"
#include "engine/models/viscosity/strain/moment.h"

namespace whorl {
namespace {

/// Properties of M = sum w r r^T that follow from the eigenvalues of M.
struct MomentShape {
    Mat3 inverse_moment = Mat3::Zero();
    Directions directions;
    bool volume = false;  ///< all directions are resolved, and no thread is thin
};

MomentShape shape_of(const Mat3& M, const CoupledOptions& o, int dimensions, Neighbourhood& n) {
    MomentShape shape;
    const Mat3d wide = M.cast<double>();
    Eigen::SelfAdjointEigenSolver<Mat3d> axes;
    axes.computeDirect(wide, Eigen::EigenvaluesOnly);
    const Vec3d s = axes.eigenvalues();
    if (!(s[2] > 0)) return shape;
    if (dimensions == 3) n.thin = static_cast<Real>(smooth_step((o.thin_below - s[1] / s[2]) / (o.thin_below - o.thin_at)));
    const bool whole = dimensions == 3 ? resolves_all(s) : s[1] >= resolved_above * s[2];
    if (whole) shape.inverse_moment = inverse_in(dimensions, wide).cast<Real>();
    shape.volume = whole && n.thin == 0;
    if (shape.volume) return shape;
    axes.computeDirect(wide);
    if (n.thin > 0) shape.directions.along = axes.eigenvectors().col(2).cast<Real>();
    if (whole) return shape;
    const Moment moment = invert_moment(axes.eigenvalues(), axes.eigenvectors(), dimensions);
    shape.inverse_moment = moment.inverse.cast<Real>();
    shape.directions.resolved = moment.resolved.cast<Real>();
    n.unresolved = static_cast<Real>(moment.unresolved);
    return shape;
}

/// Adds the walls' parts along the walls to M. Walls resolve directions, but do not change whether the fluid is a thin thread. @param M sum
/// over all pairs of the row, also with walls
void add_walls(const RowBlock& block, Index row, Mat3 M, const CoupledOptions& o, int dimensions, Neighbourhood& n, MomentShape& shape) {
    bool any = false;
    for (const WallPoint& wall : block.walls)
        if (wall.row == row) any = true, M += wall.lateral;
    if (!any) return;
    const Vec3 along = shape.directions.along;
    const Real thin = n.thin;
    n.unresolved = 0;
    shape = shape_of(M, o, dimensions, n);
    shape.directions.along = along;
    n.thin = thin;
    shape.volume = n.unresolved == 0 && thin == 0;
}

}  // namespace

/// Computes sums over the finished rows: M, its inverse, the surface indicator, and the fourth moment.
void CoupledRows::find_moments(RowBlock& block, const CoupledOptions& o) {
    const Vec4* at = positions(block);
    block.directions.clear();
    for (RowSlice& slice : block.slices) {
        SymmetricLanes M{};
        Lanes3 centre{};
        Lanes distances{}, weights{};
        FourthMoment& fourth = slice.fourth;
        for (Lanes& v : fourth.v) v = Lanes{};
        const auto add = [&](const PairLanes& p) {
            const Lanes x = p.r.x, y = p.r.y, z = p.r.z, w = p.w;
            const Lanes xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z;
            M.xx += w * xx, M.yy += w * yy, M.zz += w * zz, M.xy += w * xy, M.xz += w * xz, M.yz += w * yz;
            const Lanes wi = w / p.r2;
            const Lanes wxx = wi * xx, wyy = wi * yy, wzz = wi * zz;
            Lanes* f = fourth.v;
            f[0] += wxx * xx, f[1] += wxx * xy, f[2] += wxx * xz, f[3] += wxx * yy, f[4] += wxx * yz, f[5] += wxx * zz;
            f[6] += wyy * xy, f[7] += wyy * xz, f[8] += wzz * xy, f[9] += wzz * xz;
            f[10] += wyy * yy, f[11] += wyy * yz, f[12] += wyy * zz, f[13] += wzz * yz, f[14] += wzz * zz;
        };
        pairs_of(block, slice, at).each_plain([&](std::size_t, const PairLanes& p) {
            add(p);
            weights += p.w;
            centre = centre + p.w * p.r;
            distances += p.w * square_root(p.r2);
        });
        const SymmetricLanes without_walls = M;
        pairs_of(block, slice, at).each_wall([&](std::size_t, const PairLanes& p) { add(p); });
        slice.inverse_moment = SymmetricLanes();
        for (Index lane = 0; lane < slice.rows; ++lane) {
            const Index row = slice.row[lane];
            Neighbourhood& n = neighbourhood[block.begin + row];
            Vec3 middle(centre.x[lane], centre.y[lane], centre.z[lane]);
            if (slice.walls > 0)  // as if the mirror image of the fluid continued behind the wall
                for (const WallPoint& wall : block.walls)
                    if (wall.row == row) middle -= wall.normal * wall.normal.dot(middle);
            n.weights = weights[lane];
            n.spread = M.xx[lane] + M.yy[lane] + M.zz[lane];
            if (distances[lane] > 0) n.surface = middle.norm() / distances[lane];
            if (n.surface > 0) n.outward = -middle.normalized();
            if (n.spread > 0) {
                MomentShape shape = shape_of(lane_of(without_walls, lane), o, dimensions_, n);
                if (slice.walls > 0) add_walls(block, row, lane_of(M, lane), o, dimensions_, n, shape);
                set_lane(slice.inverse_moment, lane, shape.inverse_moment);
                if (!shape.volume) {
                    n.directions = static_cast<std::int32_t>(block.directions.size());
                    block.directions.push_back(shape.directions);
                }
            }
            slice.resolved = slice.resolved && n.unresolved == 0;
        }
    }
}

}  // namespace whorl
