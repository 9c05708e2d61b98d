#include "engine/geometry/body_contact.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace whorl {
namespace {

using Vec6d = Eigen::Matrix<double, 6, 1>;
using Mat6d = Eigen::Matrix<double, 6, 6>;

Vec3d velocity_at(const Solids& solids, std::size_t k, const Vec3d& x) {
    const Solid& solid = solids.all[k];
    return solid.body ? solid.body->velocity_at(x) : Vec3d(solid.velocity_at(x.cast<Real>()).cast<double>());
}

double length(double x, double y) { return std::sqrt(x * x + y * y); }  // std::hypot takes ten times as long

}  // namespace

struct BodyContacts::Held {
    Eigen::SparseMatrix<double> rows;                            ///< J M^-1
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> between;  ///< J M^-1 J^T
};

void BodyContacts::find(const Solids& solids, const BoundaryParticles& boundary, const ContactStep& step) {
    const std::size_t n = solids.all.size();
    step_ = step;
    points_.clear();
    moving_.assign(n, {});
    slots_ = 0;
    std::vector<std::vector<Index>> own(n);
    std::vector<double> reach(n, 0);
    std::vector<Eigen::Triplet<double>> M;
    for (std::size_t k = 0; k < n; ++k) {
        if (!solids.all[k].body) continue;
        const RigidBody& body = *solids.all[k].body;
        const Moving& m = moving_[k] = {body.velocity, body.angular_velocity(), 1 / body.mass, body.inverse_inertia(), slots_};
        for (int r = 0; r < 3; ++r) {
            M.emplace_back(slots_ + r, slots_ + r, m.lightness);
            for (int c = 0; c < 3; ++c) M.emplace_back(slots_ + 3 + r, slots_ + 3 + c, m.inverse_inertia(r, c));
        }
        slots_ += 6;
    }
    lightness_.resize(slots_, slots_);
    lightness_.setFromTriplets(M.begin(), M.end());
    held_.reset();
    if (slots_ == 0 || !(step.dt > 0)) return;
    for (Index s = 0; s < boundary.size(); ++s) {
        const auto k = static_cast<std::size_t>(boundary.solid[s]);
        const auto& body = solids.all[k].body;
        if (!body) continue;
        own[k].push_back(s);
        reach[k] = std::max(reach[k], (boundary.own_position[s].cast<double>() - body->own_centre).norm() + step.spacing);
    }
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) {
            if (a == b || !solids.all[a].body) continue;
            const RigidBody& body = *solids.all[a].body;
            // Vector from the centre of b, if b is free, to the nearest periodic image of a.
            Vec3d image = Vec3d::Zero();
            if (solids.all[b].body) {
                const Vec3d from = body.centre - solids.all[b].body->centre;
                if (step.domain.any_periodic()) image = step.domain.minimum_image(from.cast<Real>()).cast<double>() - from;
                if ((from + image).norm() > reach[a] + reach[b] + 2 * step.spacing + step.clearance) continue;
            } else if (static_cast<double>(solids.all[b].distance(body.centre.cast<Real>())) >
                       reach[a] + 2 * step.spacing + step.clearance) {
                continue;
            }
            const std::size_t first = points_.size();
            for (const Index s : own[a]) look_from(solids, boundary, a, b, s, image);
            thin(first);
        }
    want(solids);
}

/// The point of a's surface near `start` that is deepest in b, found by a descent along a's surface over at most about a spacing.
/// Without the descent, the boundary particles would represent a ball as a polyhedron, which does not roll.
Vec3d BodyContacts::deepest(const Solid& a, const Solid& b, const Vec3d& image, const Vec3d& start) const {
    const auto depth = [&](const Vec3d& x) { return static_cast<double>(b.distance(x.cast<Real>())); };
    const auto on_surface = [&](const Vec3d& x) {
        const Vec3 own = (x - image).cast<Real>();
        return Vec3d(x - (a.distance(own) * a.normal(own)).cast<double>());
    };
    const auto slope = [&](const Vec3d& x) -> Vec3d {
        const Vec3d down = -b.normal(x.cast<Real>()).cast<double>(), out = a.normal((x - image).cast<Real>()).cast<double>();
        return down - down.dot(out) * out;
    };
    Vec3d p = on_surface(start), along = slope(p);
    double gap = depth(p), step = step_.spacing / 2;
    for (int k = 0; k < 24 && step > 0.01 * step_.spacing && along.norm() > 1e-3; ++k) {
        const Vec3d q = on_surface(p + step * along.normalized());
        const double lower = depth(q);
        if (lower < gap) p = q, gap = lower, along = slope(p);
        else step /= 2;
    }
    // The descent stops early because of round-off in the depths. If both surfaces are smooth, the slope is 0 at the deepest point, and one
    // secant step for the slope finds that point.
    if (!(along.norm() > 1e-6)) return p;
    const Vec3d way = 0.01 * step_.spacing * along.normalized(), q = on_surface(p + way);
    const double bend = 1 - slope(q).dot(along) / along.squaredNorm();
    if (!(bend > 0.01)) return p;
    const Vec3d root = on_surface(p + way / bend);
    return slope(root).norm() < along.norm() / 2 ? root : p;
}

void BodyContacts::look_from(const Solids& solids, const BoundaryParticles& boundary, std::size_t a, std::size_t b, Index s,
                             const Vec3d& image) {
    const Solid& other = solids.all[b];
    const Vec3d start = boundary.position[s].cast<double>() + image;
    const double coming = (solids.all[a].body->velocity_at(start - image) - velocity_at(solids, b, start)).norm() * step_.dt;
    if (static_cast<double>(other.distance(start.cast<Real>())) > coming + 1.5 * step_.spacing + step_.clearance) return;
    Point p;
    p.place = deepest(solids.all[a], other, image, start);
    const auto apart = static_cast<double>(other.distance(p.place.cast<Real>()));
    // Distances within rounding error count as 0. Otherwise the points of a rigid face would impose slightly different velocities.
    const double rounding = 1e-5 * step_.spacing + 4 * static_cast<double>(std::numeric_limits<Real>::epsilon()) * p.place.norm();
    p.gap = std::min(0.0, apart + rounding) + std::max(0.0, apart - step_.clearance - rounding);
    if (p.gap > coming + 0.1 * step_.spacing) return;
    for (std::size_t k = points_.size(); k > 0 && points_[k - 1].a == a && points_[k - 1].b == b; --k)
        if ((points_[k - 1].place - p.place).norm() < 0.3 * step_.spacing) return;
    p.a = a, p.b = b;
    p.ways[0].along = other.normal(p.place.cast<Real>()).cast<double>();
    p.arm_a = p.place - image - solids.all[a].body->centre;
    if (other.body) p.arm_b = p.place - other.body->centre;
    p.friction = std::sqrt(solids.all[a].contact.friction * other.contact.friction);
    points_.push_back(p);
}

void BodyContacts::thin(std::size_t first) {
    constexpr int ways = 8;
    std::vector<char> seen(points_.size(), 0), kept(points_.size(), 0);
    for (std::size_t of = first; of < points_.size(); ++of) {
        if (seen[of]) continue;
        const Vec3d n = points_[of].ways[0].along, t = n.unitOrthogonal();
        std::array<std::size_t, ways + 1> best;
        best.fill(of);
        for (std::size_t k = of; k < points_.size(); ++k) {
            if (seen[k] || points_[k].ways[0].along.dot(n) < 0.9999) continue;
            seen[k] = 1;
            for (int way = 0; way < ways; ++way) {
                const double angle = 2 * std::numbers::pi * (way + 0.5) / ways;
                const Vec3d along = std::cos(angle) * t + std::sin(angle) * n.cross(t);
                if (along.dot(points_[k].place - points_[best[way]].place) > 1e-3 * step_.spacing) best[way] = k;
            }
            if (points_[k].gap < points_[best[ways]].gap) best[ways] = k;
        }
        for (const std::size_t k : best) kept[k] = 1;
        // The face as a polygon: its corners in the order of their directions, split into triangles about the middle.
        const auto corner = [&](std::size_t way) { return points_[best[way % ways]].place; };
        Vec3d middle = Vec3d::Zero();
        for (std::size_t way = 0; way < ways; ++way) middle += corner(way) / ways;
        double farthest = 0, area = 0, moment = 0;
        for (std::size_t way = 0; way < ways; ++way) {
            const Vec3d p = corner(way) - middle, q = corner(way + 1) - middle;
            const double triangle = p.cross(q).norm();
            farthest = std::max(farthest, p.norm());
            area += triangle, moment += triangle * 2 / 3 * (p.norm() + 2 * (p + q).norm() + q.norm()) / 6;
        }
        // Mean distance of the face's points from the middle; farthest/2 if the face is a line.
        const double mean = area > 1e-3 * farthest * farthest ? moment / area : farthest / 2;
        for (const std::size_t k : best) {
            const Vec3d out = points_[k].place - middle;
            points_[k].grip = mean * (out.norm() > 1e-3 * farthest ? out.normalized() : t) - out;
        }
    }
    std::size_t k = 0;
    points_.erase(std::remove_if(points_.begin(), points_.end(), [&](const Point&) { return k++ >= first && !kept[k - 1]; }),
                  points_.end());
}

void BodyContacts::want(const Solids& solids) {
    const double slow = std::sqrt(2 * step_.gravity * step_.spacing), dt = step_.dt;
    const double mending = std::max(dt, step_.gravity > 0 ? 0.1 * std::sqrt(step_.spacing / step_.gravity) : 0.0);
    for (Point& p : points_) {
        if (!solids.all[p.b].body) p.wall = velocity_at(solids, p.b, p.place);
        const Vec3d n = p.ways[0].along, t = n.unitOrthogonal();
        p.ways = {direction(p, n, Vec3d::Zero()), direction(p, t, p.grip), direction(p, n.cross(t), p.grip)};
        p.crossed = p.ways[1].arm_a.dot(p.ways[2].turn_a) + p.ways[1].arm_b.dot(p.ways[2].turn_b);
        const double coming = -speed(p, p.ways[0]);
        p.wanted = p.gap > 0 ? -p.gap / dt : -0.2 * p.gap / mending;
        const double bounce = std::max(solids.all[p.a].contact.bounce, solids.all[p.b].contact.bounce);
        if (coming * dt > p.gap && coming > slow) p.wanted = std::max(p.wanted, bounce * coming);
    }
}

BodyContacts::Direction BodyContacts::direction(const Point& p, const Vec3d& along, const Vec3d& from_place) const {
    const Moving &a = moving_[p.a], &b = moving_[p.b];
    Direction n;
    n.along = along, n.arm_a = (p.arm_a + from_place).cross(along);
    if (b.slot >= 0) n.arm_b = (p.arm_b + from_place).cross(along);
    n.turn_a = a.inverse_inertia * n.arm_a, n.turn_b = b.inverse_inertia * n.arm_b;
    n.softness = a.lightness + b.lightness + n.arm_a.dot(n.turn_a) + n.arm_b.dot(n.turn_b);
    return n;
}

double BodyContacts::speed(const Point& p, const Direction& n) const {
    const Moving &a = moving_[p.a], &b = moving_[p.b];
    return n.along.dot(a.velocity - b.velocity - p.wall) + n.arm_a.dot(a.turning) - n.arm_b.dot(b.turning);
}

void BodyContacts::push(const Point& p, Direction& n, double impulse) {
    Moving &a = moving_[p.a], &b = moving_[p.b];
    n.impulse += impulse;
    a.velocity += a.lightness * impulse * n.along, a.turning += impulse * n.turn_a;
    b.velocity -= b.lightness * impulse * n.along, b.turning -= impulse * n.turn_b;
}

/// Makes the normal velocity at least p.wanted. @returns the change of velocity [m/s]
double BodyContacts::push_apart(Point& p) {
    Direction& n = p.ways[0];
    const double change = std::max(-n.impulse, (p.wanted - speed(p, n)) / n.softness);
    if (change == 0) return 0;
    push(p, n, change);
    return std::abs(change) * n.softness;
}

/// Brakes sliding within the limit of friction. @returns the change of velocity [m/s]
double BodyContacts::hold_back(Point& p) {
    auto& [n, s, t] = p.ways;
    if (n.impulse == 0 && s.impulse == 0 && t.impulse == 0) return 0;
    const double vs = speed(p, s), vt = speed(p, t), most = p.friction * n.impulse, det = s.softness * t.softness - p.crossed * p.crossed;
    double to_s = s.impulse - (t.softness * vs - p.crossed * vt) / det, to_t = t.impulse - (s.softness * vt - p.crossed * vs) / det;
    const double soft = (s.softness + t.softness) / 2 + length((s.softness - t.softness) / 2, p.crossed);  // in the softest direction
    if (length(to_s, to_t) > most) {
        to_s = s.impulse - vs / soft, to_t = t.impulse - vt / soft;
        const double size = length(to_s, to_t);
        if (size > most) to_s *= most / size, to_t *= most / size;
    }
    const double change = length(to_s - s.impulse, to_t - t.impulse) * soft;
    push(p, s, to_s - s.impulse), push(p, t, to_t - t.impulse);
    return change;
}

BodyVector BodyContacts::velocities(const BodyVector& free) {
    constexpr int rounds = 400;
    constexpr double exactly = 1e-6;  // relative to the largest relative velocity; that of a body at rest is dt g
    for (Moving& m : moving_)
        if (m.slot >= 0) m.velocity = free.segment<3>(m.slot), m.turning = free.segment<3>(m.slot + 3);
    double fastest = 0;
    for (const Point& p : points_) {
        double square = 0;
        for (const Direction& n : p.ways) square += std::pow(speed(p, n), 2);
        fastest = std::max(fastest, std::sqrt(square) + std::abs(p.wanted));
    }
    for (Point& p : points_)
        for (Direction& n : p.ways) push(p, n, std::exchange(n.impulse, 0));
    for (int round = 0; round < rounds; ++round) {
        double largest = 0;
        for (Point& p : points_) largest = std::max(largest, push_apart(p));
        for (Point& p : points_)
            if (p.friction > 0) largest = std::max(largest, hold_back(p));
        if (largest <= exactly * fastest) break;
    }
    BodyVector found(free.size());
    for (const Moving& m : moving_)
        if (m.slot >= 0) found.segment<3>(m.slot) = m.velocity, found.segment<3>(m.slot + 3) = m.turning;
    return found;
}

void BodyContacts::add_rows(std::size_t first, std::size_t last, std::vector<Eigen::Triplet<double>>& J) const {
    // Each row r acts on the relative velocity of a and b, represented by its linear part at the centre of a and its angular part. Lengths
    // are in units of `scale`.
    const Moving &a = moving_[points_[first].a], &b = moving_[points_[first].b];
    const Vec3d between = points_[first].arm_b - points_[first].arm_a;
    double scale = step_.spacing;
    for (std::size_t k = first; k < last; ++k) scale = std::max(scale, points_[k].arm_a.norm());
    Mat6d rows = Mat6d::Zero();
    for (std::size_t k = first; k < last; ++k) {
        const Point& p = points_[k];
        if (!(p.ways[0].impulse > 0)) continue;
        for (const Direction& n : p.ways) {
            const Vec6d r = (Vec6d() << n.along, n.arm_a / scale).finished();
            rows += r * r.transpose();
            if (p.slides()) break;
        }
    }
    const Eigen::SelfAdjointEigenSolver<Mat6d> modes(rows);
    for (int m = 0; m < 6; ++m) {
        if (!(modes.eigenvalues()[m] > 1e-6 * modes.eigenvalues()[5])) continue;
        const Vec3d push = modes.eigenvectors().col(m).head<3>(), turn = scale * modes.eigenvectors().col(m).tail<3>();
        const auto row = J.empty() ? 0 : J.back().row() + 1;
        const auto add = [&](const Moving& body, const Vec6d& r) {
            for (int c = 0; c < 6 && body.slot >= 0; ++c) J.emplace_back(row, static_cast<int>(body.slot) + c, r[c]);
        };
        add(a, (Vec6d() << push, turn).finished());
        add(b, -(Vec6d() << push, turn + between.cross(push)).finished());
    }
}

void BodyContacts::hold() {
    std::vector<Eigen::Triplet<double>> J;
    for (std::size_t first = 0, last = 0; first < points_.size(); first = last) {
        while (last < points_.size() && points_[last].a == points_[first].a && points_[last].b == points_[first].b) ++last;
        add_rows(first, last, J);
    }
    held_.reset();
    if (J.empty()) return;
    Eigen::SparseMatrix<double> rows(J.back().row() + 1, slots_);
    rows.setFromTriplets(J.begin(), J.end());
    const auto held = std::make_shared<Held>();
    held->rows = rows * lightness_;
    Eigen::SparseMatrix<double> S = held->rows * rows.transpose();
    // Regularisation. Without it, redundant contacts would make the matrix singular.
    for (Eigen::Index r = 0; r < S.rows(); ++r) S.coeffRef(r, r) *= 1 + 1e-10;
    held->between.compute(S);
    held_ = held;
}

BodyVector BodyContacts::change(const BodyVector& impulses) const {
    BodyVector v = lightness_ * impulses;
    if (held_) v -= held_->rows.transpose() * held_->between.solve(BodyVector(held_->rows * impulses));
    return v;
}

void BodyContacts::resolve(Solids& solids) {
    if (points_.empty()) return;
    const auto give = [&](double times) {
        for (const Point& p : points_)
            for (const Direction& n : p.ways) {
                solids.all[p.a].body->push(times * n.given * Wrench{n.along, n.arm_a});
                if (solids.all[p.b].body) solids.all[p.b].body->push(-times * n.given * Wrench{n.along, n.arm_b});
            }
    };
    give(-1);
    velocities(velocities_of(solids));
    for (Point& p : points_)
        for (Direction& n : p.ways) n.given = n.impulse;
    give(1);
}

BodyVector velocities_of(const Solids& solids) {
    std::vector<double> all;
    for (const Solid& solid : solids.all)
        if (solid.body)
            for (const Vec3d& v : {solid.body->velocity, solid.body->angular_velocity()}) all.insert(all.end(), v.data(), v.data() + 3);
    return Eigen::Map<const BodyVector>(all.data(), static_cast<Eigen::Index>(all.size()));
}

}  // namespace whorl
