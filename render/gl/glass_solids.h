#pragma once
/// Solids of glass for refract.frag: their looks, and their shapes as exact bodies or in a distance field.
#include <map>
#include <memory>

#include "render/gl/solid_field.h"
#include "render/surface/exact_solid.h"

namespace whorl {

class GlassSolids {
public:
    explicit GlassSolids(int height) : field_(height, true) {}
    /// @param solids those of the frame that are glass. Where two overlap, the smaller one fills the common part.
    void fill(const std::vector<FrameSolid>& solids);
    /// Number of each of these solids in the shader.
    const std::vector<int>& numbers() const { return number_; }
    /// GLSL declarations of the constants that the shader needs.
    std::string constants() const;
    /// Sets the uniforms of solids_of_glass.glsl; uses one texture unit.
    void bind(gl::Program& program, int unit) const;

private:
    struct Known {
        std::optional<ExactSolid> exact;
        float volume;  ///< m^3
    };
    struct Entry {
        const FrameSolid* solid;
        const Known* known;
        std::size_t place;  ///< in the list of solids
        int channel;        ///< of the field; -1: exact
    };
    void choose_channels(std::vector<Entry>& entries);
    void add_body(const ConvexBody& body);
    void add_looks(const std::vector<Entry>& entries);

    std::map<std::shared_ptr<const TriangleMesh>, Known> known_;
    std::vector<int> number_;
    int channels_ = 0;
    SolidField field_;
    std::vector<Eigen::Vector4f> planes_, rounds_, bodies_, looks_;
    Eigen::Vector4f first_;  ///< least number of a solid in each channel
};

}  // namespace whorl
