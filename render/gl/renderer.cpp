#include "render/gl/renderer.h"

#include <Eigen/LU>
#include <algorithm>

#include "engine/core/errors.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/gl/setup.h"
#include "render/look/material.h"
#include "render/look/studio.h"

namespace whorl {

using gl::Program;

struct Renderer::Device {
    Device(int w, int h) : width(w), height(h) {}

    GlContext context;  // first: everything below is freed while it is still current
    int width, height;

    Program fluid_normal{{"mesh.vert"}, {"normal.frag"}};
    Program solid_colour{{"mesh.vert"}, {"studio.glsl", "solid.frag"}};
    Program liquid{{"screen.vert"}, {"studio.glsl", "liquid.frag"}};
    Program compose{{"screen.vert"}, {"studio.glsl", "compose.frag"}};

    gl::Texture depth = gl::texture_2d(GL_DEPTH_COMPONENT32F, width, height, false);
    gl::Texture solid = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture normal = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture sum = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture picture = gl::texture_2d(GL_RGBA8, width, height, false);
    gl::Texture ground_light = gl::texture_2d(GL_RGBA16F, 1, 1, true);
    gl::Framebuffer geometry = gl::framebuffer({solid.id(), normal.id()}, depth.id());
    gl::Framebuffer accumulate = gl::framebuffer({sum.id()}, 0);
    gl::Framebuffer output = gl::framebuffer({picture.id()}, 0);

    gl::Vertices fluid{{3, 3}};
    gl::Vertices solid_vertices{{3, 3}};
    gl::Vertices screen{{1}};

    Image draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view);
    void set_studio(Program& program, const LookOptions& look, const View& view, float ground);
    void cover_screen();
};

namespace {

void fill(gl::Vertices& vertices, const TriangleMesh& mesh) {
    vertices.fill({{mesh.position.empty() ? nullptr : mesh.position[0].data(), 3 * mesh.position.size()},
                   {mesh.normal.empty() ? nullptr : mesh.normal[0].data(), 3 * mesh.normal.size()}},
                  mesh.triangle.empty() ? nullptr : mesh.triangle[0].data(), 3 * mesh.triangle.size());
}

}  // namespace

void Renderer::Device::set_studio(Program& program, const LookOptions& look, const View& view, float ground) {
    const Studio studio = studio_of(look.background);
    program.set("studio", studio_axes(view));
    program.set("backdrop_low", studio.backdrop_low);
    program.set("backdrop_high", studio.backdrop_high);
    program.set("backdrop_glow", studio.backdrop_glow);
    program.set("key_light", studio.key);
    program.set("rim_light", studio.rim);
    program.set("fill_light", studio.fill);
    program.set("box_softness", 0.05f);
    program.set("ground_height", ground);
    program.set("ground_area", Vec3f(0, 0, 1e-9f));
    program.texture("ground_light", 7, GL_TEXTURE_2D, ground_light.id());
    program.set("eye", view.position);
}

void Renderer::Device::cover_screen() { glDrawArrays(GL_TRIANGLES, 0, 3); }

Image Renderer::Device::draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view) {
    context.make_current();
    const float ground = look.ground ? ground_height(frame) : -1e6f;
    Bounds content = bounds_of(surface.mesh.position);
    std::vector<const FrameSolid*> solids;
    for (const FrameSolid& s : frame.solids)
        if (s.mesh && !s.container && !is_level_ground(s)) solids.push_back(&s), content.add(bounds_of(s));
    if (content.empty()) content.add(frame.domain_min), content.add(frame.domain_max);
    const Eigen::Matrix4f camera = camera_matrix(view, static_cast<float>(width) / static_cast<float>(height), content);

    fill(fluid, surface.mesh);
    glViewport(0, 0, width, height);
    glDisable(GL_BLEND);
    glBindFramebuffer(GL_FRAMEBUFFER, accumulate.id());
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);

    const int samples = std::max(look.samples, 1);
    for (int i = 0; i < samples; ++i) {
        const Eigen::Matrix4f matrix = jittered(camera, sample_place(i, samples), width, height);
        const Eigen::Matrix4f to_world = matrix.inverse();
        glBindFramebuffer(GL_FRAMEBUFFER, geometry.id());
        glEnable(GL_DEPTH_TEST);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        solid_colour.use();
        set_studio(solid_colour, look, view, ground);
        solid_colour.set("view_projection", matrix);
        for (const FrameSolid* s : solids) {
            const SolidMaterial material = solid_material(s->material);
            solid_colour.set("rotation", s->rotation);
            solid_colour.set("translation", s->translation);
            solid_colour.set("solid_colour", material.colour);
            solid_colour.set("metal", material.metal);
            fill(solid_vertices, *s->mesh);
            solid_vertices.draw(GL_TRIANGLES);
        }
        glColorMaski(0, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        fluid_normal.use();
        fluid_normal.set("view_projection", matrix);
        fluid_normal.set("rotation", Mat3f(Mat3f::Identity()));
        fluid_normal.set("translation", Vec3f(Vec3f::Zero()));
        fluid_normal.set("ground_height", ground);
        fluid_normal.set("tolerance", 0.5f * frame.spacing);
        fluid.draw(GL_TRIANGLES);
        glColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

        glDisable(GL_DEPTH_TEST);
        glBindFramebuffer(GL_FRAMEBUFFER, accumulate.id());
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        const PixelBox box = pixels_of(content, camera, width, height);
        glEnable(GL_SCISSOR_TEST);
        glScissor(box.x, box.y, box.width, box.height);
        liquid.use();
        set_studio(liquid, look, view, ground);
        liquid.texture("depth_buffer", 0, GL_TEXTURE_2D, depth.id());
        liquid.texture("normal_buffer", 1, GL_TEXTURE_2D, normal.id());
        liquid.texture("solid_buffer", 2, GL_TEXTURE_2D, solid.id());
        liquid.set("to_world", to_world);
        liquid.set("weight", 1.0f / static_cast<float>(samples));
        cover_screen();
        glDisable(GL_SCISSOR_TEST);
        glDisable(GL_BLEND);
    }

    glBindFramebuffer(GL_FRAMEBUFFER, output.id());
    compose.use();
    set_studio(compose, look, view, ground);
    compose.texture("samples", 0, GL_TEXTURE_2D, sum.id());
    compose.set("to_world", Eigen::Matrix4f(camera.inverse()));
    compose.set("exposure", look.exposure);
    compose.set("aspect", static_cast<float>(width) / static_cast<float>(height));
    cover_screen();

    Image image{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    std::vector<std::uint8_t> rows(image.rgb.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
    const std::size_t stride = 3 * static_cast<std::size_t>(width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
        std::copy_n(rows.data() + (static_cast<std::size_t>(height) - 1 - y) * stride, stride, image.rgb.data() + y * stride);
    return image;
}

Renderer::Renderer(int width, int height) : device_(std::make_unique<Device>(width, height)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
std::string Renderer::device() const { return device_->context.device(); }
Image Renderer::draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view) {
    return device_->draw(frame, surface, look, view);
}

}  // namespace whorl
