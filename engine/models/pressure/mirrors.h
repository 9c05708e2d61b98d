#pragma once
/// Images of the fluid in flat walls (docs/physics.md 3).
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// The space behind a flat wall is full of images of the fluid, which are neighbours like particles:
///   rho_i = (m W_ii + sum_j m W_ij + sum_g (a_i + a_j)/2 m W(x_i - x_g))/(1 - (1 - a_i) w_i),   x_g = x_j - 2 h_j n.
/// The image g belongs to particle j (which may be i itself), h_j is the height of j above the wall, n the wall's normal and w_i the part
/// of boundary particles (density_rate.h). Near two or three walls at right angles there are images of images. a_i is 1 if the walls around
/// i are flat. It is 0 at other walls (BoundaryParticles::flat), and closer to a wall than d/10, which happens only in impacts. The kernel
/// depends on r_ij^2 + 4 h_i h_j, so the force of g on i equals that of the image of i on j.
class Mirrors {
public:
    /// @param none true: no wall has images
    void find(const InteractionContext& context, bool none = false);
    /// Number of images.
    Index size() const { return static_cast<Index>(images_.size()); }
    /// Rows of images: row i contains those that are neighbours of particle i.
    const Pairs& pairs() const { return pairs_; }
    /// Number of images that are neighbours of i.
    Index count(Index i) const { return images_.empty() ? 0 : pairs_.count(i); }
    /// Weights (a_i + a_j)/2 of the images that are neighbours of i. The array is padded to a whole group.
    const Real* weights(Index i) const { return &weight_[pairs_.first[i]]; }
    /// Calls f(g, r, distance, weight) for each image g that is a neighbour of i.
    template <class F>
    void of(Index i, F&& f) const {
        if (count(i) == 0) return;
        const Real* weight = weights(i);
        pairs_.of(i, [&](Index g, const Vec3& r, Real distance) { f(g, r, distance, *weight++); });
    }
    /// Calls f.operator()<image>(group, weights) for groups of neighbours of i. Fluid groups come first (image = false), then images.
    template <class F>
    void groups_of(const Pairs& fluid, Index i, F&& f) const {
        fluid.groups_of(i, [&](const Pairs::Group& group) { f.template operator()<false>(group, nullptr); });
        if (count(i) == 0) return;
        const Real* weight = weights(i);
        pairs_.groups_of(i, [&](const Pairs::Group& group) {
            f.template operator()<true>(group, weight);
            weight += group.count;
        });
    }
    /// a_i
    Real part(Index i) const { return part_.empty() ? 0 : part_[i]; }
    Index owner(Index g) const { return images_[g].owner; }
    /// Flat wall near a particle.
    struct Wall {
        Vec3 normal;  ///< into the fluid
        Real offset;  ///< position of the surface along the normal [m]
        Index solid;
        Real height(const Vec3& x) const { return x.dot(normal) - offset; }
    };
    struct Image {
        Index owner;
        int count;  ///< number of walls
        Wall wall[3];
    };
    const Image& image(Index g) const { return images_[g]; }
    /// Updates the positions of the images from those of the particles.
    void place(Span<const Vec3> x);
    Span<const Vec3> places() const { return places_; }
    /// of_images[g] = v of the owner, reflected in each wall of the image: v.n becomes 2 middle(wall) - v.n. @param middle Wall -> value on
    /// the wall
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
    /// Velocities of the images. @param of_solid solid -> velocity [m/s]
    template <class OfSolid>
    Span<const Vec3> velocities(Span<const Vec3> v, const OfSolid& of_solid) const {
        velocities_.resize(images_.size());
        reflect(v.data(), velocities_.data(), [&](const Wall& wall) { return wall.normal.dot(of_solid(wall.solid)); });
        return velocities_;
    }

private:
    struct Seen {
        int count = 0;  ///< number of walls
        Wall wall[3];
        bool knows(const Vec3& normal) const {
            for (int m = 0; m < count; ++m)
                if (wall[m].normal.dot(normal) > Real(0.99)) return true;
            return false;
        }
    };
    static Column<Real> flat_now(const InteractionContext& context);
    void look(const InteractionContext& context, Span<const Real> flat, Index i);
    void find_images(Index particles);
    std::size_t list_images_near(const FluidPairs& fluid, Index i, std::vector<Index>& list) const;
    void find_pairs(const FluidPairs& fluid);

    Pairs pairs_;
    Column<Real> weight_, part_;
    Column<Vec3> places_;
    mutable Column<Vec3> velocities_;
    std::vector<Seen> seen_;
    std::vector<Index> first_;  ///< index into images_, by particle
    std::vector<Image> images_;
};

}  // namespace whorl
