#include "engine/scene/scene_shapes.h"

#include <limits>
#include <numbers>

#include "engine/scene/tree.h"

namespace whorl {
namespace {

Extent extent_of(const ShapeKeys& keys, const Shape& shape) {
    constexpr double pi = std::numbers::pi, endless = std::numeric_limits<double>::infinity();
    if (!shape.bounded()) return {Vec3d::Constant(-endless), Vec3d::Constant(endless), 0};
    if (keys.kind == "box" && !keys.cut && !keys.is_open()) return {keys.min, keys.max, (keys.max - keys.min).prod()};
    if (keys.kind == "box" && !keys.is_open()) {
        const Vec3d low(keys.min.x(), keys.min.y(), 0), high(keys.max.x(), keys.max.y(), 0);
        return {low, high, (high - low).head<2>().prod()};
    }
    Vec3 min, max;
    shape.bounds(min, max);
    const double r = keys.radius;
    const double volume = keys.cut || keys.is_open() ? shape.bulk().volume
                          : keys.kind == "sphere"    ? 4 * pi / 3 * r * r * r
                          : keys.kind == "cylinder"  ? pi * r * r * (keys.to - keys.from).norm()
                                                     : shape.bulk().volume;
    return {min.cast<double>(), max.cast<double>(), volume};
}

/// The bounding box of a rotated box.
Extent turned(const Extent& e, const Solid& solid) {
    const Mat3d& turn = solid.turn;
    Vec3d middle = (e.min + e.max) / 2;
    const Vec3d half = (e.max - e.min) / 2;
    if (!half.allFinite() || turn.isIdentity()) return e;
    if (solid.own_pivot) middle = *solid.own_pivot + turn * (middle - *solid.own_pivot);
    const Vec3d reach = turn.cwiseAbs() * half;
    return {middle - reach, middle + reach, e.volume};
}

/// The shape. If its mesh file is faulty, adds the error at the key that names the file, and returns null.
/// @param domain its periodic axes repeat the shape; null for a solid, whose images depend on its pose
std::shared_ptr<const Shape> made(const Scene& scene, const std::string& name, const ShapeKeys& keys, std::vector<Problem>& problems,
                                  const Domain* domain = nullptr) {
    try {
        return domain ? make_shape(keys, *domain) : make_shape(keys);
    } catch (const InputError& e) {
        for (const Problem& p : e.problems()) problems.push_back({scene.place(name + ".file"), name + ": " + p.message(), "", ""});
        return nullptr;
    }
}

Mat3d turned_by(const Vec3d& degrees) {
    const double angle = std::numbers::pi / 180 * degrees.norm();
    return angle > 0 ? Eigen::AngleAxisd(angle, degrees.normalized()).toRotationMatrix() : Mat3d(Mat3d::Identity());
}

RigidBody body_of(const SolidKeys& keys, const Shape& shape) {
    RigidBody body(shape.bulk(), keys.density);
    body.centre += keys.position(0);
    body.turn = Eigen::Quaterniond(turned_by(keys.tilt));
    body.velocity = keys.velocity;
    body.spin_at(body.turn * keys.rotation(0));
    return body;
}

}  // namespace

ShapeKeys shape_of(const Scene& scene, const SolidKeys& keys) {
    ShapeKeys shape = keys.shape;
    if (shape.is_open() && !shape.wall) shape.wall = 3 * scene.fluid.spacing;
    return shape;
}

double slip_length_of(const SolidKeys& keys) {
    switch (keys.slip) {
        case Slip::no: return 0;
        case Slip::free: return std::numeric_limits<double>::infinity();
        case Slip::navier: return keys.slip_length;
    }
    return 0;
}

Solid solid_of(const SolidKeys& keys, std::shared_ptr<const Shape> shape) {
    Solid solid;
    solid.shape = std::move(shape);
    solid.position = keys.position;
    solid.spin = keys.rotation;
    solid.own_pivot = keys.pivot;
    solid.inside = keys.closed();
    solid.turn = keys.motion ? keys.motion(0).turn.toRotationMatrix() : turned_by(keys.tilt);
    solid.motion = keys.motion;
    solid.slip_length = slip_length_of(keys);
    solid.contact = {keys.friction, keys.bounce};
    if (keys.density > 0 && solid.shape && solid.shape->bounded()) solid.body = body_of(keys, *solid.shape);
    return solid;
}

EmitterShape opening_of(const EmitterKeys& keys, int dimensions) {
    EmitterShape shape;
    shape.slot = keys.shape == "box";
    shape.centre = keys.position(0).cast<Real>();
    shape.direction = keys.direction(0).normalized().cast<Real>();
    shape.radius = static_cast<Real>(keys.radius);
    shape.width = static_cast<Real>(keys.width);
    shape.thickness = static_cast<Real>(keys.thickness);
    shape.parabolic = keys.profile == Profile::parabolic;
    shape.plane = dimensions == 2;
    if (shape.plane && !shape.slot) shape.width = 2 * shape.radius;
    return shape;
}

SceneShapes make_shapes(const Scene& scene, std::vector<Problem>& problems) {
    SceneShapes shapes;
    const Domain domain = shapes.solids.domain = scene.domain.box();
    for (std::size_t i = 0; i < scene.blocks.size(); ++i) {
        const ShapeKeys& keys = scene.blocks[i].shape;
        shapes.blocks.push_back(made(scene, entry_name("block", i), keys, problems, &domain));
        shapes.block_extent.push_back(shapes.blocks.back() ? extent_of(keys, *shapes.blocks.back()) : Extent{});
    }
    for (std::size_t i = 0; i < scene.solids.size(); ++i) {
        const SolidKeys& keys = scene.solids[i];
        Solid solid = solid_of(keys, made(scene, entry_name("solid", i), shape_of(scene, keys), problems));
        shapes.solid_extent.push_back(solid.shape ? turned(extent_of(keys.shape, *solid.shape), solid) : Extent{});
        shapes.solids.all.push_back(std::move(solid));
    }
    for (std::size_t i = 0; i < scene.drains.size(); ++i) {
        const ShapeKeys& keys = scene.drains[i].shape;
        shapes.drains.push_back(made(scene, entry_name("drain", i), keys, problems, &domain));
        shapes.drain_extent.push_back(shapes.drains.back() ? extent_of(keys, *shapes.drains.back()) : Extent{});
    }
    if (problems.empty()) shapes.solids.set_time(0, scene.time.look_ahead());
    return shapes;
}

bool in_solids(const SceneShapes& shapes, const Vec3& x, double margin) {
    Real distance = 0;
    return shapes.solids.nearest(x, distance) >= 0 && distance < static_cast<Real>(margin);
}

}  // namespace whorl
