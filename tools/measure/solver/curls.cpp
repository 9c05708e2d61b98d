/// Errors, orders and conservation of the curls of the micropolar models.
#include <CLI/CLI.hpp>
#include <cmath>

#include "engine/scene/names.h"
#include "tests/support/micropolar_flows.h"
#include "tools/measure/solver/subcommands.h"

namespace whorl {
namespace {

/// Prints the row of a pair of curls and a Laplacian. The support is R = 2 d for Brookshaw's Laplacian, and 4 d for Monaghan's, which needs
/// it on a lattice (docs/physics.md 4).
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
