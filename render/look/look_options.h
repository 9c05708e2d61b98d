#pragma once
/// Content and look of an image: style, material, light, colours. Plain data; render/gl draws it.
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/colour.h"
#include "render/look/camera.h"

namespace whorl {

/// Colours "#rrggbb" (sRGB) of opaque layers of the first, second and third ink.
struct InkColours {
    std::vector<std::string> of{"#c8281e", "#1e50a0", "#e6b400"};
};

struct LookOptions {
    /// Surfaces: liquid (refracting) | opaque (paint, lava). Coloured by a field: particles | slice (a plane through the flow) | volume
    /// (a cloud) | tubes | ribbons (along vortex lines).
    std::string style = "liquid";
    std::string material = "honey";  ///< preset, whose values the keys below override: honey | water | paint | chocolate | lava | clay |
                                     ///< cream | milk | wax | caramel | ketchup | slime
    Vec3f absorption = Vec3f(-1, -1, -1);  ///< 1/m, Beer-Lambert coefficient per channel (linear RGB); negative: the preset's
    Colour colour = {-1, -1, -1};          ///< linear RGB of an opaque material; negative: the preset's
    float refraction = -1;                 ///< index of refraction; negative: the preset's
    float roughness = -1;                  ///< 0 mirror .. 1 matt; negative: the preset's
    /// Age [s] at which lava has lost most of its glow, if its viscosity depends on age; 0: never; negative: the preset's.
    float cooling = -1;
    float scattering = -1;              ///< m, transport mean free path of light in an opaque material; negative: the preset's
    float foam = 0;                     ///< number of points of spray and foam over the usual one; 0: none
    std::string background = "studio";  ///< studio | dark | white | transparent (lit by the studio)
    bool ground = true;                 ///< a ground with shadow under the scene
    std::string table = "none";         ///< material of the ground: none (the backdrop continues) | plain | wood | stone | cloth
    std::filesystem::path environment;  ///< panorama (.exr) that lights the scene; empty: the studio
    float surround_strength = 1;        ///< factor on the light of the studio or panorama
    float surround_turn = 0;            ///< degrees, rotation of the studio's lamps or of the panorama, anticlockwise from above
    std::vector<Light> lights;          ///< all have targets; if there are any, the studio's lamps are off
    float exposure = 1;
    int samples = 8;              ///< samples per pixel
    std::string field = "speed";  ///< speed | pressure | density | spin | vorticity | q_criterion | spin_difference | ink
    std::string colour_map = "viridis";
    InkColours inks;
    /// Values of the first and last colour of the map; equal: chosen at the start of the run, or for a single image from its frame.
    std::array<float, 2> range{0, 0};
    float trail = 0;                      ///< s, flow time that the trail behind each particle covers; 0: no trail
    std::string slice_axis = "z";         ///< x | y | z, normal of the slice
    std::optional<float> slice_position;  ///< m, position of the slice on its axis; none: the middle of the fluid
    bool streaks = true;                  ///< slice: streaks along the flow (line integral convolution)
    float streak_time = 0;                ///< s, flow time that a streak or arrow covers upstream and downstream; 0: chosen like `range`
    int arrows = 0;                       ///< slice: number of arrows along its longer side
    int isolines = 0;                     ///< slice: number of isolines
    float relief = 0;                     ///< slice: shading as a landscape; at 1 `range` is a tenth of the longer side high
    float opacity = 1;                    ///< volume: optical depth of the strongest field over the fluid's mean thickness
    int lines = 400;                      ///< tubes and ribbons: number of vortex lines, each through one particle
    float line_width = 0;                 ///< m, width of a tube where the field is strongest; 0: the spacing
    float line_length = 0;                ///< m, largest length of a line; 0: the domain's longest side
    std::string title;                    ///< text on the image; a panel without a title shows its label
    bool legend = false;
    bool time_stamp = false;
    float text_size = 0;  ///< pixels, height of a capital letter; 0: 14 in an image of 720 lines
};

/// Whether the look draws nothing behind the fluid and the solids.
inline bool is_transparent(const LookOptions& look) { return look.background == "transparent"; }

/// Whether the look draws vortex lines.
inline bool draws_lines(const LookOptions& look) { return look.style == "tubes" || look.style == "ribbons"; }

/// Whether the look colours the fluid by a field instead of drawing its surface.
inline bool shows_field(const LookOptions& look) {
    return look.style == "particles" || look.style == "slice" || look.style == "volume" || draws_lines(look);
}

const KeyTable& camera_keys();  ///< keys of CameraOptions
const KeyTable& look_keys();    ///< keys of LookOptions

}  // namespace whorl
