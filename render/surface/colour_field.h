#pragma once
/// The colour field of a fluid given by particles: near 1 inside, 0 outside, whatever the local distance between the particles.
///
///     c(x) = sum_j V_j W_j(|x - x_j|),    V_j = m/rho_j = 1 / sum_k W_j(|x_j - x_k|),    W_j(r) = (1 - r^2/R_j^2)^3 (its norm drops out)
///
/// With equal volumes V_j round surfaces would shrink by sigma^2/r (sigma: the kernel's width) and single particles vanish. Normalised, a
/// flat surface is at c = ln 2 (the integral of dF/F, F from 1/2 to 1) in the limit of many particles, and at c = 0.605 with R = 2 d:
/// there spheres and cylinders of 1 to 5 spacings keep their radius within 0.055 d, flat surfaces their place within 0.01 d
/// (tests/render/surface/surface.cpp measures it).
///
/// A wide kernel makes bumps smaller and holds a thin thread together, but bridges gaps: with R = 2.25 d two threads merge at a distance of
/// 1.1 d. So R_j is 2 d where a particle has company, and grows to 2.4 d where it has little: a single file of particles stays in one piece
/// up to distances of 2.5 d, droplets of a few particles keep their size, and thick threads stay apart down to 1 d. Drops of a single
/// particle shrink the further they are from all others, as spray is finer than the spacing.
#include "render/surface/particle_rows.h"

namespace whorl {

class ColourField {
public:
    /// @param spacing d [m]  @param radius of the kernel over the spacing
    ColourField(Span<const Vec3f> position, double spacing, double radius);

    const ParticleRows& particles() const { return rows_; }
    float reach() const { return reach_; }  ///< the largest R [m]
    /// R_j [m], in sorted order.
    const std::vector<float>& radius() const { return radius_; }
    /// V_j: the height of particle j's bump, in sorted order.
    const std::vector<float>& height() const { return height_; }

private:
    float reach_;
    ParticleRows rows_;
    std::vector<float> height_, radius_;
};

/// The particles that the field needs within a box, copied together: many evaluations there are quick.
class LocalField {
public:
    void gather(const ColourField& field, const Vec3f& low, const Vec3f& high);

    struct Sample {
        float colour;
        Vec3f gradient;  ///< 1/m
        float company;   ///< sum of kernels of the largest R: 4.3 at a flat surface, 3.9 at a thread of radius 2.5 d, 1.6 at a single file
    };
    Sample at(const Vec3f& x) const;

    std::vector<float> x, y, z, height, inverse_R2;
    float reach = 0;
};

}  // namespace whorl
