#pragma once
/// Ink markers: points, several per particle, that carry ink with the flow. Images of ink draw the markers instead of the particles, so
/// that filaments thinner than the spacing are visible. Markers do not act on the fluid.
#include "engine/models/ink/ink.h"
#include "engine/particles/search.h"

namespace whorl {

namespace field {
struct path_start {
    using type = Vec3;
    static constexpr std::string_view name = "path_start", unit = "m", meaning = "where the particle was when the ink markers last moved";
};
struct path {
    using type = Vec3;
    static constexpr std::string_view name = "path", unit = "m", meaning = "displacement by the velocity since then";
};
}  // namespace field

struct InkMarkers {
    int per_spacing = 0;  ///< along each axis; 0: no markers
    ParticleStore store;  ///< position, ink
    double waiting = 0;   ///< time since the markers last moved [s]

    /// Adds the markers of new particles, on the lattice of per_spacing points per spacing around each. @returns the first new one
    Index add(Span<const Vec3> particles, const StepContext& step);
    /// Adds markers, with the particle's ink, to every particle that has no marker within .75 spacings. Such particles are in sheets, drops
    /// and splashes, from which markers stray.
    void fill_gaps(const StepContext& step, Span<const Vec3> particles, Span<const Vec3> inks, NeighbourSearch& search);
};

/// Moves the markers when a particle has moved two spacings, and at frame times, by x_m += s(x_m). s is the linear function that fits best
/// the displacements (sums of dt u) of the particles within 1.75 spacings of the marker, plus the fit of the errors of this function at the
/// particles. s is exact for every affine motion. The displacements belong to the particles' old positions. Displacements of particles by
/// anything but their velocity do not move markers.
///
/// If ink diffuses, the ink of a marker approaches the mean of these particles like a wave of two spacings,
///     c_m += (1 - exp(-D (pi/d)^2 dt)) (sum w c_j/sum w - c_m);
/// with D the diffusivity and d the spacing. Structures larger than that follow the particles. A marker without a particle near is removed.
/// At frame times gaps are filled.
struct MoveInkMarkers {
    double diffusion = 0;  ///< m^2/s
    void operator()(const StepContext& step, Read<field::position> x, Read<field::velocity> u, Read<field::ink> c,
                    Update<field::path_start> start, Update<field::path> path, InkMarkers& markers, NeighbourSearch& search) const;
};

}  // namespace whorl
