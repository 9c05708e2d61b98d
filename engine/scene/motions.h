#pragma once
/// Motions of solids and emitters by keys and by animations of glTF files.
#include "engine/scene/reader.h"

namespace whorl {

/// Adds these motions to the `position`, `rotation` and `direction` of solids and emitters, whose texts stay those of the file, and sets
/// SolidKeys::motion. Reports invalid keys, files and nodes. The paths of files must be absolute.
void add_motions(Scene& scene, Reader& reader);

}  // namespace whorl
