#pragma once
/// Fluid that passes through an opening: a disc, or a rectangle whose axes are those of an emitter's slot; in two dimensions a line.
///
/// Every particle whose path in a step crosses the opening counts, +1 along `direction` and -1 against it: volume [m^3] and mass [kg] are
/// the totals since the run began, exact to one particle, and volume_rate and mass_rate the means since the row before (empty in the first
/// row). Openings that tile a closed surface lose nothing. A particle that is taken away in the step in which it crosses (by a drain, or
/// at the domain's end) has gone straight on with its last velocity. Particles in nozzles do not count. In two dimensions volumes are those
/// of a metre of depth.
#include <unordered_map>

#include "engine/probes/probes.h"

namespace whorl {

class FluxProbe : public Probe {
public:
    /// @param world its particles have the column `id`
    FluxProbe(const ProbeKeys& keys, const World& world);
    ProbeColumns columns() const override {
        return {{"time", "s", ""},
                {"volume_rate", "m^3/s", "volume a second"},
                {"mass_rate", "kg/s", "mass a second"},
                {"volume", "m^3", "volume that has passed"},
                {"mass", "kg", "mass that has passed"}};
    }
    void after_step(const World& world, double time) override;
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    struct Track {
        Vec3d x, place, velocity;  ///< m, in the world's axes; m and m/s along the opening's two axes and its normal
    };
    using Tracks = std::unordered_map<std::int32_t, Track>;
    struct Memory {
        double passed = 0, passed_at_row = 0, row_time = 0;  ///< particles; s
        bool any_row = false;
    };

    Tracks near_opening(const World& world, double reach) const;
    double distance(const Vec3d& place) const;
    int crossing(const Domain& domain, const Vec3d& from, const Vec3d& to) const;

    Vec3d centre_;
    Mat3d axes_;  ///< rows: along the opening, along it, across it
    double radius_, half_width_, half_thickness_;
    Tracks tracks_;  ///< at the end of the step before, by the particle's number
    Memory memory_;
};

}  // namespace whorl
