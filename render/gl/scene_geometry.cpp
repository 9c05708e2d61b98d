#include "render/gl/scene_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/surface/smooth.h"

namespace whorl {
namespace {

constexpr float solid_tolerance = 1e-4f;  // m, as depth.frag cuts solids at the ground

void fill_vertices(gl::Vertices& vertices, const TriangleMesh& mesh) {
    if (mesh.triangle.empty()) return vertices.fill({{nullptr, 0}, {nullptr, 0}}, nullptr, 0);
    vertices.fill({{mesh.position[0].data(), 3 * mesh.position.size()}, {mesh.normal[0].data(), 3 * mesh.normal.size()}},
                  mesh.triangle[0].data(), 3 * mesh.triangle.size());
}

std::pair<const float*, std::size_t> numbers(const std::vector<Vec3f>& v) { return {v.empty() ? nullptr : v[0].data(), 3 * v.size()}; }

/// With the values of its vertices; 0 without values.
void fill_vertices(gl::Vertices& vertices, const TriangleMesh& mesh, std::vector<float> age, std::vector<CrustPlace> crust,
                   std::vector<Vec3f> velocity) {
    if (mesh.triangle.empty()) return vertices.fill({{nullptr, 0}, {nullptr, 0}, {nullptr, 0}, {nullptr, 0}, {nullptr, 0}}, nullptr, 0);
    const std::size_t n = mesh.position.size();
    age.resize(n);
    crust.resize(n);
    velocity.resize(n, Vec3f::Zero());
    vertices.fill({{mesh.position[0].data(), 3 * n},
                   {mesh.normal[0].data(), 3 * n},
                   {age.data(), n},
                   {crust[0].data(), 4 * n},
                   {velocity[0].data(), 3 * n}},
                  mesh.triangle[0].data(), 3 * mesh.triangle.size());
}

}  // namespace

namespace {

/// With velocity and spin kept: R' = exp([phi]x) R, T' = T + J(phi) u t, phi = w t, J the left Jacobian of SO(3): exact for a turning about
/// any fixed axis.
std::pair<Mat3f, Vec3f> pose_after(const FrameSolid& solid, float t) {
    const Vec3f phi = t * solid.spin, u = t * solid.velocity;
    const float angle = phi.norm();
    if (angle < 1e-6f) return {solid.rotation, solid.translation + u};
    const Vec3f across = phi.cross(u), along = phi.cross(across);
    return {Eigen::AngleAxisf(angle, phi / angle).toRotationMatrix() * solid.rotation,
            solid.translation + u + (1 - std::cos(angle)) / (angle * angle) * across +
                (angle - std::sin(angle)) / (angle * angle * angle) * along};
}

Bounds bounds_of_particles(const Frame& frame) {
    Bounds bounds;
    const Vec3f radius = Vec3f::Constant(0.5f * frame.spacing);
    for (const Vec3f& x : frame.position) bounds.add(x - radius), bounds.add(x + radius);
    return bounds;
}

}  // namespace

namespace {

/// A strip an edge: both ends twice, to the left and to the right.
void fill_edges(gl::Vertices& vertices, const std::vector<std::pair<Vec3f, Vec3f>>& edges) {
    std::vector<Vec3f> position, along;
    std::vector<float> side;
    std::vector<std::uint32_t> index;
    for (const auto& [from, to] : edges) {
        const auto first = static_cast<std::uint32_t>(position.size());
        for (const Vec3f& end : {from, to})
            for (const float s : {-1.0f, 1.0f}) position.push_back(end), along.push_back(to - from), side.push_back(s);
        for (const std::uint32_t corner : {0, 1, 2, 2, 1, 3}) index.push_back(first + corner);
    }
    vertices.fill({numbers(position), numbers(along), {side.data(), side.size()}}, index.data(), index.size());
}

}  // namespace

const SceneGeometry::Model& SceneGeometry::model(const std::shared_ptr<const TriangleMesh>& mesh) {
    const auto [place, is_new] = models_.try_emplace(mesh.get());
    if (is_new) {
        place->second.mesh = mesh;
        fill_vertices(place->second.vertices, with_normals(*mesh));
        const Bounds bounds = bounds_of(mesh->position);
        place->second.size = bounds.empty() ? 0 : 2 * bounds.radius();
    }
    return place->second;
}

void SceneGeometry::fill(const Frame& frame, const Surface& surface) {
    const TriangleMesh& fluid = surface.mesh;
    if (!surface.edge.empty()) {
        // Short normals hardly count between the vertices of a triangle: each side of an edge keeps its own.
        TriangleMesh sided = fluid;
        for (const Index v : surface.edge) sided.normal[v] *= 0.02f;
        fill_vertices(fluid_, sided, surface.age, surface.crust, surface.velocity);
    } else if (fluid.normal.size() == fluid.position.size()) fill_vertices(fluid_, fluid, surface.age, surface.crust, surface.velocity);
    else fill_vertices(fluid_, with_normals(fluid), {}, {}, {});
    shape_ = Shape::surface;
    bounds_ = fluid_bounds_ = bounds_of(fluid.position);
    fill_solids(frame);
}

void SceneGeometry::fill(const Frame& frame, const std::vector<Vec3f>& colour, const Trails& trails) {
    particles_.fill({numbers(frame.position), numbers(colour)}, nullptr, 0);
    trails_.fill({numbers(trails.position), numbers(trails.colour)}, trails.index.data(), trails.index.size());
    shape_ = Shape::particles;
    bounds_ = bounds_of(trails.position);
    bounds_.add(bounds_of_particles(frame));
    fluid_bounds_ = bounds_;
    fill_solids(frame);
}

void SceneGeometry::fill(const Frame& frame, const VortexLines& lines) {
    lines_.fill({numbers(lines.position), numbers(lines.normal), numbers(lines.colour), {lines.light.data(), lines.light.size()}},
                lines.index.data(), lines.index.size());
    shape_ = Shape::lines;
    bounds_ = bounds_of(lines.position);
    bounds_.add(bounds_of_particles(frame));
    fluid_bounds_ = bounds_;
    fill_solids(frame);
}

void SceneGeometry::fill(const Frame& frame, const FlowSlice& slice) {
    shape_ = Shape::slice;
    const PixelPlane& plane = slice.plane;
    const Vec3f across = plane.pixel * static_cast<float>(plane.width) * plane.right,
                up = plane.pixel * static_cast<float>(plane.height) * plane.up;
    const std::vector<Vec3f> corner{plane.corner, plane.corner + across, plane.corner + up, plane.corner + across + up};
    const float place[] = {0, 0, 1, 0, 0, 1, 1, 1};
    const std::uint32_t index[] = {0, 1, 2, 2, 1, 3};
    slice_.fill({{corner[0].data(), 12}, {place, 8}}, index, slice.empty() ? 0 : 6);
    bounds_ = slice.empty() ? Bounds{} : bounds_of(corner);
    fluid_bounds_ = bounds_;
    fill_solids(frame);
}

void SceneGeometry::fill(const Frame& frame, const FlowGrid& grid) {
    shape_ = Shape::grid;
    bounds_ = Bounds{};
    // The nodes are at the centres of a texture's texels.
    if (!grid.empty()) bounds_.add(grid.origin - 0.5f * grid.cell), bounds_.add(grid.origin - 0.5f * grid.cell + grid.extent());
    fluid_bounds_ = bounds_;
    fill_solids(frame);
}

void SceneGeometry::fill_solids(const Frame& frame) {
    solids_.clear();
    containers_.clear();
    int number = -1;
    for (const FrameSolid& solid : frame.solids) {
        ++number;
        if (!solid.mesh || is_level_ground(solid)) continue;
        (solid.container ? containers_ : solids_).push_back({solid, &model(solid.mesh), number});
        if (solid.container && containers_.back().model->edges.count() == 0)
            fill_edges(models_.at(solid.mesh.get()).edges, sharp_edges(*solid.mesh));
        bounds_.add(bounds_of(solid));
    }
    std::erase_if(models_, [](const auto& entry) { return entry.second.mesh.use_count() == 1; });
    if (bounds_.empty()) bounds_.add(frame.domain_min), bounds_.add(frame.domain_max);
}

void SceneGeometry::draw_fluid(gl::Program& program) const {
    program.set("moment", moment_);
    program.set("rotation", Mat3f(Mat3f::Identity()));
    program.set("translation", Vec3f(Vec3f::Zero()));
    if (shape_ == Shape::particles) particles_.draw(GL_POINTS);
    if (shape_ == Shape::surface) fluid_.draw(GL_TRIANGLES);  // slices, lines and clouds throw no shadow
}

void SceneGeometry::draw_solids(gl::Program& program, bool containers, const std::function<void(const FrameSolid&)>& prepare,
                                const std::function<bool(const FrameSolid&)>& wanted) const {
    for (const auto& [solid, model, number] : containers ? containers_ : solids_) {
        if (wanted && !wanted(solid)) continue;
        const auto [rotation, translation] = pose_after(solid, moment_);
        program.set("rotation", rotation);
        program.set("translation", translation);
        prepare(solid);
        model->vertices.draw(GL_TRIANGLES);
    }
}

void SceneGeometry::draw_numbered(gl::Program& program, float interval, float tolerance) const {
    const auto place = [&](const std::pair<Mat3f, Vec3f>& now, const std::pair<Mat3f, Vec3f>& next) {
        program.set("rotation", now.first);
        program.set("translation", now.second);
        program.set("next_rotation", next.first);
        program.set("next_translation", next.second);
    };
    const std::pair<Mat3f, Vec3f> still{Mat3f::Identity(), Vec3f::Zero()};
    place(still, still);
    program.set("number", 1.0f);
    program.set("tolerance", tolerance);
    if (shape_ == Shape::surface) fluid_.draw(GL_TRIANGLES);
    program.set("tolerance", solid_tolerance);
    for (const Placed& placed : solids_) {
        place(pose_after(placed.solid, 0), pose_after(placed.solid, interval));
        program.set("number", static_cast<float>(2 + placed.number));
        placed.model->vertices.draw(GL_TRIANGLES);
    }
}

void SceneGeometry::draw_edges(gl::Program& program) const {
    for (const auto& [solid, model, number] : containers_) {
        const auto [rotation, translation] = pose_after(solid, moment_);
        program.set("rotation", rotation);
        program.set("translation", translation);
        program.set("size", model->size);
        model->edges.draw(GL_TRIANGLES);
    }
}

}  // namespace whorl
