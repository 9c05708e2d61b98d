/// Fluid in open vessels of glass.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/geometry/shape.h"
#include "render/surface/surface.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_measures.h"

using namespace whorl;
using namespace whorl::test;

namespace {

constexpr float cavity = 8, depth = 8, gap = 0.9f;  // spacings
const Vec3f cavity_origin(3, -2, 5);

/// Distance from the cavity's walls and floor, positive inside the cavity: of a cylinder on y = 0, or of a sphere about (0, 8, 0).
float in_cavity(const Vec3f& own, bool sphere) {
    return sphere ? cavity - (own - Vec3f(0, cavity, 0)).norm() : std::min(cavity - std::hypot(own.x(), own.z()), own.y());
}

/// A vessel whose particles keep `gap` from its walls, up to the height `depth`.
Frame filled_vessel(bool sphere, const Mat3f& turn, const std::string& material = "glass") {
    ShapeKeys keys;
    keys.kind = sphere ? "sphere" : "cylinder";
    keys.open = "top", keys.wall = 3, keys.radius = cavity;
    if (sphere) keys.rim = 4;
    else keys.from = {0, 0, 0}, keys.to = {0, 14, 0};
    FrameSolid vessel = solid_of(make_shape(keys)->mesh(Real(0.5), 0), material);
    vessel.rotation = turn, vessel.translation = cavity_origin + turn * Vec3f(0, sphere ? cavity : 0, 0);
    Frame frame;
    frame.spacing = 1;
    frame.solids = {vessel};
    // Shells or rings parallel to the wall, a spacing apart, each with one particle per unit of its area or length.
    for (float r = cavity - gap; r > 0; --r) {
        const int count = static_cast<int>(std::lround(sphere ? 12.566f * r * r : 6.2832f * r)) + 1;
        for (int k = 0; k < count; ++k) {
            const float part = (static_cast<float>(k) + 0.5f) / static_cast<float>(count);
            const auto add = [&](float across, float y, float angle) {
                const Vec3f own(across * std::cos(angle), y, across * std::sin(angle));
                if (y < depth) frame.position.push_back(turn * own + cavity_origin);
            };
            if (sphere) add(2 * r * std::sqrt(part * (1 - part)), cavity + r * (2 * part - 1), 2.39996f * static_cast<float>(k));
            else
                for (float y = gap; y < depth; ++y) add(r, y, 6.2832f * part);
        }
    }
    return frame;
}

TEST_CASE("fluid touches the glass of an open vessel although its particles keep 0.9 d from it, and stays inside", "[surface]") {
    const bool sphere = GENERATE(false, true);
    const Mat3f turn = GENERATE(Mat3f::Identity().eval(), Eigen::AngleAxisf(0.7f, Vec3f(1, 2, 3).normalized()).toRotationMatrix());
    const Frame frame = filled_vessel(sphere, turn);
    const Surface surface = build_surface(frame, {});
    REQUIRE(topology(surface.mesh).manifold);
    CHECK(topology(surface.mesh).components == 1);
    float beyond = 0, widest = 0;
    int on_wall = 0;
    for (const Vec3f& x : surface.mesh.position) {
        const Vec3f own = turn.transpose() * (x - cavity_origin);
        const float in = in_cavity(own, sphere);
        beyond = std::max(beyond, -in);
        if (own.y() > depth - 2) continue;  // the free surface
        widest = std::max(widest, in);
        on_wall += std::abs(in) < 0.05f ? 1 : 0;
    }
    CHECK(beyond < 0.1f);  // edges are rounded by the voxels of half a spacing
    CHECK(widest < 0.15f);
    CHECK(on_wall > 1000);
    // The distance volume, in which rays are refracted, agrees.
    CHECK(std::abs(interpolated(surface.distance, cavity_origin)) < 0.1f);
}

TEST_CASE("the line where fluid meets glass or ice is as high as the surface next to it, within a twentieth of a spacing", "[surface]") {
    // The rings of particles make bumps of a few hundredths. Left to marching cubes, the line is 0.1 d too deep.
    const Surface surface = build_surface(filled_vessel(false, Mat3f::Identity(), "ice"), {});
    float line = 0, beside = 0;
    int on_line = 0, near_line = 0, folded = 0;
    for (std::size_t v = 0; v < surface.mesh.position.size(); ++v) {
        const Vec3f own = surface.mesh.position[v] - cavity_origin;
        const float across = std::hypot(own.x(), own.z());
        if (own.y() < depth - 1 || surface.mesh.normal[v].y() < 0.4f) continue;
        if (across > cavity - 0.1f) line += own.y(), ++on_line;
        else if (across > cavity - 2) beside += own.y(), ++near_line;
    }
    line /= static_cast<float>(on_line), beside /= static_cast<float>(near_line);
    INFO("line " << line << " of " << on_line << ", beside " << beside << " of " << near_line);
    CHECK(on_line > 50);
    CHECK(std::abs(line - beside) < 0.05f);
    for (const auto& t : surface.mesh.triangle) {
        const Vec3f& a = surface.mesh.position[t[0]];
        const Vec3f area = (surface.mesh.position[t[1]] - a).cross(surface.mesh.position[t[2]] - a);
        folded += area.norm() > 1e-4f && area.dot(surface.mesh.normal[t[0]] + surface.mesh.normal[t[1]] + surface.mesh.normal[t[2]]) < 0;
    }
    CHECK(folded == 0);
}

}  // namespace
