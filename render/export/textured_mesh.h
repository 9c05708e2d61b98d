#pragma once
/// Pictures on solids as other programs read them.
#include "engine/io/frame.h"

namespace whorl {

/// A mesh whose triangles share no vertices, and the place of each vertex in the picture: (0, 0) is its upper left corner, (1, 1) its
/// lower right one, and it repeats beyond.
struct TexturedMesh {
    TriangleMesh mesh;
    std::vector<Eigen::Vector2f> place;
};
/// Places come from the solid's file if it has texture coordinates. Otherwise each triangle gets the picture along the axis that it faces
/// most. (Whorl's images blend the three projections near 45 degrees.)
/// @param solid with a mesh and a texture @throws InputError if its picture cannot be read
TexturedMesh textured_mesh(const FrameSolid& solid);

}  // namespace whorl
