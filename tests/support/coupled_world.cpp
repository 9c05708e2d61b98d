#include "tests/support/coupled_world.h"

#include <random>

namespace whorl::test {

CoupledWorld::CoupledWorld(const std::vector<Vec3>& x, Real spacing, Real nu, CoupledOptions options)
    : system(std::make_shared<CoupledSystem>(options)), viscosity_(1000 * nu) {
    stages.push_back(make_stage("rows", "neighbours", CoupledNeighbourhood{system}));
    stages.push_back(make_stage("gradient", "solve", CoupledGradient{system}));
    stages.push_back(make_stage("solve", "solve", CoupledSolve{system}));
    stages.push_back(make_stage("move", "move", CoupledMove{system}));
    stages.push_back(make_stage("shift", "shift", CoupledShift{system}));
    stages.push_back(make_stage("contact", "contact", CoupledContact{system}));
    for (const Stage& stage : stages)
        for (const FieldAccess& access : stage.accesses) world.fluid.declare(*access.field, true);
    world.step.spacing = spacing;
    world.step.volume = spacing * spacing * spacing;
    world.step.rest_density = 1000;
    world.step.mass = 1000 * world.step.volume;
    add(x);
}

Index CoupledWorld::add(const std::vector<Vec3>& x) {
    const Index old = world.fluid.size();
    world.fluid.resize(old + static_cast<Index>(x.size()));
    std::copy(x.begin(), x.end(), position().begin() + old);
    auto mu = world.fluid.column<field::viscosity>();
    std::fill(mu.begin() + old, mu.end(), viscosity_);
    return old;
}

void CoupledWorld::run(std::size_t count, Real dt, bool at_frame_time) {
    world.step.dt = dt;
    world.step.time = time;
    world.step.at_frame_time = at_frame_time;
    world.report = {};
    world.solids.set_time(time, dt);
    for (std::size_t k = 0; k < count; ++k) {
        const double start = wall_seconds(), cpu = cpu_seconds();
        stages[k].run(world);
        StageTime& t = times[stages[k].group];
        t.wall += wall_seconds() - start, t.cpu += cpu_seconds() - cpu, ++t.calls;
        seconds += wall_seconds() - start;
    }
}

bool CoupledWorld::step(Real dt, bool at_frame_time) {
    run(stages.size(), dt, at_frame_time);
    time += dt;
    return last_solve().converged;
}

bool CoupledWorld::solve_only(Real dt) {
    run(3, dt, true);
    return last_solve().converged;
}

std::vector<Vec3> blue_noise_cylinder(Real radius, Real length, Real d, unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    const double a = radius, L = length, range = 1.6 * d;
    const auto count = static_cast<std::size_t>(std::round(std::numbers::pi * a * a * L / (double(d) * d * d)));
    std::vector<Vec3d> x(count);
    for (Vec3d& p : x) {
        const double r = a * std::sqrt(uniform()), t = 2 * std::numbers::pi * uniform();
        p = {r * std::cos(t), L * uniform(), r * std::sin(t)};
    }
    const int rounds = 200;
    for (int round = 0; round < rounds; ++round) {
        // Images beyond the periodic ends and mirrored in the wall.
        std::vector<Vec3d> all = x;
        for (const Vec3d& p : x) {
            const double r = std::hypot(p[0], p[2]);
            if (r > 1e-9 && 2 * a - 2 * r < 2 * range) all.emplace_back(p[0] * (2 * a - r) / r, p[1], p[2] * (2 * a - r) / r);
        }
        for (std::size_t k = 0, n = all.size(); k < n; ++k) {
            if (all[k][1] < range) all.emplace_back(all[k] + Vec3d(0, L, 0));
            if (all[k][1] > L - range) all.emplace_back(all[k] - Vec3d(0, L, 0));
        }
        std::vector<std::vector<std::size_t>> slices(static_cast<std::size_t>((L + 2 * range) / range) + 2);
        const auto slice = [&](double y) { return static_cast<std::size_t>((y + range) / range); };
        for (std::size_t k = 0; k < all.size(); ++k) slices[slice(all[k][1])].push_back(k);
        const double step = 0.5 * (1 - 0.7 * round / rounds) * d;
        std::vector<Vec3d> moved = x;
        for (std::size_t i = 0; i < x.size(); ++i) {
            Vec3d dx = Vec3d::Zero();
            const std::size_t own = slice(x[i][1]);
            for (std::size_t k = own - 1; k <= own + 1; ++k)
                for (std::size_t j : slices[k]) {
                    const Vec3d r = x[i] - all[j];
                    const double l = r.norm();
                    if (j == i || l > range || l < 1e-10) continue;
                    dx += r / l * (1 - l / range) * (1 - l / range) * step;
                }
            if (dx.norm() > 0.2 * d) dx *= 0.2 * d / dx.norm();
            Vec3d& p = moved[i];
            p += dx;
            const double r = std::hypot(p[0], p[2]), most = a - 0.25 * d;
            if (r > most) p[0] *= most / r, p[2] *= most / r;
            p[1] -= L * std::floor(p[1] / L);
        }
        x = moved;
    }
    std::sort(x.begin(), x.end(), [](const Vec3d& p, const Vec3d& q) { return p[1] < q[1]; });
    std::vector<Vec3> out;
    for (const Vec3d& p : x) out.push_back(p.cast<Real>());
    return out;
}

double longest_link(const std::vector<Vec3d>& x) {
    std::vector<double> nearest(x.size(), 1e30);
    std::vector<bool> joined(x.size(), false);
    double longest = 0;
    for (std::size_t step = 0, at = 0; step + 1 < x.size(); ++step) {
        joined[at] = true;
        std::size_t next = 0;
        double least = 1e30;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (joined[i]) continue;
            nearest[i] = std::min(nearest[i], (x[i] - x[at]).norm());
            if (nearest[i] < least) least = nearest[i], next = i;
        }
        longest = std::max(longest, least);
        at = next;
    }
    return longest;
}

}  // namespace whorl::test
