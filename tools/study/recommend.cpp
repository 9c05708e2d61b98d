#include "tools/study/recommend.h"

#include <cstdlib>

#include "engine/core/errors.h"

namespace whorl {

bool Goal::holds(double cost, double error, double fps) const {
    return of == Of::error ? error < bound : of == Of::fps ? fps > bound : cost < bound;
}

Goal parse_goal(const std::string& text) {
    const auto fail = [&]() -> Goal {
        throw InputError({"--recommend " + text, 0, 0}, "is no goal", "", "allowed: \"error<2%\", \"fps>24\", \"cost<60\"");
    };
    const std::size_t at = text.find_first_of("<>");
    if (at == std::string::npos) return fail();
    std::string name = text.substr(0, at);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    Goal goal;
    goal.text = text;
    if (name == "error" && text[at] == '<') goal.of = Goal::Of::error;
    else if (name == "fps" && text[at] == '>') goal.of = Goal::Of::fps;
    else if (name == "cost" && text[at] == '<') goal.of = Goal::Of::cost;
    else return fail();
    char* end = nullptr;
    goal.bound = std::strtod(text.c_str() + at + 1, &end);
    const std::string unit = end;
    if (end == text.c_str() + at + 1 || !(goal.bound > 0)) return fail();
    if (unit == "%" && goal.of == Goal::Of::error) goal.bound /= 100;
    else if (!unit.empty() && !(unit == "s" && goal.of == Goal::Of::cost)) return fail();
    return goal;
}

}  // namespace whorl
