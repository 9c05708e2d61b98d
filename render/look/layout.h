#pragma once
/// Where a picture of a flow has its flow, and where its words: legend, time and label stand in a margin of their own, never on the flow.
#include "render/look/look_options.h"

namespace whorl {

struct PictureBox {
    int x = 0, y = 0, width = 0, height = 0;  ///< pixels from the upper left
};

struct Layout {
    PictureBox flow;    ///< the largest that has the flow's sides and leaves room for the words
    PictureBox margin;  ///< beside it, or below it where the flow is wider than the picture; empty where there are no words
    bool below = false;
    float text = 0;  ///< height of a capital letter [pixels]
};

/// @param aspect of the flow, width over height @param range of the legend
Layout layout_of(int width, int height, float aspect, const LookOptions& look, const std::array<float, 2>& range);
/// A picture has a legend if it shows a field by a colour map.
bool has_legend(const LookOptions& look);

}  // namespace whorl
