#pragma once
/// Pictures made smaller and laid side by side. What comes out is opaque: transparent pictures are laid over grey.
#include "render/image/image.h"

namespace whorl {

/// The picture made smaller by averaging in linear light.
Image downscaled(const Image& image, int width, int height);
/// Pictures side by side in rows of `columns`, each at most cell_width wide, in order, with small gaps.
Image contact_sheet(const std::vector<Image>& images, int columns, int cell_width);
/// Two pictures of one width.
Image one_above_other(const Image& above, const Image& below);
/// Pictures of one size in a grid, row by row, in the middle of a dark picture of width x height.
Image side_by_side(const std::vector<Image>& images, int columns, int gap, int width, int height);

}  // namespace whorl
