/// Images of fixed meshes. The stored ones were drawn with Mesa's software driver; on other devices small differences are expected and the
/// tolerance is the same.
#include <cmath>

#include "engine/core/random.h"
#include "engine/geometry/shape.h"
#include "render/gl/renderer.h"
#include "tests/golden/stored.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace {

struct Picture {
    Frame frame;
    Surface surface;
    LookOptions look;
    View view{Vec3f(0.06f, 0.13f, 0.30f), Vec3f(0, 0.035f, 0), Vec3f(0, 1, 0), 24};
};

Picture picture_of(const std::string& material, Surface surface = {}, const std::string& background = LookOptions().background) {
    Picture picture;
    picture.surface = std::move(surface);
    picture.look.material = material, picture.look.background = background;
    picture.frame.spacing = 0.002f;
    picture.frame.domain_min = Vec3f(-0.1f, 0, -0.1f);
    picture.frame.domain_max = Vec3f(0.1f, 0.14f, 0.1f);
    return picture;
}

Surface coil() { return test::coiled_thread(0.005f, 0.018f, 4, 0.12f, 0.0015f); }

void add_solid(Frame& frame, TriangleMesh mesh, const std::string& material, bool container = false) {
    frame.solids.push_back(test::solid_of(std::move(mesh), material, container));
}

void compare(const Picture& picture, const std::string& name) {
    Renderer renderer(320, 240);
    test::compare_with_stored(over_grey(renderer.draw(picture.frame, picture.surface, picture.look, picture.view)), name,
                              renderer.device());
}

}  // namespace

TEST_CASE("honey coils on the ground", "[golden]") { compare(picture_of("honey", coil()), "honey_coil"); }

TEST_CASE("honey runs from a metal nozzle onto a ceramic plate", "[golden]") {
    Picture picture = picture_of("honey", coil());
    picture.frame.domain_min.y() = -0.008f;
    add_solid(picture.frame, test::cylinder_mesh(Vec3f(0, -0.008f, 0), 0.06f, 0.008f), "ceramic");
    add_solid(picture.frame, test::cylinder_mesh(Vec3f(0, 0.118f, 0), 0.007f, 0.04f), "metal");
    picture.view.position = Vec3f(0.08f, 0.15f, 0.40f);
    picture.view.target = Vec3f(0, 0.055f, 0);
    compare(picture, "honey_plate");
}

TEST_CASE("a wooden ball on a ceramic plate, shadowed by a metal rod", "[golden]") {
    Picture picture = picture_of("honey");
    picture.frame.domain_min.y() = -0.008f;
    add_solid(picture.frame, test::cylinder_mesh(Vec3f(0, -0.008f, 0), 0.07f, 0.008f), "ceramic");
    add_solid(picture.frame, test::sphere(Vec3f(0, 0.0215f, 0), 0.022f, 0.0015f).mesh, "wood");
    add_solid(picture.frame, test::cylinder_mesh(Vec3f(-0.035f, 0, 0.02f), 0.004f, 0.06f), "metal");
    picture.view.target = Vec3f(0, 0.02f, 0);
    compare(picture, "solids_shade");
}

TEST_CASE("water waves in a glass box", "[golden]") {
    Picture picture = picture_of("water", test::pool(0.05f, 0.02f, 0.001f));
    add_solid(picture.frame, test::box_mesh(Vec3f(-0.05f, 0, -0.05f), Vec3f(0.05f, 0.06f, 0.05f)), "glass", true);
    compare(picture, "water_box");
}

TEST_CASE("spray over foam on waves in a glass box, in a dark studio", "[golden]") {
    Picture picture = picture_of("water", test::pool(0.05f, 0.02f, 0.001f), "dark");
    picture.look.foam = 1;
    add_solid(picture.frame, test::box_mesh(Vec3f(-0.05f, 0, -0.05f), Vec3f(0.05f, 0.06f, 0.05f)), "glass", true);
    picture.view.open = 0.01f;
    RandomNumbers random(1);
    const auto add = [&](const Vec3f& x, const Vec3f& u, float foam, float airborne) {
        picture.frame.position.push_back(x), picture.frame.velocity.push_back(u);
        picture.frame.scalar["foam"].push_back(foam), picture.frame.scalar["airborne"].push_back(airborne);
        picture.frame.scalar["grain"].push_back(static_cast<float>(random()));
    };
    const auto place = [&](float from, float to) { return from + (to - from) * static_cast<float>(random()); };
    for (int k = 0; k < 600; ++k) add({place(-0.05f, 0), place(0.012f, 0.02f), place(-0.05f, 0.05f)}, {0.1f, 0, 0}, place(0, 1), 0);
    for (int k = 0; k < 60; ++k)
        add({place(0, 0.03f), place(0.025f, 0.05f), place(-0.02f, 0.02f)}, {place(0, 1), 1, 0}, 1, 0.02f + place(0, 0.05f));
    compare(picture, "water_foam");
}

TEST_CASE("a wooden bar in a glass half full of water with a drop of ink", "[golden]") {
    Picture picture = picture_of("water", {}, "white");
    Frame& frame = picture.frame;
    frame.spacing = 0.004f;
    for (Vec3f x(-0.038f, 0, 0); x.x() < 0.04f; x.x() += frame.spacing)
        for (x.y() = 0.002f; x.y() < 0.04f; x.y() += frame.spacing)
            for (x.z() = -0.038f; x.z() < 0.04f; x.z() += frame.spacing)
                if (std::hypot(x.x(), x.z()) < 0.0385f) {
                    frame.position.push_back(x);
                    frame.vector["ink"].emplace_back(0.5f * std::exp(-(x - Vec3f(0.02f, 0.02f, 0.02f)).squaredNorm() / 1.5e-4f), 0, 0);
                }
    frame.velocity.resize(frame.position.size(), Vec3f::Zero());
    add_solid(frame, test::cylinder_mesh(Vec3f::Zero(), 0.04f, 0.06f), "glass", true);
    add_solid(frame, test::box_mesh(Vec3f(-0.03f, 0.01f, -0.004f), Vec3f(0.005f, 0.055f, 0.004f)), "wood");
    picture.surface = build_surface(frame, {});
    compare(picture, "water_glass");
}

TEST_CASE("a ball of glass next to an open vessel of glass with water, on a cloth", "[golden]") {
    Picture picture = picture_of("water", test::pool(0.03f, 0.02f, 0.001f), "white");
    picture.look.table = "cloth";
    picture.frame.domain_min.y() = -0.006f;
    ShapeKeys vessel;
    vessel.min = {-0.03, 0, -0.03}, vessel.max = {0.03, 0.04, 0.03}, vessel.open = "top", vessel.wall = 0.006;
    add_solid(picture.frame, make_shape(vessel)->mesh(0, 0), "glass");
    add_solid(picture.frame, make_sphere({0.065, 0.016, 0.03}, 0.022)->mesh(Real(0.002), 0), "glass");
    picture.view.target = Vec3f(0.015f, 0.02f, 0);
    compare(picture, "glass");
}

TEST_CASE("paint is opaque and glossy, in a dark studio", "[golden]") { compare(picture_of("paint", coil(), "dark"), "paint_dark"); }

TEST_CASE("chocolate on white", "[golden]") { compare(picture_of("chocolate", coil(), "white"), "chocolate_white"); }

TEST_CASE("light shines through a coil of wax, in a dark studio", "[golden]") { compare(picture_of("wax", coil(), "dark"), "wax_dark"); }

TEST_CASE("coils of caramel, ketchup and slime, each next to a ball of ice", "[golden]") {
    for (const char* material : {"caramel", "ketchup", "slime"}) {
        Picture picture = picture_of(material, coil());
        add_solid(picture.frame, test::sphere(Vec3f(0.045f, 0.02f, 0.03f), 0.02f, 0.001f).mesh, "ice");
        compare(picture, material);
    }
}

TEST_CASE("honey on a table of boards, seen through a wide lens", "[golden]") {
    Picture picture = picture_of("honey", coil());
    picture.look.table = "wood";
    picture.look.samples = 16;
    picture.view.aperture = 0.02f;
    picture.view.focus = 0.32f;
    compare(picture, "table_wood");
}

TEST_CASE("honey and a glass without a background but for their shadow", "[golden]") {
    Picture picture = picture_of("honey", coil(), "transparent");
    add_solid(picture.frame, test::box_mesh(Vec3f(0.03f, 0, -0.02f), Vec3f(0.07f, 0.04f, 0.02f)), "glass", true);
    compare(picture, "honey_transparent");
}

TEST_CASE("a cloth of checks on a box, on a slab of stone", "[golden]") {
    Picture picture = picture_of("honey");
    picture.look.table = "stone";
    add_solid(picture.frame, test::box_mesh(Vec3f(-0.06f, 0, -0.04f), Vec3f(0.06f, 0.04f, 0.04f)), "cloth");
    picture.view.target = Vec3f(0, 0.02f, 0);
    compare(picture, "cloth_stone");
}

TEST_CASE("lava of all ages with a crust on it, over rock that it lights", "[golden]") {
    Picture picture = picture_of("lava", coil(), "dark");
    std::vector<float> grain;
    Frame inside;
    inside.spacing = picture.frame.spacing;
    RandomNumbers random(1);
    for (Vec3f x(-0.03f, 0, 0); x.x() < 0.03f; x.x() += inside.spacing)
        for (x.y() = 0; x.y() < 0.13f; x.y() += inside.spacing)
            for (x.z() = -0.03f; x.z() < 0.03f; x.z() += inside.spacing) {
                inside.position.push_back(x), inside.velocity.push_back(Vec3f::Zero());
                grain.push_back(static_cast<float>(random()));
            }
    for (const Vec3f& x : picture.surface.mesh.position) picture.surface.age.push_back(4 - 40 * x.y());
    picture.surface.crust = crust_of(picture.surface.mesh.position, inside, grain);
    add_solid(picture.frame, test::box_mesh(Vec3f(-0.1f, -0.02f, -0.1f), Vec3f(0.1f, 0, 0.1f)), "rock");
    compare(picture, "lava_crust");
}

namespace {

/// Particles in the coil with the velocity `velocity`.
template <class F>
Picture particles(F&& velocity) {
    Picture picture = picture_of("honey");
    test::each_node(test::coiled_thread(0.005f, 0.018f, 4, 0.12f, 0.002f).distance, [&](const Vec3f& x, float distance) {
        if (distance < 0) picture.frame.position.push_back(x), picture.frame.velocity.push_back(velocity(x));
    });
    picture.look.style = "particles";
    return picture;
}

}  // namespace

TEST_CASE("particles are spheres coloured by their speed", "[golden]") {
    compare(particles([](const Vec3f& x) { return Vec3f(0, -2 * x.y(), 0); }), "particles_speed");
}

TEST_CASE("a signed field with its legend and the time, in a dark studio", "[golden]") {
    Picture picture = particles([](const Vec3f&) { return Vec3f::Zero(); });
    for (const Vec3f& x : picture.frame.position) picture.frame.vector["spin"].emplace_back(0, 0, 500 * x.x());
    picture.frame.time = 1.25;
    picture.look.field = "spin";
    picture.look.colour_map = "coolwarm";
    picture.look.range = {-10, 10};
    picture.look.background = "dark";
    picture.look.legend = picture.look.time_stamp = true;
    compare(picture, "particles_legend");
}

TEST_CASE("two inks in honey that coils, and in paint", "[golden]") {
    Picture picture = particles([](const Vec3f&) { return Vec3f::Zero(); });
    picture.surface = coil();
    for (const Vec3f& x : picture.frame.position) picture.frame.vector["ink"].push_back(x.x() > 0 ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0));
    picture.look.style = "liquid";
    compare(picture, "honey_inks");
    picture.look.style = "opaque", picture.look.material = "paint";
    compare(picture, "paint_inks");
}

namespace {

/// A ball of fluid with two linked rings of vorticity or ink.
Picture linked_rings() {
    Picture picture = picture_of("water", {}, "white");
    picture.look.style = "volume";
    picture.look.ground = false;
    picture.look.opacity = 3;
    const auto in_ring = [](const Vec3f& x, const Vec3f& centre, const Vec3f& axis) {
        const Vec3f r = x - centre;
        const float along = r.dot(axis), across = (r - along * axis).norm() - 0.025f;
        return std::exp(-(along * along + across * across) / (0.006f * 0.006f));
    };
    for (Vec3f x(-0.06f, 0, 0); x.x() < 0.06f; x.x() += 0.0025f)
        for (x.y() = -0.02f; x.y() < 0.09f; x.y() += 0.0025f)
            for (x.z() = -0.06f; x.z() < 0.06f; x.z() += 0.0025f) {
                const float a = in_ring(x, Vec3f(-0.0125f, 0.035f, 0), Vec3f::UnitZ());
                const float b = in_ring(x, Vec3f(0.0125f, 0.035f, 0), Vec3f::UnitY());
                picture.frame.position.push_back(x);
                picture.frame.velocity.emplace_back(0, 0, 0);
                picture.frame.vector["ink"].emplace_back(a, b, 0);
                picture.frame.scalar["q_criterion"].push_back(100 * (a + b) - 10);
            }
    picture.frame.spacing = 0.0025f;
    return picture;
}

}  // namespace

TEST_CASE("two linked rings of ink as a lit volume on white", "[golden]") {
    Picture picture = linked_rings();
    picture.look.field = "ink";
    compare(picture, "volume_ink");
}

TEST_CASE("the Q of two linked rings as a lit volume in a dark studio, with its legend", "[golden]") {
    Picture picture = linked_rings();
    picture.look.field = "q_criterion";
    picture.look.colour_map = "inferno";
    picture.look.background = "dark";
    picture.look.legend = true;
    compare(picture, "volume_q");
}

TEST_CASE("tubes and ribbons along the vorticity of two linked rings", "[golden]") {
    Picture picture = linked_rings();
    const auto round = [](const Vec3f& x, const Vec3f& centre, const Vec3f& axis) { return Vec3f(axis.cross(x - centre)); };
    for (const Vec3f& x : picture.frame.position) {
        const Vec3f a = round(x, Vec3f(-0.0125f, 0.035f, 0), Vec3f::UnitZ()), b = round(x, Vec3f(0.0125f, 0.035f, 0), Vec3f::UnitY());
        const Vec3f& share = picture.frame.vector["ink"][picture.frame.vector["vorticity"].size()];
        picture.frame.vector["vorticity"].push_back(share.x() * a + share.y() * b);
        picture.frame.scalar["grain"].push_back(std::fmod(0.618034f * static_cast<float>(picture.frame.scalar["grain"].size()), 1.0f));
    }
    picture.look.field = "q_criterion";
    picture.look.range = {0, 90};
    picture.look.lines = 1000;
    picture.look.style = "tubes";
    compare(picture, "tubes");
    picture.look.style = "ribbons";
    picture.look.background = "dark";
    compare(picture, "ribbons");
}
