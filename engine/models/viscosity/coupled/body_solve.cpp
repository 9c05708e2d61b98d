#include "engine/models/viscosity/coupled/body_solve.h"

#include "engine/models/bodies/body_motion.h"

namespace whorl {

std::size_t BodySolve::begin(const InteractionContext& context) {
    // With less than a layer of particles in the gap, fluid could not leave it.
    constexpr double clearance = 1;
    if (!context.solids.any_free()) return 0;
    mass_ = static_cast<double>(context.step.mass);
    inertia.set_up(context.solids, context.step.mass, 0, {}, [](Index, std::size_t) { return BodyTouch{}; });
    before_.resize(static_cast<std::size_t>(inertia.entries()));
    inertia.read(context.solids, before_);
    contacts_.find(context.solids, context.boundary, contact_step(context.step, clearance * static_cast<double>(context.step.spacing)));
    return before_.size();
}

void BodySolve::momenta(Span<Vec3> entries) const { inertia.weigh(before_, entries); }

void BodySolve::guess(const Vec3& fall, Span<Vec3> entries) const {
    std::copy(before_.begin(), before_.end(), entries.begin());
    for (std::size_t k = 0; k < before_.size(); k += 2) entries[k] -= fall;
}

BodyVector BodySolve::vector_of(Span<const Vec3> entries) const {
    BodyVector all(static_cast<Eigen::Index>(3 * entries.size()));
    for (std::size_t k = 0; k < entries.size(); ++k) all.segment<3>(static_cast<Eigen::Index>(3 * k)) = entries[k].cast<double>();
    return all;
}

void BodySolve::write(const BodyVector& from, Span<Vec3> entries) const {
    for (std::size_t k = 0; k < entries.size(); ++k) entries[k] = from.segment<3>(static_cast<Eigen::Index>(3 * k)).cast<Real>();
}

bool BodySolve::touch(Span<const Vec3> velocities, Span<Vec3> change) {
    if (contacts_.empty()) return false;
    constexpr double nothing = 1e-6;  // relative to the velocities, about their round-off
    const BodyVector free = vector_of(velocities), after = contacts_.velocities(free);
    if (!((after - free).norm() > nothing * free.norm())) return false;
    contacts_.hold();
    write(after - free, change);
    return in_contact_ = true;
}

void BodySolve::free_part(Span<Vec3> entries) const {
    std::vector<Vec3> impulses(entries.size());
    inertia.weigh(entries, impulses);
    write(contacts_.change(mass_ * vector_of(impulses)), entries);
}

void BodySolve::free_part_of_forces(Span<Vec3> entries) const {
    std::vector<Vec3> moved(entries.size());
    write(contacts_.change(mass_ * vector_of(entries)), moved);
    inertia.weigh(moved, entries);
}

void BodySolve::take_over(Span<const Vec3> velocities, Solids& solids) const {
    for (std::size_t b = 0; b < inertia.body.size(); ++b) {
        RigidBody& body = *solids.all[inertia.body[b].solid].body;
        body.velocity = velocities[2 * b].cast<double>();
        body.spin_at(velocities[2 * b + 1].cast<double>());
    }
}

}  // namespace whorl
