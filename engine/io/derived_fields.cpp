#include "engine/io/derived_fields.h"

#include <Eigen/LU>
#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/particles/search.h"

namespace whorl {
namespace {

bool contains(const std::vector<std::string>& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Column<Mat3> velocity_gradients(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain) {
    Pairs pairs;
    NeighbourSearch().find(x, support, domain, pairs);
    Column<Mat3> gradient(x.size());
    parallel_for(pairs.size(), [&](Index i) {
        // G minimises sum w |u_i - u_j - G r_ij|^2: G = (sum w (u_i - u_j) r^T) (sum w r r^T)^-1.
        Mat3 moments = Mat3::Zero(), change = Mat3::Zero();
        pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real near = 1 - distance / support, w = near * near;
            moments += w * r * r.transpose();
            change += w * (u[i] - u[j]) * r.transpose();
        });
        const Real size = moments.trace();
        gradient[i] = Mat3::Zero();
        if (!(size > 0)) return;
        moments.diagonal().array() += Real(1e-4) * size;  // neighbours in a line or a sheet say nothing about the other directions
        gradient[i] = change * moments.inverse();
    });
    return gradient;
}

Vec3 curl_of(const Mat3& G) { return Vec3(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1)); }

Column<Vec3> vorticity(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain) {
    const Column<Mat3> G = velocity_gradients(x, u, support, domain);
    Column<Vec3> curl(x.size());
    parallel_for(static_cast<Index>(x.size()), [&](Index i) { curl[i] = curl_of(G[i]); });
    return curl;
}

Real q_criterion(const Mat3& G) {
    const Mat3 strain = (G + G.transpose()) / 2, turning = (G - G.transpose()) / 2;
    return (turning.squaredNorm() - strain.squaredNorm()) / 2;
}

void add_derived_fields(const World& world, const std::vector<std::string>& fields, Frame& frame) {
    const bool difference = contains(fields, "spin_difference") && world.fluid.find("spin") != nullptr;
    const bool q = contains(fields, "q_criterion");
    if (!difference && !q && !contains(fields, "vorticity")) return;
    const auto x = world.fluid.column<field::position>();
    const Column<Mat3> G = velocity_gradients(x, world.fluid.column<field::velocity>(), world.step.support, world.step.domain);
    const auto put = [&](const char* name, auto&& value) {
        std::vector<Vec3f>& values = frame.vector[name];
        values.resize(x.size());
        parallel_for(world.fluid.size(), [&](Index i) { values[i] = value(i).template cast<float>(); });
    };
    if (q) {
        std::vector<float>& values = frame.scalar["q_criterion"];
        values.resize(x.size());
        parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<float>(q_criterion(G[i])); });
    }
    if (contains(fields, "vorticity")) put("vorticity", [&](Index i) { return curl_of(G[i]); });
    if (!difference) return;
    const auto spin = world.fluid.column<field::spin>();
    put("spin_difference", [&](Index i) -> Vec3 { return spin[i] - curl_of(G[i]) / 2; });
}

}  // namespace whorl
