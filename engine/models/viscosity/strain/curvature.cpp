#include "engine/models/viscosity/strain/curvature.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/strain/moment.h"

namespace whorl {

Mat3 curvature_strain(const Mat3& G, Real dt) {
    const Real moved = dt * G.norm(), counted = std::min(moved, Real(0.4));
    if (!(moved > 0)) return Mat3::Zero();
    const Mat3 C = counted / moved * dt * G, B = C * (Mat3::Identity() - C).inverse();
    const Mat3 bent = B * B * (2 * Mat3::Identity() + B).inverse();
    const Mat3 T = (bent + bent.transpose()) / 2;
    return std::min(Real(1), Real(0.2) * counted / std::max(T.norm(), std::numeric_limits<Real>::min())) / dt * T;
}

Mat3 turned_rigidly(const Mat3& G, const Mat3& P) { return G - P * G.transpose() * (Mat3::Identity() - P); }

void VelocityGradient::operator()(const InteractionContext& context, Read<field::role> role, Read<field::velocity> u,
                                  Write<field::velocity_gradient> G) const {
    const StepContext& step = context.step;
    const BoundaryParticles& boundary = context.boundary;
    const std::vector<char> slip = slips(context.solids);
    const WallShear shear{step.spacing / 2};
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(u.size(), [&](Index i) {
            G[i].setZero();
            if (role[i] != 0) return;
            Real M[3][3] = {}, A[3][3] = {};
            context.pairs.groups_of(i, [&](const Pairs::Group& group) {
                alignas(64) Real v[3][Pairs::Group::most], w[Pairs::Group::most];
                group.gather(u.values.data(), v);
                for (Index l = 0; l < group.padded(); ++l) w[l] = -step.volume * kernel.slope(group.distance[l]);
                for (int b = 0; b < 3; ++b)
                    for (int a = 0; a < 3; ++a) {
                        Real moment = 0, difference = 0;
                        for (Index l = 0; l < group.padded(); ++l) {
                            const Real weighted = w[l] * group.r[b][l];
                            difference += (u[i][a] - v[a][l]) * weighted;
                            moment += group.r[a][l] * weighted;
                        }
                        A[a][b] += difference;
                        M[a][b] += moment;
                    }
            });
            Mat3 differences;
            Mat3d moments;
            differences << A[0][0], A[0][1], A[0][2], A[1][0], A[1][1], A[1][2], A[2][0], A[2][1], A[2][2];
            moments << M[0][0], M[0][1], M[0][2], M[0][1], M[1][1], M[1][2], M[0][2], M[1][2], M[2][2];
            if (boundary.size() > 0) {
                const Real factor = solid_factor * gate.weight(kernel, i, context.solid_pairs, boundary.volume, solid_factor);
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    const auto whose = static_cast<std::size_t>(boundary.solid[s]);
                    const Real w = -factor * boundary.volume[s] * kernel.slope(distance);
                    if (slip[whose] || !(w > 0)) return;
                    const Pose& pose = context.solids.all[whose].pose;
                    const Vec3 wall = pose.velocity_over(-step.dt, boundary.position[s] + r),
                               there = pose.velocity_over(-step.dt, boundary.position[s]);
                    differences += (shear.stretch(r, boundary.normal[s]) * (u[i] - wall) + (wall - there)) * (w * r).transpose();
                    moments += (w * r * r.transpose()).template cast<double>();
                });
            }
            const Moment moment = invert_moment(moments, kernel.dimensions);
            G[i] = differences * moment.inverse.cast<Real>();
            if (!moment.whole) G[i] = turned_rigidly(G[i], moment.resolved.cast<Real>());
        });
    });
}

}  // namespace whorl
