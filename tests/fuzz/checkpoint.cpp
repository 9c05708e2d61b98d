// Checkpoints.
#include "engine/io/checkpoint.h"

#include "tests/fuzz/sealed.h"

using namespace whorl;

namespace {

constexpr std::string_view kind = "WHORLCP2";

Checkpoint from_bytes(std::string_view bytes) { return read_checkpoint(fuzz::as_file(bytes, ".whorl")); }

}  // namespace

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    return fuzz::mutate_sealed(kind, data, size, most, seed);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        from_bytes(fuzz::text_of(data, size));
    } catch (const EnvironmentError& error) {
        fuzz::expect(*error.what() != 0, "a refusal has words");
        return 0;
    }
    fuzz::expect_refusal_of_changes(std::string(fuzz::text_of(data, size)), from_bytes);
    return 0;
}
