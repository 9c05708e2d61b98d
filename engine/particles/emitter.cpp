#include "engine/particles/emitter.h"

#include <algorithm>
#include <array>
#include <istream>
#include <ostream>

#include "engine/core/parallel.h"
#include "engine/particles/sample.h"

namespace whorl {

struct Emitter::State {
    EmitterShape shape;
    Expression speed_of_time;
    double start, stop;
    Real spacing, depth;
    std::int16_t role;
    Solid body, guarded;  ///< guarded: body without its first spacing behind the opening, into which emitted fluid may come back
    Solid end;
    std::array<Pose, 3> at_start;  ///< poses of body, guarded and end at t = 0
    EmitterShape shape_at_start;
    Vec3 width_at_start, thickness_at_start;
    VectorExpression centre_of_time, direction_of_time;
    bool moving = false;
    Pose pose;  ///< motion since t = 0
    Domain domain;
    double faster = 1;         ///< area of the opening over the area of its part outside solids
    bool full = false;         ///< the pipe is filled from the start
    std::vector<Vec3> places;  ///< positions of the particles that fill the pipe at the start, as long as they are not in the store
    double ahead = 0;          ///< length of pipe that these particles fill [m]; the column begins behind them

    Real apart() const { return static_cast<Real>(least_clearance) * spacing; }  ///< smallest distance of free fluid from the pipe
    /// Whether the position q in the opening's frame is in the part of the pipe that the moving column fills.
    bool in_column(const Vec3& q) const { return pipe_distance(shape, q) < Real(0.3) * spacing && q.z() > -depth - spacing / 20; }

    Vec3 width_axis, thickness_axis;
    double length = 0;            ///< length of a block of the column, the period with which its particles repeat [m]
    std::vector<Vec3> block;      ///< positions in the opening's frame: x and y across, z in [0, length) in the order of emission
    std::vector<Vec3> first;      ///< first copy of the block, adapted to the initial filling of the pipe
    std::vector<long> next_copy;  ///< number of copies of each particle of the block that have entered
    double pushed = 0;            ///< integral of the mean speed [m]

    /// Speed over mean speed at a point of the opening.
    double profile(Real across_width, Real across_thickness) const {
        if (!shape.parabolic) return 1;
        if (shape.plane || shape.slot) {
            const double s = shape.plane ? 2 * across_width / static_cast<double>(shape.width)
                                         : 2 * across_thickness / static_cast<double>(shape.thickness);
            return 1.5 * std::max(0.0, 1 - s * s);
        }
        const double r2 = static_cast<double>(across_width) * across_width + static_cast<double>(across_thickness) * across_thickness;
        return 2 * std::max(0.0, 1 - r2 / (static_cast<double>(shape.radius) * shape.radius));
    }
    double peak() const { return !shape.parabolic ? 1 : shape.plane || shape.slot ? 1.5 : 2; }
    int dimensions() const { return shape.plane ? 2 : 3; }
    double volume() const { return std::pow(static_cast<double>(spacing), dimensions()); }  ///< volume of a particle

    long column_count() const {
        return std::lround(column_points(opening_area(shape), static_cast<double>(spacing), shape.parabolic, dimensions()));
    }

    double mean_speed(double t) const { return t < start || t > stop ? 0 : faster * std::max(0.0, speed_of_time(t)); }

    /// Integral of the mean speed over [t, t + dt] by Simpson's rule, restricted to [start, stop].
    double push_during(double t, double dt) const {
        const double from = std::max(t, start), to = std::min(t + dt, stop);
        if (from >= to) return 0;
        const double h = to - from;
        return h / 6 * (mean_speed(from) + 4 * mean_speed(from + h / 2) + mean_speed(to));
    }

    double half_width() const { return shape.plane || shape.slot ? shape.width / 2 : shape.radius; }
    double half_thickness() const { return shape.plane ? 0 : shape.slot ? shape.thickness / 2 : shape.radius; }

    /// Fills the block with `count` relaxed random points in the pipe. @param period along the pipe [m]; 0: all in one cross-section
    void fill_pipe(long count, double period, std::uint64_t seed) {
        RandomNumbers random(seed);
        while (static_cast<long>(block.size()) < count) {
            const Vec3d q((2 * random() - 1) * half_width(), (2 * random() - 1) * half_thickness(), random() * period);
            if (pipe_distance(shape, q.cast<Real>()) < 0) block.push_back(q.cast<Real>());
        }
        Domain along;
        along.max = Vec3::Constant(static_cast<Real>(4 * (half_width() + half_thickness() + spacing)));
        along.min = -along.max;
        if (period > 0) {
            along.min.z() = 0;
            along.max.z() = static_cast<Real>(period);
            along.periodic[2] = true;
        }
        relax(
            block, [this](const Vec3& q) { return pipe_distance(shape, q); }, spacing, along, 300);
    }

    /// Plug flow moves as a whole: a periodic column of blue noise. Its length makes its volume a whole number of particles, so that the
    /// mass flow is exact.
    void make_column(std::uint64_t seed) {
        const long count = column_count();
        length = static_cast<double>(count) * volume() / opening_area(shape);
        fill_pipe(count, length, seed);
    }

    /// Parabolic flow shears a column, so layers of blue noise would slide past each other, and particles would meet. Instead, each
    /// particle of a blue noise in the cross-section repeats along its own streamline, with a random phase. Streamlines stay apart at any
    /// speed.
    void make_streamlines(std::uint64_t seed) {
        const long count = column_count();
        length = volume() * static_cast<double>(count) / opening_area(shape);
        fill_pipe(count, 0, seed);
        RandomNumbers random(seed + 1);
        for (Vec3& q : block) q.z() = static_cast<Real>(random() * length);
    }

    /// Relaxes the first particles of the column into positions behind `before`. @param before positions of the particles ahead of the
    /// column, in the opening's frame but with z against the flow
    void join(std::vector<Vec3> before) {
        const auto begin = static_cast<Real>(ahead);
        std::vector<Vec3> near;
        const auto moves = [&](const Vec3& q) { return q.z() < 2 * spacing; };
        for (const Vec3& q : block)
            for (Real copy = 0; copy < 6 * spacing; copy += static_cast<Real>(length))
                (copy == 0 && moves(q) ? near : before).push_back(q + Vec3(0, 0, begin + copy));
        relax(
            near, [&](const Vec3& q) { return std::max(pipe_distance(shape, q), -q.z()); }, spacing, {}, 100, before);
        first = block;
        for (std::size_t k = 0, n = 0; k < block.size(); ++k)
            if (moves(block[k])) first[k] = near[n++] - Vec3(0, 0, begin);
    }

    /// Whether free fluid is so near that it interacts with the particles in the pipe.
    bool meets_fluid(const ParticleStore& fluid) const {
        const auto x = fluid.column<field::position>();
        const auto role_of = fluid.column<field::role>();
        const Real near = Real(1.5) * spacing;
        return parallel_sum(fluid.size(), [&](Index i) { return role_of[i] >= 0 && body.distance(x[i]) < near ? 1 : 0; }) > 0;
    }

    /// Particles that enter while the column advances by `push`. A particle at height z of copy c of the block is at s = factor * pushed -
    /// (ahead + c length + z) along the flow, measured from the opening. It enters in the step at whose end s >= -depth.
    std::vector<Vec3> entering(double pushed_before, double push, std::vector<long>& next) const {
        std::vector<Vec3> all;
        for (std::size_t k = 0; k < block.size(); ++k) {
            for (;; ++next[k]) {
                const Vec3& q = next[k] == 0 ? first[k] : block[k];
                const double factor = profile(q.x(), q.y());
                const double z = ahead + static_cast<double>(next[k]) * length + q.z();
                if (z > factor * (pushed_before + push) + depth) break;
                all.push_back(world(Vec3(q.x(), q.y(), static_cast<Real>(factor * pushed_before - z))));
            }
        }
        return all;
    }

    /// Motion of the opening from t = 0 to t: x(t) = R x(0) + c.
    struct Motion {
        Mat3d R;
        Vec3d c;
    };
    Motion motion_to(double t) const {
        const Vec3d from = direction_of_time(0).normalized(), to = direction_of_time(t).normalized();
        const Mat3d R = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
        return {R, centre_of_time(t) - R * centre_of_time(0)};
    }
    void set_pose(const Pose& to) {
        pose = to;
        shape.centre = pose.rotation * shape_at_start.centre + pose.translation;
        shape.direction = pose.rotation * shape_at_start.direction;
        width_axis = pose.rotation * width_at_start, thickness_axis = pose.rotation * thickness_at_start;
        const std::array<Solid*, 3> parts{&body, &guarded, &end};
        for (std::size_t k = 0; k < parts.size(); ++k) {
            Pose& part = parts[k]->pose;
            part.rotation = pose.rotation * at_start[k].rotation;
            part.translation = pose.rotation * at_start[k].translation + pose.translation;
            parts[k]->repeats = Repeats(*parts[k]->shape, domain, part.rotation, part.translation);
        }
    }

    Vec3 world(const Vec3& q) const { return shape.centre + q.x() * width_axis + q.y() * thickness_axis + q.z() * shape.direction; }
    Vec3 local(const Vec3& x) const {
        const Vec3 r = x - shape.centre;
        return {r.dot(width_axis), r.dot(thickness_axis), r.dot(shape.direction)};
    }
};

Emitter::Emitter(EmitterShape shape, Expression speed, double start, double stop, Real spacing, Real depth, int number, std::uint64_t seed,
                 const Domain& domain, Real narrower)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.shape = shape.narrower(narrower);
    s.faster = opening_area(shape) / opening_area(s.shape);
    shape = s.shape;
    s.domain = domain;
    s.speed_of_time = std::move(speed);
    s.start = start;
    s.stop = stop;
    s.spacing = spacing;
    s.depth = depth;
    s.role = static_cast<std::int16_t>(-number);
    opening_axes(shape, s.width_axis, s.thickness_axis);
    s.body = nozzle_body(shape, depth, spacing, domain);
    s.end = nozzle_end(shape, depth, spacing, domain);
    shape.centre -= spacing * shape.direction;
    s.guarded = nozzle_body(shape, depth - spacing, spacing, domain);

    s.shape_at_start = s.shape;
    s.width_at_start = s.width_axis, s.thickness_at_start = s.thickness_axis;
    s.at_start = {s.body.pose, s.guarded.pose, s.end.pose};
    if (shape.parabolic) s.make_streamlines(seed);
    else s.make_column(seed);
    s.first = s.block;
    s.next_copy.assign(s.block.size(), 0);
}

Emitter::~Emitter() = default;
Emitter::Emitter(Emitter&&) noexcept = default;

void Emitter::follow(VectorExpression position, VectorExpression direction) {
    state_->centre_of_time = std::move(position), state_->direction_of_time = std::move(direction);
    state_->moving = state_->centre_of_time.depends_on_time() || state_->direction_of_time.depends_on_time();
}

void Emitter::set_time(double t) {
    if (!state_->moving) return;
    constexpr double dt = 1e-4;
    const State::Motion now = state_->motion_to(t), later = state_->motion_to(t + dt);
    const Eigen::AngleAxisd turn(later.R * now.R.transpose());
    state_->set_pose(
        {now.R.cast<Real>(), now.c.cast<Real>(), ((later.c - now.c) / dt).cast<Real>(), (turn.angle() / dt * turn.axis()).cast<Real>()});
}

void Emitter::enter(ParticleStore& fluid, double t, double dt) {
    State& s = *state_;
    set_time(t);
    if (t + dt < s.start && !s.full && !s.meets_fluid(fluid)) return;
    const double push = s.push_during(t, dt);

    const Index before = fluid.size();
    std::vector<Vec3> entering = s.entering(s.pushed, push, s.next_copy);
    const std::size_t first_placed = static_cast<std::size_t>(before) + entering.size();
    entering.insert(entering.end(), s.places.begin(), s.places.end());
    s.places.clear();
    fluid.resize(before + static_cast<Index>(entering.size()));
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    const auto role = fluid.column<field::role>();
    for (std::size_t k = 0; k < entering.size(); ++k) {
        x[before + k] = entering[k];
        role[before + k] = s.role;
    }

    const double speed = dt > 0 ? push / dt : 0;
    Mat3d turn = Mat3d::Identity();
    Vec3d shift = Vec3d::Zero();  // a point of the opening at x is at turn x + shift at the end of the step
    if (s.moving) {
        const State::Motion now = s.motion_to(t), next = s.motion_to(t + dt);
        turn = next.R * now.R.transpose(), shift = next.c - turn * now.c;
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (role[i] != s.role) continue;
        const Vec3 q = s.local(x[i]);
        // Particles that enter now start behind the end of the column, and reach it during this step.
        const bool moves = s.in_column(q) || (i >= static_cast<std::size_t>(before) && i < first_placed);
        u[i] = static_cast<Real>(moves ? speed * s.profile(q.x(), q.y()) : 0) * s.shape.direction;
        if (!s.moving || !(dt > 0)) continue;
        // The velocity that leads to the particle's place in the opening's frame at the end of the step.
        const Vec3d begin = x[i].cast<double>(), reached = turn * (begin + dt * u[i].cast<double>()) + shift;
        u[i] = ((reached - begin) / dt).cast<Real>();
    }
    s.pushed += push;
}

Index Emitter::release(ParticleStore& fluid, double t) {
    set_time(t);
    const State& s = *state_;
    const auto x = fluid.column<field::position>();
    const auto role = fluid.column<field::role>();
    Index released = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (role[i] == s.role && s.local(x[i]).z() >= 0) role[i] = 0, ++released;
    return released;
}

void Emitter::keep_out(ParticleStore& fluid) const {
    const State& s = *state_;
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    const auto role = fluid.column<field::role>();
    const Vec3 middle = s.shape.centre - s.depth / 2 * s.shape.direction;
    const Real reach = 2 * s.depth + static_cast<Real>(s.half_width() + s.half_thickness());
    parallel_for(fluid.size(), [&](Index i) {
        if (role[i] != 0 || s.domain.minimum_image(x[i] - middle).squaredNorm() > reach * reach) return;
        const Solid& near = s.end.distance(x[i]) < s.guarded.distance(x[i]) ? s.end : s.guarded;
        const Real distance = near.distance(x[i]);
        if (!(distance < s.apart())) return;
        const Vec3 n = near.normal(x[i]);
        x[i] += (s.apart() - distance) * n;
        const Vec3 relative = s.moving ? Vec3(u[i] - s.pose.velocity_at(x[i])) : u[i];
        if (const Real inward = relative.dot(n); inward < 0) u[i] -= inward * n;
    });
}

std::vector<Vec3> Emitter::filling() const {
    std::vector<long> none(state_->block.size(), 0);
    return state_->entering(0, 0, none);
}

void Emitter::be_full(std::vector<Vec3> places) {
    State& s = *state_;
    std::vector<Vec3> before;
    for (const Vec3& x : places)
        if (const Vec3 q = s.local(x); s.in_column(q)) before.emplace_back(q.x(), q.y(), -q.z());
    for (const Vec3& q : before) s.ahead = std::max(s.ahead, static_cast<double>(q.z() + s.spacing / 2));
    if (!s.shape.parabolic) s.join(std::move(before));
    s.full = true, s.places = std::move(places);
}

bool Emitter::is_full() const { return state_->full; }

void Emitter::close(double t) { state_->stop = std::min(state_->stop, t); }

bool Emitter::takes(const Vec3& x) const {
    const State& s = *state_;
    return s.body.distance(x) < 0 || std::min(s.end.distance(x), s.guarded.distance(x)) < s.apart();
}

Real Emitter::distance(const Vec3& x) const { return std::min(state_->body.distance(x), state_->end.distance(x)); }

double Emitter::expected_particles() const { return state_->pushed * opening_area(state_->shape) / state_->volume(); }

double Emitter::speed(double t) const { return state_->peak() * state_->mean_speed(t); }

const EmitterShape& Emitter::shape() const { return state_->shape; }

const Pose& Emitter::pose() const { return state_->pose; }

void Emitter::change(Expression speed, double start, double stop) {
    state_->speed_of_time = std::move(speed);
    state_->start = start, state_->stop = stop;
}

void Emitter::save(std::ostream& out) const {
    out.write(reinterpret_cast<const char*>(&state_->pushed), sizeof(double));
    out.write(reinterpret_cast<const char*>(state_->next_copy.data()),
              static_cast<std::streamsize>(state_->next_copy.size() * sizeof(long)));
}

bool Emitter::load(std::istream& in) {
    in.read(reinterpret_cast<char*>(&state_->pushed), sizeof(double));
    in.read(reinterpret_cast<char*>(state_->next_copy.data()), static_cast<std::streamsize>(state_->next_copy.size() * sizeof(long)));
    if (!in) throw EnvironmentError("the saved state of an emitter ends too early", "", "resume from an older checkpoint");
    // Rejects a damaged state. In a valid one, the entered copies of each particle of the block have kept up with the flow; otherwise the
    // next step would add copies almost without end.
    const State& s = *state_;
    if (!std::isfinite(s.pushed) || s.pushed < 0) return false;
    for (std::size_t k = 0; k < s.block.size(); ++k) {
        const double entered = static_cast<double>(s.next_copy[k]) * s.length,
                     flowed = s.profile(s.block[k].x(), s.block[k].y()) * s.pushed;
        if (s.next_copy[k] < 0 || s.ahead + entered + s.length < (1 - 1e-6) * flowed) return false;
    }
    return true;
}

}  // namespace whorl
