
#include <algorithm>
#include <cmath>
#include <string>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "render/image/image.h"

namespace whorl {
namespace {

// Source pixels that a target pixel covers along one axis, with the weight of each.
struct Cover {
    int first = 0;
    std::vector<float> share;  // adds up to 1
};

std::vector<Cover> covers(int from, int to) {
    std::vector<Cover> result(to);
    const double step = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        const double begin = i * step, end = std::min<double>(from, (i + 1) * step);
        Cover& cover = result[i];
        cover.first = std::min(from - 1, static_cast<int>(begin));
        for (int k = cover.first; k < std::max<double>(end, cover.first + 1); ++k)
            cover.share.push_back(static_cast<float>((std::min<double>(end, k + 1) - std::max<double>(begin, k)) / (end - begin)));
    }
    return result;
}

void paste(Image& onto, const Image& image, int x, int y) {
    if (!image.alpha.empty()) return paste(onto, over_grey(image), x, y);
    WHORL_ASSERT(x >= 0 && y >= 0 && x + image.width <= onto.width && y + image.height <= onto.height,
                 +std::to_string(image.width) + "x" + std::to_string(image.height));
    for (int row = 0; row < image.height; ++row) std::copy_n(image.pixel(0, row), 3 * image.width, onto.pixel(x, y + row));
}

}  // namespace

Image downscaled(const Image& image, int width, int height) {
    WHORL_ASSERT(width > 0 && height > 0 && image.width > 0 && image.height > 0);
    const std::vector<Cover> columns = covers(image.width, width), rows = covers(image.height, height);
    Image result = plain_image(width, height, 0);
    parallel_blocks(height, 1, [&](Index y, Index) {
        const Cover& row = rows[y];
        for (int x = 0; x < width; ++x) {
            const Cover& column = columns[x];
            Vec3f light = Vec3f::Zero();
            for (std::size_t j = 0; j < row.share.size(); ++j)
                for (std::size_t i = 0; i < column.share.size(); ++i) {
                    const std::uint8_t* p = image.pixel(column.first + static_cast<int>(i), row.first + static_cast<int>(j));
                    light += row.share[j] * column.share[i] * Vec3f(linear_light(p[0]), linear_light(p[1]), linear_light(p[2]));
                }
            for (int c = 0; c < 3; ++c) result.pixel(x, y)[c] = srgb_byte(light[c]);
        }
    });
    return result;
}

Image contact_sheet(const std::vector<Image>& images, int columns, int cell_width) {
    if (images.empty()) return {};
    const int gap = std::max(2, cell_width / 60);
    std::vector<Image> cells;
    int cell_height = 0, widest = 0;
    for (const Image& image : images) {
        const int width = std::min(cell_width, image.width);
        const int height = std::max(1, static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width)));
        const Image whole = over_grey(image);
        cells.push_back(width == image.width ? whole : downscaled(whole, width, height));
        cell_height = std::max(cell_height, height);
        widest = std::max(widest, width);
    }
    columns = std::clamp(columns, 1, static_cast<int>(cells.size()));
    const int rows = (static_cast<int>(cells.size()) + columns - 1) / columns;
    Image sheet = plain_image(columns * (widest + gap) + gap, rows * (cell_height + gap) + gap, 24);
    for (int i = 0; i < static_cast<int>(cells.size()); ++i)
        paste(sheet, cells[i], gap + (i % columns) * (widest + gap), gap + (i / columns) * (cell_height + gap));
    return sheet;
}

Image side_by_side(const std::vector<Image>& images, int columns, int gap, int width, int height) {
    WHORL_ASSERT(!images.empty() && columns > 0);
    const int rows = (static_cast<int>(images.size()) + columns - 1) / columns, w = images[0].width, h = images[0].height;
    const int left = (width - columns * w - (columns - 1) * gap) / 2, top = (height - rows * h - (rows - 1) * gap) / 2;
    WHORL_ASSERT(left >= 0 && top >= 0);
    Image whole = plain_image(width, height, 0);
    const Image first = images[0].alpha.empty() ? images[0] : over_grey(images[0]);
    for (std::size_t k = 0; k < whole.rgb.size(); ++k) whole.rgb[k] = first.rgb[k % 3];
    for (int i = 0; i < static_cast<int>(images.size()); ++i)
        paste(whole, images[i], left + (i % columns) * (w + gap), top + (i / columns) * (h + gap));
    return whole;
}

Image one_above_other(const Image& above, const Image& below) {
    WHORL_ASSERT(above.width == below.width);
    Image whole = plain_image(above.width, above.height + below.height, 0);
    paste(whole, above, 0, 0);
    paste(whole, below, 0, above.height);
    return whole;
}

}  // namespace whorl
