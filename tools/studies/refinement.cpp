#include <fmt/format.h>

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "engine/sph/operators.h"
#include "tools/studies/studies.h"

namespace whorl {
namespace {

/// The vortex of Taylor and Green (1937) in a box of length 1: cells of vortices that stretch each other. Reynolds number 1000.
const std::string vortex = R"toml([time]
end = 2
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
gradient = "difference"
artificial_viscosity = 0
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
velocity = ["sin(2*pi*x)*cos(2*pi*y)*cos(2*pi*z)", "-cos(2*pi*x)*sin(2*pi*y)*cos(2*pi*z)", "0"]
)toml";

/// A stream past a cylinder, Reynolds number 200, between banks without friction; a slab of four layers of particles.
const std::string street = R"toml([time]
end = 2
[domain]
min = [-0.06, -0.045, 0.0]
max = [ 0.22,  0.045, 0.0133334]
periodic = [true, false, true]
gravity = [0.05, 0, 0]
[fluid]
spacing = 3.33333e-3
viscosity = 0.03
[models]
pressure = "wcsph"
viscosity = "explicit"
[pressure]
sound_speed = 4
background_pressure = 300
gradient = "difference"
artificial_viscosity = 0
[[block]]
shape = "box"
min = [-0.06, -0.04, 0]
max = [ 0.22,  0.04, 0.0133334]
velocity = ["0.3", "0.03*sin(40*x)", "0"]
[[solid]]
shape = "cylinder"
from = [0, 0.001, 0]
to = [0, 0.001, 0.0133334]
radius = 0.01
[[solid]]
shape = "box"
min = [-0.08, -0.045, -0.02]
max = [ 0.24, -0.04, 0.03]
slip = "free"
[[solid]]
shape = "box"
min = [-0.08, 0.04, -0.02]
max = [ 0.24, 0.045, 0.03]
slip = "free"
)toml";

/// Per kg: kinetic energy, that of the motion across the stream (y), and enstrophy.
struct Measured {
    double energy = 0, across = 0, enstrophy = 0;  ///< J, J, 1/s^2
};

Measured measured(const World& w) {
    const auto u = w.fluid.column<field::velocity>();
    const auto rho = w.fluid.column<field::density>();
    std::vector<Real> V(rho.size());
    for (std::size_t i = 0; i < V.size(); ++i) V[i] = w.step.mass / rho[i];
    const double n = w.fluid.size();
    const auto mean = [&](const auto& f) {
        return parallel_sum(w.fluid.size(), [&](Index i) { return 0.5 * static_cast<double>(f(i)); }) / n;
    };
    return with_kernel(w.step.kernel, w.step.support, [&](const auto& W) {
        return Measured{mean([&](Index i) { return u[i].squaredNorm(); }), mean([&](Index i) { return u[i].y() * u[i].y(); }),
                        mean([&](Index i) { return curl(w.fluid_pairs, i, W, Span<const Real>(V), u).squaredNorm(); })};
    });
}

std::vector<Measured> run(const std::string& text, const std::vector<std::string>& changes, const std::vector<double>& times) {
    ReadRequest request;
    for (const std::string& change : changes) request.changes.push_back(parse_change(change));
    const Scene scene = read_scene_text(text, "vortex.toml", request);
    Simulation simulation(scene, make_plan(scene));
    std::vector<Measured> rows;
    for (const double time : times) {
        while (simulation.time() < time)
            if (simulation.step(time).diverged) return rows;
        rows.push_back(measured(simulation.world()));
    }
    return rows;
}

/// Coarse, coarse with spin, fine.
struct Three {
    std::vector<Measured> coarse, spin, fine;
    Three(const std::string& text, const std::vector<std::string>& with, const std::vector<std::string>& finer,
          const std::vector<double>& times)
        : coarse(run(text, {}, times)), spin(run(text, with, times)), fine(run(text, finer, times)) {}
    std::string columns(std::size_t k, double Measured::*what, int digits) const {
        std::string cells;
        for (const auto* rows : {&coarse, &spin, &fine})
            cells += k < rows->size() ? fmt::format(" {:.{}f} |", (*rows)[k].*what, digits) : std::string(" diverged |");
        return cells;
    }
};

}  // namespace

std::string refinement_table() {
    std::vector<std::string> spin{"models.micropolar=seed", "micropolar.transfer_viscosity=0.8", "micropolar.micro_inertia=2.5e-4",
                                  "micropolar.xsph_spin=0", "micropolar.xsph_velocity=0"};
    const std::vector<double> times{0.25, 0.5, 0.75, 1, 1.5, 2};
    const Three box(vortex, spin, {"fluid.spacing=0.03125"}, times);
    std::string table =
        "| t [s] | energy [J/kg]: coarse | with spin | fine | enstrophy [1/s^2]: coarse | with spin | fine "
        "|\n|---|---|---|---|---|---|---|\n";
    for (std::size_t k = 0; k < times.size(); ++k)
        table +=
            fmt::format("| {:.2f} |", times[k]) + box.columns(k, &Measured::energy, 4) + box.columns(k, &Measured::enstrophy, 2) + "\n";
    return table;
}

std::string refinement_street_table() {
    const std::vector<std::string> spin{"models.micropolar=seed", "micropolar.transfer_viscosity=0.024", "micropolar.micro_inertia=4e-6",
                                        "micropolar.xsph_spin=0", "micropolar.xsph_velocity=0"};
    std::vector<double> times;
    for (int k = 1; k <= 16; ++k) times.push_back(k / 8.0);
    const Three wake(street, spin, {"fluid.spacing=1.66666e-3", "domain.max=[0.22,0.045,0.0066667]", "block[0].max=[0.22,0.04,0.0066667]"},
                     times);
    std::string table =
        "| t [s] | energy across [mJ/kg]: coarse | with spin | fine | enstrophy [1/s^2]: coarse | with spin | fine "
        "|\n|---|---|---|---|---|---|---|\n";
    for (std::size_t k = 3; k < times.size(); k += 4) {
        // Means of half a second, about one and a half vortices.
        const auto cells = [&](double Measured::*what, double scale, int digits) {
            std::string text;
            for (const auto* rows : {&wake.coarse, &wake.spin, &wake.fine}) {
                double sum = 0;
                for (std::size_t j = k - 3; j <= k; ++j) sum += j < rows->size() ? (*rows)[j].*what : std::nan("");
                text += fmt::format(" {:.{}f} |", scale * sum / 4, digits);
            }
            return text;
        };
        table += fmt::format("| {:.1f} to {:.1f} |", times[k] - 0.5, times[k]) + cells(&Measured::across, 1e3, 3) +
                 cells(&Measured::enstrophy, 1, 0) + "\n";
    }
    return table;
}

}  // namespace whorl
