// libFuzzer's entry. HEXRELIEF_FUZZ_TARGET names the target.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
    static const hexrelief::fuzz::Target& target = []() -> const hexrelief::fuzz::Target& {
        const char* const name = std::getenv("HEXRELIEF_FUZZ_TARGET");
        return hexrelief::fuzz::target(name ? name : "");
    }();
    hexrelief::fuzz::run(target, {bytes, count});
    return 0;
}
