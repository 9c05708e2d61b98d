#include "engine/models/projection/projection_bodies.h"

#include <Eigen/Eigenvalues>

#include "engine/core/parallel.h"
#include "engine/geometry/body_contact.h"
#include "engine/math/local_fit.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {

/// A_s = a_s (n_s + c + E q_s), q_s from the centre, a_s the particle's share of a flat layer; c and E are such that a uniform pressure
/// makes no force and a linear one the weight of the fluid that the body takes the place of:  sum A = 0,  sum A q^T = volume 1.
void PressureOnBodies::find_surfaces(const Surroundings& around) {
    const SolidParticles& layer = around.layer;
    const StepContext& step = around.step;
    const Real d = step.spacing, of_layer = layer_factor(step.kernel, step.support, d) / d;
    place_of_.assign(layer.size(), 0);
    for (std::size_t k = 0; k < around.solids.all.size(); ++k) {
        if (!around.solids.all[k].body) continue;
        const RigidBody& body = *around.solids.all[k].body;
        Surface surface{k, {}, {}};
        std::vector<Eigen::Vector4d> place;
        Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
        Eigen::Matrix<double, 4, 3> wanted = Eigen::Matrix<double, 4, 3>::Zero();
        wanted.bottomRows<3>() = body.volume * Mat3d::Identity();
        for (Index s = 0; s < layer.size(); ++s) {
            if (static_cast<std::size_t>(layer.solid[s]) != k) continue;
            place_of_[s] = static_cast<Index>(surface.layer.size());
            const Vec3d n = layer.own_normal[s].cast<double>(), q = (layer.own_position[s] + d / 2 * layer.own_normal[s]).cast<double>();
            place.push_back((Eigen::Vector4d() << 1, q - body.own_centre).finished());
            surface.layer.push_back(s);
            surface.area.push_back(static_cast<double>(of_layer * layer.volume[s]) * n);
            moments += surface.area.back().norm() * place.back() * place.back().transpose();
            wanted -= place.back() * surface.area.back().transpose();
        }
        if (step.dimensions() == 2) moments(3, 3) = 1;
        const Eigen::Matrix<double, 4, 3> slant = moments.ldlt().solve(wanted);
        for (std::size_t s = 0; s < place.size(); ++s) surface.area[s] += surface.area[s].norm() * slant.transpose() * place[s];
        surfaces_.push_back(std::move(surface));
    }
}

PressureOnBodies::Row& PressureOnBodies::row_of(Body& body, Index particle) {
    Index& row = row_of_[particle];
    if (row < 0) row = static_cast<Index>(body.rows.size()), body.rows.push_back(Row{particle});
    return body.rows[row];
}

/// K: the surface's pressures by least squares. Where no fluid touches the surface there is none.
void PressureOnBodies::add_surface(const Surface& surface, const Surroundings& around, Read<field::role> role, Body& body) {
    struct Near {
        std::vector<Index> particle;
        std::vector<Vec3d> place;  ///< over the reach
        std::vector<double> weight;
    };
    const SolidParticles& layer = around.layer;
    const Real d = around.step.spacing, reach = around.step.support - d / 2, wet = Real(1.2) * d;
    std::vector<Near> near(surface.layer.size());
    for (const Index i : near_) {
        if (role[i] != 0) continue;
        around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
            if (static_cast<std::size_t>(layer.solid[s]) != surface.solid) return;
            const Vec3 to = r - d / 2 * layer.normal[s];
            if (!(to.norm() < reach)) return;
            near[place_of_[s]].particle.push_back(i);
            near[place_of_[s]].place.push_back((to / reach).cast<double>());
        });
    }
    parallel_for(static_cast<Index>(near.size()), [&](Index s) {
        bool touched = false;
        for (const Vec3d& place : near[s].place) touched = touched || place.norm() * static_cast<double>(reach) < static_cast<double>(wet);
        if (touched) near[s].weight = fitted_at_origin(near[s].place);
    });
    const Mat3d R = around.solids.all[surface.solid].body->turn.toRotationMatrix();
    for (std::size_t s = 0; s < near.size(); ++s) {
        const Index q = surface.layer[s];
        Wrench6 push;
        push.head<3>() = -(R * surface.area[s]);
        push.tail<3>() = ((layer.position[q] + d / 2 * layer.normal[q]).cast<double>() - body.centre).cross(push.head<3>());
        for (std::size_t k = 0; k < near[s].weight.size(); ++k) row_of(body, near[s].particle[k]).K += near[s].weight[k] * push;
    }
}

/// Q before its slant.
void PressureOnBodies::add_flux(const ProjectionSystem& walls, std::size_t solid, const Surroundings& around, Read<field::role> role,
                                Body& body) {
    const SolidParticles& layer = around.layer;
    const auto V = static_cast<double>(around.step.volume);
    for (const Index i : near_) {
        if (role[i] != 0) continue;
        walls.walls_of(i, [&](const WallTouch& touch) {
            if (static_cast<std::size_t>(layer.solid[touch.s]) != solid || touch.flux == 0) return;
            const Vec3d push = V * static_cast<double>(touch.flux) * layer.normal[touch.s].cast<double>();
            Row& row = row_of(body, i);
            row.Q.head<3>() += push;
            row.Q.tail<3>() += (layer.position[touch.s].cast<double>() - body.centre).cross(push);
            row.flux -= V * static_cast<double>(touch.flux);
        });
    }
}

/// Q_i += flux_i X^T t_i such that sum Q_i t_i = sum K_i t_i with t = (1, x, x (r^-D - 1)), r = |x| over its mean square root: fields that are
/// uniform, that grow outwards as weight's, and that fall off as those of a dipole do.
void PressureOnBodies::slant(const Surroundings& around, Body& body) {
    using Terms = Eigen::Matrix<double, 7, 1>;
    const auto from_centre = [&](const Row& row) -> Vec3d {
        return around.step.domain.minimum_image(around.pairs.x_own[row.particle] - body.centre.cast<Real>()).cast<double>();
    };
    double weight = 0, squares = 0;
    for (const Row& row : body.rows) weight += row.flux, squares += row.flux * from_centre(row).squaredNorm();
    if (!(squares > 0)) return;
    const double size = std::sqrt(squares / weight);
    const auto terms_of = [&](const Row& row) -> Terms {
        const Vec3d x = from_centre(row) / size;
        const double falls = std::pow(std::max(x.norm(), 0.1), -around.step.dimensions()) - 1;
        return (Terms() << 1, x, falls * x).finished();
    };
    Eigen::Matrix<double, 7, 7> moments = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 6> wanted = Eigen::Matrix<double, 7, 6>::Zero();
    for (const Row& row : body.rows) {
        const Terms t = terms_of(row);
        moments += row.flux * t * t.transpose();
        wanted += t * (row.K - row.Q).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 7, 7>> modes(moments);
    Terms inverse = Terms::Zero();
    for (int m = 0; m < 7; ++m)
        if (modes.eigenvalues()[m] > 1e-6 * modes.eigenvalues()[6]) inverse[m] = 1 / modes.eigenvalues()[m];
    const Eigen::Matrix<double, 7, 6> X = modes.eigenvectors() * inverse.asDiagonal() * modes.eigenvectors().transpose() * wanted;
    for (Row& row : body.rows) row.Q += row.flux * X.transpose() * terms_of(row);
}

void PressureOnBodies::build(const ProjectionSystem& walls, const Surroundings& around, Read<field::role> role, Span<const char> unknown) {
    bodies_.clear();
    if (!around.solids.any_free()) return;
    if (surfaces_.empty()) find_surfaces(around);
    rest_density_ = static_cast<double>(around.step.rest_density);
    row_of_.assign(unknown.size(), -1);
    near_ = particles_at_bodies(around);
    for (const Surface& surface : surfaces_) {
        const RigidBody& state = *around.solids.all[surface.solid].body;
        Body body{state.mass, state.inverse_inertia(), state.centre, {}};
        add_surface(surface, around, role, body);
        add_flux(walls, surface.solid, around, role, body);
        slant(around, body);
        for (const Row& row : body.rows) row_of_[row.particle] = -1;
        std::erase_if(body.rows, [&](const Row& row) { return !unknown[row.particle]; });
        bodies_.push_back(std::move(body));
    }
}

PressureOnBodies::Wrench6 PressureOnBodies::sum(const Body& body, Wrench6 Row::*weight, Span<const Real> p) {
    return parallel_sum(static_cast<Index>(body.rows.size()), Wrench6(Wrench6::Zero()), [&](Index e) -> Wrench6 {
        const Row& row = body.rows[e];
        return static_cast<double>(p[row.particle]) * row.*weight;
    });
}

void PressureOnBodies::add_product(Span<const Real> p, Span<Real> Ap) const {
    for (const Body& body : bodies_) {
        Wrench6 twist = rest_density_ * sum(body, &Row::Q, p);
        twist.head<3>() /= body.mass;
        twist.tail<3>() = body.inverse_inertia * Vec3d(twist.tail<3>());
        parallel_for(static_cast<Index>(body.rows.size()), [&](Index e) {
            const Row& row = body.rows[e];
            Ap[row.particle] += static_cast<Real>(row.Q.dot(twist));
        });
    }
}

double PressureOnBodies::push(Span<const Real> p, double dt, const Surroundings& around) const {
    if (bodies_.empty()) return 0;
    double largest = 0;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
        const Wrench6 pressed = sum(bodies_[b], std::getenv("WHORL_K") ? &Row::K : &Row::Q, p);
        RigidBody& state = *around.solids.all[surfaces_[b].solid].body;
        state.velocity += dt / state.mass * pressed.head<3>();
        state.spin_momentum += dt * pressed.tail<3>();
        largest = std::max(largest, dt / state.mass * pressed.head<3>().norm());
    }
    around.solids.place_bodies();
    around.layer.follow(around.solids);
    return largest;
}

void ProjectionBodyDrift::operator()(const Surroundings& around) const {
    system->body_start.clear();
    for (Solid& solid : around.solids.all) {
        if (!solid.body) continue;
        system->body_start.push_back({solid.body->velocity, solid.body->angular_velocity()});
        solid.body->move(static_cast<double>(around.step.dt));
    }
}

void ProjectionBodyMove::operator()(const Surroundings& around) const {
    const StepContext& step = around.step;
    const auto dt = static_cast<double>(step.dt);
    resolve_contacts(around.solids, around.layer, {dt, static_cast<double>(step.spacing), step.domain},
                     static_cast<double>(step.gravity.norm()));
    auto start = system->body_start.begin();
    for (Solid& solid : around.solids.all) {
        if (!solid.body) continue;
        RigidBody& body = *solid.body;
        body.centre += dt / 2 * (body.velocity - start->velocity);
        body.turn = (Eigen::Quaterniond(turn_by(dt / 2 * (body.angular_velocity() - start->turning))) * body.turn).normalized();
        ++start;
    }
    around.solids.place_bodies();
    around.layer.follow(around.solids);
}

}  // namespace whorl
