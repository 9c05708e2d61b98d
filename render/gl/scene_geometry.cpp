#include "render/gl/scene_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "render/look/texture_places.h"
#include "render/surface/smooth.h"

namespace whorl {
namespace {

constexpr float solid_tolerance = 1e-4f;  // m: solids are cut this far below the ground, as in draw_faces() of solid_passes.cpp

/// Fills in a mesh with the surface's values per vertex; missing values are 0.
void fill_vertices(gl::Vertices& vertices, const TriangleMesh& mesh, const Surface& surface) {
    std::vector<float> age = surface.age;
    std::vector<std::array<float, 4>> crust = surface.crust.nearest;
    std::vector<Vec3f> velocity = surface.velocity;
    const std::size_t n = mesh.position.size();
    age.resize(n);
    crust.resize(n);
    velocity.resize(n, Vec3f::Zero());
    vertices.fill({gl::numbers(mesh.position),
                   gl::numbers(mesh.normal),
                   {age.data(), n},
                   {n > 0 ? crust[0].data() : nullptr, 4 * n},
                   gl::numbers(velocity)},
                  n > 0 ? mesh.triangle[0].data() : nullptr, 3 * mesh.triangle.size());
}

constexpr int plates_per_row = 256;
static_assert(sizeof(CrustPlate) == 8 * sizeof(float));

/// Stores CrustPlate's eight numbers in two texels.
gl::Texture texture_of(std::vector<CrustPlate> plates) {
    const int rows = static_cast<int>((plates.size() + plates_per_row - 1) / plates_per_row);
    plates.resize(static_cast<std::size_t>(rows) * plates_per_row);
    gl::Texture texture = gl::texture_2d(GL_RGBA32F, 2 * plates_per_row, rows, false);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 2 * plates_per_row, rows, GL_RGBA, GL_FLOAT, plates.data());
    return texture;
}

/// Pose after t [s] at constant velocity u and spin w: R' = exp([phi]x) R, T' = T + J(phi) u t, with phi = w t and J the left Jacobian of
/// SO(3). Exact for rotation about any fixed axis.
std::pair<Mat3f, Vec3f> pose_after(const FrameSolid& solid, float t) {
    const Vec3f phi = t * solid.spin, u = t * solid.velocity;
    const float angle = phi.norm();
    if (angle < 1e-6f) return {solid.rotation, solid.translation + u};
    const Vec3f across = phi.cross(u), along = phi.cross(across);
    return {Eigen::AngleAxisf(angle, phi / angle).toRotationMatrix() * solid.rotation,
            solid.translation + u + (1 - std::cos(angle)) / (angle * angle) * across +
                (angle - std::sin(angle)) / (angle * angle * angle) * along};
}

/// Fills in one strip per edge. Each end is stored twice, for the left and the right side of the strip.
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
    vertices.fill({gl::numbers(position), gl::numbers(along), {side.data(), side.size()}}, index.data(), index.size());
}

}  // namespace

void SceneGeometry::Model::fill(const FrameSolid& solid) {
    mesh = solid.mesh;
    const Bounds bounds = bounds_of(mesh->position);
    size = bounds.empty() ? 0 : 2 * bounds.radius();
    if (mesh->triangle.empty()) return;
    std::vector<Eigen::Vector2f> place;
    if (!solid.appearance.texture_mesh.empty()) place = texture_places(*mesh, solid.appearance.texture_mesh);
    if (place.empty())
        return vertices.fill({gl::numbers(mesh->position), gl::numbers(mesh->normal)}, mesh->triangle[0].data(), 3 * mesh->triangle.size());
    // Corners at one point may have different coordinates, so that each triangle has its own.
    has_places = true;
    vertices = gl::Vertices({3, 3, 1, 4});
    std::vector<Vec3f> position, normal;
    std::vector<float> age(place.size()), crust;
    std::vector<std::uint32_t> index;
    for (const auto& t : mesh->triangle)
        for (const std::uint32_t v : t) {
            const Eigen::Vector2f& p = place[index.size()];
            position.push_back(mesh->position[v]), normal.push_back(mesh->normal[v]);
            crust.insert(crust.end(), {p.x(), p.y(), 0, 0});
            index.push_back(static_cast<std::uint32_t>(index.size()));
        }
    vertices.fill({gl::numbers(position), gl::numbers(normal), {age.data(), age.size()}, {crust.data(), crust.size()}}, index.data(),
                  index.size());
}

const SceneGeometry::Model& SceneGeometry::model(const FrameSolid& solid) {
    const auto& mesh = solid.mesh;
    const auto [place, is_new] = models_.try_emplace(mesh.get());
    if (is_new) place->second.fill(solid);
    return place->second;
}

void SceneGeometry::fill(const Frame& frame, const Surface& surface) {
    if (surface.edge.empty()) fill_vertices(fluid_, surface.mesh, surface);
    else {
        // Short normals have little weight in the interpolation over a triangle, so each side of an edge keeps its own normal.
        TriangleMesh sided = surface.mesh;
        for (const Index v : surface.edge) sided.normal[v] *= 0.02f;
        fill_vertices(fluid_, sided, surface);
    }
    if (!surface.crust.plate.empty()) plates_ = texture_of(surface.crust.plate);
    spacing_ = frame.spacing;
    fill(frame, Shape::surface, bounds_of(surface.mesh.position));
}

void SceneGeometry::bind_crust(gl::Program& program, int unit) const {
    program.texture("plates", unit, GL_TEXTURE_2D, plates_.id());
    program.set("plates_per_row", plates_per_row);
    program.set("spacing", spacing_);
    program.set("moment", moment_);
}

void SceneGeometry::fill(const Frame& frame, const std::vector<Vec3f>& colour, const Bounds& fluid) {
    particles_.fill({gl::numbers(frame.position), gl::numbers(colour)}, nullptr, 0);
    fill(frame, Shape::particles, fluid);
}

void SceneGeometry::fill(const Frame& frame, Shape shape, const Bounds& fluid) {
    shape_ = shape;
    bounds_ = fluid_bounds_ = fluid;
    solids_.clear();
    containers_.clear();
    glass_.clear();
    int number = -1;
    for (const FrameSolid& solid : frame.solids) {
        ++number;
        if (!solid.mesh || is_level_ground(solid)) continue;
        (solid.container ? containers_ : is_glass(solid) ? glass_ : solids_).push_back({solid, &model(solid), number});
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
    if (shape_ == Shape::surface) fluid_.draw(GL_TRIANGLES);
}

void SceneGeometry::draw_solids(gl::Program& program, bool containers, const std::function<void(const FrameSolid&)>& prepare,
                                const std::function<bool(const FrameSolid&)>& wanted) const {
    draw(containers ? containers_ : solids_, program, prepare, wanted);
}

void SceneGeometry::draw_glass(gl::Program& program, const std::function<void(const FrameSolid&)>& prepare) const {
    draw(glass_, program, prepare, {});
}

void SceneGeometry::draw(const std::vector<Placed>& placed, gl::Program& program, const std::function<void(const FrameSolid&)>& prepare,
                         const std::function<bool(const FrameSolid&)>& wanted) const {
    for (const auto& [solid, model, number] : placed) {
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
    for (const auto* some : {&solids_, &glass_})
        for (const Placed& placed : *some) {
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
