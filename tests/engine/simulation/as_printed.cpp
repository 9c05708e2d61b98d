/// models.notes = "as_printed": a step of the third note's system against its printed sums, and the plan for this key.
#include "engine/scene/as_printed.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/poured_honey.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace as_printed_test {
namespace {

const std::string cloud =
    text::time(0.01, "fixed_step = 1e-3") + text::domain({-1, -1, -1}, {2, 2, 2}, "gravity = [0, -1, 0]") +
    text::fluid(0.1, 0.5, "density = 1") + text::models("wcsph", "explicit") + "micropolar = \"notes\"\nnotes = \"as_printed\"\n" +
    "[pressure]\nsound_speed = 3\nbackground_pressure = 0.1\n[micropolar]\ntransfer_viscosity = 0.3\nexchange = \"explicit\"\n" +
    text::block({0, 0, 0}, {0.5, 0.5, 0.5},
                "sampling = \"jittered\"\nvelocity = [\"sin(3*y)\", \"cos(2*x)\", \"0.3*z\"]\nspin = [\"y\", \"0.5*x\", \"cos(3*z)\"]");

struct State {
    std::vector<Vec3d> x, u, w;
    explicit State(const Simulation& simulation) {
        const ParticleStore& fluid = simulation.world().fluid;
        const auto copy = [](Span<const Vec3> from, std::vector<Vec3d>& to) {
            for (const Vec3& v : from) to.push_back(v.cast<double>());
        };
        copy(fluid.column<field::position>(), x), copy(fluid.column<field::velocity>(), u), copy(fluid.column<field::spin>(), w);
    }
};

/// One step of the note in double, all pairs: the weakly compressible equation, then the spin's, then XSPH of u and of w, then the move.
void printed_step(State& s, bool second_laplacian) {
    constexpr double d = 0.1, R = 2 * d, h = d, dt = 1e-3, rho_0 = 1, m = rho_0 * d * d * d, mu = 0.5, sum_mu = 0.8, theta = 2, C_0 = 3,
                     gamma = 7, p_0 = 0.1, alpha = 0.002, beta = 0.125;
    const double sigma = 8 / (std::numbers::pi * R * R * R);
    const auto W = [&](double r) {
        const double q = r / R;
        return q < 0.5 ? sigma * (6 * q * q * (q - 1) + 1) : q < 1 ? 2 * sigma * std::pow(1 - q, 3) : 0;
    };
    const auto grad = [&](const Vec3d& r) {
        const double q = r.norm() / R, slope = q < 0.5 ? 6 * q * (3 * q - 2) : q < 1 ? -6 * (1 - q) * (1 - q) : 0;
        return Vec3d(sigma / R * slope * r.normalized());
    };
    const std::size_t n = s.x.size();
    const auto sum = [&](std::size_t i, auto&& term) {
        Vec3d all = Vec3d::Zero();
        for (std::size_t j = 0; j < n; ++j)
            if (j != i && (s.x[i] - s.x[j]).norm() < R) all += term(j, Vec3d(s.x[i] - s.x[j]));
        return all;
    };
    std::vector<double> rho(n), p(n);
    for (std::size_t i = 0; i < n; ++i) {
        rho[i] = m * W(0) + sum(i, [&](std::size_t, const Vec3d& r) { return Vec3d(m * W(r.norm()), 0, 0); }).x();
        p[i] = std::max(C_0 * C_0 * rho_0 / gamma * (std::pow(rho[i] / rho_0, gamma) - 1) + p_0, 0.0);
    }
    const auto first = [&](std::size_t i, const std::vector<Vec3d>& v) {
        return sum(i, [&](std::size_t j, const Vec3d& r) { return Vec3d(m / rho[j] * (v[j] - v[i]) * 2 * grad(r).norm() / r.norm()); });
    };
    State next = s;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d laplacian = !second_laplacian ? first(i, s.u) : sum(i, [&](std::size_t j, const Vec3d& r) {
            return Vec3d(2 * (3 + 2) * m / rho[j] * (s.u[i] - s.u[j]).dot(r) / (r.squaredNorm() + 0.01 * h * h) * grad(r));
        });
        const Vec3d grad_p = rho[i] * sum(i, [&](std::size_t j, const Vec3d& r) {
                                 return Vec3d(m * (p[i] / (rho[i] * rho[i]) + p[j] / (rho[j] * rho[j])) * grad(r));
                             });
        const Vec3d curl_w = -rho[i] * sum(i, [&](std::size_t j, const Vec3d& r) {
            return Vec3d(m * (s.w[i] / (rho[i] * rho[i]) + s.w[j] / (rho[j] * rho[j])).cross(grad(r)));
        });
        const Vec3d curl_u = sum(i, [&](std::size_t j, const Vec3d& r) { return Vec3d(m / rho[i] * (s.u[i] - s.u[j]).cross(grad(r))); });
        next.u[i] += dt * ((-grad_p + mu * laplacian + sum_mu * curl_w) / rho[i] + Vec3d(0, -1, 0));
        next.w[i] += dt / (theta * rho[i]) * (mu * first(i, s.w) + sum_mu * (curl_u - 2 * s.w[i]));
    }
    const State kicked = next;
    for (std::size_t i = 0; i < n; ++i) {
        const auto smoothed = [&](const std::vector<Vec3d>& v) {
            return sum(i, [&](std::size_t j, const Vec3d& r) { return Vec3d(m / rho[j] * W(r.norm()) * (v[j] - v[i])); });
        };
        next.u[i] += alpha * smoothed(kicked.u);
        next.w[i] += beta * smoothed(kicked.w);
        next.x[i] += dt * next.u[i];
    }
    s = next;
}

std::string messages(const std::vector<std::string>& changes, const std::string& more = "") { return messages_with(changes, cloud + more); }

}  // namespace

TEST_CASE("two steps of the third note's system equal its printed sums within 1e-4", "[micropolar][printed]") {
    for (const bool second : {false, true}) {
        CAPTURE(second);
        const Scene scene = scene_with({std::string("viscosity.laplacian=") + (second ? "monaghan" : "brookshaw")}, cloud);
        Simulation simulation(scene, make_plan(scene));
        const State start(simulation);
        State expected = start;
        for (int k = 0; k < 2; ++k) printed_step(expected, second), simulation.step(1);
        const State found(simulation);
        REQUIRE(found.x.size() == 125);
        double most_u = 0, most_w = 0, off_x = 0, off_u = 0, off_w = 0;
        for (std::size_t i = 0; i < found.x.size(); ++i) {
            std::size_t k = 0;  // the same particle after sorting
            for (std::size_t j = 0; j < found.x.size(); ++j)
                if ((expected.x[j] - found.x[i]).norm() < (expected.x[k] - found.x[i]).norm()) k = j;
            most_u = std::max(most_u, (expected.u[k] - start.u[k]).norm());
            most_w = std::max(most_w, (expected.w[k] - start.w[k]).norm());
            off_x = std::max(off_x, (expected.x[k] - found.x[i]).norm());
            off_u = std::max(off_u, (expected.u[k] - found.u[i]).norm());
            off_w = std::max(off_w, (expected.w[k] - found.w[i]).norm());
        }
        // Single precision: 1e-7 of the velocities, of which two steps change a hundredth.
        CHECK(off_u < 1e-4 * most_u);
        CHECK(off_w < 1e-4 * most_w);
        CHECK(off_x < 1e-6);
    }
}

TEST_CASE("as printed: the plan refuses models and values that are in no note, by key", "[plan][printed]") {
    CHECK(messages({}) == "no error");
    for (const auto& [changes, part] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"micropolar.micro_inertia=1"}, "micropolar.micro_inertia = 1.0 is not what the notes print, 2.0"},
             {{"models.micropolar=eringen"}, "\"eringen\" is not in the notes"},
             {{"models.viscosity=full"}, "use \"full_assembled\""},
             {{"models.pressure=coupled"}, "is not in the notes"},
             {{"viscosity.laplacian=split"}, "viscosity.laplacian = \"split\" is not in the notes"},
             {{"models.pressure=ppe", "pressure.form=constraint"}, "pressure.form = \"constraint\" is not what"}}) {
        CAPTURE(changes);
        CHECK_THAT(messages(changes), Catch::Contains(part));
    }
    const std::string body = "[[solid]]\nshape = \"box\"\nmin = [1, 1, 1]\nmax = [1.5, 1.5, 1.5]\ndensity = 500\n";
    CHECK_THAT(messages({"models.pressure=ppe"}, body), Catch::Contains("does not move free bodies"));
    const Scene water = as_printed(scene_with({"models.pressure=ppe"}, cloud));
    CHECK(water.pressure.source == PressureSource::density);
    CHECK(water.pressure.cycle == MultigridCycle::v_cycle);
    CHECK(water.pressure.correction == 1);
    CHECK(water.pressure.damping == 0);
}

}  // namespace as_printed_test
