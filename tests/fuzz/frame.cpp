// Whole frames (--export raw), and the surfaces of small ones.
#include "engine/io/frame.h"

#include "tests/fuzz/checksummed.h"
#include "tests/fuzz/small_run.h"

using namespace whorl;

namespace {

constexpr std::string_view kind = "WHORLFR5";

Frame from_bytes(std::string_view bytes) { return read_frame(fuzz::as_file(bytes, ".frame")); }

}  // namespace

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    return fuzz::mutate_sealed(kind, data, size, most, seed);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string sound(fuzz::text_of(data, size));
    Frame frame;
    try {
        frame = from_bytes(sound);
    } catch (const InputError& error) {
        fuzz::expect(*error.what() != 0, "a mistake has words");
        return 0;
    }
    const std::size_t n = frame.position.size();
    bool one_each = frame.velocity.size() == n;
    for (const auto& [name, values] : frame.scalar) one_each = one_each && values.size() == n;
    for (const auto& [name, values] : frame.vector) one_each = one_each && values.size() == n;
    for (const auto& [name, values] : frame.whole) one_each = one_each && values.size() == n;
    fuzz::expect(one_each, "every field has a value for each particle");
    for (const FrameSolid& solid : frame.solids)
        if (solid.mesh)
            for (const auto& triangle : solid.mesh->triangle)
                for (const auto corner : triangle) fuzz::expect(corner < solid.mesh->position.size(), "corners are vertices");
    fuzz::surface_of(frame, {});
    fuzz::expect_refusal_of_changes(sound, from_bytes);
    return 0;
}
