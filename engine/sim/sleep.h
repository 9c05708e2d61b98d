#pragma once
/// Fluid at rest is not solved for: it sleeps, out of the stages' sight, until something moves nearby.
///
/// A particle is quiet while it stays within `tolerance` spacings of its anchor, its mean place over the past (weights fade within `after`
/// seconds): while it moves by less than that in such a time, however long it has been creeping. Once all particles within reach have been
/// quiet for `after` seconds it falls asleep: its velocity is zero and stays so. Sleepers next to somebody awake are held in the store with
/// a prescribed role, so that every model treats them as it treats fluid that a nozzle holds; the others are put away. Whoever moves (is
/// not quiet for half of `after`, or is a tenth of a spacing off its anchor) wakes all sleepers within reach. Reach is a kernel radius and
/// what CFL allows between two looks.
///
/// At every frame time all particles are in the store with their own roles: frames, probes and checkpoints know nothing of sleep.
#include "engine/sim/world.h"

namespace whorl {

namespace field {
struct anchor {
    using type = Vec3;
    static constexpr std::string_view name = "anchor", unit = "m",
                                      meaning = "where the particle was over the last half second, at most what counts as rest away";
};
/// Negative: asleep.
struct quiet_time {
    using type = Real;
    static constexpr std::string_view name = "quiet_time", unit = "s",
                                      meaning = "since it last was farther from its anchor than what counts as rest; negative: asleep";
};
}  // namespace field

/// The last of a step's stages: sleepers stay where they are, whatever the models before it did.
struct HoldSleepers {
    void operator()(Read<field::role> role, Read<field::anchor> anchor, Update<field::quiet_time> quiet, Update<field::velocity> u,
                    Update<field::position> x) const;
};

struct SleepOptions {
    Real tolerance = 0;      ///< spacings
    Real after = Real(0.5);  ///< s
    Real cfl = Real(0.4);    ///< spacings that a particle may move in a step
};

class Sleep {
public:
    /// Steps between two looks, counted from the frame time.
    static constexpr long look_every = 4;
    static constexpr std::int16_t asleep_role = -32768;

    explicit Sleep(SleepOptions options) : options_(options) {}

    /// After a step: brings all particles back into the store, sees who rests and who wakes. @param elapsed s, since the last look
    void look(World& world, double elapsed);
    /// Before a step: takes out of the store who sleeps far from all others, holds who sleeps next to somebody awake.
    void put_away(World& world);
    /// Brings all particles back, with their own roles.
    void gather(World& world);
    /// Something changed that everybody feels. Only where all particles are in the store.
    void wake_all(World& world);

    Index sleepers() const { return sleepers_; }  ///< of the last look

private:
    struct Cell;
    class Cells;
    double reach(const World& world) const;  ///< m
    bool near_moving_solid(const World& world, const Vec3& x) const;
    void follow(World& world, Real elapsed) const;
    void copy_dormant(const ParticleStore& fluid, const std::vector<Index>& away);

    SleepOptions options_;
    ParticleStore dormant_;
    Index sleepers_ = 0;
};

}  // namespace whorl
