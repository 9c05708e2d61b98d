#pragma once
/// Parts of a scene as its text. A point has as many numbers as the scene has dimensions; `more` are further lines of the part.
#include <string>
#include <vector>

namespace whorl::test::text {

using Point = std::vector<double>;  ///< m
/// Without z in two dimensions.
Point point(int dimensions, double x, double y, double z);

std::string time(double end, const std::string& more = "");
/// Sets domain.dimensions = 2 if the points have two numbers.
std::string domain(const Point& min, const Point& max, const std::string& more = "");
/// @param viscosity dynamic viscosity [Pa s]; 0 leaves the scene's default
std::string fluid(double spacing, double viscosity = 0, const std::string& more = "");
/// Empty names leave the choice to the plan.
std::string models(const std::string& pressure, const std::string& viscosity = "");
/// models.pressure = "ppe" with this pressure.form.
std::string pressure_form(const std::string& form);

/// A box of fluid.
std::string block(const Point& min, const Point& max, const std::string& more = "");
/// A ball or disc of fluid.
std::string drop(const Point& centre, double radius, const std::string& more = "");
/// Solids: a box, a box that holds the fluid, a ball or disc, and a plane through `at`.
std::string box(const Point& min, const Point& max, const std::string& more = "");
std::string tank(const Point& min, const Point& max, const std::string& more = "");
std::string ball(const Point& centre, double radius, const std::string& more = "");
std::string plane(const Point& at, const Point& normal, const std::string& more = "");
/// A round nozzle. @param speed m/s
std::string emitter(const Point& position, double radius, double speed, const std::string& more = "");
/// A box that removes fluid.
std::string drain(const Point& min, const Point& max, const std::string& more = "");

}  // namespace whorl::test::text
