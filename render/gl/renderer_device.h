#pragma once
/// The passes of an image and the objects on the graphics device that they share.
#include <optional>
#include <set>

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
#include "render/gl/solid_field.h"
#include "render/gl/solid_pictures.h"
#include "render/look/material.h"
#include "render/look/overlay.h"

namespace whorl {

/// Texture units that passes share. Each pass uses units 0 .. 3 for its own textures.
constexpr int ground_unit = 4, shadow_unit = 5, field_unit = 7, solid_unit = 9, solid_light_unit = 10, ink_unit = 12, surround_unit = 13;

/// Stencil values of pixels that show a solid, and of pixels that show the fluid.
constexpr GLint solid_seen = 1, fluid_seen = 2;

/// Prepares for drawing solids or the fluid down to the height `lowest` [m]; drawn pixels get the stencil value `seen`.
inline void begin_geometry(gl::Program& program, GLint seen, float lowest) {
    program.set("cuts", 1);
    program.set("lowest", lowest);
    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
}

inline void end_geometry() {
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_STENCIL_TEST);
}

/// Limits drawing to pixels whose stencil value passes the comparison with `seen`; other pixels cost the software driver nothing.
inline void shade_where(GLenum comparison, GLint seen) {
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(comparison, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
}

/// Everything that an image is drawn from, except geometry.
struct Shot {
    const LookOptions& look;
    View view;
    Material material;
    float hides = 1;    ///< fraction of the surrounding light that the fluid keeps from objects inside it
    float spacing = 0;  ///< m
    float ground = 0;   ///< m
    Eigen::Matrix4f camera;
    Mat3f to_ray;  ///< position in the image (-1 .. 1, -1 .. 1, 1) -> direction
    float aspect = 1;
    bool blurred = false;    ///< the sum of the samples is blurred along the motion
    bool has_age = false;    ///< the fluid's surface has ages
    bool has_crust = false;  ///< the fluid's surface has plates of crust
    std::vector<EmissivePatch> patches;
    std::set<Pattern> patterns;  ///< textures of the solids
    std::string constants;       ///< GLSL constants of all programs

    /// Whether every pixel needs all samples. Otherwise a pixel that differs little from its neighbours keeps its first sample. The relief
    /// of a crust is found from neighbouring pixels, which later samples would lack.
    bool needs_all_samples() const { return look.samples < 2 || view.blurs() || shows_field(look) || has_crust; }
    /// Height below which nothing is drawn [m].
    float lowest() const { return look.ground ? ground : -1e6f; }
    /// Whether all samples share the solids' light of the first one: they see the solids at the same moment and from about the same
    /// position.
    bool keeps_solid_light() const { return view.open <= 0; }
    bool camera_moves() const { return !(view.position_velocity.isZero(0) && view.target_velocity.isZero(0)); }
    /// Whether the samples look up the background in the backdrop, which shows it from the frame's position. Only the lens moves them.
    bool samples_backdrop() const { return view.aperture > 0 && !(view.open > 0 && camera_moves()) && !is_transparent(look); }
    /// Whether the motion of the camera blurs the background, which the samples do not show.
    bool blurs_background() const { return blurred && !is_transparent(look) && camera_moves(); }
    /// Whether the surface's displacement is stored per pixel: the surface moves while the shutter is open, its distance field does not.
    bool keeps_motion() const { return view.open > 0 && material.refracts; }
};

/// Colour of the fluid drawn as an opaque body.
inline Vec3f body_colour(const Material& material) { return material.refracts ? material.scatter : material.colour; }

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
