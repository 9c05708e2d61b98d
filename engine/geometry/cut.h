#pragma once
/// What the plane z = 0 cuts out of a box, a sphere or a cylinder along z: the shapes of a flow in two dimensions.
#include "engine/geometry/shape.h"

namespace whorl {

/// Whether the plane cuts the shape, and in a rectangle or a disc; else why not, in words that go on after the shape's name.
std::string why_no_cut(const ShapeKeys& keys);
/// A rectangle or a disc. Distances and normals lie in the plane, whatever z. @param keys why_no_cut() is empty
std::shared_ptr<const Shape> make_cut(const ShapeKeys& keys);

}  // namespace whorl
