/// Kinetic energy and enstrophy of a run at given times.
#include <CLI/CLI.hpp>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/scene/names.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tests/support/micropolar_flows.h"
#include "tools/measure/solver/subcommands.h"

namespace whorl {
namespace {

/// Per kg: kinetic energy, that of the motion across the stream (y), and enstrophy.
struct Measured {
    double energy = 0, across = 0, enstrophy = 0;  ///< J, J, 1/s^2
};

/// sum_j V_j (u_i - u_j) x grad W_ij
template <class Kernel>
Vec3 difference_curl(const World& w, Index i, const Kernel& kernel) {
    const auto u = w.fluid.column<field::velocity>();
    const auto rho = w.fluid.column<field::density>();
    Vec3 sum = Vec3::Zero();
    w.fluid_pairs.of(
        i, [&](Index j, const Vec3& r, Real distance) { sum += w.step.mass / rho[j] * kernel.slope(distance) * (u[i] - u[j]).cross(r); });
    return sum;
}

Measured measured(const World& w) {
    const auto u = w.fluid.column<field::velocity>();
    const double n = w.fluid.size();
    const auto mean = [&](const auto& f) {
        return parallel_sum(w.fluid.size(), [&](Index i) { return 0.5 * static_cast<double>(f(i)); }) / n;
    };
    return with_kernel(w.step.kernel, w.step.support, [&](const auto& kernel) {
        return Measured{mean([&](Index i) { return u[static_cast<std::size_t>(i)].squaredNorm(); }),
                        mean([&](Index i) { return u[static_cast<std::size_t>(i)].y() * u[static_cast<std::size_t>(i)].y(); }),
                        mean([&](Index i) { return difference_curl(w, i, kernel).squaredNorm(); })};
    });
}

/// Ends early where the run diverges.
void print_vorticity(const std::string& file, const std::vector<std::string>& changes, const std::vector<double>& times) {
    ReadRequest request;
    for (const std::string& change : changes) request.changes.push_back(parse_change(change));
    const Scene scene = read_scene(file, request);
    Simulation simulation(scene, make_plan(scene));
    print_csv("time", "energy", "energy_across", "enstrophy");
    for (const double time : times) {
        while (simulation.time() < time)
            if (simulation.step(time).diverged) return;
        const Measured m = measured(simulation.world());
        print_csv(time, m.energy, m.across, m.enstrophy);
    }
}

}  // namespace

void add_vorticity(CLI::App& program) {
    struct Keys {
        std::string scene;
        std::vector<std::string> changes;
        std::vector<double> times;
    };
    const auto keys = std::make_shared<Keys>();
    CLI::App* app = program.add_subcommand("vorticity", "kinetic energy, that across the stream, and enstrophy of a run, per kg");
    app->add_option("scene", keys->scene)->required();
    app->add_option("--set", keys->changes, "KEY=VALUE of the scene")->allow_extra_args(false);
    app->add_option("--times", keys->times, "s")->required();
    app->callback([keys] { print_vorticity(keys->scene, keys->changes, keys->times); });
}

namespace {

/// The first Laplacian at R = 2 d, the second at 4 d, which it needs on a lattice (docs/physics.md 4).
void print_row(CurlForm velocity, CurlForm spin, bool central) {
    const test::Micropolar2 flow{1, 1.5, 0.02, 0.05}, blob{0.05, 0.05, 1e-4, 2e-3};
    MicropolarOptions forms;
    forms.curl_velocity = velocity;
    forms.curl_spin = spin;
    forms.implicit_exchange = false;
    const double support = central ? 4 : 2;
    const test::VortexError coarse = taylor_green_error(flow, forms, central, 16, support),
                            fine = taylor_green_error(flow, forms, central, 32, support);
    const test::VortexError uneven = taylor_green_error(flow, forms, central, 32, support, 0.1);
    const test::Drift drift = blob_drift(blob, forms, central, 200);
    print_csv(name_of(velocity), name_of(spin), central ? "monaghan" : "brookshaw", fine.velocity,
              std::log2(coarse.velocity / fine.velocity), fine.spin, std::log2(coarse.spin / fine.spin), uneven.velocity, uneven.spin,
              drift.momentum, drift.angular_momentum, drift.exchange);
}

}  // namespace

void add_curls(CLI::App& program) {
    program.add_subcommand("curls", "error, order and conservation of the 3 x 3 pairs of curls and the two Laplacians")->callback([] {
        print_csv("curl_velocity", "curl_spin", "laplacian", "velocity_error", "velocity_order", "spin_error", "spin_order",
                  "uneven_velocity_error", "uneven_spin_error", "momentum", "angular_momentum", "energy");
        for (const bool central : {false, true})
            for (const auto& [velocity, velocity_name] : choices(CurlForm{}))
                for (const auto& [spin, spin_name] : choices(CurlForm{})) print_row(velocity, spin, central);
    });
}

}  // namespace whorl
