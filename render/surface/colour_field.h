#pragma once
/// The colour field of a fluid given by particles: near 1 inside, 0 outside, whatever the local distance between the particles.
///
///     c(x) = sum_j V_j W(|x - x_j|),    V_j = m/rho_j = 1 / sum_k W(|x_j - x_k|),    W(r) = (1 - r^2/R^2)^3 (its norm drops out)
///
/// With equal volumes V_j round surfaces would shrink by sigma^2/r (sigma: the kernel's width) and single particles vanish. Normalised, a flat
/// surface stands at c = ln 2 (the integral of dF/F, F from 1/2 to 1) in the limit of many particles, and at c = 0.615 with R = 2.25 d: there
/// spheres and cylinders of 1.5 to 5 spacings keep their radius within 0.05 d, flat surfaces their place within 0.03 d
/// (tools/bench/surface.cpp measures it), and a single file of particles stays in one piece up to distances of 2.5 d. A wider kernel makes bumps a little smaller,
/// but threads that come near each other merge earlier (with R = 2.25 d: at 1 d).
#include "render/surface/particle_rows.h"

namespace whorl {

class ColourField {
public:
    /// @param spacing d [m]  @param radius of the kernel over the spacing
    ColourField(Span<const Vec3f> position, double spacing, double radius);

    const ParticleRows& particles() const { return rows_; }
    float reach() const { return reach_; }  ///< R [m]
    /// V_j: the height of particle j's bump, in sorted order.
    const std::vector<float>& height() const { return height_; }

private:
    float reach_;
    ParticleRows rows_;
    std::vector<float> height_;
};

/// The particles that the field needs within a box, copied together: many evaluations there are quick.
class LocalField {
public:
    void gather(const ColourField& field, const Vec3f& low, const Vec3f& high);

    struct Sample {
        float colour;
        Vec3f gradient;  ///< 1/m
    };
    Sample at(const Vec3f& x) const;

    std::vector<float> x, y, z, height;
    std::vector<Index> original;  ///< index in the frame
    float reach = 0;
};

}  // namespace whorl
