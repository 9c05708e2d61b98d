#include <Eigen/Eigenvalues>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/body_motion.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/pressure/projection/projection.h"

namespace whorl {

/// Area vectors A_s = a_s (n_s + c + E q_s), with q_s relative to the centre and a_s the particle's area in a flat layer. c and E are such
/// that a uniform pressure exerts no force, and a pressure linear in position the weight of the displaced fluid:
///   sum A = 0,   sum A q^T = volume * identity.
PressureOnBodies::Surface PressureOnBodies::surface_of(const InteractionContext& context, std::size_t solid, double volume,
                                                       const Vec3d& own_centre, bool& closed) {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    const Real d = step.spacing, of_layer = layer_factor(step.kernel, step.support, d) / d;
    Surface surface{solid, {}, {}};
    std::vector<Eigen::Vector4d> place;
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> wanted = Eigen::Matrix<double, 4, 3>::Zero();
    wanted.bottomRows<3>() = volume * Mat3d::Identity();
    for (Index s = 0; s < boundary.size(); ++s) {
        if (static_cast<std::size_t>(boundary.solid[s]) != solid) continue;
        const Vec3d n = boundary.own_normal[s].cast<double>(),
                    q = (boundary.own_position[s] + d / 2 * boundary.own_normal[s]).cast<double>();
        place.push_back((Eigen::Vector4d() << 1, q - own_centre).finished());
        surface.boundary.push_back(s);
        surface.area.push_back(static_cast<double>(of_layer * boundary.volume[s]) * n);
        moments += surface.area.back().norm() * place.back() * place.back().transpose();
        wanted -= place.back() * surface.area.back().transpose();
    }
    closed = wanted.row(0).norm() < 0.05 * moments(0, 0) && wanted.bottomRows<3>().norm() < 0.3 * volume;
    if (step.dimensions() == 2) moments(3, 3) = 1;
    const Eigen::Matrix<double, 4, 3> slant = moments.ldlt().solve(wanted);
    for (std::size_t s = 0; s < place.size(); ++s) surface.area[s] += surface.area[s].norm() * slant.transpose() * place[s];
    return surface;
}

/// Adds the rows of a body before slant().
void PressureOnBodies::add_rows(const ProjectionSystem& walls, std::size_t solid, const InteractionContext& context,
                                const std::vector<Index>& near, Read<field::role> role, Body& body) {
    const BoundaryParticles& boundary = context.boundary;
    const auto V = static_cast<double>(context.step.volume);
    for (const Index i : near) {
        if (role[i] != 0) continue;
        Row row{i};
        walls.walls_of(i, [&](const WallTouch& touch) {
            if (static_cast<std::size_t>(boundary.solid[touch.s]) != solid) return;
            const Vec3d push = V * static_cast<double>(touch.flux) * boundary.normal[touch.s].cast<double>();
            row.Q.head<3>() += push;
            row.Q.tail<3>() += (boundary.position[touch.s].cast<double>() - body.centre).cross(push);
            row.flux -= V * static_cast<double>(touch.flux);
        });
        if (row.flux > 0) body.rows.push_back(row);
    }
}

/// Moments of the wetted part of the surface.
PressureOnBodies::Moments PressureOnBodies::surface_moments(const Surface& surface, const InteractionContext& context,
                                                            const std::vector<Index>& near, const Body& body) {
    const BoundaryParticles& boundary = context.boundary;
    const Real d = context.step.spacing;
    // A point of the surface counts as wetted if a particle is within this distance. From the nearest particle of a lattice over the
    // surface a point is at most sqrt(1 + 1/4) d away in 2D and sqrt(1 + 2/4) d in 3D. If a single point in the wetted surface were dry, a
    // uniform pressure would move the body.
    const Real reach = Real(0.85) * std::sqrt(static_cast<Real>(context.step.dimensions())) * d;
    std::vector<char> wet(boundary.size(), 0);
    for (const Index i : near)
        context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
            if ((r - d / 2 * boundary.normal[s]).norm() < reach) wet[s] = 1;
        });
    const Solid& solid = context.solids.all[surface.solid];
    const Mat3d R = solid.body ? solid.body->turn.toRotationMatrix() : Mat3d(solid.pose.rotation.cast<double>());
    Moments moments = Moments::Zero();
    for (std::size_t k = 0; k < surface.boundary.size(); ++k) {
        const Index s = surface.boundary[k];
        if (!wet[s]) continue;
        const Vec3d arm = (boundary.position[s] + d / 2 * boundary.normal[s]).cast<double>() - body.centre;
        Wrench6 push;
        push.head<3>() = -(R * surface.area[k]);
        push.tail<3>() = arm.cross(push.head<3>());
        moments += (Eigen::Vector4d() << 1, arm).finished() * push.transpose();
    }
    return moments;
}

/// Q_i += flux_i X^T (1, x_i) such that sum (1, x_i) Q_i^T = `of_surface`, with x relative to the centre.
void PressureOnBodies::slant(const InteractionContext& context, const Moments& of_surface, Body& body) {
    Moments wanted = of_surface;
    const auto terms_of = [&](const Row& row) -> Eigen::Vector4d {
        const Vec3 x = context.step.domain.minimum_image(context.pairs.x_own[row.particle] - body.centre.cast<Real>());
        return (Eigen::Vector4d() << 1, x.cast<double>()).finished();
    };
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    for (const Row& row : body.rows) {
        const Eigen::Vector4d t = terms_of(row);
        moments += row.flux * t * t.transpose();
        wanted -= t * row.Q.transpose();
    }
    // Scaled to a unit diagonal, so that the cutoff of the eigenvalues does not depend on the unit of length.
    Eigen::Vector4d scale = Eigen::Vector4d::Zero();
    for (int m = 0; m < 4; ++m)
        if (moments(m, m) > 0) scale[m] = 1 / std::sqrt(moments(m, m));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> modes(Eigen::Matrix4d(scale.asDiagonal() * moments * scale.asDiagonal()));
    Eigen::Vector4d inverse = Eigen::Vector4d::Zero();
    for (int m = 0; m < 4; ++m)
        if (modes.eigenvalues()[m] > 1e-3) inverse[m] = 1 / modes.eigenvalues()[m];
    const Eigen::Matrix4d in_modes = scale.asDiagonal() * modes.eigenvectors();
    const Moments X = in_modes * inverse.asDiagonal() * in_modes.transpose() * wanted;
    for (Row& row : body.rows) row.Q += row.flux * X.transpose() * terms_of(row);
}

PressureOnBodies::Body PressureOnBodies::rows_of(const ProjectionSystem& walls, const Surface& surface, const InteractionContext& context,
                                                 const std::vector<Index>& near, Read<field::role> role) {
    Body body{context.solids.all[surface.solid].centre(), {}};
    add_rows(walls, surface.solid, context, near, role, body);
    slant(context, surface_moments(surface, context, near, body), body);
    return body;
}

void PressureOnBodies::build(const ProjectionSystem& walls, const InteractionContext& context, Read<field::role> role,
                             Span<const char> unknown) {
    bodies_.clear();
    if (!context.solids.any_free()) return;
    const bool first = surfaces_.empty();
    bool closed = false;
    for (std::size_t k = 0; k < context.solids.all.size() && first; ++k)
        if (const auto& body = context.solids.all[k].body)
            surfaces_.push_back(surface_of(context, k, body->volume, body->own_centre, closed));
    rest_density_ = static_cast<double>(context.step.rest_density);
    const std::vector<Index> near = particles_at_bodies(context);
    for (const Surface& surface : surfaces_) {
        Body body = rows_of(walls, surface, context, near, role);
        std::erase_if(body.rows, [&](const Row& row) { return !unknown[row.particle]; });
        bodies_.push_back(std::move(body));
    }
    contacts_.find(context.solids, context.boundary, contact_step(context.step, 2 * static_cast<double>(context.step.spacing)));
}

PressureOnBodies::Wrench6 PressureOnBodies::sum(const Body& body, Span<const Real> p) {
    return parallel_sum(static_cast<Index>(body.rows.size()), Wrench6(Wrench6::Zero()), [&](Index e) -> Wrench6 {
        const Row& row = body.rows[e];
        return static_cast<double>(p[row.particle]) * row.Q;
    });
}

BodyVector PressureOnBodies::impulses(Span<const Real> p) const {
    BodyVector all(static_cast<Eigen::Index>(6 * bodies_.size()));
    for (std::size_t b = 0; b < bodies_.size(); ++b) all.segment<6>(static_cast<Eigen::Index>(6 * b)) = sum(bodies_[b], p);
    return all;
}

void PressureOnBodies::add_product(Span<const Real> p, Span<Real> Ap) const {
    if (bodies_.empty()) return;
    const BodyVector change = contacts_.change(rest_density_ * impulses(p));
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
        const Wrench6 twist = change.segment<6>(static_cast<Eigen::Index>(6 * b));
        parallel_for(static_cast<Index>(bodies_[b].rows.size()), [&](Index e) {
            const Row& row = bodies_[b].rows[e];
            Ap[row.particle] += static_cast<Real>(row.Q.dot(twist));
        });
    }
}

void PressureOnBodies::push(Span<const Real> p, double dt, const InteractionContext& context) {
    if (bodies_.empty()) return;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
        const Wrench6 pressed = dt * sum(bodies_[b], p);
        context.solids.all[surfaces_[b].solid].receive(Push::pressure, {pressed.head<3>(), pressed.tail<3>()});
    }
    contacts_.resolve(context.solids);
    contacts_.hold();
    context.solids.place_bodies();
    context.boundary.follow(context.solids);
}

std::vector<std::size_t> PressureOnBodies::write_closed(const ProjectionSystem& walls, const InteractionContext& context,
                                                        Read<field::role> role, Span<const Real> p) {
    if (!closed_) {
        closed_.emplace();
        for (std::size_t k = 0; k < context.solids.all.size(); ++k) {
            const Solid& solid = context.solids.all[k];
            if (solid.body || solid.inside || !solid.probed || !solid.shape->bounded()) continue;
            const MassProperties bulk = solid.shape->bulk();
            bool closed = false;
            const Surface surface = surface_of(context, k, bulk.volume, bulk.centre, closed);
            if (closed) closed_->push_back(surface);
        }
    }
    std::vector<std::size_t> solids;
    for (const Surface& surface : *closed_) {
        solids.push_back(surface.solid);
        const Body body = rows_of(walls, surface, context, particles_at(context, surface.solid), role);
        const Wrench6 pressed = static_cast<double>(context.step.dt) * sum(body, p);
        Solid& solid = context.solids.all[surface.solid];
        solid.receive(Push::pressure, Wrench{pressed.head<3>(), pressed.tail<3>()} + -1 * solid.ledger[Push::pressure]);
    }
    return solids;
}

void ProjectionBodyDrift::operator()(const InteractionContext& context) const {
    system->body_start.clear();
    for (Solid& solid : context.solids.all) {
        if (!solid.body) continue;
        system->body_start.push_back({solid.body->velocity, solid.body->angular_velocity()});
        solid.body->move(static_cast<double>(context.step.dt));
    }
}

void ProjectionBodyMove::operator()(const InteractionContext& context) const {
    const StepContext& step = context.step;
    const auto dt = static_cast<double>(step.dt);
    auto start = system->body_start.begin();
    for (Solid& solid : context.solids.all) {
        if (!solid.body) continue;
        RigidBody& body = *solid.body;
        body.centre += dt / 2 * (body.velocity - start->velocity);
        body.turn = (Eigen::Quaterniond(turn_by(dt / 2 * (body.angular_velocity() - start->turning))) * body.turn).normalized();
        ++start;
    }
    context.solids.place_bodies();
    context.boundary.follow(context.solids);
}

}  // namespace whorl
