#pragma once
/// Colour field of a fluid given by particles: near 1 inside and 0 outside, for any local distance between the particles.
///
///     c(x) = sum_j V_j W_j(|x - x_j|),    V_j = m/rho_j = 1 / sum_k W_j(|x_j - x_k|),    W_j(r) = (1 - r^2/R_j^2)^3 (its normalisation
///     factor cancels)
///
/// With equal volumes V_j a sphere of radius r would shrink by sigma^2/r (sigma: the kernel's standard deviation along an axis), and single
/// particles would vanish. With the V_j above and many particles, a flat surface is at c = ln 2, the integral of dF/F for F from 1/2 to 1.
/// F is the fraction of a particle's kernel that lies in the fluid: 1/2 at the surface and 1 deep inside. With R = 2 d a flat surface is at
/// c = 0.605. At that value spheres and cylinders of 1 to 5 spacings keep their radius within 0.055 d, and flat surfaces their position
/// within 0.01 d (measured by tests/render/surface/surface.cpp).
///
/// A wide kernel makes bumps smaller and keeps a thin thread together, but it bridges gaps: with R = 2.25 d two threads merge at a distance
/// of 1.1 d. So R_j is 2 d if a particle has many neighbours, and grows to 2.4 d if it has few. A single file of particles then stays in
/// one piece up to distances of 2.5 d, droplets of a few particles keep their size, and thick threads stay apart down to 1 d. A lone
/// particle is drawn smaller the farther it is from all others, because real spray is finer than the spacing.
#include "render/surface/ghosts.h"
#include "render/surface/particle_rows.h"

namespace whorl {

class ColourField {
public:
    /// @param spacing d [m]  @param radius kernel radius [spacings]
    ColourField(Span<const Vec3f> position, double spacing, double radius);

    const ParticleRows& particles() const { return rows_; }
    float reach() const { return reach_; }  ///< the largest R [m]
    /// R_j [m], in sorted order.
    const std::vector<float>& radius() const { return radius_; }
    /// V_j in sorted order, factor of the particle's kernel.
    const std::vector<float>& height() const { return height_; }

private:
    float reach_;
    ParticleRows rows_;
    std::vector<float> height_, radius_;
};

/// Copy of the particles that the field needs within a box, for many fast evaluations there.
class LocalField {
public:
    /// @param at_glass for points that Cut::off_glass() moves, too
    void gather(const ColourField& field, const Vec3f& low, const Vec3f& high, bool at_glass = false);

    struct Sample {
        float colour;
        Vec3f gradient;  ///< 1/m
        float company;   ///< sum of kernels of the largest R: 4.3 at a flat surface, 3.9 at a thread of radius 2.5 d, 1.6 at a single file
    };
    Sample at(const Vec3f& x) const;
    /// The field at x near the cut: no more than cut_colour(), and at glass no less than half a kernel's radius away from it, because fluid
    /// wets glass but its particles keep a distance.
    Sample at(const Vec3f& x, const Cut& near, float iso) const;
    /// Distance from glass over which the field is constant [m].
    float wetting() const { return 0.42f * reach; }

    std::vector<float> x, y, z, height, inverse_R2;
    float reach = 0;
};

}  // namespace whorl
