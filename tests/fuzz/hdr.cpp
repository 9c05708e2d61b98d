// Radiance pictures, and the light that comes from them.
#include <cmath>

#include "engine/core/errors.h"
#include "engine/core/grid_index.h"
#include "render/look/environment.h"
#include "tests/fuzz/target.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const Environment image = read_environment(fuzz::as_file(fuzz::text_of(data, size), ".hdr"));
        fuzz::expect(image.rgb.size() == 3 * grid_count(image.width, image.height), "a picture has all its pixels");
        for (const float x : image.rgb) fuzz::expect(std::isfinite(x) && x >= 0, "light is finite");
        brightest_side(light_of(image));
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
