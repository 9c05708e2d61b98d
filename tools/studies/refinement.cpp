#include <fmt/format.h>

#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "engine/sph/operators.h"
#include "tools/studies/studies.h"

namespace whorl {
namespace {

/// The vortex of Taylor and Green (1937) in a box of length 1: cells of vortices that stretch each other.
const std::string vortex = R"toml([time]
end = 0.8
[domain]
min = [0, 0, 0]
max = [1, 1, 1]
periodic = [true, true, true]
gravity = [0, 0, 0]
[fluid]
spacing = 0.0625
viscosity = 1
[models]
pressure = "wcsph"
viscosity = "explicit"
[pressure]
sound_speed = 10
background_pressure = 1000
sound_damping = 0
artificial_viscosity = 0
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
velocity = ["sin(2*pi*x)*cos(2*pi*y)*cos(2*pi*z)", "-cos(2*pi*x)*sin(2*pi*y)*cos(2*pi*z)", "0"]
)toml";

struct Measured {
    double energy = 0, enstrophy = 0;  ///< J and J/m^2 per kg
};

Measured measured(const World& w) {
    const auto u = w.fluid.column<field::velocity>();
    const auto rho = w.fluid.column<field::density>();
    std::vector<Real> V(rho.size());
    for (std::size_t i = 0; i < V.size(); ++i) V[i] = w.step.mass / rho[i];
    const double n = w.fluid.size();
    return with_kernel(w.step.kernel, w.step.support, [&](const auto& W) {
        Measured all;
        all.energy = parallel_sum(w.fluid.size(), [&](Index i) { return 0.5 * static_cast<double>(u[static_cast<std::size_t>(i)].squaredNorm()); }) / n;
        all.enstrophy = parallel_sum(w.fluid.size(), [&](Index i) {
            return 0.5 * static_cast<double>(curl(w.fluid_pairs, i, W, Span<const Real>(V), u).squaredNorm());
        }) / n;
        return all;
    });
}

std::vector<Measured> run(const std::vector<std::string>& changes, const std::vector<double>& times) {
    ReadRequest request;
    for (const std::string& change : changes) request.changes.push_back(parse_change(change));
    const Scene scene = read_scene_text(vortex, "vortex.toml", request);
    Simulation simulation(scene, make_plan(scene));
    std::vector<Measured> rows;
    for (const double time : times) {
        while (simulation.time() < time)
            if (simulation.step(time).diverged) return rows;
        rows.push_back(measured(simulation.world()));
    }
    return rows;
}

}  // namespace

std::string refinement_table() {
    const std::vector<double> times{0.1, 0.2, 0.3, 0.4, 0.6, 0.8};
    const std::vector<std::string> spin{"models.micropolar=seed", "micropolar.transfer_viscosity=0.8", "micropolar.micro_inertia=2.5e-4",
                                        "micropolar.xsph_spin=0", "micropolar.xsph_velocity=0"};
    const std::vector<Measured> coarse = run({}, times), with = run(spin, times), fine = run({"fluid.spacing=0.03125"}, times);
    std::string table =
        "| t [s] | energy: coarse | coarse with spin | fine | enstrophy: coarse | coarse with spin | fine |\n|---|---|---|---|---|---|---|\n";
    for (std::size_t k = 0; k < times.size(); ++k) {
        const auto at = [&](const std::vector<Measured>& rows) { return k < rows.size() ? rows[k] : Measured{}; };
        table += fmt::format("| {:.1f} | {:.4f} | {:.4f} | {:.4f} | {:.2f} | {:.2f} | {:.2f} |\n", times[k], at(coarse).energy, at(with).energy, at(fine).energy,
                             at(coarse).enstrophy, at(with).enstrophy, at(fine).enstrophy);
    }
    return table;
}

}  // namespace whorl
