#include "engine/io/snapshot.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/geometry/mesh_file.h"
#include "engine/io/columns.h"
#include "engine/particles/search.h"

namespace whorl {
namespace {

/// Mesh in the solid's own axes. For a fixed solid it contains all periodic images that reach into the domain.
TriangleMesh drawn_mesh(const Solid& solid, const Domain& domain, Real spacing, Real extent) {
    const TriangleMesh one = solid.shape->mesh(spacing, extent);
    if (solid.moves() || !solid.repeats.any()) return one;
    TriangleMesh all;
    for (const Vec3& shift : solid.repeats.shifts_into(domain)) {
        TriangleMesh image = one;
        const Vec3f own = (solid.pose.rotation.transpose() * shift).cast<float>();
        for (Vec3f& x : image.position) x += own;
        append(all, image);
    }
    return all;
}

/// Translation of the drawn mesh. A moving solid is drawn once, at the image whose middle is in the domain.
Vec3 drawn_translation(const Solid& solid, const Domain& domain) {
    if (!solid.moves() || !solid.repeats.any()) return solid.pose.translation;
    return solid.pose.translation + solid.repeats.shifts_into(domain).front();
}

bool contains(const std::vector<std::string>& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

void add_ink_markers(const World& world, Frame& frame) {
    const InkMarkers& markers = world.ink_markers;
    if (markers.per_spacing == 0) return;
    FrameMarkers& of = frame.ink_markers;
    of.spacing = static_cast<float>(world.step.spacing) / static_cast<float>(markers.per_spacing);
    for (const Vec3& x : markers.store.column<field::position>()) of.position.push_back(x.cast<float>());
    for (const Vec3& c : markers.store.column<field::ink>()) of.ink.push_back(c.cast<float>());
}

FrameEmitter drawn_opening(const Emitter& emitter) {
    const EmitterShape& opening = emitter.shape();
    EmitterShape start = opening;
    start.direction = emitter.pose().rotation.transpose() * opening.direction;
    Vec3 width, thickness;
    opening_axes(start, width, thickness);
    width = emitter.pose().rotation * width;
    const bool disc = !opening.slot && !opening.plane;
    const Real wide = disc ? 2 * opening.radius : opening.width, thick = disc ? wide : opening.thickness;
    return {opening.centre.cast<float>(), opening.direction.cast<float>(), width.cast<float>(),
            static_cast<float>(wide),     static_cast<float>(thick),       opening.slot};
}

/// Removes the fluid in nozzles that are not shown.
void hide_pipes(const Simulation& simulation, Frame& frame) {
    const auto& emitters = simulation.scene().emitters;
    if (std::all_of(emitters.begin(), emitters.end(), [](const EmitterKeys& e) { return e.appearance.show; })) return;
    const auto role = simulation.world().fluid.column<field::role>();
    const auto keep = [&](auto& values) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < values.size(); ++i)
            if (role[i] >= 0 || emitters[static_cast<std::size_t>(-role[i]) - 1].appearance.show) values[kept++] = values[i];
        values.resize(kept);
    };
    keep(frame.position), keep(frame.velocity);
    for (auto& [name, values] : frame.scalar) keep(values);
    for (auto& [name, values] : frame.vector) keep(values);
    for (auto& [name, values] : frame.whole) keep(values);
}

}  // namespace

Snapshots::Snapshots(const Simulation& simulation, std::vector<std::string> fields) : fields_(std::move(fields)) {
    const World& world = simulation.world();
    const Real spacing = world.step.spacing, extent = 2 * world.step.domain.size().maxCoeff();
    for (const Solid& solid : world.solids.all) {
        FrameSolid drawn;
        drawn.mesh = std::make_shared<TriangleMesh>(drawn_mesh(solid, world.step.domain, spacing, extent));
        drawn.container = solid.inside;
        drawn.ground = !solid.shape->bounded();
        solids_.push_back(std::move(drawn));
    }
    for (const Emitter& emitter : simulation.emitters()) {
        FrameSolid nozzle;
        // The nozzle is long compared with its bore, so that it looks like a pipe rather than a ring.
        const EmitterShape& opening = emitter.shape();
        const Real bore = opening.slot ? opening.thickness : 2 * opening.radius;
        nozzle.mesh = std::make_shared<TriangleMesh>(nozzle_mesh(opening, spacing, std::max(4 * spacing, 4 * bore)));
        solids_.push_back(std::move(nozzle));
    }
}

void Snapshots::share_meshes(const Snapshots& earlier) {
    for (std::size_t k = 0; k < std::min(solids_.size(), earlier.solids_.size()); ++k) {
        const std::shared_ptr<const TriangleMesh> before = earlier.solids_[k].mesh, now = solids_[k].mesh;
        if (before->position == now->position && before->triangle == now->triangle) solids_[k].mesh = before;
    }
}

Frame Snapshots::take(const Simulation& simulation, int number) const {
    const World& world = simulation.world();
    Frame frame = particles_of(world, fields_);
    add_derived_fields(world, fields_, frame);
    if (contains(fields_, "ink")) add_ink_markers(world, frame);
    frame.number = number;
    frame.time = simulation.time();
    frame.solids = solids_;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        frame.solids[k].rotation = world.solids.all[k].pose.rotation.cast<float>();
        frame.solids[k].translation = drawn_translation(world.solids.all[k], world.step.domain).cast<float>();
        frame.solids[k].velocity = world.solids.all[k].pose.velocity.cast<float>();
        frame.solids[k].spin = world.solids.all[k].pose.angular_velocity.cast<float>();
    }
    std::size_t k = world.solids.all.size();
    const auto look_like = [](FrameSolid& drawn, const Appearance& appearance) {
        drawn.appearance = appearance;
        if (!appearance.show) drawn.mesh.reset();
    };
    for (std::size_t s = 0; s < k; ++s) look_like(frame.solids[s], simulation.scene().solids[s].appearance);
    for (std::size_t e = 0; e < simulation.emitters().size(); ++e)
        look_like(frame.solids[k + e], simulation.scene().emitters[e].appearance);
    for (const Emitter& emitter : simulation.emitters()) {
        frame.emitters.push_back(drawn_opening(emitter));
        const Pose& pose = emitter.pose();
        FrameSolid& nozzle = frame.solids[k++];
        nozzle.rotation = pose.rotation.cast<float>(), nozzle.translation = pose.translation.cast<float>();
        nozzle.velocity = pose.velocity.cast<float>(), nozzle.spin = pose.angular_velocity.cast<float>();
    }
    hide_pipes(simulation, frame);
    return frame;
}

Frame particles_of(const World& world, const std::vector<std::string>& fields) {
    Frame frame;
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const std::size_t n = x.size();
    frame.spacing = static_cast<float>(world.step.spacing);
    frame.domain_min = world.step.domain.min.cast<float>();
    frame.domain_max = world.step.domain.max.cast<float>();
    frame.periodic = world.step.domain.periodic;
    frame.dimensions = world.step.dimensions();
    frame.position.resize(n);
    frame.velocity.resize(n);
    parallel_for(world.fluid.size(), [&](Index i) {
        frame.position[i] = x[i].cast<float>();
        frame.velocity[i] = u[i].cast<float>();
    });
    for (const NumberColumn& column : columns_named(world.fluid, fields)) {
        if (column.name == "position" || column.name == "velocity") continue;
        if (column.components == 3) {
            std::vector<Vec3f>& values = frame.vector[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) {
                for (int c = 0; c < 3; ++c) values[i][c] = static_cast<float>(column.value(i, c));
            });
        } else if (column.components == 1 && column.integer) {
            std::vector<std::int32_t>& values = frame.whole[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<std::int32_t>(column.value(i)); });
        } else if (column.components == 1) {
            std::vector<float>& values = frame.scalar[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<float>(column.value(i)); });
        }
    }
    return frame;
}

namespace {

/// A closed loop in the plane of an opening.
using Loop = std::vector<Vec3f>;

/// Adds the band between two loops with equal numbers of points. Seen from the front and looking along the loops, `to` is to the left of
/// `from`. @param round_normals normals at the points of the loops; null: those of flat faces
void add_band(TriangleMesh& mesh, const Loop& from, const Loop& to, const Loop* round_normals) {
    const std::size_t n = from.size();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        for (const Vec3f& p : {from[k], from[next], to[next], to[k]}) mesh.position.push_back(p);
        const Vec3f flat = (from[next] - from[k]).cross(to[k] - from[k]).normalized();
        for (const std::size_t v : {k, next, next, k}) mesh.normal.push_back(round_normals ? (*round_normals)[v] : flat);
        mesh.triangle.push_back({first, first + 1, first + 2});
        mesh.triangle.push_back({first, first + 2, first + 3});
    }
}

Loop shifted(Loop loop, const Vec3f& by) {
    for (Vec3f& p : loop) p += by;
    return loop;
}

Loop negative(Loop loop) {
    for (Vec3f& p : loop) p = -p;
    return loop;
}

}  // namespace

TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length) {
    const Vec3f back = -opening.direction.cast<float>(), centre = opening.centre.cast<float>();
    const float gap = 0.5f * static_cast<float>(spacing), wall = 0.75f * static_cast<float>(spacing);
    Vec3 across = Vec3::Zero(), along = Vec3::Zero();
    opening_axes(opening, across, along);
    const Vec3f a = across.cast<float>(), b = along.cast<float>();  // a x b points backwards, against the flow

    Loop inner, outer, normals;
    if (opening.slot) {
        const float w = static_cast<float>(opening.width) / 2, t = static_cast<float>(opening.thickness) / 2;
        for (const auto& [s, q] : {std::pair{1.f, 1.f}, {-1.f, 1.f}, {-1.f, -1.f}, {1.f, -1.f}}) {
            inner.push_back(centre + s * (w + gap) * a + q * (t + gap) * b);
            outer.push_back(centre + s * (w + gap + wall) * a + q * (t + gap + wall) * b);
        }
    } else {
        constexpr int segments = 64;
        for (int k = 0; k < segments; ++k) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / segments;
            normals.push_back(std::cos(angle) * a + std::sin(angle) * b);
            inner.push_back(centre + (static_cast<float>(opening.radius) + gap) * normals.back());
            outer.push_back(centre + (static_cast<float>(opening.radius) + gap + wall) * normals.back());
        }
    }
    const Vec3f rise = static_cast<float>(length) * back;
    const Loop inward = negative(normals);
    TriangleMesh mesh;
    add_band(mesh, outer, shifted(outer, rise), opening.slot ? nullptr : &normals);
    add_band(mesh, shifted(inner, rise), inner, opening.slot ? nullptr : &inward);
    add_band(mesh, inner, outer, nullptr);
    add_band(mesh, shifted(outer, rise), shifted(inner, rise), nullptr);
    return mesh;
}

Column<Mat3> velocity_gradients(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain) {
    Pairs pairs;
    NeighbourSearch().find(x, support, domain, pairs);
    Column<Mat3> gradient(x.size());
    parallel_for(pairs.size(), [&](Index i) {
        // G minimises sum w |u_i - u_j - G r_ij|^2, so G = (sum w (u_i - u_j) r^T) (sum w r r^T)^-1.
        Mat3 moments = Mat3::Zero(), change = Mat3::Zero();
        pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real near = 1 - distance / support, w = near * near;
            moments += w * r * r.transpose();
            change += w * (u[i] - u[j]) * r.transpose();
        });
        const Real size = moments.trace();
        gradient[i] = Mat3::Zero();
        if (!(size > 0)) return;
        moments.diagonal().array() += Real(1e-4) * size;  // neighbours on a line or in a plane do not determine the other directions
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
