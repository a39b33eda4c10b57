// libFuzzer's entry. HEXRELIEF_FUZZ_TARGET names the target; without it the program's own name does,
// fuzz_TARGET.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tests/fuzz/targets.h"

namespace {
const hexrelief::fuzz::Target* target = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
    const char* const named = std::getenv("HEXRELIEF_FUZZ_TARGET");
    const std::string program = (*arguments)[0];
    target = &hexrelief::fuzz::target(named ? named : program.substr(program.find_last_of("/_") + 1));
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
    hexrelief::fuzz::run(*target, {bytes, count});
    return 0;
}
