#include "tools/film/panel_difference.h"

#include <algorithm>

#include "engine/io/frame_file.h"
#include "render/flow/plate.h"
#include "tools/film/colour_range.h"
#include "tools/film/contact_sheet.h"

namespace whorl {

namespace fs = std::filesystem;

void draw_differences(const SceneFile& file, const std::string& title, const fs::path& one, const fs::path& other, const fs::path& folder,
                      int frames) {
    if (!fs::exists(frame_file(one, frames)) && fs::exists(picture_file(folder, frames))) return;
    const auto pair_of = [&](int number) { return std::pair{read_frame(frame_file(one, number)), read_frame(frame_file(other, number))}; };
    constexpr int looked_at = 24;  // frames
    float most = 0;
    for (int n = 0; n < std::min(frames, looked_at); ++n) {
        const auto [a, b] = pair_of(frames <= looked_at ? n + 1 : 1 + n * (frames - 1) / (looked_at - 1));
        most = std::max(most, usual_difference(a, b, file.look));
    }
    const float high = most > 0 ? static_cast<float>(round_number_above(most)) : 1;
    LookOptions look = file.look;
    look.title = title;
    fs::create_directories(folder / "frames");
    for (int number = 1; number <= frames; ++number) {
        const auto [a, b] = pair_of(number);
        const auto& size = file.scene.output.size;
        write_png(picture_file(folder, number), draw_difference_plate(a, b, look, {-high, high}, size[0], size[1]));
    }
}

}  // namespace whorl
