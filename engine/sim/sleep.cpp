#include "engine/sim/sleep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <unordered_map>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Appends the columns of one store to another that has the same.
void append(const ParticleStore& from, ParticleStore& to) {
    const auto before = static_cast<std::size_t>(to.size());
    to.resize(to.size() + from.size());
    for (const ParticleStore::Entry* entry : from.entries()) {
        const std::size_t bytes = entry->info->bytes;
        auto* target = static_cast<char*>(to.find(entry->info->name)->column->data());
        std::memcpy(target + before * bytes, std::as_const(*entry->column).data(), bytes * static_cast<std::size_t>(from.size()));
    }
}

}  // namespace

void HoldSleepers::operator()(Read<field::role> role, Read<field::anchor> anchor, Update<field::quiet_time>, Update<field::velocity> u,
                              Update<field::position> x) const {
    parallel_for(u.size(), [&](Index i) {
        if (role[i] != Sleep::asleep_role) return;
        u[i].setZero();
        x[i] = anchor[i];
    });
}

/// The fluid in cells as wide as the reach: what is within reach of a particle lies in its cell or the 26 around it.
struct Sleep::Cells {
    /// What a cell as wide as the reach knows of its particles.
    struct Cell {
        bool restless = false;  ///< somebody moves: nobody falls asleep
        bool stirs = false;     ///< or somebody awake has moved a little: sleepers wake
        bool awake = false;
        Real least_quiet = std::numeric_limits<Real>::infinity();  ///< s, sleepers do not count

        void operator+=(const Cell& o) {
            restless |= o.restless, stirs |= o.stirs, awake |= o.awake;
            least_quiet = std::min(least_quiet, o.least_quiet);
        }
    };

    std::array<double, 3> origin{}, inverse_edge{};
    std::array<std::int64_t, 3> period{};  ///< cells along a periodic axis, else 0
    std::unordered_map<std::int64_t, Cell> cells;

    Cells(const Domain& domain, double reach) {
        for (int a = 0; a < 3; ++a) {
            origin[a] = domain.min[a];
            inverse_edge[a] = 1 / reach;
            if (!domain.periodic[a]) continue;
            const double length = double(domain.max[a]) - double(domain.min[a]);
            period[a] = std::max<std::int64_t>(1, static_cast<std::int64_t>(length / reach));
            inverse_edge[a] = static_cast<double>(period[a]) / length;
        }
    }
    std::array<std::int64_t, 3> place(const Vec3& x) const {
        std::array<std::int64_t, 3> c{};
        for (std::size_t a = 0; a < 3; ++a)
            c[a] = static_cast<std::int64_t>(std::clamp(std::floor((x[static_cast<int>(a)] - origin[a]) * inverse_edge[a]), -1e6, 1e6));
        return c;
    }
    std::int64_t key(std::array<std::int64_t, 3> c) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (period[a] > 0) c[a] = (c[a] % period[a] + period[a]) % period[a];
        return ((c[0] + (1 << 20)) << 42) + ((c[1] + (1 << 20)) << 21) + (c[2] + (1 << 20));
    }
    /// What is within reach, and perhaps a little further.
    std::unordered_map<std::int64_t, Cell> blurred(const std::vector<std::array<std::int64_t, 3>>& places) const {
        std::unordered_map<std::int64_t, Cell> all;
        for (const auto& c : places) {
            const auto [found, fresh] = all.try_emplace(key(c));
            if (!fresh) continue;
            for (std::int64_t dx = -1; dx <= 1; ++dx)
                for (std::int64_t dy = -1; dy <= 1; ++dy)
                    for (std::int64_t dz = -1; dz <= 1; ++dz)
                        if (const auto near = cells.find(key({c[0] + dx, c[1] + dy, c[2] + dz})); near != cells.end())
                            found->second += near->second;
        }
        return all;
    }
};

void Sleep::gather(World& world) {
    ParticleStore& fluid = world.fluid;
    if (dormant_.size() > 0) append(dormant_, fluid), dormant_.resize(0);
    const auto role = fluid.column<field::role>();
    for (std::int16_t& r : role)
        if (r == asleep_role) r = 0;
}

void Sleep::wake_all(World& world) {
    for (Real& q : world.fluid.column<field::quiet_time>()) q = std::max(q, Real(0));
    sleepers_ = 0;
}

void Sleep::look(World& world, double elapsed) {
    gather(world);
    ParticleStore& fluid = world.fluid;
    const auto n = static_cast<std::size_t>(fluid.size());
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    const auto anchor = fluid.column<field::anchor>();
    const auto quiet = fluid.column<field::quiet_time>();
    const Domain& domain = world.step.domain;
    const Real d = world.step.spacing, most = options_.tolerance * d, time = static_cast<Real>(elapsed);
    const double reach = world.step.support + static_cast<double>(look_every) * options_.cfl * d;

    // The anchor follows as a mean over the past does: what creeps with v is v `after` ahead of it for good, and counts as quiet or not by
    // that.
    const Real follows = std::min(Real(1), time / options_.after);
    parallel_for(fluid.size(), [&](Index i) {
        if (quiet[i] < 0) return;
        const Vec3 ahead = domain.minimum_image(x[i] - anchor[i]);
        const Real way = ahead.norm();
        quiet[i] = way > most ? 0 : quiet[i] + time;
        anchor[i] = x[i] - (1 - follows) * (way > most ? most / way : 1) * ahead;
    });
    const bool solids_move = world.solids.any_moving();
    Cells cells(domain, reach);
    std::vector<std::array<std::int64_t, 3>> places(n);
    for (std::size_t k = 0; k < n; ++k) {
        places[k] = cells.place(domain.wrapped(x[k]));
        bool restless = quiet[k] >= 0 && quiet[k] < options_.after / 2;
        Real distance = 0;
        if (solids_move)
            if (const int s = world.solids.nearest(x[k], distance); s >= 0 && distance < reach)
                restless |= world.solids.all[s].pose.velocity_at(x[k]).norm() * options_.after > most;
        // Where much counts as rest, a tenth of a spacing is yet enough to press on a sleeper.
        const bool stirs = restless || (quiet[k] >= 0 && domain.minimum_image(x[k] - anchor[k]).norm() > Real(0.1) * d);
        cells.cells[cells.key(places[k])] +=
            Cells::Cell{restless, stirs, quiet[k] >= 0, quiet[k] >= 0 ? quiet[k] : std::numeric_limits<Real>::infinity()};
    }
    const auto near = cells.blurred(places);
    sleepers_ = 0;
    for (std::size_t k = 0; k < n; ++k) {
        const Cells::Cell& around = near.at(cells.key(places[k]));
        if (quiet[k] < 0 && around.stirs) {
            quiet[k] = options_.after / 2;  // awake, but no reason to wake others until it moves itself
        } else if (quiet[k] >= 0 && !around.restless && around.least_quiet >= options_.after) {
            quiet[k] = -1;
            anchor[k] = x[k];
            u[k].setZero();
            if (fluid.has<field::spin>()) fluid.column<field::spin>()[k].setZero();
        }
        sleepers_ += quiet[k] < 0;
    }
}

void Sleep::tuck_in(World& world) {
    if (sleepers_ == 0) {  // after a resume nobody has looked yet
        for (const Real q : std::as_const(world.fluid).column<field::quiet_time>()) sleepers_ += static_cast<Index>(q < 0);
        if (sleepers_ == 0) return;
    }
    ParticleStore& fluid = world.fluid;
    const Index n = fluid.size();
    const Domain& domain = world.step.domain;
    const double reach = world.step.support + static_cast<double>(look_every) * options_.cfl * world.step.spacing;
    std::vector<Index> here, away;
    {
        const auto x = std::as_const(fluid).column<field::position>();
        const auto quiet = std::as_const(fluid).column<field::quiet_time>();
        const auto role = fluid.column<field::role>();
        Cells cells(domain, reach);
        std::vector<std::array<std::int64_t, 3>> places(x.size());
        for (std::size_t k = 0; k < x.size(); ++k) {
            places[k] = cells.place(domain.wrapped(x[k]));
            cells.cells[cells.key(places[k])] += Cells::Cell{false, false, quiet[k] >= 0, 0};
        }
        const auto near = cells.blurred(places);
        for (Index i = 0; i < n; ++i) {
            const bool deep = quiet[i] < 0 && !near.at(cells.key(places[i])).awake;
            (deep ? away : here).push_back(i);
            if (!deep && quiet[i] < 0 && role[i] == 0) role[i] = asleep_role;
        }
    }
    if (away.empty()) return;
    for (const ParticleStore::Entry* entry : fluid.entries()) dormant_.declare(*entry->info, entry->lasting);
    dormant_.resize(static_cast<Index>(away.size()));
    for (const ParticleStore::Entry* entry : fluid.entries()) {
        const std::size_t bytes = entry->info->bytes;
        const auto* source = static_cast<const char*>(std::as_const(*entry->column).data());
        auto* target = static_cast<char*>(dormant_.find(entry->info->name)->column->data());
        parallel_for(static_cast<Index>(away.size()), [&](Index k) {
            const auto at = static_cast<std::size_t>(k);
            std::memcpy(target + at * bytes, source + static_cast<std::size_t>(away[at]) * bytes, bytes);
        });
        // Whole numbers name groups of the moment (a preconditioner's): who comes back later belongs to none.
        if (entry->info->integer && entry->info != &field_info<field::role>()) std::memset(target, 0, bytes * away.size());
    }
    fluid.gather(here);
}

}  // namespace whorl
