#pragma once
/// Images of the fluid in flat walls (docs/physics.md 3).
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// The space behind a flat wall is full of images of the fluid. They are neighbours like others,
///   rho_i = (m W_ii + sum_j m W_ij + sum_g (a_i + a_j)/2 m W(x_i - x_g))/(1 - (1 - a_i) w_i),   x_g = x_j - 2 h_j n,
/// with j the particle (i, too) whose image g is; beside two walls at right angles there are images of images. a_i is 1 where the walls
/// about i are flat and 0 elsewhere (SolidParticles::flat), and nearer than d/10 to a wall, which an impact alone reaches. As W depends on
/// r_ij^2 + 4 h_i h_j, g pushes i as the image of i pushes j.
class Mirrors {
public:
    /// What the neighbours are with images. `around` itself where there are none. @param none no wall shows images
    Surroundings find(const Surroundings& around, bool none = false);
    /// The same, as found.
    Surroundings seen(const Surroundings& around) const {
        return {part_.empty() ? around.pairs : pairs_, around.solid_pairs, around.solids, around.layer, around.step};
    }
    /// Images.
    Index size() const { return static_cast<Index>(images_.size()); }
    /// a_i
    Real part(Index i) const { return part_.empty() ? 0 : part_[i]; }
    Index owner(Index j) const { return j < particles_ ? j : images_[j - particles_].owner; }
    /// Factors of the pairs of i in the density, nullptr: all are 1.
    const Real* weights(Index i) const { return part_.empty() || !weighted_[i] ? nullptr : &weight_[pairs_.first[i]]; }
    /// A flat wall before a particle.
    struct Wall {
        Vec3 normal;  ///< into the fluid
        Real offset;  ///< of the surface along it [m]
        Index solid;
        Real height(const Vec3& x) const { return x.dot(normal) - offset; }
    };
    struct Image {
        Index owner;
        int count;  ///< of walls
        Wall wall[2];
    };
    const Image& image(Index g) const { return images_[g - particles_]; }
    /// Lets images follow the particles.
    void place(Span<const Vec3> x);
    Span<const Vec3> places() const { return places_; }
    /// of_images[g] = v of the owner, mirrored: the part along each wall's normal becomes twice `middle` less it. @param middle of a Wall
    template <class Vector, class Middle>
    void reflect(const Vector* v, Vector* of_images, const Middle& middle) const {
        parallel_for(size(), [&](Index g) {
            const Image& image = images_[g];
            Vector there = v[image.owner];
            for (int m = 0; m < image.count; ++m) {
                const Wall& wall = image.wall[m];
                there.template head<3>() -= 2 * (wall.normal.dot(there.template head<3>()) - middle(wall)) * wall.normal;
            }
            of_images[g] = there;
        });
    }
    /// The velocities v, and after them those of the images. @param of_solid by solid [m/s]
    template <class OfSolid>
    Span<const Vec3> velocities(Span<const Vec3> v, const OfSolid& of_solid) const {
        if (size() == 0) return v;
        velocities_.assign(v.begin(), v.end());
        velocities_.resize(v.size() + images_.size());
        reflect(v.data(), velocities_.data() + v.size(), [&](const Wall& wall) { return wall.normal.dot(of_solid(wall.solid)); });
        return velocities_;
    }

private:
    struct Seen {
        int own = 0, count = 0;  ///< of walls: those that solid neighbours belong to; with those of neighbours
        Wall wall[3];
        bool knows(const Vec3& normal) const {
            for (int m = 0; m < count; ++m)
                if (wall[m].normal.dot(normal) > Real(0.99)) return true;
            return false;
        }
    };
    static Column<Real> flat_now(const Surroundings& around);
    void look(const Surroundings& around, Span<const Real> flat, Index i);
    void ask_neighbours(const Surroundings& around, Index i);
    void find_images();
    void find_pairs(const Surroundings& around);

    Index particles_ = 0;
    FluidPairs pairs_;
    Column<Real> weight_, part_;
    Column<Vec3> places_;
    mutable Column<Vec3> velocities_;
    std::vector<Seen> seen_;
    std::vector<char> near_, weighted_;  ///< by particle: whether solid neighbours are a wall; whether a weight is not 1
    std::vector<Index> first_;           ///< by particle, into images_
    std::vector<Image> images_;
};

}  // namespace whorl
