#include "engine/geometry/body_contact.h"

#include <algorithm>
#include <cmath>

namespace whorl {
namespace {

/// A place on the surface of body `a` at the surface of solid `b`.
struct ContactPoint {
    std::size_t a, b;
    Vec3d normal;                        ///< from b to a
    Vec3d arm_a, arm_b = Vec3d::Zero();  ///< from the centres [m]; arm_b: where b is free
    Vec3d wall = Vec3d::Zero();          ///< m/s, of b, where it is not
    double softness = 0;                 ///< 1/kg, along the normal
    Vec3d place;                         ///< m
    double gap = 0;                      ///< m
    double wanted = 0;                   ///< m/s, the least v_n
    double friction = 0;
    Vec3d impulse = Vec3d::Zero();  ///< on a [kg m/s]
};

/// A body while impulses act on it.
struct MovingBody {
    Vec3d velocity = Vec3d::Zero(), turning = Vec3d::Zero();  ///< m/s, rad/s
    double lightness = 0;                                     ///< 1/kg
    Mat3d inverse_inertia = Mat3d::Zero();
    void push(const Vec3d& impulse, const Vec3d& arm) { velocity += lightness * impulse, turning += inverse_inertia * arm.cross(impulse); }
    /// How fast it moves along n at the arm for an impulse of 1 along it [1/kg].
    double softness(const Vec3d& arm, const Vec3d& n) const {
        const Vec3d torque = arm.cross(n);
        return lightness + torque.dot(inverse_inertia * torque);
    }
};

class Contacts {
public:
    Contacts(Solids& solids, const SolidParticles& layer, const ContactStep& step)
        : solids_(solids), layer_(layer), step_(step), moving_(solids.all.size()) {
        for (std::size_t k = 0; k < moving_.size(); ++k)
            if (const auto& body = solids.all[k].body)
                moving_[k] = {body->velocity, body->angular_velocity(), 1 / body->mass, body->inverse_inertia()};
    }

    void find() {
        const std::size_t n = solids_.all.size();
        std::vector<std::vector<Index>> own(n);
        std::vector<double> reach(n, 0);
        for (Index s = 0; s < layer_.size(); ++s) {
            const auto k = static_cast<std::size_t>(layer_.solid[s]);
            const auto& body = solids_.all[k].body;
            if (!body) continue;
            own[k].push_back(s);
            reach[k] = std::max(reach[k], (layer_.own_position[s].cast<double>() - body->own_centre).norm() + step_.spacing);
        }
        for (std::size_t a = 0; a < n; ++a)
            for (std::size_t b = 0; b < n; ++b) {
                if (a == b || !solids_.all[a].body) continue;
                const RigidBody& body = *solids_.all[a].body;
                // From the centre of b, if it is free, to the nearest image of a.
                Vec3d image = Vec3d::Zero();
                if (solids_.all[b].body) {
                    const Vec3d from = body.centre - solids_.all[b].body->centre;
                    if (step_.domain.any_periodic()) image = step_.domain.minimum_image(from.cast<Real>()).cast<double>() - from;
                    if ((from + image).norm() > reach[a] + reach[b] + 2 * step_.spacing + step_.clearance) continue;
                } else if (static_cast<double>(solids_.all[b].distance(body.centre.cast<Real>())) >
                           reach[a] + 2 * step_.spacing + step_.clearance) {
                    continue;
                }
                for (const Index s : own[a]) look_from(a, b, s, image);
            }
    }

    void solve(double gravity) {
        const double slow = std::sqrt(2 * gravity * step_.spacing);
        for (ContactPoint& p : points_) {
            if (!solids_.all[p.b].body) p.wall = velocity(p.b, p.place);
            p.softness = softness(p, p.normal);
            const double coming = -relative(p).dot(p.normal);
            p.wanted = p.gap > 0 ? -p.gap / step_.dt : -0.2 * p.gap / step_.dt;
            const double bounce = std::max(solids_.all[p.a].contact.bounce, solids_.all[p.b].contact.bounce);
            if (coming * step_.dt > p.gap && coming > slow) p.wanted = std::max(p.wanted, bounce * coming);
        }
        constexpr int rounds = 60;
        for (int round = 0; round < rounds; ++round) {
            double largest = 0;
            for (ContactPoint& p : points_) largest = std::max(largest, push_apart(p));
            for (ContactPoint& p : points_)
                if (p.friction > 0 && p.impulse.dot(p.normal) > 0) hold_back(p);
            if (largest < 1e-6 * step_.spacing / step_.dt) break;
        }
        for (const ContactPoint& p : points_) {
            solids_.all[p.a].body->push(Wrench::at(p.arm_a, p.impulse));
            if (solids_.all[p.b].body) solids_.all[p.b].body->push(Wrench::at(p.arm_b, -p.impulse));
        }
    }
    bool empty() const { return points_.empty(); }

private:
    /// The place on the surface of a nearest to layer particle s that is deepest in b: down along the surface from there, up to about a
    /// spacing. The particles alone would make a polyhedron of a ball, which does not roll.
    Vec3d deepest(const Solid& a, const Solid& b, const Vec3d& image, Index s) const {
        const auto depth = [&](const Vec3d& x) { return static_cast<double>(b.distance(x.cast<Real>())); };
        const auto on_surface = [&](const Vec3d& x) {
            const Vec3 own = (x - image).cast<Real>();
            return Vec3d(x - (a.distance(own) * a.normal(own)).cast<double>());
        };
        Vec3d p = on_surface(layer_.position[s].cast<double>() + image);
        double gap = depth(p), step = step_.spacing / 2;
        for (int k = 0; k < 24 && step > 0.01 * step_.spacing; ++k) {
            const Vec3d down = -b.normal(p.cast<Real>()).cast<double>(), out = a.normal((p - image).cast<Real>()).cast<double>();
            const Vec3d along = down - down.dot(out) * out;
            if (along.norm() < 1e-3) break;
            const Vec3d q = on_surface(p + step * along.normalized());
            const double lower = depth(q);
            if (lower < gap) p = q, gap = lower;
            else step /= 2;
        }
        return p;
    }
    void look_from(std::size_t a, std::size_t b, Index s, const Vec3d& image) {
        const Solid& other = solids_.all[b];
        const Vec3d start = layer_.position[s].cast<double>() + image;
        const double coming = (solids_.all[a].body->velocity_at(start - image) - velocity(b, start)).norm() * step_.dt;
        if (static_cast<double>(other.distance(start.cast<Real>())) > coming + 1.5 * step_.spacing + step_.clearance) return;
        ContactPoint p;
        p.place = deepest(solids_.all[a], other, image, s);
        const auto apart = static_cast<double>(other.distance(p.place.cast<Real>()));
        p.gap = apart < 0 ? apart : std::max(0.0, apart - step_.clearance);
        if (p.gap > coming + 0.1 * step_.spacing) return;
        for (std::size_t k = points_.size(); k > 0 && points_[k - 1].a == a && points_[k - 1].b == b; --k)
            if ((points_[k - 1].place - p.place).norm() < 0.3 * step_.spacing) return;
        p.a = a, p.b = b;
        p.normal = other.normal(p.place.cast<Real>()).cast<double>();
        p.arm_a = p.place - image - solids_.all[a].body->centre;
        if (other.body) p.arm_b = p.place - other.body->centre;
        p.friction = std::sqrt(solids_.all[a].contact.friction * other.contact.friction);
        points_.push_back(p);
    }
    Vec3d velocity(std::size_t k, const Vec3d& x) const {
        const Solid& solid = solids_.all[k];
        return solid.body ? solid.body->velocity_at(x) : Vec3d(solid.velocity_at(x.cast<Real>()).cast<double>());
    }
    Vec3d relative(const ContactPoint& p) const {
        const MovingBody &a = moving_[p.a], &b = moving_[p.b];
        return a.velocity + a.turning.cross(p.arm_a) - b.velocity - b.turning.cross(p.arm_b) - p.wall;
    }
    /// Of the two together.
    double softness(const ContactPoint& p, const Vec3d& n) const {
        return moving_[p.a].softness(p.arm_a, n) + moving_[p.b].softness(p.arm_b, n);
    }
    void push(ContactPoint& p, const Vec3d& impulse) {
        p.impulse += impulse;
        moving_[p.a].push(impulse, p.arm_a);
        moving_[p.b].push(-impulse, p.arm_b);
    }
    /// @returns the change of velocity [m/s]
    double push_apart(ContactPoint& p) {
        const double before = p.impulse.dot(p.normal);
        const double after = std::max(0.0, before + (p.wanted - relative(p).dot(p.normal)) / p.softness);
        if (after == before) return 0;
        push(p, (after - before) * p.normal);
        return std::abs(after - before) * p.softness;
    }
    void hold_back(ContactPoint& p) {
        const double pressed = p.impulse.dot(p.normal);
        const Vec3d v = relative(p), sliding = v - v.dot(p.normal) * p.normal;
        const double speed = sliding.norm();
        if (!(speed > 0)) return;
        const Vec3d before = p.impulse - pressed * p.normal;
        Vec3d after = before - sliding / softness(p, sliding / speed);
        if (const double size = after.norm(); size > p.friction * pressed) after *= p.friction * pressed / size;
        push(p, after - before);
    }

    Solids& solids_;
    const SolidParticles& layer_;
    const ContactStep& step_;
    std::vector<MovingBody> moving_;  ///< by solid; those that no force moves have no lightness
    std::vector<ContactPoint> points_;
};

}  // namespace

void resolve_contacts(Solids& solids, const SolidParticles& layer, const ContactStep& step, double gravity) {
    if (!(step.dt > 0)) return;
    Contacts contacts(solids, layer, step);
    contacts.find();
    if (!contacts.empty()) contacts.solve(gravity);
}

}  // namespace whorl
