#include "engine/geometry/touch.h"

#include <algorithm>
#include <cmath>

namespace whorl {
namespace {

/// A ball of body `a` at the surface of solid `b`.
struct Point {
    std::size_t a, b;
    Vec3d normal;           ///< from b to a
    Vec3d arm_a, arm_b;     ///< from the centres [m]; arm_b: where b is free
    Vec3d place;            ///< m
    double gap = 0;         ///< m
    double wanted = 0;      ///< m/s, the least v_n
    double friction = 0;
    Vec3d impulse = Vec3d::Zero();  ///< on a [kg m/s]
};

class Touching {
public:
    Touching(Solids& solids, const SolidParticles& layer, const TouchStep& step) : solids_(solids), layer_(layer), step_(step) {}

    void find() {
        const std::size_t n = solids_.all.size();
        std::vector<std::vector<Index>> own(n);
        std::vector<double> reach(n, 0);
        for (Index s = 0; s < layer_.size(); ++s) {
            const auto k = static_cast<std::size_t>(layer_.solid[static_cast<std::size_t>(s)]);
            const auto& body = solids_.all[k].body;
            if (!body) continue;
            own[k].push_back(s);
            reach[k] = std::max(reach[k], (layer_.own_position[static_cast<std::size_t>(s)].cast<double>() - body->own_centre).norm() + step_.spacing / 2);
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
                    if ((from + image).norm() > reach[a] + reach[b] + 2 * step_.spacing) continue;
                } else if (static_cast<double>(solids_.all[b].distance(body.centre.cast<Real>())) > reach[a] + 2 * step_.spacing) {
                    continue;
                }
                for (const Index s : own[a]) at_ball(a, b, s, image);
            }
    }

    void solve(double gravity) {
        const double slow = std::sqrt(2 * gravity * step_.spacing);
        for (Point& p : points_) {
            const double coming = -relative(p).dot(p.normal);
            p.wanted = p.gap > 0 ? -p.gap / step_.dt : -0.2 * p.gap / step_.dt;
            const double bounce = std::max(solids_.all[p.a].contact.bounce, solids_.all[p.b].contact.bounce);
            if (coming * step_.dt > p.gap && coming > slow) p.wanted = std::max(p.wanted, bounce * coming);
        }
        constexpr int rounds = 60;
        for (int round = 0; round < rounds; ++round) {
            double largest = 0;
            for (Point& p : points_) largest = std::max(largest, push_apart(p));
            for (Point& p : points_)
                if (p.friction > 0 && p.impulse.dot(p.normal) > 0) hold_back(p);
            if (largest < 1e-6 * step_.spacing / step_.dt) break;
        }
    }
    bool empty() const { return points_.empty(); }

private:
    void at_ball(std::size_t a, std::size_t b, Index s, const Vec3d& image) {
        const Solid& other = solids_.all[b];
        const Vec3d ball = layer_.position[static_cast<std::size_t>(s)].cast<double>() + image;
        const double gap = static_cast<double>(other.distance(ball.cast<Real>())) - step_.spacing / 2;
        const Vec3d own = solids_.all[a].body->velocity_at(ball - image), its = velocity(b, ball);
        if (gap > (own - its).norm() * step_.dt + 0.1 * step_.spacing) return;
        Point p;
        p.a = a, p.b = b, p.gap = gap;
        p.normal = other.normal(ball.cast<Real>()).cast<double>();
        p.place = ball - step_.spacing / 2 * p.normal;
        p.arm_a = p.place - image - solids_.all[a].body->centre;
        if (other.body) p.arm_b = p.place - other.body->centre;
        p.friction = std::sqrt(solids_.all[a].contact.friction * other.contact.friction);
        points_.push_back(p);
    }
    Vec3d velocity(std::size_t k, const Vec3d& x) const {
        const Solid& solid = solids_.all[k];
        return solid.body ? solid.body->velocity_at(x) : Vec3d(solid.pose.velocity_at(x.cast<Real>()).cast<double>());
    }
    Vec3d relative(const Point& p) const {
        const RigidBody& a = *solids_.all[p.a].body;
        return a.velocity + a.angular_velocity().cross(p.arm_a) - velocity(p.b, p.place);
    }
    /// How fast the two part along n for an impulse of 1 along it [1/kg].
    double softness(const Point& p, const Vec3d& n) const {
        const auto of = [&](const RigidBody& body, const Vec3d& arm) {
            const Vec3d turning = arm.cross(n);
            return 1 / body.mass + turning.dot(body.inverse_inertia() * turning);
        };
        return of(*solids_.all[p.a].body, p.arm_a) + (solids_.all[p.b].body ? of(*solids_.all[p.b].body, p.arm_b) : 0);
    }
    void push(Point& p, const Vec3d& impulse) {
        p.impulse += impulse;
        solids_.all[p.a].body->push(impulse, p.arm_a);
        if (solids_.all[p.b].body) solids_.all[p.b].body->push(-impulse, p.arm_b);
    }
    /// @returns the change of velocity [m/s]
    double push_apart(Point& p) {
        const double before = p.impulse.dot(p.normal), soft = softness(p, p.normal);
        const double after = std::max(0.0, before + (p.wanted - relative(p).dot(p.normal)) / soft);
        if (after == before) return 0;
        push(p, (after - before) * p.normal);
        return std::abs(after - before) * soft;
    }
    void hold_back(Point& p) {
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
    const TouchStep& step_;
    std::vector<Point> points_;
};

}  // namespace

void touch(Solids& solids, const SolidParticles& layer, const TouchStep& step, double gravity) {
    if (!(step.dt > 0)) return;
    Touching touching(solids, layer, step);
    touching.find();
    if (!touching.empty()) touching.solve(gravity);
}

}  // namespace whorl
