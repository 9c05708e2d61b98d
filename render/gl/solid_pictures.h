#pragma once
/// Pictures on solids (Appearance::texture).
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/gl/objects.h"

namespace whorl {

class SolidPictures {
public:
    /// Reads the pictures of the solids that are not known yet. @throws InputError if one cannot be read
    void fill(const std::vector<FrameSolid>& solids);
    /// Sets the uniforms of face.frag for a solid with a picture; uses one texture unit.
    void bind(gl::Program& program, int unit, const FrameSolid& solid) const;

private:
    struct Picture {
        gl::Texture texture;
        float height = 1;  ///< over its width
    };
    struct Extent {
        std::shared_ptr<const TriangleMesh> mesh;  ///< kept alive: its address is the key
        Vec3f middle;                              ///< m
        float longest;                             ///< m
    };
    std::map<std::string, Picture> pictures_;
    std::map<const TriangleMesh*, Extent> extents_;
};

}  // namespace whorl
