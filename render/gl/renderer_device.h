#pragma once
/// The passes of an image and the objects on the graphics device that they share.
#include <optional>

#include "render/gl/aov_pass.h"
#include "render/gl/context.h"
#include "render/gl/field_texture.h"
#include "render/gl/flow_shapes.h"
#include "render/gl/foam_pass.h"
#include "render/gl/glass_pass.h"
#include "render/gl/ground_light.h"
#include "render/gl/motion_blur.h"
#include "render/gl/objects.h"
#include "render/gl/renderer.h"
#include "render/gl/sample_accumulator.h"
#include "render/gl/scene_geometry.h"
#include "render/gl/scene_lighting.h"
#include "render/gl/shot.h"
#include "render/gl/solid_field.h"
#include "render/gl/solid_pictures.h"
#include "render/look/overlay.h"

namespace whorl {

/// Texture units that passes share. Each pass uses units 0 .. 3 for its own textures.
constexpr int ground_unit = 4, shadow_unit = 5, field_unit = 7, solid_unit = 9, solid_light_unit = 10, ink_unit = 12, surround_unit = 13;

struct Renderer::Device {
    Device(int w, int h) : width(w), height(h) { glEnable(GL_PROGRAM_POINT_SIZE); }
    ~Device() { context.make_current(); }  // deleting objects acts on the current context

    // renderer.cpp: an image, its samples, and what follows them
    Image draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view);
    PictureLayers draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view, const NextView& next);
    std::array<float, 2> begin(const Frame& frame, const LookOptions& look);
    Shot sum_samples(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view,
                     const std::array<float, 2>& range, const PictureBox& box);
    bool refracts(const Material& material) const { return material.refracts && !field.empty(); }
    void set_studio(gl::Program& program, const Shot& shot) const;
    LayerView layer_view(const Shot& shot, const NextView& next) const;
    void blur_motion(const Shot& shot, float open);
    void draw_foam(const Shot& shot, const Frame& frame, float open);
    void draw_sample(const Shot& shot, int sample);
    void draw_from(const Shot& shot, int sample);

    // solid_passes.cpp
    void find_solid_light(const Shot& shot, const Eigen::Matrix4f& matrix);
    void bind_faces(gl::Program& program) const;
    void set_solid_light(gl::Program& program, const Shot& shot, const Eigen::Matrix4f& matrix) const;
    void draw_faces(const Shot& shot, const Eigen::Matrix4f& matrix);
    void shade_solids(const Shot& shot, const Eigen::Matrix4f& matrix, GLuint target);

    // fluid_passes.cpp
    void draw_fluid(const Shot& shot, const Eigen::Matrix4f& matrix);
    void shade_sample(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);
    void set_body(gl::Program& program, const Material& material) const;
    void shade_fluid(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);

    // glass_passes.cpp
    void draw_glass(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);
    void draw_refracted(const Shot& shot, const std::vector<FrameSolid>& solids);

    // composing.cpp
    enum class Light { shown, linear, behind_glass };
    void draw_backdrop(const Shot& shot);
    void compose(const Shot& shot, GLuint target, Light light);
    PictureLayers light_of(const Shot& shot);
    Image read_back() const;

    GlContext context;  // declared first, so that all objects below are deleted while it is current
    int width, height;

    gl::Program fluid_normal{{"mesh.vert"}, {"octahedral.glsl", "normal.frag"}};
    gl::Program solid_depth{{"mesh.vert"}, {"depth.frag"}};
    gl::Programs solid_faces{{"mesh.vert"}, {"studio.glsl", "textures.glsl", "octahedral.glsl", "face.frag"}};
    gl::Programs solid_colour{{"screen.vert"},
                              {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "shadow.glsl", "solid_light.glsl",
                               "hot.glsl", "octahedral.glsl", "faces.glsl", "solid.frag"}};
    gl::Programs solid_light_program{{"screen.vert"},
                                     {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "shadow.glsl",
                                      "solid_light.glsl", "octahedral.glsl", "faces.glsl", "solid_light.frag"}};
    gl::Programs liquid{{"screen.vert"},
                        {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "inks.glsl", "body.glsl",
                         "octahedral.glsl", "liquid.frag"}};
    gl::Programs opaque{{"screen.vert"},
                        {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "inks.glsl", "crust.glsl",
                         "octahedral.glsl", "opaque.frag"}};
    gl::Programs glass_walls{{"mesh.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "glass.frag"}};
    gl::Programs glass_edges{{"edge.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "edge.frag"}};
    gl::Programs behind{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "behind.frag"}};
    gl::Programs composing{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "compose.frag"}};

    gl::Texture depth = gl::texture_2d(GL_DEPTH24_STENCIL8, width, height, false);
    gl::Texture solid = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture normal = gl::texture_2d(GL_RGBA32F, width, height, false);
    gl::Texture glass = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture picture = gl::texture_2d(GL_RGBA8, width, height, false);
    gl::Texture face_colour = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture face_normals = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture face_distance = gl::texture_2d(GL_R32F, width, height, false);
    gl::Framebuffer faces = gl::framebuffer({face_colour.id(), face_normals.id(), face_distance.id()}, depth.id());
    gl::Framebuffer geometry = gl::framebuffer({solid.id(), normal.id()}, depth.id());
    gl::Texture crust;  // or displacement of the surface; created for the first fluid that needs it
    gl::Framebuffer crusted_geometry;
    gl::Framebuffer glass_target = gl::framebuffer({glass.id()}, depth.id());
    gl::Framebuffer output = gl::framebuffer({picture.id()}, 0);
    std::optional<AovPass> aov_pass;  // created at first use
    std::optional<MotionBlur> motion_blur;
    std::optional<FoamPass> foam_pass;
    std::optional<GlassPass> glass_pass;

    SampleAccumulator samples{width, height, depth};
    Backdrop backdrop{width, height};
    SceneGeometry scene;
    FieldTexture field;
    SolidField solid_field{height};
    SolidPictures pictures;
    SolidLight solid_light{width, height};
    FlowShapes flow;
    InkField inks;
    GroundLight ground_light{height};
    SceneLighting lighting;
};

}  // namespace whorl
