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

/// What a cell as wide as the reach knows of its particles.
struct Sleep::Cell {
    bool restless = false;  ///< somebody moves: nobody falls asleep
    bool stirs = false;     ///< or somebody awake has moved a little: sleepers wake
    bool awake = false;
    Real least_quiet = std::numeric_limits<Real>::infinity();  ///< s, sleepers do not count

    void operator+=(const Cell& o) {
        restless |= o.restless, stirs |= o.stirs, awake |= o.awake;
        least_quiet = std::min(least_quiet, o.least_quiet);
    }
};

/// The fluid in cells as wide as the reach: what is within reach of a particle lies in its cell or the 26 around it.
class Sleep::Cells {
public:
    Cells(const Domain& domain, double reach) {
        deep = domain.dimensions() == 2 ? 0 : 1;
        for (int a = 0; a < 3; ++a) {
            origin[a] = domain.min[a];
            inverse_edge[a] = 1 / reach;
            if (!domain.periodic[a]) continue;
            const double length = double(domain.max[a]) - double(domain.min[a]);
            period[a] = std::max<std::int64_t>(1, static_cast<std::int64_t>(length / reach));
            inverse_edge[a] = static_cast<double>(period[a]) / length;
        }
    }
    /// Adds the next particle, in the order of the store. @param x where it is
    void add(const Vec3& x, const Cell& state) {
        std::array<std::int64_t, 3> c{};
        for (int a = 0; a < 3; ++a)
            c[a] = static_cast<std::int64_t>(std::clamp(std::floor((x[a] - origin[a]) * inverse_edge[a]), -1e6, 1e6));
        places.push_back(c);
        cells[key(c)] += state;
    }
    std::int64_t key_of(Index i) const { return key(places[i]); }
    /// For each cell with particles, by its key: what is within their reach, and perhaps a little further.
    std::unordered_map<std::int64_t, Cell> within_reach() const {
        std::unordered_map<std::int64_t, Cell> all;
        for (const auto& c : places) {
            const auto [found, fresh] = all.try_emplace(key(c));
            if (!fresh) continue;
            for (std::int64_t dx = -1; dx <= 1; ++dx)
                for (std::int64_t dy = -1; dy <= 1; ++dy)
                    for (std::int64_t dz = -deep; dz <= deep; ++dz)
                        if (const auto near = cells.find(key({c[0] + dx, c[1] + dy, c[2] + dz})); near != cells.end())
                            found->second += near->second;
        }
        return all;
    }

private:
    std::array<double, 3> origin{}, inverse_edge{};
    std::array<std::int64_t, 3> period{};  ///< cells along a periodic axis, else 0
    std::int64_t deep = 1;                 ///< cells along z to look at to each side: in the plane none
    std::unordered_map<std::int64_t, Cell> cells;
    std::vector<std::array<std::int64_t, 3>> places;  ///< of each particle

    std::int64_t key(std::array<std::int64_t, 3> c) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (period[a] > 0) c[a] = (c[a] % period[a] + period[a]) % period[a];
        return ((c[0] + (1 << 20)) << 42) + ((c[1] + (1 << 20)) << 21) + (c[2] + (1 << 20));
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

double Sleep::reach(const World& world) const {
    return world.step.support + static_cast<double>(look_every) * options_.cfl * world.step.spacing;
}

/// Whether a solid that moves is within reach: whoever it may push does not rest.
bool Sleep::near_moving_solid(const World& world, const Vec3& x) const {
    Real distance = 0;
    const int s = world.solids.nearest(x, distance);
    return s >= 0 && distance < reach(world) &&
           world.solids.all[s].pose.velocity_at(x).norm() * options_.after > options_.tolerance * world.step.spacing;
}

/// The anchor follows as a mean over the past does: what creeps with v is v `after` ahead of it for good, and counts as quiet or not by
/// that.
void Sleep::follow(World& world, Real elapsed) const {
    const auto x = std::as_const(world.fluid).column<field::position>();
    const auto anchor = world.fluid.column<field::anchor>();
    const auto quiet = world.fluid.column<field::quiet_time>();
    const Real most = options_.tolerance * world.step.spacing, follows = std::min(Real(1), elapsed / options_.after);
    parallel_for(world.fluid.size(), [&](Index i) {
        if (quiet[i] < 0) return;
        const Vec3 ahead = world.step.domain.minimum_image(x[i] - anchor[i]);
        const Real way = ahead.norm();
        quiet[i] = way > most ? 0 : quiet[i] + elapsed;
        anchor[i] = x[i] - (1 - follows) * (way > most ? most / way : 1) * ahead;
    });
}

void Sleep::look(World& world, double elapsed) {
    gather(world);
    follow(world, static_cast<Real>(elapsed));
    ParticleStore& fluid = world.fluid;
    const auto x = std::as_const(fluid).column<field::position>();
    const auto anchor = fluid.column<field::anchor>();
    const auto quiet = fluid.column<field::quiet_time>();
    const Domain& domain = world.step.domain;
    const bool solids_move = world.solids.any_moving();
    Cells cells(domain, reach(world));
    for (Index i = 0; i < fluid.size(); ++i) {
        const bool awake = quiet[i] >= 0;
        const bool restless = (awake && quiet[i] < options_.after / 2) || (solids_move && near_moving_solid(world, x[i]));
        // Where much counts as rest, a tenth of a spacing is yet enough to press on a sleeper.
        const bool stirs = restless || (awake && domain.minimum_image(x[i] - anchor[i]).norm() > Real(0.1) * world.step.spacing);
        cells.add(domain.wrapped(x[i]), {restless, stirs, awake, awake ? quiet[i] : std::numeric_limits<Real>::infinity()});
    }
    const auto near = cells.within_reach();
    sleepers_ = 0;
    for (Index i = 0; i < fluid.size(); ++i) {
        const Cell& around = near.at(cells.key_of(i));
        if (quiet[i] < 0 && around.stirs) {
            quiet[i] = options_.after / 2;  // awake, but no reason to wake others until it moves itself
        } else if (quiet[i] >= 0 && !around.restless && around.least_quiet >= options_.after) {
            quiet[i] = -1;
            anchor[i] = x[i];
            fluid.column<field::velocity>()[i].setZero();
            if (fluid.has<field::spin>()) fluid.column<field::spin>()[i].setZero();
        }
        sleepers_ += quiet[i] < 0;
    }
}

void Sleep::put_away(World& world) {
    if (sleepers_ == 0) {  // after a resume nobody has looked yet
        for (const Real q : std::as_const(world.fluid).column<field::quiet_time>()) sleepers_ += static_cast<Index>(q < 0);
        if (sleepers_ == 0) return;
    }
    ParticleStore& fluid = world.fluid;
    std::vector<Index> here, away;
    {
        const auto x = std::as_const(fluid).column<field::position>();
        const auto quiet = std::as_const(fluid).column<field::quiet_time>();
        const auto role = fluid.column<field::role>();
        Cells cells(world.step.domain, reach(world));
        for (Index i = 0; i < fluid.size(); ++i) cells.add(world.step.domain.wrapped(x[i]), {false, false, quiet[i] >= 0, 0});
        const auto near = cells.within_reach();
        for (Index i = 0; i < fluid.size(); ++i) {
            const bool deep = quiet[i] < 0 && !near.at(cells.key_of(i)).awake;
            (deep ? away : here).push_back(i);
            if (!deep && quiet[i] < 0 && role[i] == 0) role[i] = asleep_role;
        }
    }
    if (away.empty()) return;
    copy_dormant(fluid, away);
    fluid.gather(here);
}

void Sleep::copy_dormant(const ParticleStore& fluid, const std::vector<Index>& away) {
    for (const ParticleStore::Entry* entry : fluid.entries()) dormant_.declare(*entry->info, entry->lasting);
    dormant_.resize(static_cast<Index>(away.size()));
    for (const ParticleStore::Entry* entry : fluid.entries()) {
        const std::size_t bytes = entry->info->bytes;
        const auto* source = static_cast<const char*>(std::as_const(*entry->column).data());
        auto* target = static_cast<char*>(dormant_.find(entry->info->name)->column->data());
        parallel_for(static_cast<Index>(away.size()), [&](Index k) {
            std::memcpy(target + static_cast<std::size_t>(k) * bytes, source + static_cast<std::size_t>(away[k]) * bytes, bytes);
        });
        // Whole numbers name groups of the moment (a preconditioner's): who comes back later belongs to none.
        if (entry->info->integer && entry->info != &field_info<field::role>()) std::memset(target, 0, bytes * away.size());
    }
}

}  // namespace whorl
