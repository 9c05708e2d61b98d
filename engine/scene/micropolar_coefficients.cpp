
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/models/micropolar/micropolar.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/as_printed.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/plan.h"

namespace whorl {
namespace {

constexpr double notes_transfer_below = 0.4;  ///< limit in the source notes [Pa s]
constexpr double infinity = std::numeric_limits<double>::infinity();

double length_of_spin(const Scene& scene) { return scene.micropolar.spin_length > 0 ? scene.micropolar.spin_length : scene.fluid.spacing; }

bool given(const Scene& scene, const std::string& key) { return scene.places.count(key) > 0; }

/// The larger eigenvalue of the matrix ((-p, q), (r, -s)), 0 if it is negative [1/s].
double growth(double p, double q, double r, double s) { return std::max(0.0, (std::hypot(p - s, 2 * std::sqrt(q * r)) - p - s) / 2); }

/// Whether fluid can turn without friction: at a free surface or along a curved wall with free slip. Flat walls exert a torque on it.
bool slides(const Scene& scene, const Plan& plan) {
    return plan.free_surface || std::any_of(scene.solids.begin(), scene.solids.end(), [](const SolidKeys& s) {
               return s.slip == Slip::free && s.shape.kind != "box" && s.shape.kind != "plane";
           });
}

double smoothing_viscosity(const MicropolarKeys& keys, double support, double dt) {
    return xsph_viscosity(keys.xsph_velocity, support, keys.xsph_time > 0 ? keys.xsph_time : dt);
}

constexpr double most_growth = 10;  ///< largest growth factor of the speed in the run: the flow would then be as fast as its planned speed
                                    ///< of sound

}  // namespace

double MicropolarNumbers::growing_length() const {
    if (!grows()) return infinity;
    const double k2 = coupling * (coupling - 2 * viscosity) / (viscosity * spin_viscosity);
    return 2 * std::numbers::pi / std::sqrt(k2);
}

double MicropolarNumbers::wave_growth(double shortest, double longest, double smoothing) const {
    constexpr int lengths = 100;
    double most = 0;
    for (int l = 0; l < lengths; ++l) {
        const double k = 2 * std::numbers::pi / (longest * std::pow(shortest / longest, l / (lengths - 1.0)));
        const double kappa = coupling / density, exchange = kappa * k * std::sqrt(1 / micro_inertia);
        most = std::max(most, growth((viscosity / density + smoothing) * k * k, exchange, exchange,
                                     (2 * kappa + spin_viscosity / density * k * k) / micro_inertia));
    }
    return most;
}

double MicropolarNumbers::growth_of_turning(double radius, int dimensions, double smoothing) const {
    const double over_inertia = (dimensions + 2) / (radius * radius), answers = 2 * coupling / (density * micro_inertia);
    const double torque = (pair_viscosity + composed_coupling) / density + smoothing;
    // If the torques are equal, angular momentum is conserved, and the growth is 0 except for round-off.
    return torque >= (1 - 1e-9) * coupling / density ? 0
                                                     : growth(over_inertia * torque, over_inertia * coupling / density, answers, answers);
}

double MicropolarNumbers::spin_length() const {
    return grows() || coupling == 0 ? infinity : std::sqrt(viscosity * spin_viscosity / (coupling * (2 * viscosity - coupling)));
}

Scene calibrated(const Scene& scene) {
    const MicropolarTraits& traits = traits_of(scene.models.micropolar);
    Scene chosen = as_printed(scene);
    if (!traits.spins || !scene.micropolar.effective_viscosity) return chosen;
    const double twice = 2 * *scene.micropolar.effective_viscosity, l = length_of_spin(scene);
    chosen.fluid.viscosity = Expression(traits.viscosity_by_transfer > 0 ? 0.0 : twice);
    chosen.micropolar.transfer_viscosity = traits.coupling_by_mu > 0 ? 0 : twice;
    chosen.micropolar.spin_viscosity = twice * l * l;
    chosen.micropolar.micro_inertia = l * l;
    return chosen;
}

MicropolarNumbers micropolar_numbers(const Scene& scene, const ViscosityTraits& viscosity, bool slides) {
    const MicropolarKeys& keys = scene.micropolar;
    const double mu = scene.fluid.viscosity(0), transfer = keys.transfer_viscosity, l = length_of_spin(scene);
    const MicropolarTraits& traits = traits_of(scene.models.micropolar);
    const bool explicit_mu = viscosity.viscous && !viscosity.implicit;
    MicropolarNumbers n;
    n.density = scene.fluid.density;
    n.coupling = traits.coupling_by_mu * mu + transfer;
    const double own = (explicit_mu ? mu : 0) + traits.viscosity_by_transfer * transfer;
    n.viscosity = own + (viscosity.implicit ? mu : 0);
    n.slides = slides;
    const LaplacianForm automatic = slides && !n.grows() ? LaplacianForm::split : LaplacianForm::brookshaw;
    const LaplacianForm form = explicit_mu ? scene.viscosity.laplacian.value_or(automatic) : automatic;
    n.pair_viscosity = form == LaplacianForm::monaghan ? 0 : own;
    if (form == LaplacianForm::split) {
        // The composed curl supplies the torque that the coupling lacks. Half of its coupling acts as viscosity, so the remaining
        // viscosity is reduced by this half.
        if (!viscosity.implicit) n.pair_viscosity = std::min(n.coupling, 2 * own - n.coupling);
        n.composed_coupling = n.coupling - n.pair_viscosity;
        if (viscosity.implicit && n.composed_coupling > 0) n.implicit_share = 1 - n.composed_coupling / (2 * mu);
    }
    n.central_viscosity = n.composed_coupling > 0 ? 0 : own - n.pair_viscosity;
    n.spin_viscosity = keys.spin_viscosity.value_or((mu + traits.viscosity_by_transfer * transfer) * l * l);
    n.micro_inertia = keys.micro_inertia;
    return n;
}

void choose_micropolar(Plan& plan, const Scene& scene, const Scene& asked, double flow_step, double radius) {
    const auto choose = [&](const char* key, std::string value, bool automatic, std::string reason) {
        plan.choices.push_back({key, std::move(value), automatic, std::move(reason)});
    };
    MicropolarNumbers& n = plan.spin = micropolar_numbers(scene, plan.traits.viscosity, slides(scene, plan));
    if (n.slides && std::isfinite(radius))
        n.turning_growth = n.growth_of_turning(radius, plan.dimensions(), smoothing_viscosity(scene.micropolar, plan.support, flow_step));
    const double d = plan.spacing;
    const auto length = [&](double l) { return std::isfinite(l) ? fmt::format("{:.3g} m ({:.2g} d)", l, l / d) : std::string("infinite"); };
    choose("models.micropolar", name_of(plan.micropolar), false,
           fmt::format("effective viscosity of slow flows {:.3g} Pa s (viscosity {:.3g} - coupling {:.3g}/2); response time of the spin "
                       "{:.3g} s, length {}",
                       n.effective_viscosity(), n.viscosity, n.coupling, n.response_time(), length(n.spin_length())));
    if (n.slides && std::abs(n.pair_viscosity + n.composed_coupling - n.coupling) < 1e-9 * n.coupling)
        choose("micropolar viscosity", n.composed_coupling > 0 ? "split, with a composed curl" : "split", !scene.viscosity.laplacian,
               fmt::format("adds no energy to fluid that turns freely: {:.3g} Pa s along u_i - u_j, {:.3g} without torque, {:.3g} through "
                           "the curl of curl u - 2 w",
                           n.pair_viscosity, n.viscosity - n.pair_viscosity - n.composed_coupling / 2, n.composed_coupling / 2));
    if (asked.micropolar.effective_viscosity) {
        const std::string wanted = fmt::format("calibrated for {:g} Pa s", *asked.micropolar.effective_viscosity);
        choose("fluid.viscosity", scene.fluid.viscosity.text(), true, wanted + ": viscosity = coupling = twice that");
        choose("micropolar.transfer_viscosity", fmt::format("{:g}", scene.micropolar.transfer_viscosity), true,
               wanted + ": half of the coupling that would add energy; angular momentum is conserved");
        choose("micropolar.spin_viscosity", fmt::format("{:.3g}", n.spin_viscosity), true,
               fmt::format("calibrated for a spin length of {:.3g} m: twice the effective viscosity times its square", n.spin_length()));
        choose("micropolar.micro_inertia", fmt::format("{:.3g}", n.micro_inertia), true,
               "calibrated to the spin length squared: spin and momentum diffuse equally fast");
    } else if (!asked.micropolar.spin_viscosity) {
        choose("micropolar.spin_viscosity", fmt::format("{:.3g}", n.spin_viscosity), true,
               fmt::format("viscosity l^2 with l = {:.3g} m", length_of_spin(scene)));
    }
    const double stable = n.coupling > 0 ? exchange_step(n.coupling / n.density, n.micro_inertia,
                                                         largest_curl(plan.kernel, static_cast<Real>(plan.support), static_cast<Real>(d)))
                                         : infinity;
    const ExchangeScheme scheme = scene.micropolar.exchange;
    const bool automatic = scheme == ExchangeScheme::automatic;
    n.implicit_exchange = automatic ? stable < flow_step : scheme == ExchangeScheme::implicit;
    choose("micropolar.exchange", n.implicit_exchange ? "implicit" : "explicit", automatic,
           fmt::format("the stable explicit step {:.3g} s is {} than the {:.3g} s that all else allows", stable,
                       stable < flow_step ? "shorter" : "longer", flow_step));
}

namespace {

/// Describes the growth of fluid that turns freely, and a fix.
std::pair<std::string, std::string> turning_text(const MicropolarNumbers& n, const Scene& scene) {
    return {
        fmt::format("fluid that turns freely (at a free surface, or along a round wall without friction) gains energy: the coupling of "
                    "{:.3g} Pa s, with a torque of the viscosity of {:.3g} Pa s, makes it turn faster by exp({:.3g}) or more in the run",
                    n.coupling, n.pair_viscosity, n.turning_growth * scene.time.end),
        n.grows() ? "use \"eringen\", or a fluid.viscosity of at least micropolar.transfer_viscosity with a model that applies it"
                  : "use viscosity.laplacian = \"split\" or \"auto\""};
}

}  // namespace

void warn_micropolar(Plan& plan, const Scene& scene) {
    const MicropolarNumbers& n = plan.spin;
    const auto add = [&](std::string text) { plan.warnings.push_back(std::move(text)); };
    if (n.grows()) {
        const double from = n.growing_length();
        const double rate = n.wave_growth(2 * plan.spacing, (scene.domain.max - scene.domain.min).maxCoeff(),
                                          smoothing_viscosity(scene.micropolar, plan.support, scene.time.max_step));
        add(fmt::format(
            "the micropolar system adds energy: its coupling {:.3g} Pa s is more than twice its viscosity {:.3g} Pa s, so slow flows have "
            "an effective viscosity of {:.3g} Pa s, and {} grow, the fastest by exp({:.3g}) in the run. No time step or exchange scheme "
            "prevents that; XSPH smoothing damps only short waves. models.micropolar = \"eringen\" always dissipates, and so does "
            "\"notes\" with fluid.viscosity >= micropolar.transfer_viscosity",
            n.coupling, n.viscosity, n.effective_viscosity(),
            from > 0 ? fmt::format("waves longer than {:.3g} m", from) : std::string("waves of every length"), rate * scene.time.end));
    }
    if (n.turning_growth > 0) {
        const auto [growth, remedy] = turning_text(n, scene);
        add(growth + "; " + remedy);
    }
    if (n.coupling > 0 && n.response_time() > scene.time.end)
        add(
            fmt::format("the response time of the spin is {:.3g} s, longer than the run of {:g} s: at its end the spin has {:.2g} % of its "
                        "value in a steady flow. With micropolar.micro_inertia = {:.2g} m^2 it would respond in a tenth of the run",
                        n.response_time(), scene.time.end, -100 * std::expm1(-scene.time.end / n.response_time()),
                        0.2 * scene.time.end * n.coupling / n.density));
    if (const double transfer = scene.micropolar.transfer_viscosity; plan.micropolar == MicropolarModel::notes && !n.grows() &&
                                                                     !scene.micropolar.effective_viscosity &&
                                                                     transfer >= notes_transfer_below)
        add(fmt::format("micropolar.transfer_viscosity = {:g} Pa s: the source of \"notes\" uses less than {:g}", transfer,
                        notes_transfer_below));
    if (n.coupling == 0) add("the micropolar coupling is 0: the spin does not act on the flow");
}

void check_micropolar(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    const KeyProblems report(scene, problems);
    if (!plan.traits.micropolar.spins) {
        if (plan.viscosity == ViscosityModel::explicit_laplacian && scene.viscosity.laplacian == LaplacianForm::split)
            report("viscosity.laplacian",
                   "viscosity.laplacian = \"split\" splits by the coupling of a micropolar model, and the scene has no such model", "",
                   "allowed: brookshaw or monaghan");
        return;
    }
    if (plan.spin.grows() && plan.spin.composed_coupling > 0)
        report("viscosity.laplacian",
               fmt::format("viscosity.laplacian = \"split\" leaves {:.3g} Pa s for the strain (viscosity {:.3g} minus half of the coupling "
                           "{:.3g}), which adds energy",
                           plan.spin.effective_viscosity(), plan.spin.viscosity, plan.spin.coupling),
               "use \"eringen\" or a smaller micropolar.transfer_viscosity", "allowed: auto, brookshaw or monaghan");
    if (std::exp(plan.spin.turning_growth * scene.time.end) > most_growth) {
        const auto [growth, remedy] = turning_text(plan.spin, scene);
        report(scene.viscosity.laplacian ? "viscosity.laplacian" : "models.micropolar", growth, remedy);
    }
    if (plan.spin.slides && scene.micropolar.curl_velocity == CurlForm::symmetric &&
        scene.micropolar.curl_spin.value_or(CurlForm::symmetric) != CurlForm::symmetric)
        report("micropolar.curl_spin",
               "micropolar.curl_velocity = \"symmetric\" turns particles that merely move with a free surface, and a difference as "
               "curl_spin does not take that energy from the flow, which tears the fluid apart",
               "use curl_velocity = \"difference_own_density\" with curl_spin = \"symmetric\"");
    if (!plan.traits.pressure.has_micropolar)
        report("models.pressure", "models.pressure = " + described(plan.traits.pressure) + " has no micropolar terms",
               "use \"wcsph\" or \"ppe\"", "allowed: auto, wcsph, ppe or none");
    if (!scene.fluid.viscosity.is_constant())
        report("fluid.viscosity", "fluid.viscosity varies, and a micropolar model couples flow and spin by one viscosity", "give a number");
    const bool calibrates = scene.micropolar.effective_viscosity.has_value();
    if (calibrates)
        for (const char* key :
             {"fluid.viscosity", "micropolar.transfer_viscosity", "micropolar.spin_viscosity", "micropolar.micro_inertia"})
            if (given(scene, key)) report(key, std::string(key) + " is chosen by micropolar.effective_viscosity", "remove one of them");
    if (plan.micropolar == MicropolarModel::notes && plan.spin.grows() && !calibrates && !given(scene, "micropolar.transfer_viscosity"))
        report("models.micropolar",
               fmt::format(
                   "models.micropolar = \"notes\" would add energy: its coupling, fluid.viscosity + the default "
                   "micropolar.transfer_viscosity = {:g} Pa s, is more than twice the {:g} Pa s that models.viscosity = \"{}\" applies",
                   scene.micropolar.transfer_viscosity, plan.spin.viscosity, name_of(plan.viscosity)),
               "set micropolar.transfer_viscosity (to at most fluid.viscosity for dissipation, or more if intended), or use "
               "\"eringen\"");
}

}  // namespace whorl
