#include "engine/theory/coil_theory.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/binary_io.h"
#include "engine/core/types.h"
#include "engine/math/boundary_value.h"

namespace whorl {
namespace {

/// Dimensionless parameters, with the symbols of coil_theory.h; index 0: at the nozzle, nu = eta/rho. Scales: the fall H for lengths, U0
/// for speeds, 3 eta A0 U0/H for N, 3 eta I0 U0/H^2 for M.
struct ThreadNumbers {
    double gravity = 0;      ///< G = g H^2/(3 nu U0)
    double inertia = 0;      ///< Re = U0 H/(3 nu)
    double capillarity = 0;  ///< Ca = gamma H/(3 eta a0 U0)
    double slenderness = 0;  ///< e = a0/H
};

ThreadNumbers numbers_of(const CoilParameters& p) {
    const double viscous = 3 * p.viscosity * p.speed;
    return {p.gravity * p.fall * p.fall / viscous, p.speed * p.fall / (3 * p.viscosity),
            p.surface_tension * p.fall / (viscous * p.nozzle_radius), p.nozzle_radius / p.fall};
}

/// The equations of the thread, as a family of problems with the parameter `depth`. The numbers of `full`, except slenderness, are
/// multiplied by (exp(depth) - 1)/(exp(full_depth) - 1), so depth 0 is infinite viscosity and full_depth is the requested problem. In
/// addition to the 16 functions, ln Omega, ln L and the depth are unknowns. The last condition is turn_weight ln Omega + depth_weight depth
/// = distance.
struct ThreadProblem {
    static constexpr int functions = 19, start_conditions = 10;
    enum At { x_at = 0, t_at = 3, u_at = 6, w_at = 7, n_at = 10, m_at = 13, omega_at = 16, length_at = 17, depth_at = 18 };  ///< u = ln U
    template <class T>
    using Vector3 = Vector<T, 3>;

    ThreadNumbers full;  ///< numbers at the depth `full_depth`
    double full_depth = 0;
    double turn_weight = 0, depth_weight = 1, distance = 0;  ///< coefficients and right-hand side of the last condition

    template <class T>
    T share(const T& depth) const {
        using std::exp;
        return full_depth > 0 ? T((exp(depth) - T(1)) * T(1 / std::expm1(full_depth))) : T(0);
    }

    template <class T>
    Vector<T, functions> slope(const Vector<T, functions>& y) const {
        using std::exp;
        const Vector3<T> x = y.template segment<3>(x_at), t = y.template segment<3>(t_at), w = y.template segment<3>(w_at),
                         N = y.template segment<3>(n_at), M = y.template segment<3>(m_at);
        const T U = exp(y[u_at]), slowness = exp(-y[u_at]), Omega = exp(y[omega_at]), L = exp(y[length_at]), part = share(y[depth_at]);
        const T G = part * T(full.gravity), Re = part * T(full.inertia), Ca = part * T(full.capillarity);
        const double e = full.slenderness;

        const Vector3<T> W(T(0), T(0), Omega), t_slope = slowness * (w - W).cross(t);
        const T u_slope = t.dot(N) - Ca * exp(T(-0.5) * y[u_at]);
        const Vector3<T> acceleration = U * U * (u_slope * t + t_slope) + T(2) * U * W.cross(t) + W.cross(W.cross(x));
        Vector<T, functions> f;
        f.template segment<3>(x_at) = L * t;
        f.template segment<3>(t_at) = L * t_slope;
        f[u_at] = L * u_slope;
        f.template segment<3>(w_at) = L * U * U * (M + T(0.5) * t.dot(M) * t);
        f.template segment<3>(n_at) = L * slowness * (Re * acceleration + G * Vector3<T>(T(0), T(0), T(1)));
        f.template segment<3>(m_at) = T(-4 / (e * e)) * L * t.cross(N);
        f.template tail<3>() = Vector3<T>(T(0), T(0), T(0));
        return f;
    }

    template <class T>
    Vector<T, start_conditions> at_start(const Vector<T, functions>& y) const {
        Vector<T, start_conditions> miss = y.template head<start_conditions>();  // x, t, u, w
        miss[t_at + 2] += T(1);
        return miss;
    }

    template <class T>
    Vector<T, functions - start_conditions> at_end(const Vector<T, functions>& y) const {
        using std::exp;
        const T U = exp(y[u_at]), Omega = exp(y[omega_at]), radius = T(full.slenderness) * exp(T(-0.5) * y[u_at]);
        Vector<T, functions - start_conditions> miss;
        miss << y[x_at + 2] + T(1) - radius, U * y[t_at] - Omega * y[x_at + 1], U * y[t_at + 1] + Omega * y[x_at], y[t_at + 2], y[w_at],
            y[w_at + 1], y[w_at + 2], y[x_at + 1], T(turn_weight) * y[omega_at] + T(depth_weight) * y[depth_at] - T(distance);
        return miss;
    }
};

using Thread = Curve<ThreadProblem::functions>;
using Solver = Collocation<ThreadProblem>;

double turning(const Thread& thread) { return thread.y.front()[ThreadProblem::omega_at]; }
double depth(const Thread& thread) { return thread.y.front()[ThreadProblem::depth_at]; }

/// Whether the thread is a single loop: its foot has x > 0, it is 1 to 4 falls long, and it nowhere runs nearly straight up.
bool is_coil(const Thread& thread) {
    const auto& foot = thread.y.back();
    const double length = foot[ThreadProblem::length_at];
    return foot[ThreadProblem::x_at] > 0 && length > 0 && length < std::log(4.0) &&
           std::all_of(thread.y.begin(), thread.y.end(), [](const auto& y) { return y[ThreadProblem::t_at + 2] < 0.9; });
}

/// First guess without gravity and inertia: a quintic curve of constant speed from nozzle to foot, with the right slope and curvature at
/// both ends.
Thread first_guess(double slenderness, double omega, double radius) {
    constexpr int intervals = 80, fine = 25;  // intervals of the mesh, and points of the curve in each
    constexpr double rate = 1.15;             // |dx/dq| at the ends, about the length
    const Vec3d down(0, 0, -rate), foot(radius, 0, -1), along(0, -rate, 0), inward(-rate * rate / radius, 0, 0);
    const auto place = [&](double q) -> Vec3d {
        const double a = q * q * q, b = a * q, c = b * q;
        return (q - 6 * a + 8 * b - 3 * c) * down + (a / 2 - b + c / 2) * inward + (-4 * a + 7 * b - 3 * c) * along +
               (10 * a - 15 * b + 6 * c) * foot;
    };
    std::vector<Vec3d> points;
    std::vector<double> lengths;
    for (int k = 0; k <= fine * intervals; ++k) {
        points.push_back(place(static_cast<double>(k) / (fine * intervals)));
        lengths.push_back(k == 0 ? 0 : lengths.back() + (points.back() - points[points.size() - 2]).norm());
    }
    const double length = lengths.back(), ds = length / intervals;
    using Field = std::vector<Vec3d>;
    Field x;
    std::size_t i = 0;
    for (int k = 0; k <= intervals; ++k) {
        while (i + 2 < points.size() && lengths[i + 1] < k * ds) ++i;
        x.push_back(points[i] + (k * ds - lengths[i]) / (lengths[i + 1] - lengths[i]) * (points[i + 1] - points[i]));
    }
    const auto slope = [&](const Field& f) {
        Field g(f.size());
        for (std::size_t k = 0; k < f.size(); ++k) {
            const std::size_t from = k == 0 ? 0 : k - 1, to = std::min(k + 1, f.size() - 1);
            g[k] = (f[to] - f[from]) / (static_cast<double>(to - from) * ds);
        }
        return g;
    };
    Field t = slope(x), w(x.size()), M(x.size());
    for (Vec3d& tangent : t) tangent.normalize();
    t.front() = -Vec3d::UnitZ(), t.back() = -Vec3d::UnitY();
    const Field t_slope = slope(t);
    for (std::size_t k = 1; k + 1 < w.size(); ++k) w[k] = t[k].cross(t_slope[k]) + omega * (Vec3d::UnitZ() - t[k].z() * t[k]);
    w.front() = w.back() = Vec3d::Zero();
    const Field w_slope = slope(w);
    for (std::size_t k = 0; k < M.size(); ++k) M[k] = w_slope[k] - w_slope[k].dot(t[k]) / 3 * t[k];
    const Field M_slope = slope(M);
    Thread thread;
    for (std::size_t k = 0; k < x.size(); ++k) {
        Vector<double, ThreadProblem::functions> y;
        y << x[k], t[k], 0, w[k], slenderness * slenderness / 4 * t[k].cross(M_slope[k]), M[k], std::log(omega), std::log(length), 0;
        thread.s.push_back(static_cast<double>(k) / intervals);
        thread.y.push_back(y);
    }
    return thread;
}

/// Follows the branch of coils with a limited number of linear solves.
class Follower {
public:
    Follower(const ThreadNumbers& numbers, const std::atomic<bool>* give_up) : give_up_(give_up) {
        problem_.full = numbers;
        // Bending resists a gravity G of up to the order of e^2, so for a thin thread the branch starts at numbers of that order.
        const double little = std::min(1.0, std::pow(numbers.slenderness / 0.05, 2));
        problem_.full_depth = std::log1p(std::max({numbers.gravity, numbers.inertia, numbers.capillarity}) / little);
    }

    /// The requested coil, continued from a coil with similar parameters.
    std::optional<Thread> from_neighbour(const Thread& neighbour) { return settled(at_depth(neighbour, problem_.full_depth)); }
    /// The requested coil, continued from infinite viscosity.
    std::optional<Thread> from_infinite_viscosity();
    int effort() const { return effort_; }

private:
    static constexpr int coarse = 60;  ///< intervals while following the branch

    bool solve(Thread& thread, int most_steps) {
        if (effort_ >= CoilSolver::most_effort || (give_up_ && *give_up_)) return false;
        const SolveReport report = Solver::solve(problem_, thread, {1e-7, most_steps});
        effort_ += report.iterations;
        return report.converged && is_coil(thread);
    }
    Thread on_even_mesh(const Thread& thread, int intervals) const {
        return Solver::on_mesh(problem_, thread, Solver::even_mesh(problem_, thread, intervals));
    }
    void hold_depth(double depth) { problem_.turn_weight = 0, problem_.depth_weight = 1, problem_.distance = depth; }
    std::optional<Thread> at_depth(const Thread& neighbour, double depth);
    std::optional<Thread> without_gravity();
    std::optional<Thread> next(const Thread& before, const Thread& now, double& stride);
    std::optional<Thread> settled(std::optional<Thread> thread);

    ThreadProblem problem_;
    const std::atomic<bool>* give_up_;
    int effort_ = 0;
};

std::optional<Thread> Follower::at_depth(const Thread& neighbour, double depth) {
    hold_depth(depth);
    Thread thread = on_even_mesh(neighbour, coarse);
    for (auto& y : thread.y) y[ThreadProblem::depth_at] = depth;
    if (!solve(thread, 12)) return std::nullopt;
    return thread;
}

/// The purely viscous coil: guessed for a thread of medium slenderness, then continued to the requested slenderness.
std::optional<Thread> Follower::without_gravity() {
    hold_depth(0);
    const double wanted = problem_.full.slenderness, guessed = std::clamp(wanted, 0.02, 0.08);
    const int strides = static_cast<int>(std::ceil(std::abs(std::log(wanted / guessed)) / 0.25));
    std::optional<Thread> thread;
    problem_.full.slenderness = guessed;
    for (const auto& [omega, radius] : {std::pair{4.1, 0.235}, {3.5, 0.28}, {3.0, 0.3}, {5.0, 0.2}}) {
        thread = first_guess(guessed, omega, radius);
        if (solve(*thread, 30)) break;
        thread.reset();
    }
    for (int k = 1; k <= strides && thread; ++k) {
        problem_.full.slenderness = guessed * std::pow(wanted / guessed, static_cast<double>(k) / strides);
        thread = at_depth(*thread, 0);
    }
    problem_.full.slenderness = wanted;
    return thread;
}

/// The next coil along the branch, at the distance `stride` in the plane of ln Omega and depth. This pseudo-arclength continuation (Keller
/// 1977) also passes folds. @param stride (in, out) adapted to the convergence
std::optional<Thread> Follower::next(const Thread& before, const Thread& now, double& stride) {
    constexpr double longest = 0.5, shortest = 2e-4;
    const double d_turning = turning(now) - turning(before), d_depth = depth(now) - depth(before), apart = std::hypot(d_turning, d_depth);
    const std::vector<double> mesh = Solver::even_mesh(problem_, now, coarse);
    const Thread from = Solver::on_mesh(problem_, before, mesh), here = Solver::on_mesh(problem_, now, mesh);
    problem_.turn_weight = d_turning / apart, problem_.depth_weight = d_depth / apart;
    for (; stride > shortest && effort_ < CoilSolver::most_effort; stride /= 2) {
        problem_.distance = problem_.turn_weight * turning(now) + problem_.depth_weight * depth(now) + stride;
        Thread thread = here;
        for (std::size_t i = 0; i < thread.y.size(); ++i) thread.y[i] += stride / apart * (here.y[i] - from.y[i]);
        if (!solve(thread, 8)) continue;
        // After a long stride, a sharp turn may mean that another branch was reached.
        const double went = std::hypot(turning(thread) - turning(now), depth(thread) - depth(now));
        if (stride / went < (stride > 0.03 ? 0.85 : 0.3) || depth(thread) < -1e-6) continue;
        stride = std::min(longest, 1.5 * stride);
        return thread;
    }
    return std::nullopt;
}

std::optional<Thread> Follower::from_infinite_viscosity() {
    constexpr int most_strides = 400;
    auto before = without_gravity();
    if (!before) return std::nullopt;
    const double goal = problem_.full_depth;
    double stride = std::min(0.05, goal);
    auto now = at_depth(*before, stride);
    for (; !now && stride > 1e-4; stride /= 3) now = at_depth(*before, stride / 3);
    if (!now) return std::nullopt;
    stride = 0.1;
    for (int k = 0; depth(*now) < goal; ++k) {
        auto further = k < most_strides ? next(*before, *now, stride) : std::nullopt;
        if (!further) return std::nullopt;
        before = std::move(now), now = std::move(further);
    }
    // The goal lies between the last two coils.
    const double part = depth(*now) > depth(*before) ? (goal - depth(*before)) / (depth(*now) - depth(*before)) : 1;
    Thread between = Solver::on_mesh(problem_, *before, now->s);
    for (std::size_t i = 0; i < between.y.size(); ++i) between.y[i] += part * (now->y[i] - between.y[i]);
    return settled(at_depth(between, goal));
}

/// Solves on finer and finer meshes, until frequency and radius change by less than 1e-4.
std::optional<Thread> Follower::settled(std::optional<Thread> thread) {
    for (int intervals = 2 * coarse; thread && intervals <= 8 * coarse; intervals *= 2) {
        Thread finer = on_even_mesh(*thread, intervals);
        if (!solve(finer, 8)) return std::nullopt;
        const double change = std::abs(turning(finer) - turning(*thread)) +
                              std::abs(std::log(finer.y.back()[ThreadProblem::x_at] / thread->y.back()[ThreadProblem::x_at]));
        thread = std::move(finer);
        if (change < 1e-4) return thread;
    }
    return std::nullopt;
}

CoilTheory with_dimensions(const Thread& thread, const CoilParameters& p) {
    const auto& foot = thread.y.back();
    CoilTheory theory;
    theory.frequency = std::exp(foot[ThreadProblem::omega_at]) * p.speed / p.fall / (2 * std::numbers::pi);
    theory.radius = foot[ThreadProblem::x_at] * p.fall;
    theory.thread_radius = p.nozzle_radius * std::exp(-foot[ThreadProblem::u_at] / 2);
    theory.length = std::exp(foot[ThreadProblem::length_at]) * p.fall;
    return theory;
}

}  // namespace

double relative_change(const CoilParameters& a, const CoilParameters& b) {
    double largest = 0;
    const auto compare = [&](double p, double q) {
        if (p == q) return;
        const double change = std::abs(p - q) / std::min(std::abs(p), std::abs(q));
        if (!(change <= largest)) largest = change;  // NaN differs from everything
    };
    compare(a.nozzle_radius, b.nozzle_radius), compare(a.speed, b.speed), compare(a.viscosity, b.viscosity);
    compare(a.gravity, b.gravity), compare(a.fall, b.fall), compare(a.surface_tension, b.surface_tension);
    return largest;
}

struct CoilSolver::State {
    CoilParameters parameters;  ///< those of `last`
    std::optional<Thread> last;
    int effort = 0;
};

CoilSolver::CoilSolver() : state_(std::make_unique<State>()) {}
CoilSolver::~CoilSolver() = default;
CoilSolver::CoilSolver(CoilSolver&&) noexcept = default;
CoilSolver& CoilSolver::operator=(CoilSolver&&) noexcept = default;

std::optional<CoilTheory> CoilSolver::at(const CoilParameters& p, const std::atomic<bool>* give_up) {
    state_->effort = 0;
    if (!(p.nozzle_radius > 0 && p.speed > 0 && p.viscosity > 0 && p.gravity >= 0 && p.fall > p.nozzle_radius && p.surface_tension >= 0))
        return std::nullopt;
    Follower follower(numbers_of(p), give_up);
    std::optional<Thread> thread;
    if (state_->last && relative_change(p, state_->parameters) <= 0.1) {
        thread = follower.from_neighbour(*state_->last);
        if (thread && std::abs(turning(*thread) - turning(*state_->last)) > 0.3) thread.reset();
    }
    if (!thread) thread = follower.from_infinite_viscosity();
    state_->effort = follower.effort();
    state_->last = thread;
    state_->parameters = p;
    if (!thread) return std::nullopt;
    const CoilTheory theory = with_dimensions(*thread, p);
    if (!(theory.radius > theory.thread_radius)) return std::nullopt;
    return theory;
}

int CoilSolver::effort() const { return state_->effort; }

void CoilSolver::save(std::ostream& out) const {
    put(out, state_->parameters);
    const std::size_t nodes = state_->last ? state_->last->s.size() : 0;
    put(out, nodes);
    for (std::size_t i = 0; i < nodes; ++i) {
        put(out, state_->last->s[i]);
        for (const double value : state_->last->y[i]) put(out, value);
    }
}

void CoilSolver::load(std::istream& in) {
    take(in, state_->parameters);
    std::size_t nodes = 0;
    take(in, nodes);
    if (!in || nodes > 100'000) return state_->last.reset();
    Thread thread;
    thread.s.resize(nodes), thread.y.resize(nodes);
    for (std::size_t i = 0; i < nodes; ++i) {
        take(in, thread.s[i]);
        for (double& value : thread.y[i]) take(in, value);
    }
    state_->last.reset();
    if (in && nodes > 1) state_->last = std::move(thread);
}

}  // namespace whorl
