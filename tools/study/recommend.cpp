#include "tools/study/recommend.h"

#include <cstdlib>

#include "engine/core/errors.h"

namespace whorl {

bool Wish::holds(double cost, double error, double fps) const {
    return of == Of::error ? error < bound : of == Of::fps ? fps > bound : cost < bound;
}

Wish parse_wish(const std::string& text) {
    const auto fail = [&]() -> Wish {
        throw InputError({"--recommend " + text, 0, 0}, "is no wish", "", "allowed: \"error<2%\", \"fps>24\", \"cost<60\"");
    };
    const std::size_t at = text.find_first_of("<>");
    if (at == std::string::npos) return fail();
    std::string name = text.substr(0, at);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    Wish wish;
    wish.text = text;
    if (name == "error" && text[at] == '<') wish.of = Wish::Of::error;
    else if (name == "fps" && text[at] == '>') wish.of = Wish::Of::fps;
    else if (name == "cost" && text[at] == '<') wish.of = Wish::Of::cost;
    else return fail();
    char* end = nullptr;
    wish.bound = std::strtod(text.c_str() + at + 1, &end);
    const std::string unit = end;
    if (end == text.c_str() + at + 1 || !(wish.bound > 0)) return fail();
    if (unit == "%" && wish.of == Wish::Of::error) wish.bound /= 100;
    else if (!unit.empty() && !(unit == "s" && wish.of == Wish::Of::cost)) return fail();
    return wish;
}

}  // namespace whorl
