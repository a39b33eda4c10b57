// Libraries of the program's own that are opened only when they are needed, because they bring in others.
#pragma once

#include <dlfcn.h>

#include <array>
#include <filesystem>
#include <string>

namespace hexrelief {

// The folder of the program, and that of the shared library that this may be a part of.
inline std::array<std::filesystem::path, 2> own_folders() {
    static const char inside = 0;
    std::error_code failure;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", failure).parent_path();
    Dl_info own{};
    if (dladdr(&inside, &own) == 0 || own.dli_fname == nullptr || *own.dli_fname != '/')
        return {program, program};
    return {program, std::filesystem::path(own.dli_fname).parent_path()};
}

struct ModuleFunction {
    void* function = nullptr;
    std::string failure;  // why there is none
};

// Finds the library `file` beside the program, in ../lib/hexrelief or ../lib from there, or in such places
// from the shared library that this is a part of, and opens it for good.
inline ModuleFunction open_module(const std::string& file, const char* function) {
    const std::array folders = own_folders();
    // The last two are for programs that are built into folders below the build root, as the tests are.
    for (const std::filesystem::path& folder : folders)
        for (const char* const place : {"", "../lib/hexrelief", "../lib", "../hexrelief", "hexrelief",
                                        "../../../hexrelief", "..", "../..", "../../.."}) {
            std::error_code failure;
            const std::filesystem::path path = (folder / place / file).lexically_normal();
            if (!std::filesystem::exists(path, failure)) continue;
            void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
            if (library == nullptr) return {nullptr, dlerror()};
            if (void* const symbol = dlsym(library, function)) return {symbol, {}};
            return {nullptr, path.string() + " is not hexrelief's; reinstall it"};
        }
    return {nullptr, file + " is not in " + folders[0].string() + " nor in ../lib/hexrelief"};
}

}  // namespace hexrelief
