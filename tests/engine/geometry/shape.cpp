#include "engine/geometry/shape.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "engine/core/errors.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/revolved.h"

using namespace whorl;

namespace {

Vec3 random_point(std::mt19937& random, Real size) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = size * (2 * Real(random()) / Real(4294967296.0) - 1);
    return x;
}

std::filesystem::path temporary(const std::string& name, const std::string& text) {
    const auto file = std::filesystem::temp_directory_path() / ("whorl_shapes_" + name);
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

std::string message_of(const std::filesystem::path& file) {
    try {
        make_mesh(file, 1, Vec3d::Zero());
    } catch (const InputError& error) { return error.what(); }
    return "no error";
}

const char* cube_obj =
    "# a cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5/1/1 6/2/1 7/3/1 8/4/1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n";

std::vector<Vec3f> cube_triangles() {
    const auto cube = make_box(Vec3d::Zero(), Vec3d::Ones())->mesh(1, 1);
    std::vector<Vec3f> corners;
    for (const auto& t : cube.triangle)
        for (auto k : t) corners.push_back(cube.position[k]);
    return corners;
}

/// The enclosed volume and whether every edge is shared by two triangles turned alike, after joining equal positions.
double volume_of(const TriangleMesh& mesh, bool& closed) {
    std::map<std::array<float, 6>, int> edges;
    double volume = 0;
    for (const auto& t : mesh.triangle) {
        const Vec3f a = mesh.position[t[0]], b = mesh.position[t[1]], c = mesh.position[t[2]];
        volume += double(a.dot(b.cross(c))) / 6;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f p = mesh.position[t[k]], q = mesh.position[t[(k + 1) % 3]];
            const auto key = [](const Vec3f& u, const Vec3f& v) {
                return std::array<float, 6>{u[0] + 0.f, u[1] + 0.f, u[2] + 0.f, v[0] + 0.f, v[1] + 0.f, v[2] + 0.f};
            };
            ++edges[key(p, q)];
            --edges[key(q, p)];
        }
    }
    closed = true;
    for (const auto& [edge, count] : edges) closed = closed && count == 0;
    return volume;
}

}  // namespace

TEST_CASE("every shape's distance grows at rate 1 along its normal and is 0 at the foot point", "[geometry]") {
    std::mt19937 random(1);
    const auto obj = temporary("cube.obj", cube_obj);
    const std::shared_ptr<const Shape> shapes[] = {make_box({-0.5, -0.2, 0}, {0.5, 0.9, 0.3}),
                                                   make_sphere({0.1, 0, 0}, 0.6),
                                                   make_cylinder({0, -0.4, 0.1}, {0.3, 0.5, 0}, 0.3),
                                                   make_plane({0, 0.1, 0}, {1, 2, -1}),
                                                   make_mesh(obj, 0.8, {-0.3, -0.4, -0.2}),
                                                   make_capsule({-0.3, 0, 0.1}, {0.3, 0.2, 0}, 0.25),
                                                   make_cone({0, -0.4, 0}, {0.1, 0.5, 0.2}, 0.4, 0.15),
                                                   make_cone({0, 0.5, 0}, {0, -0.5, 0}, 0.5, 0)};
    for (const auto& shape : shapes)
        for (int k = 0; k < 400; ++k) {
            const Vec3 x = random_point(random, 1);
            const Real distance = shape->distance(x);
            if (distance < 0) continue;  // inside, near the middle, the nearest surface changes
            const Vec3 n = shape->normal(x);
            REQUIRE(n.norm() == Approx(1).epsilon(1e-5));
            REQUIRE(std::abs(shape->distance(x - distance * n)) < 1e-5);
            REQUIRE(shape->distance(x + Real(0.1) * n) == Approx(distance + Real(0.1)).epsilon(1e-4));
        }
}

// Exact volumes and moments; the meshes that are drawn are closed and have these volumes within the square of half an edge's angle.
TEST_CASE("capsules, cones and tori have their volumes, inertias and closed meshes", "[geometry]") {
    const double pi = std::numbers::pi, R = 0.5, a = 0.2, h = 0.8;
    struct Case {
        std::shared_ptr<const Shape> shape;
        double volume, along;  // inertia about the axis over the volume
    };
    const double capsule = pi * a * a * h + 4 * pi / 3 * a * a * a;
    const double frustum = pi * h / 3 * (R * R + R * a + a * a);
    const Case cases[] = {
        {make_capsule({0.1, 0, 0}, {0.1, h, 0}, a), capsule,
         (pi * a * a * h * a * a / 2 + 4 * pi / 3 * a * a * a * 2 * a * a / 5) / capsule},
        {make_cone({0, 0, 0}, {0, 0, h}, R, a), frustum, 0.3 * (std::pow(R, 5) - std::pow(a, 5)) / (std::pow(R, 3) - std::pow(a, 3))},
        {make_torus({0, 0.3, 0}, {1, 1, 0}, R, a), 2 * pi * pi * R * a * a, R * R + 0.75 * a * a}};
    const Vec3d axes[] = {Vec3d::UnitY(), Vec3d::UnitZ(), Vec3d(1, 1, 0).normalized()};
    for (std::size_t k = 0; k < 3; ++k) {
        INFO(k);
        const MassProperties bulk = cases[k].shape->bulk();
        CHECK(bulk.volume == Approx(cases[k].volume).epsilon(1e-6));
        CHECK(axes[k].dot(bulk.inertia() * axes[k]) == Approx(cases[k].along * bulk.volume).epsilon(1e-5));
        bool closed = false;
        CHECK(volume_of(cases[k].shape->mesh(Real(0.02), 1), closed) == Approx(bulk.volume).epsilon(4e-3));
        CHECK(closed);
    }
    const Vec3 hole(Real(0.1), Real(0.3), Real(0.2));
    CHECK(make_torus({0, 0, 0}, {0, 0, 2}, R, a)->distance(hole) == Approx(std::hypot(std::hypot(0.1, 0.3) - R, 0.2) - a).margin(1e-6));
    const double apex = make_cone({0, 0, 0}, {0, 0, h}, R, 0)->bulk().centre.z();
    CHECK(apex == Approx(h / 4).epsilon(1e-5));
}

TEST_CASE("a mesh of a shape measures the shape's own distance, inside, outside, at edges and corners", "[geometry]") {
    std::mt19937 random(2);
    const auto box = make_box({-0.5, -0.2, 0}, {0.5, 0.9, 0.3});
    const auto box_mesh = make_mesh(box->mesh(1, 1), "box");  // its faces do not share vertices: joined where equal
    for (int k = 0; k < 2000; ++k) {
        const Vec3 x = random_point(random, 1);
        REQUIRE(box_mesh->distance(x) == Approx(box->distance(x)).margin(2e-6));
    }
}

TEST_CASE("mesh parts are solid in any orientation and contact, and a part inside another is a hollow", "[geometry]") {
    using Box = std::pair<Vec3d, Vec3d>;
    const auto cube = [](double from, double to) { return Box(Vec3d::Constant(from), Vec3d::Constant(to)); };
    struct Case {
        std::vector<Box> parts;
        double volume;
        std::vector<std::pair<Vec3d, double>> distances;
    };
    const auto on_diagonal = [](double place) { return Vec3d(Vec3d::Constant(place)); };
    const double root = std::sqrt(3);
    std::vector<Case> cases{
        {{cube(0, 1), cube(2, 2.2)}, 1.008, {{on_diagonal(0.5), -0.5}, {on_diagonal(2.1), -0.1}, {on_diagonal(1.9), 0.1 * root}}},
        {{cube(-1, 1), cube(-0.5, 0.5)}, 7, {{on_diagonal(0.75), -0.25}, {on_diagonal(0), 0.5}, {on_diagonal(2), root}}},
        {{cube(-1, 1), cube(-0.5, 0.5), cube(-0.2, 0.2)},
         7.064,
         {{on_diagonal(0.75), -0.25}, {on_diagonal(0.4), 0.1}, {Vec3d::Zero(), -0.2}}},
        // overlapping, once with a hollow in the overlap
        {{cube(0, 1), cube(0.4, 1.4)},
         1.784,
         {{on_diagonal(0.3), -0.3}, {on_diagonal(0.55), -0.45}, {on_diagonal(1.1), -0.3}, {on_diagonal(2.4), root}}},
        {{cube(0, 1), cube(0.4, 1.4), cube(0.5, 0.9)},
         1.72,
         {{on_diagonal(0.7), 0.2}, {on_diagonal(0.45), -0.05 * root}, {on_diagonal(0.2), -0.2}}},
        // bars that cross, no corner of one inside the other
        {{{{-1, -0.2, -0.2}, {1, 0.2, 0.2}}, {{-0.1, -1, -0.1}, {0.1, 1, 0.1}}},
         0.384,
         {{Vec3d(0, 0.19, 0), -0.1}, {Vec3d(0.09, 0, 0), -0.2}}},
        // a cube on a cube, and a bar along a cube's edge
        {{cube(0, 1), {{0, 1, 0}, {1, 2, 1}}},
         2,
         {{{0.5, 0.5, 0.5}, -0.5}, {{0.5, 0.9, 0.5}, -0.1}, {{0.5, 1.1, 0.5}, -0.1}, {{0.5, 3, 0.5}, 1}}},
        {{cube(0, 1), {{1, 1, 0}, {1.2, 1.2, 1}}}, 1.04, {{{0.9, 0.9, 0.5}, -0.1}, {{1.05, 1.1, 0.5}, -0.05}, {{1.15, 0.9, 0.5}, 0.1}}}};
    for (const int axis : {0, 1, 2})  // a hollow that opens to a side
        for (const double side : {-1.0, 1.0}) {
            const Vec3d c = 0.75 * side * Vec3d::Unit(axis), half = Vec3d::Constant(0.25);
            cases.push_back({{cube(-1, 1), {c - half, c + half}}, 7.875, {{c, 0.25}, {-c, -0.25}, {2 * c, 0.5}}});
        }
    for (const Case& c : cases)
        for (unsigned turned = 0; turned < 1u << c.parts.size(); ++turned) {
            TriangleMesh mesh;
            for (std::size_t part = 0; part < c.parts.size(); ++part) {
                const TriangleMesh box = make_box(c.parts[part].first, c.parts[part].second)->mesh(1, 1);
                const auto first = static_cast<std::uint32_t>(mesh.position.size());
                mesh.position.insert(mesh.position.end(), box.position.begin(), box.position.end());
                for (const auto& t : box.triangle) {
                    const bool flip = turned >> part & 1;
                    mesh.triangle.push_back({first + t[0], first + t[flip ? 2 : 1], first + t[flip ? 1 : 2]});
                }
            }
            const auto shape = make_mesh(std::move(mesh), "parts");
            CAPTURE(turned, c.parts.size(), c.volume);
            CHECK(shape->bulk().volume == Approx(c.volume).epsilon(0.01));
            for (const auto& [place, distance] : c.distances) {
                CAPTURE(place);
                const Vec3 x = place.cast<Real>();
                CHECK(shape->distance(x) == Approx(distance).margin(1e-5));
                if (distance > 0) CHECK(std::abs(shape->distance(x - Real(distance) * shape->normal(x))) < 1e-5);
            }
        }
}

TEST_CASE("drawn meshes of bodies are closed, face outward and enclose the body's volume", "[geometry]") {
    bool closed = false;
    CHECK(volume_of(make_box({0, 0, 0}, {1, 2, 3})->mesh(0.1f, 1), closed) == Approx(6).epsilon(1e-5));
    CHECK(closed);
    // 64 segments miss 0.4 per cent of the volume.
    CHECK(volume_of(make_sphere({1, 2, 3}, 0.5)->mesh(0, 1), closed) == Approx(4 * std::numbers::pi / 3 * 0.125).epsilon(0.005));
    CHECK(closed);
    CHECK(volume_of(make_cylinder({0, 0, 0}, {1, 1, 0}, 0.5)->mesh(0, 1), closed) ==
          Approx(std::numbers::pi * 0.25 * std::sqrt(2)).epsilon(0.005));
    CHECK(closed);
    for (const auto& shape : {make_box({0, 0, 0}, {1, 2, 3}), make_sphere({1, 2, 3}, 0.5), make_cylinder({0, 0, 0}, {1, 1, 0}, 0.5)}) {
        const TriangleMesh mesh = shape->mesh(Real(0.02), 1);
        REQUIRE(mesh.normal.size() == mesh.position.size());
        for (std::size_t k = 0; k < mesh.position.size(); ++k) {
            REQUIRE(std::abs(shape->distance(mesh.position[k].cast<Real>())) < 1e-5);
            REQUIRE(shape->distance((mesh.position[k] + 0.01f * mesh.normal[k]).cast<Real>()) > 0.0099);
        }
    }
}

TEST_CASE("OBJ, PLY, STL and glTF, ascii and binary, give the same cube", "[geometry]") {
    const auto corners = cube_triangles();
    std::string stl = "solid cube\n", binary_stl(80, ' '), ply, binary_ply;
    std::string big_ply, buffer;
    const auto append = [&](std::string& to, const auto& value) {
        char bytes[sizeof(value)];
        std::memcpy(bytes, &value, sizeof(value));
        to.append(bytes, sizeof(value));
        if (&to == &binary_ply) big_ply.append(std::reverse_iterator(bytes + sizeof(value)), std::reverse_iterator(bytes));
    };
    append(binary_stl, std::uint32_t(corners.size() / 3));
    const std::string header =
        "element vertex 36\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty float nx\n"
        "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
    ply = "ply\nformat ascii 1.0\ncomment made by hand\n" + header;
    binary_ply = "ply\nformat binary_little_endian 1.0\n" + header;
    big_ply = "ply\nformat binary_big_endian 1.0\n" + header;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vec3f& x = corners[k];
        const std::string words = std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]);
        if (k % 3 == 0) stl += "facet normal 0 0 0\n outer loop\n";
        stl += "  vertex " + words + "\n";
        if (k % 3 == 2) stl += " endloop\nendfacet\n";
        if (k % 3 == 0) binary_stl += std::string(12, '\0');
        for (int a = 0; a < 3; ++a) append(binary_stl, x[a]), append(buffer, x[a]);
        if (k % 3 == 2) binary_stl += std::string(2, '\0');
        ply += words + (k % 2 == 0 ? " 255 nan\n" : " 255 -1e999\n");  // normals of degenerate faces
        for (int a = 0; a < 3; ++a) append(binary_ply, x[a]);
        append(binary_ply, '\x7f');
        append(binary_ply, std::numeric_limits<float>::quiet_NaN());
    }
    for (int k = 0; k < 12; ++k) {
        ply += "3 " + std::to_string(3 * k) + " " + std::to_string(3 * k + 1) + " " + std::to_string(3 * k + 2) + "\n";
        append(binary_ply, '\3');
        for (int l = 0; l < 3; ++l) append(binary_ply, 3 * k + l);
    }
    stl += "endsolid cube\n";
    const auto cube = make_box(Vec3d::Zero(), Vec3d::Ones());
    std::mt19937 random(3);
    std::string old_mac = cube_obj, doubled = cube_obj;
    std::replace(old_mac.begin(), old_mac.end(), '\n', '\r');
    for (std::size_t at = 0; (at = doubled.find('\n', at)) != std::string::npos; at += 3) doubled.replace(at, 1, "\r\r\n");
    std::string goes_on = cube_obj;
    goes_on.replace(goes_on.find("f 1 4 3 2"), 9, "# in C:\\models\\\nf 1 \\\n\\\r\n 4 3\\\n 2");
    goes_on.replace(goes_on.find("v 1 0 0"), 7, "v 1\\\n0 0");
    std::string commented = cube_obj, upper = "\n \n" + stl, one_line = stl, solid = binary_stl;
    for (std::size_t at = 0; (at = commented.find('\n', at)) != std::string::npos; at += 8) commented.replace(at, 1, " # text\n ");
    std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    std::replace(one_line.begin(), one_line.end(), '\n', ' ');
    solid.replace(0, 5, "solid"), solid += "and more";
    const std::string gltf =
        R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "scale": [-1, 1, 1], "translation": [1, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 432, "uri": ")" +
        temporary("cube.bin", buffer).filename().string() +
        R"("}], "bufferViews": [{"buffer": 0, "byteLength": 432}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 36,
            "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}]})";
    for (const auto& [name, text] : {std::pair{"cube.obj", std::string(cube_obj)},
                                     {"marked.obj", "\xEF\xBB\xBF" + std::string(cube_obj).substr(9)},
                                     {"old_mac.obj", old_mac},
                                     {"doubled.obj", doubled},
                                     {"goes_on.obj", goes_on},
                                     {"marked.stl", "\xEF\xBB\xBF" + stl},
                                     {"marked.ply", "\xEF\xBB\xBF" + ply},
                                     {"ascii.stl", stl},
                                     {"binary.stl", binary_stl},
                                     {"commented.obj", commented},
                                     {"upper.STL", upper},
                                     {"one_line.stl", one_line},
                                     {"solid.stl", solid},
                                     {"big.ply", big_ply},
                                     {"cube.gltf", gltf},
                                     {"ascii.ply", ply},
                                     {"binary.ply", binary_ply}}) {
        INFO(name);
        const auto shape = make_mesh(temporary(name, text), 2, {1, 0, 0});
        for (int k = 0; k < 50; ++k) {
            const Vec3 x = random_point(random, 2);
            REQUIRE(shape->distance(2 * x + Vec3(1, 0, 0)) == Approx(2 * cube->distance(x)).margin(1e-5));
        }
    }
    // The mesh of a named node, in the axes of the node.
    std::string moved = gltf;
    moved.replace(moved.find("[1, 0, 0]}]"), 11, "[1, 0, 7], \"name\": \"cube\"}]");
    const std::filesystem::path file = temporary("moved.gltf", moved);
    Vec3 low, high;
    make_mesh(file, 1, {0, 0, 0})->bounds(low, high);
    CHECK((low - Vec3(0, 0, 7)).norm() < 1e-6);
    make_mesh(file, 1, {0, 0, 0}, "cube")->bounds(low, high);
    CHECK(low.norm() < 1e-6);
    CHECK((high - Vec3(1, 1, 1)).norm() < 1e-6);
    CHECK_THROWS_WITH(make_mesh(file, 1, {0, 0, 0}, "ball"), Catch::Contains("has no node \"ball\""));
}

TEST_CASE("a broken mesh file is reported with line and fault", "[geometry]") {
    using Catch::Matchers::Contains;
    CHECK_THAT(message_of("/nowhere/x.obj"), Contains("/nowhere/x.obj") && Contains("cannot be opened"));
    CHECK_THAT(message_of(temporary("a.obj", "v 0 0 0\nv 1 0 zero\n")), Contains("a.obj:2") && Contains("\"zero\" is not a number"));
    CHECK_THAT(message_of(temporary("a.obj", "v 0 0 0\nv 1  1e60 0\n")),
               Contains("a.obj:2:6: \"1e60\" is too large; allowed: numbers from -3.4e+38 to 3.4e+38"));
    CHECK_THAT(message_of(temporary("a.obj", "v 0 0 0\rv 1 \\\r\n zero 0\r\n")), Contains("a.obj:3:2: \"zero\" is not a number"));
    CHECK_THAT(message_of(temporary("a.obj", "\xEF\xBB\xBFv 0 zero 0\n")), Contains("a.obj:1:5: \"zero\" is not a number"));
    CHECK_THAT(message_of(temporary("a.obj", "v 0 0\n")), Contains("a.obj:1:6: a number is missing; allowed: numbers from"));
    CHECK_THAT(message_of(temporary("a.obj", "v 0 1e-60 -1e-400\n")), Contains("no triangles"));  // numbers, as good as 0
    CHECK_THAT(message_of(temporary("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n")), Contains("b.obj:4") && Contains("vertex 4"));
    CHECK_THAT(message_of(temporary("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n")), Contains("b.obj:4:7: \"x\" is not a number"));
    CHECK_THAT(message_of(temporary("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")), Contains("3 of its 3 edges are open"));
    CHECK_THAT(message_of(temporary("d.obj", "# nothing\n")), Contains("no triangles"));
    CHECK_THAT(message_of(temporary("e.fbx", "")), Contains(".obj, .ply, .stl"));
    CHECK_THAT(message_of(temporary("f.stl", "solid\nfacet\nvertex 0 0\n")), Contains("f.stl:3"));
    CHECK_THAT(message_of(temporary("g.ply", "ply\nformat binary_middle_endian 1.0\nend_header\n")),
               Contains("g.ply:2") && Contains("binary_little_endian"));
    CHECK_THAT(message_of(temporary("h.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1\n2\n")),
               Contains("ends at vertex 3 of 3"));
    const std::string triangle =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    std::string nowhere = triangle + "3 0 1 2\n";
    nowhere.replace(nowhere.find("0 1 0"), 5, "0 nan");
    CHECK_THAT(message_of(temporary("n.ply", nowhere)), Contains("n.ply:12:3: \"nan\" is not a number"));
    for (const char* corner : {"3", "-1", "4294967296", "1e30"}) {
        CAPTURE(corner);
        CHECK_THAT(message_of(temporary("k.ply", triangle + "3 0 1 " + corner + "\n")),
                   Contains("the file has 3 vertices, counted from 0"));
    }
    CHECK_THAT(message_of(temporary("l.ply", "ply\nformat binary_little_endian 1.0\nelement thing 666666666666666666\nend_header\n")),
               Contains("element thing has no property"));
    std::string cut(80, 'x');
    cut += std::string("\x08\0\0\0", 4) + std::string(70, '\0');
    CHECK_THAT(message_of(temporary("i.stl", cut)), Contains("its header announces 8 triangles, it contains 1"));
    std::string flipped = cube_obj;
    flipped.replace(flipped.find("f 1 2 6 5"), 9, "f 5 6 2 1");
    CHECK_THAT(message_of(temporary("j.obj", flipped)), Contains("opposite orientations"));
}

namespace {

/// A prism of height 1 over the polygon, whose caps begin with the corner `first`.
std::string prism(const std::vector<std::array<double, 2>>& polygon, std::size_t first, double far = 0) {
    const std::size_t n = polygon.size();
    std::string vertices, low, high, sides;
    for (const double z : {0, 1})
        for (const auto& [x, y] : polygon) vertices += fmt::format("v {:.9f} {:.9f} {:.9f}\n", far + x, far + y, far + z);
    for (std::size_t k = 0; k < n; ++k) {
        low += fmt::format(" {}", (first + n - k) % n + 1), high += fmt::format(" {}", n + (first + k) % n + 1);
        sides += fmt::format("f {} {} {} {}\n", k + 1, (k + 1) % n + 1, n + (k + 1) % n + 1, n + k + 1);
    }
    return vertices + "f" + low + "\nf" + high + "\n" + sides;
}

}  // namespace

TEST_CASE("a concave polygon of a mesh encloses its volume, whatever its first corner", "[geometry]") {
    const std::vector<std::array<double, 2>> notch{{3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}, {0, 0}},
        arrow{{0, 0.5}, {1, 0}, {0, 2}, {-1, 0}};
    for (std::size_t first = 0; first < 8; ++first) {
        const auto shape = make_mesh(temporary("notch.obj", prism(notch, first)), 1, Vec3d::Zero());
        CHECK(shape->bulk().volume == Approx(7).epsilon(1e-6));
        CHECK(shape->distance({Real(1.5), 2, Real(0.5)}) == Approx(0.5).epsilon(1e-6));
        CHECK(shape->distance({Real(1.5), Real(0.6), Real(0.5)}) == Approx(-0.4).epsilon(1e-6));
        CHECK(shape->remarks.empty());
    }
    for (std::size_t first = 0; first < 4; ++first)
        CHECK(make_mesh(temporary("arrow.obj", prism(arrow, first)), 1, Vec3d::Zero())->distance({0, Real(0.4), Real(0.5)}) > 0);
}

TEST_CASE("a self-intersecting mesh is solid where its winding number is not 0, and is reported", "[geometry]") {
    std::vector<std::array<double, 2>> star;
    for (int k = 0; k < 5; ++k) star.push_back({std::cos(0.8 * std::numbers::pi * k), std::sin(0.8 * std::numbers::pi * k)});
    const auto shape = make_mesh(temporary("star.obj", prism(star, 0)), 1, Vec3d::Zero());
    // Five points about a pentagon, around which the rim runs twice. The volume is estimated from 200,000 sample points.
    CHECK(shape->bulk().volume == Approx(1.1226).epsilon(0.003));
    CHECK(shape->distance({0, 0, Real(0.5)}) < Real(-0.3));
    CHECK(shape->distance({Real(0.35), 0, Real(0.5)}) < 0);
    CHECK(shape->distance({Real(-0.5), 0, Real(0.5)}) > 0);
    REQUIRE(shape->remarks.size() == 1);
    CHECK(shape->remarks[0].find("intersects itself") != std::string::npos);
}

TEST_CASE("faces and parts without a volume are left out of a mesh and reported", "[geometry]") {
    // Three corners apart from the cube, with a face either way; a face of the cube twice; a face with two equal corners.
    const std::string more = "v 5 0 0\nv 6 0 0\nv 5 1 0\nf 9 10 11\nf 9 11 10\nf 1 4 3 2\nf 1 2 1\n";
    const auto shape = make_mesh(temporary("more.obj", cube_obj + more), 1, Vec3d::Zero());
    CHECK(shape->remarks == std::vector<std::string>{"faces without an area left out: 1", "faces that repeat others left out: 4"});
    for (const Vec3& x : {Vec3(5, Real(0.3), 1), Vec3(5, Real(0.3), -1), Vec3(-3, -3, 2)}) CHECK(shape->distance(x) > 0);
    CHECK(shape->bulk().volume == Approx(1));
    // A flat part of four faces, whose halves are cut along different diagonals.
    const std::string flat = "v 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nf 9 10 11\nf 9 11 12\nf 10 9 12\nf 10 12 11\n";
    const auto other = make_mesh(temporary("flat.obj", cube_obj + flat), 1, Vec3d::Zero());
    CHECK(other->remarks == std::vector<std::string>{"parts without a volume left out: 1"});
    CHECK_THAT(message_of(temporary("none.obj", flat.substr(0, flat.find('f')) + "f 1 2 3\nf 1 3 2\n")),
               Catch::Contains("encloses no volume"));
}

TEST_CASE("a mesh far from the origin is moved in double precision, or refused", "[geometry]") {
    const std::vector<std::array<double, 2>> square{{0.1, 0.1}, {1.3, 0.1}, {1.3, 1.3}, {0.1, 1.3}};
    const auto file = temporary("far.obj", prism(square, 0, 4e6));
    const auto shape = make_mesh(file, 1, Vec3d::Constant(-4e6));
    CHECK(shape->bulk().volume == Approx(1.44).epsilon(1e-6));
    CHECK(shape->distance({Real(0.7), Real(0.7), 2}) == Approx(1).epsilon(1e-6));
    CHECK_THAT(message_of(file),
               Catch::Contains("far.obj: single precision rounds positions 4e+06 m from the origin to 0.48 m, too coarse"));
}
