#pragma once
/// Content and look of an image: style, material, light, colours. Plain data; render/gl draws it.
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/core/types.h"
#include "render/look/camera.h"

namespace whorl {

/// "#rrggbb" (sRGB) of the first, second and third ink, where they are thick.
struct InkColours {
    std::vector<std::string> of{"#c8281e", "#1e50a0", "#e6b400"};
};

/// Linear red, green, blue; in a file also "#rrggbb" (sRGB).
struct Colour : Vec3f {
    using Vec3f::Vec3f;
};

struct LookOptions {
    /// liquid (refracting surface) | opaque (paint, lava) | and coloured by a field: particles | slice (a plane through the flow) | volume
    /// (a cloud) | tubes | ribbons (along vortex lines)
    std::string style = "liquid";
    std::string material = "honey";        ///< preset that the keys below start from: honey | water | paint | chocolate | lava | clay
    Vec3f absorption = Vec3f(-1, -1, -1);  ///< 1/m, Beer-Lambert a colour channel (linear RGB); negative: the preset's
    Colour colour = {-1, -1, -1};          ///< linear RGB of an opaque material; negative: the preset's
    float refraction = -1;                 ///< index; negative: the preset's
    float roughness = -1;                  ///< 0 mirror .. 1 matt; negative: the preset's
    float cooling =
        -1;  ///< s, lava: in which it loses most of its glow, where its viscosity depends on age; 0: never; negative: the preset's
    std::string background = "studio";  ///< studio | dark | white | transparent (lit by the studio)
    bool ground = true;                 ///< a ground with shadow under the scene
    std::string table = "none";         ///< what the ground is: none (the backdrop's paper) | plain | wood | stone | cloth
    std::filesystem::path environment;  ///< panorama of the surroundings, which lights the scene; empty: the studio
    float exposure = 1;
    int samples = 8;              ///< a pixel
    std::string field = "speed";  ///< speed | pressure | density | spin | vorticity | q_criterion | spin_difference | ink
    std::string colour_map = "viridis";
    InkColours inks;
    std::array<float, 2> range{0, 0};     ///< of the colour map; equal: a film's is chosen at its start, a single picture's from its frame
    float trail = 0;                      ///< s, of the flow's way behind each particle; 0: none
    std::string slice_axis = "z";         ///< x | y | z, across the slice
    std::optional<float> slice_position;  ///< m on that axis; none: the middle of the fluid
    bool streaks = true;                  ///< slice: streaked along the flow (line integral convolution)
    float streak_time = 0;                ///< s, of the flow's way to each side that a streak or arrow shows; 0: chosen as the range is
    int arrows = 0;                       ///< slice: how many along its longer side
    int isolines = 0;                     ///< slice: how many values have a line
    float relief = 0;                     ///< slice: 1: lit as a landscape whose range is a tenth of the longer side high
    float opacity = 1;                    ///< volume: optical depth over the fluid's mean thickness, of the strongest field
    int lines = 400;                      ///< tubes and ribbons: number of particles with a line through them
    float line_width = 0;                 ///< m, of a tube where the field is strongest; 0: the spacing
    float line_length = 0;                ///< m, at most; 0: the domain's longest side
    std::string title;                    ///< text on the image; of a panel: its label
    bool legend = false;
    bool time_stamp = false;
};

/// Whether the look draws nothing behind the fluid and the solids.
inline bool is_transparent(const LookOptions& look) { return look.background == "transparent"; }

/// Whether the look draws vortex lines.
inline bool draws_lines(const LookOptions& look) { return look.style == "tubes" || look.style == "ribbons"; }

/// Whether the look colours the fluid by a field instead of drawing its surface.
inline bool shows_field(const LookOptions& look) {
    return look.style == "particles" || look.style == "slice" || look.style == "volume" || draws_lines(look);
}

const KeyTable& camera_keys();  ///< of CameraOptions
const KeyTable& look_keys();    ///< of LookOptions

}  // namespace whorl
