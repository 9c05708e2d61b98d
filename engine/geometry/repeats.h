#pragma once
/// Periodic images of shapes: in a periodic domain every shape repeats with each period.
#include "engine/geometry/shape.h"

namespace whorl {

/// The images of a bounded shape along the domain's periodic axes. The fluid interacts with their union.
class Repeats {
public:
    Repeats() = default;
    /// @param rotation, translation from the shape's own axes to the domain's axes
    Repeats(const Shape& shape, const Domain& domain, const Mat3& rotation = Mat3::Identity(), const Vec3& translation = Vec3::Zero());

    bool any() const { return any_; }
    /// Displacements [m], whole periods, of the images that reach into the domain. The first is the displacement of the image whose middle
    /// is in the domain. Along an axis whose period the shape spans, only that image counts.
    std::vector<Vec3> shifts_into(const Domain& domain) const;
    /// Smallest signed distance [m] from x to any image. @param distance signed distance from the shape itself, as a function of position
    /// @param image (out) the position equivalent to x, moved by whole periods, that is nearest to the shape itself. Along an axis that the
    /// shape spans without ends, its coordinate is that of the shape's centre
    template <class F>
    Real least(const Vec3& x, F&& distance, Vec3& image) const {
        Vec3 near = x;
        for (int a = 0; a < 3; ++a)
            if (endless_[a]) near[a] = centre_[a];
            else if (period_[a] > 0) near[a] -= period_[a] * std::nearbyint((near[a] - centre_[a]) / period_[a]);
        image = near;
        Real best = distance(near);
        // The image with the nearest centre need not have the nearest surface. Along each axis the next image may have a nearer one.
        for (unsigned other = 1; other <= axes_; ++other) {
            if ((other & ~axes_) != 0) continue;
            Vec3 at = near;
            bool may = true;
            for (int a = 0; a < 3 && may; ++a) {
                if (!(other >> a & 1)) continue;
                at[a] -= std::copysign(period_[a], near[a] - centre_[a]);
                const Real apart = std::abs(at[a] - centre_[a]) - half_[a];  // lower bound of the distance to that image
                may = apart <= 0 || apart < best;
            }
            if (!may) continue;
            if (const Real there = distance(at); there < best) best = there, image = at;
        }
        return best;
    }

private:
    Vec3 period_ = Vec3::Zero();  ///< m, 0: not repeated
    Vec3 centre_ = Vec3::Zero(), half_ = Vec3::Zero();
    std::array<bool, 3> endless_{false, false, false};
    unsigned axes_ = 0;  ///< bit a: the shape repeats along axis a
    bool any_ = false;
};

/// A shape with its periodic images. Distance and normal are those of the nearest image; bounds, volume and mesh are those of one image.
class Repeated final : public Shape {
public:
    /// @param shape must outlive this object
    Repeated(const Shape& shape, const Domain& domain) : shape_(shape), repeats_(shape, domain) {}
    Repeated(std::shared_ptr<const Shape> shape, const Domain& domain) : Repeated(*shape, domain) {
        remarks = shape->remarks, owned_ = std::move(shape);
    }

    Real distance(const Vec3& x) const override {
        Vec3 image;
        return distance(x, image);
    }
    Vec3 normal(const Vec3& x) const override {
        Vec3 image;
        distance(x, image);
        return shape_.normal(image);
    }
    void bounds(Vec3& min, Vec3& max) const override { shape_.bounds(min, max); }
    bool bounded() const override { return shape_.bounded(); }
    bool prismatic(int axis) const override { return shape_.prismatic(axis); }
    bool shell() const override { return shape_.shell(); }
    MassProperties bulk() const override { return shape_.bulk(); }
    TriangleMesh mesh(Real edge, Real extent) const override { return shape_.mesh(edge, extent); }
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        return shape_.surface_samples(offset, region);
    }

private:
    Real distance(const Vec3& x, Vec3& image) const {
        image = x;
        if (!repeats_.any()) return shape_.distance(x);
        return repeats_.least(
            x, [this](const Vec3& at) { return shape_.distance(at); }, image);
    }
    std::shared_ptr<const Shape> owned_;
    const Shape& shape_;
    Repeats repeats_;
};

/// The shape, with its images if the domain is periodic. @throws InputError like make_shape(keys)
std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys, const Domain& domain);

}  // namespace whorl
