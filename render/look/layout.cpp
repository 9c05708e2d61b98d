#include "render/look/layout.h"

#include <algorithm>
#include <cmath>

#include "render/image/text.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// The largest box of that aspect in the middle of another.
PictureBox fitted(const PictureBox& room, float aspect) {
    PictureBox box = room;
    const float wide = static_cast<float>(room.width), tall = static_cast<float>(room.height);
    if (wide > aspect * tall) box.width = std::max(1, static_cast<int>(std::lround(aspect * tall)));
    else box.height = std::max(1, static_cast<int>(std::lround(wide / aspect)));
    box.x += (room.width - box.width) / 2, box.y += (room.height - box.height) / 2;
    return box;
}

float column_width(const LookOptions& look, const std::array<float, 2>& range, float text) {
    float wide = 0;
    if (!look.title.empty()) wide = text_width(look.title, text);
    if (look.time_stamp) wide = std::max(wide, text_width("t = 00.000 s", text));
    if (has_legend(look)) {
        const Ticks ticks = ticks_of(range[0], range[1], 7);
        wide = std::max(wide, text_width(field_title(look, ticks.power), text));
        for (const std::string& label : ticks.label) wide = std::max(wide, 3 * text + text_width(label, text));
    }
    return wide > 0 ? wide + 2 * text : 0;
}

}  // namespace

bool has_legend(const LookOptions& look) { return look.legend && shows_field(look) && look.field != "ink"; }

Layout layout_of(int width, int height, float aspect, const LookOptions& look, const std::array<float, 2>& range) {
    Layout layout;
    // Legible at 360 lines, and no larger than need be at 1080.
    layout.text = std::max(9.0f, static_cast<float>(std::min(width, height)) / 51);
    const bool words = !look.title.empty() || look.time_stamp || has_legend(look);
    if (!words) {
        layout.flow = fitted({0, 0, width, height}, aspect);
        return layout;
    }
    const int edge = static_cast<int>(std::lround(0.8f * layout.text));
    const int strip = static_cast<int>(std::lround((has_legend(look) ? 4.6f : 2.2f) * layout.text));
    const int column = std::min(width / 2, static_cast<int>(std::lround(column_width(look, range, layout.text))));
    const PictureBox above = fitted({edge, edge, width - 2 * edge, height - edge - strip}, aspect);
    const PictureBox beside = fitted({edge, edge, width - edge - column, height - 2 * edge}, aspect);
    layout.below = above.width >= beside.width;
    layout.flow = layout.below ? above : beside;
    // What is left over on the far side goes to the margin: flow and words stand together in the middle of the picture.
    if (layout.below) layout.margin = {layout.flow.x, layout.flow.y + layout.flow.height, layout.flow.width, strip};
    else layout.margin = {layout.flow.x + layout.flow.width, layout.flow.y, column, layout.flow.height};
    return layout;
}

}  // namespace whorl
