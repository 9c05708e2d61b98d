#include "tests/support/scene_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace whorl::test::text {
namespace {

std::string lines_of(const std::string& more) { return more.empty() || more.back() == '\n' ? more : more + "\n"; }

std::string box_of(const std::string& table, const Point& min, const Point& max, const std::string& more) {
    return fmt::format("[[{}]]\nshape = \"box\"\nmin = {}\nmax = {}\n{}", table, min, max, lines_of(more));
}

std::string sphere_of(const std::string& table, const Point& centre, double radius, const std::string& more) {
    return fmt::format("[[{}]]\nshape = \"sphere\"\nposition = {}\nradius = {}\n{}", table, centre, radius, lines_of(more));
}

}  // namespace

Point point(int dimensions, double x, double y, double z) { return dimensions == 2 ? Point{x, y} : Point{x, y, z}; }

std::string time(double end, const std::string& more) { return fmt::format("[time]\nend = {}\n{}", end, lines_of(more)); }

std::string domain(const Point& min, const Point& max, const std::string& more) {
    return fmt::format("[domain]\ndimensions = {}\nmin = {}\nmax = {}\n{}", min.size(), min, max, lines_of(more));
}

std::string fluid(double spacing, double viscosity, const std::string& more) {
    const std::string own = viscosity > 0 ? fmt::format("viscosity = {}\n", viscosity) : "";
    return fmt::format("[fluid]\nspacing = {}\n{}{}", spacing, own, lines_of(more));
}

std::string models(const std::string& pressure, const std::string& viscosity) {
    std::string all = "[models]\n";
    if (!pressure.empty()) all += fmt::format("pressure = \"{}\"\n", pressure);
    if (!viscosity.empty()) all += fmt::format("viscosity = \"{}\"\n", viscosity);
    return all;
}

std::string pressure_form(const std::string& form) { return models("ppe") + fmt::format("[pressure]\nform = \"{}\"\n", form); }

std::string block(const Point& min, const Point& max, const std::string& more) { return box_of("block", min, max, more); }
std::string drop(const Point& centre, double radius, const std::string& more) { return sphere_of("block", centre, radius, more); }
std::string box(const Point& min, const Point& max, const std::string& more) { return box_of("solid", min, max, more); }
std::string tank(const Point& min, const Point& max, const std::string& more) {
    return box_of("solid", min, max, "container = true\n" + lines_of(more));
}
std::string ball(const Point& centre, double radius, const std::string& more) { return sphere_of("solid", centre, radius, more); }
std::string plane(const Point& at, const Point& normal, const std::string& more) {
    return fmt::format("[[solid]]\nshape = \"plane\"\nposition = {}\nnormal = {}\n{}", at, normal, lines_of(more));
}
std::string emitter(const Point& position, double radius, double speed, const std::string& more) {
    return fmt::format("[[emitter]]\nposition = {}\nradius = {}\nspeed = {}\n{}", position, radius, speed, lines_of(more));
}
std::string drain(const Point& min, const Point& max, const std::string& more) { return box_of("drain", min, max, more); }

}  // namespace whorl::test::text
