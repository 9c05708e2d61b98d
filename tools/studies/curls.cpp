#include <fmt/format.h>

#include <cmath>

#include "engine/scene/names.h"
#include "tests/support/micropolar_flows.h"
#include "tools/studies/studies.h"

namespace whorl {
namespace {

/// The first Laplacian at R = 2 d, the second at 4 d, which it needs on a lattice (docs/physics.md 4).
std::string row(CurlForm velocity, CurlForm spin, bool central) {
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
    return fmt::format("| {} | {} | {} | {:.2f} | {:.1f} | {:.2f} | {:.1f} | {:.1f} / {:.1f} | {:.0e} | {:.0e} | {:.0e} |\n",
                       name_of(velocity), name_of(spin), central ? "monaghan" : "brookshaw", 100 * fine.velocity,
                       std::log2(coarse.velocity / fine.velocity), 100 * fine.spin, std::log2(coarse.spin / fine.spin),
                       100 * uneven.velocity, 100 * uneven.spin, drift.momentum, drift.angular_momentum, drift.exchange);
}

}  // namespace

std::string curl_table() {
    std::string table =
        "| curl u | curl w | Laplacian | error of u [%] | order | error of w [%] | order | uneven: u / w [%] | momentum | angular momentum "
        "| energy |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const bool central : {false, true})
        for (const auto& [velocity, velocity_name] : choices(CurlForm{}))
            for (const auto& [spin, spin_name] : choices(CurlForm{})) table += row(velocity, spin, central);
    return table;
}

}  // namespace whorl
