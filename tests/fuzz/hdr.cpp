// Radiance pictures.
#include <cmath>

#include "engine/core/errors.h"
#include "render/image/image.h"
#include "tests/fuzz/target.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const FloatImage image = read_hdr(fuzz::as_file(fuzz::text_of(data, size), ".hdr"));
        fuzz::expect(image.rgb.size() == 3 * grid_count(image.width, image.height), "a picture has all its pixels");
        for (const float x : image.rgb) fuzz::expect(std::isfinite(x) && x >= 0, "light is finite");
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
