#include "render/gl/flow_shapes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/flow/cloud.h"
#include "render/flow/slice.h"
#include "render/flow/vortex_lines.h"
#include "render/look/environment.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

/// (strength * colour, strength) of each particle, so that a particle of strength 0 has no weight in a mean.
std::vector<Eigen::Vector4f> glow_of(const FieldColours& colours) {
    std::vector<Eigen::Vector4f> glow;
    for (std::size_t p = 0; p < colours.colour.size(); ++p) {
        const Vec3f& c = colours.colour[p];
        glow.push_back(colours.strength[p] * Eigen::Vector4f(c.x(), c.y(), c.z(), 1));
    }
    return glow;
}

/// Optical depth per length of the strongest field [1/m]. The shortest side of the box gets four times the optical depth `opacity`,
/// because the strong parts are small.
float thickness_of(const FlowGrid& grid, float opacity) { return 4 * opacity / std::max(grid.extent().minCoeff(), 1e-9f); }

Vec3f lamp_of(const View& view) { return studio_axes(view).transpose() * lamp_of_clouds(); }

/// In a dark studio a light from behind separates the cloud from the backdrop.
CloudLight light_of(const LookOptions& look, const View& view) {
    const Studio studio = studio_of(look.background);
    const Vec3f behind = studio_axes(view).transpose() * Vec3f(0.45f, 0.55f, -0.7f).normalized();
    const float rim = look.background == "dark" ? 0.08f : 0;
    return {lamp_of(view), 2.2f * studio.sun, 0.9f * studio.sky, behind, rim * studio.rim, 0.12f};
}

VortexLines lines_of(const Frame& frame, const LookOptions& look, const View& view, const std::vector<Eigen::Vector4f>& glow) {
    const auto vorticity = frame.vector.find("vorticity");
    if (vorticity == frame.vector.end()) return {};
    const FlowGrid grid = flow_grid(frame, vorticity->second, glow, 3'000'000);
    const float side = (frame.domain_max - frame.domain_min).maxCoeff();
    return vortex_lines(
        frame, grid,
        {look.lines, look.line_width > 0 ? look.line_width : frame.spacing, look.line_length > 0 ? 0.5f * look.line_length : 0.5f * side,
         look.style == "ribbons", thickness_of(grid, 1), lamp_of(view)});
}

Bounds bounds_of_particles(const Frame& frame) {
    Bounds bounds;
    const Vec3f radius = Vec3f::Constant(0.5f * frame.spacing);
    for (const Vec3f& x : frame.position) bounds.add(x - radius), bounds.add(x + radius);
    return bounds;
}

}  // namespace

void FlowShapes::fill(SceneGeometry& scene, const Frame& frame, const LookOptions& look, const View& view,
                      const std::array<float, 2>& range, int pixels) {
    if (look.style == "slice") {
        const Vec3f paper = Vec3f::Constant(look.background == "dark" ? 0.02f : 0.9f);
        return scene.fill(frame, fill_slice(flow_slice(frame, look, range, slice_plane(frame, look, pixels), paper)));
    }
    const FieldColours colours = field_colours(frame, look, range);
    if (look.style == "particles") {
        Trails behind;
        if (look.trail > 0)
            behind = trails(frame, colours.colour, flow_grid(frame, frame.velocity, {}), look.trail, 0.5f * frame.spacing, view.position);
        trails_.fill({gl::numbers(behind.position), gl::numbers(behind.colour)}, behind.index.data(), behind.index.size());
        Bounds bounds = bounds_of_particles(frame);
        bounds.add(bounds_of(behind.position));
        return scene.fill(frame, colours.colour, bounds);
    }
    const std::vector<Eigen::Vector4f> glow = glow_of(colours);
    if (draws_lines(look)) {
        const VortexLines lines = lines_of(frame, look, view, glow);
        tubes_.fill(
            {gl::numbers(lines.position), gl::numbers(lines.colour), gl::numbers(lines.normal), {lines.light.data(), lines.light.size()}},
            lines.index.data(), lines.index.size());
        Bounds bounds = bounds_of_particles(frame);
        bounds.add(bounds_of(lines.position));
        return scene.fill(frame, bounds);
    }
    if (look.field != "ink") return scene.fill(frame, fill_cloud(flow_grid(frame, {}, glow, 3'000'000, 0.5f), look, view));
    const Frame points = inked_points(frame);
    scene.fill(frame, fill_cloud(flow_grid(points, {}, glow_of(field_colours(points, look, range)), 3'000'000, 0.5f), look, view));
}

Bounds FlowShapes::fill_cloud(const FlowGrid& grid, const LookOptions& look, const View& view) {
    cloud_box_ = {};
    if (grid.empty()) return cloud_box_;
    const Vec3f low = grid.origin - 0.5f * grid.cell;  // nodes are at the centres of texels
    cloud_box_.add(low), cloud_box_.add(low + grid.extent());
    cloud_thickness_ = thickness_of(grid, look.opacity);
    const Cloud cloud = lit_cloud(grid, cloud_thickness_, light_of(look, view));
    gl::fill_3d(cloud_light_, grid.n[0], grid.n[1], grid.n[2], cloud.lit[0].data(), 4);
    gl::fill_3d(cloud_blocks_, cloud.blocks[0], cloud.blocks[1], cloud.blocks[2], cloud.most.data());
    cloud_cell_ = grid.cell;
    return cloud_box_;
}

Bounds FlowShapes::fill_slice(const FlowSlice& flow) {
    const PixelPlane& plane = flow.plane;
    const Vec3f across = plane.pixel * static_cast<float>(plane.width) * plane.right,
                up = plane.pixel * static_cast<float>(plane.height) * plane.up;
    const std::vector<Vec3f> corner{plane.corner, plane.corner + across, plane.corner + up, plane.corner + across + up};
    const float place[] = {0, 0, 1, 0, 0, 1, 1, 1};
    const std::uint32_t index[] = {0, 1, 2, 2, 1, 3};
    corners_.fill({gl::numbers(corner), {place, 8}}, index, flow.empty() ? 0 : 6);
    if (flow.empty()) return {};
    if (plane.width != slice_width_ || plane.height != slice_height_) {
        slice_ = gl::texture_2d(GL_RGBA16F, plane.width, plane.height, true);
        slice_width_ = plane.width, slice_height_ = plane.height;
    }
    glBindTexture(GL_TEXTURE_2D, slice_.id());
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, plane.width, plane.height, GL_RGBA, GL_FLOAT, flow.rgba.data());
    return bounds_of(corner);
}

void FlowShapes::draw(const SceneGeometry& scene, const FlowView& flow, const Eigen::Matrix4f& matrix) {
    if (flow.look.style == "particles") {
        flow.set_studio(particles_);
        particles_.set("view_projection", matrix);
        particles_.set("to_world", Eigen::Matrix4f(matrix.inverse()));
        particles_.set("radius", (flow.look.trail > 0 ? 0.25f : 0.5f) * flow.spacing);  // half the size, so that trails show
        particles_.set("pixels", 0.5f * static_cast<float>(flow.height) / std::tan(flow.view.fov * std::numbers::pi_v<float> / 360));
        particles_.set("picture_size", Eigen::Vector2f(static_cast<float>(flow.width), static_cast<float>(flow.height)));
        scene.draw_fluid(particles_);
        if (flow.look.trail <= 0) return;
        trail_.use();
        trail_.set("view_projection", matrix);
        trail_.set("eye", flow.view.position);
        trails_.draw(GL_TRIANGLES);
    } else if (draws_lines(flow.look)) {
        flow.set_studio(lines_);
        lines_.set("view_projection", matrix);
        tubes_.draw(GL_TRIANGLES);
    } else if (flow.look.style == "slice") {
        slice_colour_.use();
        slice_colour_.texture("slice", 0, GL_TEXTURE_2D, slice_.id());
        slice_colour_.set("view_projection", matrix);
        slice_colour_.set("eye", flow.view.position);
        corners_.draw(GL_TRIANGLES);
    }
}

void FlowShapes::shade_cloud(const LookOptions& look, const View& view, const gl::Texture& solids, const Eigen::Matrix4f& matrix,
                             int sample) {
    const auto samples = static_cast<float>(std::max(look.samples, 1));
    volume_.use();
    volume_.texture("solid_buffer", 0, GL_TEXTURE_2D, solids.id());
    volume_.texture("lit", 2, GL_TEXTURE_3D, cloud_light_.id());
    volume_.texture("most", 3, GL_TEXTURE_3D, cloud_blocks_.id());
    volume_.set("to_world", Eigen::Matrix4f(matrix.inverse()));
    volume_.set("eye", view.position);
    volume_.set("box_low", cloud_box_.low);
    volume_.set("box_high", cloud_box_.high);
    volume_.set("block_size", Vec3f(static_cast<float>(Cloud::block) * cloud_cell_));
    volume_.set("thickness", cloud_thickness_);
    // The samples of a pixel use different points along the ray. Together the points are as dense as those of a single fine ray.
    volume_.set("march", std::min(2.0f, std::sqrt(samples)) * cloud_cell_.minCoeff());
    volume_.set("turn", static_cast<float>(sample) / samples);
    volume_.set("weight", 1 / samples);
    gl::draw_screen();
}

}  // namespace whorl
