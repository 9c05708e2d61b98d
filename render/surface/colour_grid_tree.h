#pragma once
/// The OpenVDB side of the colour grid: included by .cpp files only (it takes 20 s to compile).
#include <openvdb/openvdb.h>

#include "render/surface/colour_grid.h"

namespace whorl {

struct ColourGrid::Tree {
    openvdb::FloatTree floats{0.0f};
};

/// OpenVDB's tables of types, set up once; and its threads, as many as Whorl's own.
void prepare_openvdb();

}  // namespace whorl
